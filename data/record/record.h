/* SPDX-License-Identifier: MIT */
/* The room "record": how a stack was made, as text in its first page. */
#ifndef RECORD_H
#define RECORD_H

#include "data/options/options.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/tiff/tiff.h"
#include "spectral.h"

/* Everything that decides the bytes of a stack, except the files that its scene names, and OpenGL.
 */
struct record {
    const char *program; /* name and version */
    const char *scene;   /* as the command line named it */
    const char *scene_sha256;
    const char *renderer;        /* "raster", or OpenGL's GL_RENDERER */
    char *options[MAX_RECORDED]; /* each one word: "--size=300x200"; not owned */
    int n_options;
    /* The lights of the scene, each as SPECTRUM*INTENSITY; the arrays are owned. */
    const char **lights, **ambients;
    int n_lights, n_ambients;
    /* scene_white, at each wavelength; owned. NULL and 0 where nothing shines, or in a stack
     * without this record. */
    double *white;
    int n_white;
    double illumination;
    /* How its spectra were sampled: as sampling_name and for which detector; NULL: at the
     * wavelengths. Segments are two limits a page, which lies between them; they rise without
     * overlap, and at most LARGEST_QUADRATURE pages share one. The response is the weights of a
     * fixed sampling, which hold for the cells of 1 nm in range_nm, and white_response is the
     * detector's response to the white there, if it sees it; owned. n_* are numbers in each array.
     */
    const char *sampling, *sampling_detector;
    double *segments, *response;
    int n_segments, n_response;
    double range_nm[2];
    double white_response[3];
    bool has_white_response;
    bool components; /* pages are no radiances at wavelengths */
    /* The objects that the numbers of the object map stand for, from 1; 0 is the background. The
     * array is owned. */
    const char **objects;
    int n_objects;
    /* Only of record_read: how samples become radiances, and the offset of the object map with its
     * bytes a pixel; 0: there is none. */
    const char *full_scale, *scale;
    uint64_t map_offset;
    int map_bytes;
    char *text; /* lights, ambients and, of record_read, all strings point into it; owned */
};
/* Returns how many decimal digits of a number read back as the same double. */
int exact_digits(double number);
/* Records a scene: its name, its lights, its white and its sampling (NULL: none). Scene and
 * sampling must outlive the record. */
bool record_scene(const struct scene *scene, const struct sampling *sampling, struct record *out,
                  struct error *err);
/* Writes lines "KEY: VALUE" into an allocated text; NULL: no memory. In values, control characters,
 * bytes that are no UTF-8, and '%' become %XX, as in a URL. */
char *record_text(const struct record *record);
/* Reads the record in the description of a stack's first page. Refuses, as no stack of this
 * program, an image without a record or with one that contradicts itself. */
bool record_read(const struct image *image, struct record *out, struct error *err);
void record_free(struct record *record);

#endif
