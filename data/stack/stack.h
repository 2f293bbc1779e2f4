/* SPDX-License-Identifier: MIT */
/* The room "stack": writing a spectral stack, and reading one. */
#ifndef STACK_H
#define STACK_H

#include "data/options/options.h"
#include "data/pages/pages.h"
#include "data/record/record.h"
#include "data/spectra/spectra.h"
#include "data/tiff/tiff.h"
#include "spectral.h"

/* ---- stack.c: the multi-page TIFF ---- */

struct stack_options {
    int width, height, n_wavelengths;
    const double *wavelengths_nm;
    double full_scale;      /* radiance of the largest count: 65535, of 8 bits 255 */
    int bits;               /* of a sample: 8 or 16 of counts, 32 of float radiances; 0: 16 */
    const char *scene;      /* for the description */
    const char *provenance; /* lines of text for the description: record_text */
    int map_bytes;          /* of a pixel's number in the object map: 1 or 2; 0: there is no map */
    const char *const *labels; /* of the pages, which then have no wavelengths; NULL: they have */
};
/* A stack that is being written: laid out at once, then filled in rectangles of any order. */
struct stack_writer {
    struct pages pages; /* and behind them the object map */
    struct stack_options options;
};
/* Lays the file out. The strings in options are copied into the file. The wavelengths are not
 * copied: they must outlive the writer. */
bool stack_open(struct stack_writer *out, const char *path, const struct stack_options *options,
                struct error *err);
/* Page n_wavelengths is the object map, behind the last page. */
struct stack_rectangle {
    int page, x, y, width, height;
};
/* Writes the samples of a rectangle, row by row without gaps: uint8_t or uint16_t counts, or
 * floats; of the object map uint8_t or uint16_t. */
bool stack_write(struct stack_writer *writer, const struct stack_rectangle *to, const void *samples,
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
/* Lets a finished stack appear under its name: see output_pass. */
bool stack_commit(struct stack_writer *writer, struct outputs *outputs, struct error *err);
void stack_discard(struct stack_writer *writer); /* safe after commit */
const char *stack_library(void);                 /* name and version of the libtiff in use */

/* ---- verdict.c: the verdict on a stack, in numbers ---- */

/* How the check of all samples ended, as the line of a stack records it. */
struct stack_verdict {
    char word[16]; /* "agreed", "differs", "not verified" */
    uint64_t samples, exact, within_1;
    double largest; /* difference, in counts */
    uint64_t unexplained, pixels, unchecked, objects;
};
void stack_verdict_text(const struct stack_verdict *verdict, char out[STACK_VERDICT]);
/* Returns false where the line records no numbers: nothing was checked, or the reference's pixels
 * are stored. */
bool stack_verdict_read(const char *line, struct stack_verdict *out);

/* ---- cube.c: a spectral stack to be read ---- */

/* A stack of this program, of wavelengths or of components; or any TIFF of grey pages or bands that
 * records increasing wavelengths as OME-XML, GDAL_METADATA or page names. */
struct cube {
    struct image image;
    struct record record; /* zeroed in a stack of another program; map_bytes is 0 where no object
                             map lies where it should */
    bool components;      /* pages have no wavelengths: image.wavelengths_nm is 1, 2, ... */
};
/* Reads no samples. Messages name the path; their status is EXIT_INPUT. */
bool cube_open(const char *path, struct cube *out, struct error *err);
/* Refuses a cube of components: "WHAT needs radiances ...". */
bool cube_needs_radiance(const struct cube *cube, const char *what, struct error *err);
/* Finds the weights of the pages in each channel: out[channel * n_pages + page]. They follow from
 * the sampling that the stack records, otherwise from detector_weights. Refuses weights too large
 * to compute with, and, for a fixed sampling, any detector but its own. */
bool cube_weights(const struct cube *cube, const struct detector *detector, double *out,
                  struct error *err);
/* Finds the response of such weights to a radiance of 1 everywhere. Fails where memory runs out. */
bool cube_equal_response(const struct cube *cube, const struct detector *detector,
                         const double *weights, double out[3], struct error *err);
/* Finds the part of each sensitivity outside the range of the pages, as detector_lost. */
void cube_lost(const struct cube *cube, const struct detector *detector, double out[3]);
/* Finds the white's radiance at each page's wavelength (for box its mean), n_pages values. The
 * white is the SPECTRUM that the word of a command line names; NULL: the one that the stack
 * records. Refuses a stack that records none, and a white that is 0 everywhere. */
bool cube_white(const struct cube *cube, const char *spectrum, double *out, struct error *err);
struct white_request {
    const char *spectrum; /* as cube_white takes it */
    bool needed;          /* refuse a stack without a white, even if `spectrum` is NULL */
};
/* Finds the response of weights (cube_weights) to a white; in a fixed stack, the response of its
 * detector to the white at every nm. *found: there is a white. Refuses a missing white that is
 * needed or named, and a white too large to compute with. */
bool cube_white_response(const struct cube *cube, const struct white_request *request,
                         const double *weights, bool *found, double out[3], struct error *err);
/* How an observer sees a stack. */
struct sight {
    double *weights; /* of X, Y and Z, as cube_weights; owned */
    double white[3]; /* XYZ */
    bool has_white;
};
/* Refuses what observer_read, cube_weights and cube_white_response refuse. */
bool sight_make(const struct cube *cube, const char *observer, const struct white_request *white,
                struct sight *out, struct error *err);
void sight_free(struct sight *sight);
/* Reads the numbers of the objects at n pixels of a row, from 1, with names in record.objects. 0 is
 * the background; -1 means an unknown number, or a stack without an object map. */
bool cube_objects(const struct cube *cube, int x, int y, int n, int *out, struct error *err);
void cube_close(struct cube *cube);

/* ---- join.c: parts of a picture become its stack; spectral join ---- */

/* Joins the stacks of parts, in any order, into the bytes of the whole stack. Refuses parts that
 * are missing, double, or of another render. Fails with EXIT_DIFFERENT where too little of the
 * whole picture could be checked. */
bool command_join(struct options *options, struct error *err);

/* ---- sidecar.c: the ENVI header of a stack, STACK.tif.hdr; spectral envi ---- */

/* Writes the header of a stack. */
bool command_envi(struct options *options, struct error *err);
/* Refuses a stack that will be no file (/dev/null, a pipe), and a header that cannot be written.
 * Leaves no file. */
bool sidecar_can_open(const char *stack, struct error *err);
/* Lets a finished stack appear under its name, which is `path` as the user wrote it, and then its
 * header. The header is complete before the stack appears: if it fails by then, neither appears. */
bool stack_commit_envi(struct stack_writer *writer, const char *path, struct outputs *outputs,
                       struct error *err);
/* Returns the name of a stack's header, allocated; NULL: no memory. */
char *sidecar_name(const char *stack, struct error *err);

/* ---- command.c: spectral info ---- */

/* Prints how a stack was made. */
bool command_info(struct options *options, struct error *err);
/* Opens a stack and reads its record. The caller closes the image and frees the record, also after
 * a failure; the record needs the image no longer. */
bool record_open(const char *path, struct image *image, struct record *out, struct error *err);

/* ---- Inside this room ---- */

#define PAGE_LABEL "%.10g nm"
/* tags.c: returns the width of a page: the mean distance to its neighbours; 0: it is the only one.
 */
double page_width_nm(const double *wavelengths_nm, int n, int page);
/* Sets all tags of the current directory but those of its format. It is the page_tags of a
 * stack_writer, to which `stack` points. */
bool tags_set(struct tiff *tiff, const void *stack, int page, struct error *err);

#endif
