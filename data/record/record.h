/* SPDX-License-Identifier: MIT */
/* The room "record": how a stack was made, as text in its first page. */
#ifndef RECORD_H
#define RECORD_H

#include "data/inputs/inputs.h"
#include "data/options/options.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/tiff/tiff.h"
#include "spectral.h"

struct texts {
    const char **text; /* the array is owned, the texts are not */
    int n;
};
struct numbers {
    double *value; /* owned */
    int n;
};
/* Rows of a picture, from the top, that lie in a stack of their own. */
struct part_rows {
    int first, count;
};
/* Everything that decides the bytes of a stack, except OpenGL. A member is a row in `fields` of
 * record.c, by which it is written, read and freed. */
struct record {
    const char *program; /* name and version */
    const char *scene;   /* as the command line named it */
    const char *scene_sha256;
    struct texts files;          /* that the scene names, as inputs_digest prints them */
    const char *renderer;        /* "raster", or OpenGL's GL_RENDERER */
    char *options[MAX_RECORDED]; /* each one word: "--size=300x200"; not owned */
    int n_options;
    struct texts lights, ambients; /* of the scene, each as SPECTRUM*INTENSITY */
    /* scene_white, on each page; none where nothing shines, in pages of components, or in a stack
     * without this record. */
    struct numbers white;
    struct numbers illumination; /* one: the sum of the lights' intensities, if there is a white */
    /* How the spectra were sampled: as sampling_name, and for which detector; NULL: at the
     * wavelengths. */
    const char *sampling, *sampling_detector;
    const char *components; /* "yes": pages have no wavelengths; NULL: they are radiances */
    /* Two limits a page, which lies between them. They rise without overlap, and at most
     * LARGEST_QUADRATURE pages share one segment. */
    struct numbers segments;
    /* A fixed sampling has a response: its weights. They hold for the cells of 1 nm between the two
     * limits in range_nm. white_response is the detector's response to the white there: three
     * numbers, or none if it does not see the white. */
    struct numbers response, range_nm, white_response;
    struct texts objects; /* by their numbers in the object map, from 1; 0 is the background */
    /* Only a part has these: its first row, its number of rows and that of the picture; the
     * wavelengths of its pages, with all digits. */
    struct numbers rows, wavelengths;
    /* Only record_read sets these: how samples become radiances; the object map, "OFFSET
     * BYTES_PER_PIXEL", and both of its numbers, 0 where there is no map. */
    const char *full_scale, *scale, *object_map;
    uint64_t map_offset;
    int map_bytes;
    char *text; /* files, lights, ambients and, once it is read, all strings point into it; owned */
};
/* Returns how many decimal digits of a number read back as the same double. */
int exact_digits(double number);
/* Records a scene: its name, its files and that of the detector it is drawn for (NULL: none), its
 * lights, its white and its sampling (NULL: none). Scene and sampling must outlive the record. */
bool record_scene(const struct scene *scene, const struct sampling *sampling, const char *detector,
                  struct record *out, struct error *err);
/* Records that the stack has these rows of a picture, and n wavelengths (components: 0). height:
 * the rows of the picture. */
bool record_part(struct record *record, const struct part_rows *rows, int height,
                 const double *wavelengths_nm, int n, struct error *err);
/* Compares the files that a scene names, and that of its detector (NULL: none), with those that are
 * recorded. *change says in words what the first difference is; "": there is none. */
enum { FILE_CHANGE = 1024 };
bool record_find_change(const struct record *record, const struct scene *scene,
                        const char *detector, char change[FILE_CHANGE], struct error *err);
/* Writes lines "KEY: VALUE" into an allocated text; NULL: no memory. In values, control characters,
 * bytes that are no UTF-8, and '%' become %XX, as in a URL. */
char *record_text(const struct record *record, struct error *err);
/* Reads the record in the description of a stack's first page. Refuses an image without a record,
 * or with a record that contradicts itself. */
bool record_read(const struct image *image, struct record *out, struct error *err);
/* Returns the sum of the lights' intensities; 0: no white is recorded. */
double record_illumination(const struct record *record);
void record_free(struct record *record);

#endif
