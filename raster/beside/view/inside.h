/* SPDX-License-Identifier: MIT */
/* Only the files of the room "view" include this. */
#ifndef RASTER_BESIDE_VIEW_INSIDE_H
#define RASTER_BESIDE_VIEW_INSIDE_H

#include "raster/beside/colour/colour.h"
#include "raster/beside/see/see.h"
#include "raster/beside/view/view.h"
#include "raster/render/render.h"

struct view_options {
    double budget; /* MB; 0: not given */
    bool still, gallery;
};

/* A scene that is being viewed, and what is found on the way. */
struct viewing {
    struct options *options; /* their output is the page, or the picture */
    const struct plan *plan;
    struct lit_scene lit;  /* of the plan; a description needs none */
    size_t bytes;          /* of a page */
    double exposure;       /* of a picture */
    uint64_t out_of_gamut; /* its pixels with a clipped channel */
    struct notes *notes;
};
/* All functions that take a view and end in _write write its output. On failure no file has been
 * created or changed. */

/* ---- live.c: a page that draws the scene itself ---- */

/* Writes a page that holds this program and all files of the scene. The scene was read under
 * marked_name. */
bool live_write(struct viewing *view, struct error *err);

/* Returns the scene's name with a mark, so that the paths of all files that the scene names by
 * relative names begin in another way than a path from / on. Read the scene under this name.
 * Allocated; NULL: no memory. */
char *marked_name(const char *scene, struct error *err);

/* ---- drawing.c: a drawn scene, whose light and detector can be changed ---- */

/* Draws the plan's picture by the reference and writes a page of it. The plan's lights are
 * exchangeable (plan_options). */
bool viewer_write(struct viewing *view, struct error *err);
/* Write the data of such a page alone, for a live page. First its description as JSON: spectra,
 * lights, objects, detectors. Then its planes: the length of their shape as JSON in 11 digits and a
 * line's end; this JSON; float planes of weights and textures; 16-bit surfaces. */
bool description_write(struct viewing *view, struct error *err);
bool weights_write(struct viewing *view, struct error *err);

/* Writes the picture that the page shows first. */
bool still_write(struct viewing *view, struct error *err);

/* ---- stack_page.c: a stack in a page ---- */

/* A stack as a page shows it: means of factor x factor pixels. */
struct stack_page {
    const struct options *options; /* detector and display are those that the page shows first */
    double budget_bytes;           /* of samples, as text of the page, before they are compressed */
    /* The findings. */
    struct stack_rows rows; /* those of one row of the page at a time */
    int factor, width, height;
    bool counts; /* samples are 16-bit counts; otherwise floats */
    size_t n_pixels;
    void *samples;     /* [page][pixel]: uint16_t or float; owned */
    double n_bytes;    /* of the samples */
    uint16_t *objects; /* the object of each pixel, from 1; owned; NULL: none is recorded */
    size_t bytes;      /* of the page */
};
/* Writes the page of a stack, the operand, or of any cube that cube_open reads, to the options'
 * output. Samples of TIFF files of whole numbers stay counts, all others floats. alone: writes the
 * data alone, for a page that has opened the stack. The caller frees *of, also after a failure. */
bool stack_page_write(struct stack_page *of, struct options *options, bool alone,
                      struct error *err);
void stack_page_free(struct stack_page *of);

enum { LARGEST_SAMPLE = UINT16_MAX }; /* of a plane */

/* Writes the differences between neighbours, all low bytes before all high bytes: 2 n bytes. Small
 * and similar numbers compress well. */
void put_differences(const uint16_t *samples, size_t n, unsigned char *out);
/* ---- description.c: what a page knows beside its pixels ---- */

/* Describes a scene as JSON, allocated: its spectra, lights, objects, detectors, ... NULL: see err.
 */
char *description_make(const struct viewing *view, struct error *err);
/* Puts all detectors that can see the pages of a cube, the chosen one first, if the options name
 * one; for a stack also their responses to the white and to a radiance of 1. Then come all
 * adaptations and all displays, that of the options last. Fails, see *err, where memory runs out,
 * and where the detector or the display of the options is refused. */
void put_eyes(const struct cube *cube, bool is_stack, const struct options *options,
              struct json *json, struct error *err);

/* drawing.c. Puts the head of data: the length of a description in 11 digits, a line's end, and the
 * description, filled up with blanks so that numbers can follow. Frees the description. */
void put_head(struct printed *to, char *json);

/* ---- viewer.c: a page from its parts ---- */

/* Put an element of a page's data: a text in JSON, which it frees; bytes, deflated (RFC 1950), in
 * base64 (RFC 4648). A text that is NULL, or a failure to pack, leaves *err: then no page is
 * written.
 */
void put_json(struct printed *to, const char *id, char *json);
void put_packed(struct printed *to, const char *id, const void *bytes, size_t length,
                struct error *err);
enum page_kind { PAGE_STILL, PAGE_STACK, PAGE_LIVE, PAGE_VERIFIER };
struct page_parts {
    enum page_kind kind;
    struct printed data;  /* elements that put_json and put_packed make */
    struct printed first; /* a PNG that the page shows while it starts; empty: none */
    int width, height;    /* of that */
};
/* Writes a page of these parts, which it frees, to the options' output, unless *err has a failure
 * already. */
bool page_write(struct page_parts *parts, struct options *options, size_t *bytes,
                struct error *err);
/* drawing.c. Draws the picture that the page of a scene shows first: see develop_scene. */
bool put_first(struct viewing *view, struct page_parts *to, struct error *err);

#endif
