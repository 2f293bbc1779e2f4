/* SPDX-License-Identifier: MIT */
/* The room "stack": writes a spectral stack, with a text in its first page on how it was made, and
 * reads one; lists the files that a scene is made of. Only this room knows the tags of a stack. */
#ifndef DATA_STACK_STACK_H
#define DATA_STACK_STACK_H

#include "data/images/images.h"
#include "data/sampling/sampling.h"

/* Materials, spectra, textures, meshes: files that decide a picture, and that are not built in. */
struct inputs {
    char *
        *file; /* "SHA-256 PATH", in the order of strcmp of the paths, each once; both are owned */
    int n;
    struct index paths;
};
/* Lists the files that the scene's text and its options name, as far as the picture needs them and
 * they are there: a material that no object uses is not read, and a plan refuses a missing file
 * that it needs. detector: a file or a built-in name; NULL: the scene is not sampled for one.
 * texts: lists the files of the scene's text, too, unless that came from a pipe. Digests are those
 * of the files as this process has read them, or else it reads them. The caller frees *out, also
 * after a failure. */
bool inputs_list(const struct scene *scene, const char *detector, bool texts, struct inputs *out,
                 struct error *err);
void inputs_free(struct inputs *inputs);
/* Returns the path in "SHA-256 PATH"; "": there is none. */
enum { SHA256_DIGITS = 64 };
const char *input_path(const char *file);

#define ABSOLUTE_UNIT "W sr-1 m-2 nm-1"
#define RELATIVE_UNIT ABSOLUTE_UNIT " (relative)"
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
 * record.c, by which it is read and freed. */
struct record {
    const char *program; /* name and version */
    const char *scene;   /* as the command line named it */
    const char *scene_sha256;
    struct texts files;            /* that the scene names, as inputs_list makes them */
    const char *renderer;          /* "raster", or OpenGL's GL_RENDERER */
    const char *mipmaps;           /* whose level of detail: a driver's; NULL: there are none */
    struct texts options;          /* each one word: "--size=300x200" */
    struct texts lights, ambients; /* of the scene, each as SPECTRUM*INTENSITY */
    const char *unit;              /* of radiances: ABSOLUTE_UNIT; NULL: they are relative */
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
/* A new stack records this of its scene. */
struct recorded {
    const struct scene *scene;
    const struct sampling *sampling; /* NULL: none */
    const char *renderer, *mipmaps;  /* as in struct record */
    const struct options *options;   /* with those that are recorded, and the detector */
};
/* Print lines "KEY: VALUE" of a record; in values, control characters, bytes that are no UTF-8, and
 * '%' become %XX, as in a URL. First comes the scene with its files, lights, white and sampling;
 * then each object, with the key "object"; last, of a part, its rows of the picture, which has
 * `height`, and n wavelengths (components: 0). */
void record_put(struct printed *to, const char *key, const char *value);
bool record_put_scene(struct printed *to, const struct recorded *made, struct error *err);
/* Prints whence a file comes that is no stack: the program, the scene of `what` ("maps of"), its
 * digest, the options. */
void record_put_beside(struct printed *to, const char *what, const struct scene *scene,
                       const struct options *options);
void record_put_part(struct printed *to, const struct part_rows *rows, int height,
                     const double *wavelengths_nm, int n);
/* Compares the files that a scene names, and that of its detector (NULL: none), with those that are
 * recorded. Refuses the first difference. */
bool record_has_files(const struct record *record, const struct scene *scene, const char *detector,
                      struct error *err);
/* Reads the record of a stack, which tags_read has opened; it needs the image no longer. Refuses an
 * image without a record, or with a record that contradicts itself or the image. */
bool record_read(const struct image *image, struct record *out, struct error *err);
/* Returns the sum of the lights' intensities; 0: no white is recorded. */
double record_illumination(const struct record *record);
void record_free(struct record *record);

/* ---- stack.c: the multi-page TIFF ---- */

struct stack_options {
    int width, height, n_wavelengths;
    const double *wavelengths_nm;
    double full_scale;      /* radiance of the largest count: 65535, of 8 bits 255 */
    int bits;               /* of a sample: 8 or 16 of counts, 32 of float radiances; 0: 16 */
    const char *scene;      /* for the description */
    const char *provenance; /* lines of text for the description: a record */
    int map_bytes;          /* of a pixel's number in the object map: 1 or 2; 0: there is no map */
    /* names the pages, which then have no wavelengths; NULL: they have */
    const struct sampling_method *components;
    const char *names; /* lines, of pages that are raw values; NULL: they are radiances */
    const char *unit;  /* of these values, or of radiances; NULL: RELATIVE_UNIT */
};
/* A stack that is being written: laid out at once, then filled by pages_write with uint8_t or
 * uint16_t counts, or floats. Page n_wavelengths is the object map, of uint8_t or uint16_t. */
struct stack_writer {
    struct pages pages;
    struct stack_options options;
};
/* Lays the file out, with copies of what the options point to. */
bool stack_open(struct stack_writer *out, const char *path, const struct stack_options *options,
                struct error *err);
/* Stores `verdict` (the check in one line, printable ASCII, at most STACK_VERDICT - 1 bytes) in the
 * room that stack_open left for it, and reads all directories again to see that they are whole. */
enum { STACK_VERDICT = 512 };
bool stack_finish(struct stack_writer *writer, const char *verdict, struct error *err);
/* The first byte in which two stacks differ. */
struct stack_difference {
    bool compared, found;
    bool in_map;    /* at x, y of the object map, which is no page */
    int page, x, y; /* page -1: outside the pages */
};
/* Compares a finished stack, not committed yet, with a file. Refuses a file that cannot be read. */
bool stack_compare(const struct stack_writer *writer, const char *path,
                   struct stack_difference *out, struct error *err);
void stack_discard(struct stack_writer *writer); /* safe after output_pass */
const char *stack_library(void);                 /* name and version of the libtiff in use */

/* ---- stack.c: the verdict on a stack, in numbers ---- */

/* How the check of all samples ended, as the line of a stack records it. */
struct stack_verdict {
    char word[16]; /* "agreed", "differs", "not verified" */
    uint64_t samples, exact, within_1;
    double largest;                                          /* difference, in counts */
    uint64_t unexplained, pixels, unchecked, objects, edges; /* edges: of the unchecked ones */
};
void stack_verdict_text(const struct stack_verdict *verdict, char out[STACK_VERDICT]);
/* Returns how many of the unchecked pixels of objects decide whether a picture is verified. The
 * share `most` of its pixels may stay unchecked. Those along edges do not decide while their share
 * is at most EDGE_SHARES times as large; with a share of 0 all of them decide. */
enum { EDGE_SHARES = 25 };
uint64_t stack_unchecked(const struct stack_verdict *verdict, double most);

/* ---- tags_read.c ---- */

/* The image_tags of stacks, and of any TIFF that records wavelengths as OME-XML, GDAL_METADATA or
 * page names. */
bool tags_read(struct image *image, int n, struct page_record *out, struct error *err);

/* ---- cube.c: a spectral stack to be read ---- */

/* A stack of this program, of wavelengths or of components; or any TIFF of grey pages or bands that
 * records increasing wavelengths as OME-XML, GDAL_METADATA or page names. */
struct cube {
    struct image image;
    struct record record; /* zeroed in a stack of another program; map_bytes is 0 where no object
                             map lies where it should */
    bool components;      /* pages have no wavelengths: image.wavelengths_nm is 1, 2, ... */
    bool raw;             /* pages are channels, as develop --raw writes; numbers likewise */
    const char *unit;     /* of radiances */
};
/* Reads no samples. Messages name the path; their status is EXIT_INPUT. The caller closes *out,
 * also after a failure. */
bool cube_open(const char *path, struct cube *out, struct error *err);
bool cube_or_raw_open(const char *path, struct cube *out, struct error *err); /* takes raw values */
/* Refuses a cube of components: "WHAT needs radiances ...". */
bool cube_needs_radiance(const struct cube *cube, const char *what, struct error *err);
void cube_close(struct cube *cube);

/* ---- join.c: parts of a picture become its stack; spectral join ---- */

/* Joins the stacks of parts, in any order, into the bytes of the whole stack. Refuses parts that
 * are missing, double, or of another render. Fails with EXIT_DIFFERENT where too little of the
 * whole picture could be checked. */
extern const struct command join_command;
/* The share of object pixels that may stay unchecked, unless --unchecked says otherwise. */
#define USUAL_UNCHECKED 0.01

/* ---- sidecar.c: the ENVI header of a stack, STACK.tif.hdr; spectral envi ---- */

/* Writes the header of a stack. */
extern const struct command envi_command;
/* Returns the name of a stack's header, allocated; NULL: no memory. */
char *sidecar_name(const char *stack, struct error *err);

/* ---- command.c: spectral info ---- */

/* Prints how a stack was made. */
extern const struct command info_command;

#endif
