/* SPDX-License-Identifier: MIT */
/* Only the files of the room "view" include this. */
#ifndef RASTER_BESIDE_VIEW_INSIDE_H
#define RASTER_BESIDE_VIEW_INSIDE_H

#include "data/base/base.h"
#include "data/files/files.h"
#include "data/scene/scene.h"
#include "data/stack/stack.h"
#include "raster/beside/view/view.h"
#include "raster/plan/plan.h"
#include "raster/render/render.h"

struct view_options {
    const char *budget;
    bool still, gallery;
};

/* ---- live.c: a page that draws the scene itself ---- */

/* Returns whether this program holds itself for browsers: ./build.sh live makes such a one. Only it
 * writes live pages. */
bool has_live_pages(void);

struct viewer_result {
    size_t bytes;
    int n_illuminants, n_detectors; /* 0: a live page finds them */
};
/* Writes a page that holds this program and all files of the scene, to the options' output. The
 * scene was read under marked_name. Makes the notes on the scene. On failure no file has been
 * created or changed. The caller frees *notes, here and below, also after a failure. */
bool live_write(const struct plan *plan, struct options *options, struct viewer_result *out,
                struct notes *notes, struct error *err);

/* ---- drawing.c: a drawn scene, whose light and detector can be changed ---- */

/* Draws the plan's picture by the reference and writes a page of it. The plan's lights are
 * exchangeable (plan_options). outputs get the page: see output_pass. Refuses pictures and scenes
 * that are too large for a page. */
bool viewer_write(const struct plan *plan, const char *path, struct viewer_result *out,
                  struct notes *notes, struct outputs *outputs, struct error *err);
/* Write the data of such a page alone, for a live page. First its description as JSON: spectra,
 * lights, objects, detectors. Then its planes: the length of their shape as JSON in 11 digits and a
 * line's end; this JSON; float planes of weights and textures; 16-bit surfaces. */
bool description_write(const struct plan *plan, const char *path, struct outputs *outputs,
                       struct error *err);
bool weights_write(const struct plan *plan, const char *path, struct outputs *outputs,
                   struct error *err);

/* ---- stack.c: a stack in a page ---- */

struct stack_result {
    size_t bytes;
    int width, height, n_bands, factor; /* of the stack; the page shows means of factor x factor */
};
struct stack_page_options {
    double budget_bytes; /* of samples, as text of the page, before they are compressed */
    bool alone;          /* write the data alone, for a page that has opened the stack */
};
/* Writes a page of a stack, or of any cube that cube_open reads. Samples of TIFF files of whole
 * numbers stay counts, all others floats. outputs get it: see output_pass. */
bool stack_page_write(const char *stack, const char *path, const struct stack_page_options *options,
                      struct stack_result *out, struct outputs *outputs, struct error *err);

/* ---- still.c: the picture that the page shows first ---- */

/* Draws the plan's picture by the reference, as cie1931 sees it without adaptation on an sRGB
 * display at exposure 1, and writes it as PNG. *out_of_gamut is the number of pixels with a clipped
 * channel. Makes the notes on the scene. Memory does not grow with the picture's height. On failure
 * no file has been created or changed. */
bool still_write(const struct plan *plan, const char *path, uint64_t *out_of_gamut,
                 struct notes *notes, struct outputs *outputs, struct error *err);

/* The largest sample of a plane, and the most pixels: browsers refuse longer texts and larger
 * canvases. */
enum { LARGEST_SAMPLE = 65535, LARGEST_PAGE = 1 << 24 };

/* Planes of one value a position, and a pixel may have several: the weight of the constant
 * term, then the diffuse and the specular weight of each light, then the values of spectral
 * textures at their own wavelengths. Materials share the planes: a position shows one material. */
struct planes {
    size_t n_positions;
    int n_weights, n_pages; /* planes of weights, and of textures */
    uint16_t *surface;      /* from 1; 0: background */
    float *values;          /* [plane][position] */
    double *place[2]; /* of each position in its spectral texture, in texels; NULL: there is none */
};

/* ---- files.c: the files of a scene, as seen from its folder ---- */

/* A file that is not built in. */
struct page_file {
    char *name; /* relative to the scene's folder, without "." and ".."; owned */
    const char *path;
};
struct page_files {
    struct page_file *list; /* the first one is the scene's; owned */
    int n;
    struct index places;  /* in the list, by name */
    struct inputs inputs; /* own the paths of files that are no texts of the scene */
    char *above;          /* how the paths of files in that folder begin: "" or "scenes/"; owned */
};
/* Returns the scene's name with a mark, so that the paths of all files that the scene names by
 * relative names begin in another way than a path from / on. Read the scene under this name.
 * Allocated; NULL: no memory. */
char *marked_name(const char *scene);
/* Lists the texts of a scene and the files that it names. The scene must outlive *out. Refuses a
 * file outside of the scene's folder. The caller frees *out, also after a failure. */
bool page_files_make(const struct scene *scene, struct page_files *out, struct error *err);
void page_files_free(struct page_files *files);

/* Refuses pictures and scenes that are too large for a page: more than LARGEST_PAGE pixels, or
 * LARGEST_SAMPLE instances. */
bool page_allows(const struct plan *plan, struct error *err);
/* Draws the planes by the reference. notes NULL: makes none. Refuses what page_allows refuses. The
 * caller frees *out and *notes, also after a failure. */
bool planes_rasterize(const struct plan *plan, struct planes *out, struct notes *notes,
                      struct error *err);
/* Writes the differences between neighbours, all low bytes before all high bytes: 2 n bytes. Small
 * and similar numbers compress well. */
void put_differences(const uint16_t *samples, size_t n, unsigned char *out);
/* Returns the value of sample 1 of a plane, so that the plane's largest value is LARGEST_SAMPLE. */
double plane_scale(const struct planes *planes, int plane);
/* Returns the surfaces, then all planes in units of their scales, as 16-bit samples: see
 * put_differences. Allocated; NULL: no memory. */
unsigned char *planes_bytes(const struct planes *planes, const double *scale, size_t *length,
                            struct error *err);
void planes_free(struct planes *planes);

/* description.c. Describes a scene as JSON, allocated: its spectra, lights, objects, detectors, ...
 * Counts illuminants and detectors in *result. NULL: see err. */
char *description_make(const struct plan *plan, struct viewer_result *result, struct error *err);

void json_rows(struct json *json, const char *key, const double *rows,
               int n); /* three of n numbers */
void put_adaptations(struct json *json);
void put_displays(struct json *json);

/* drawing.c. Puts the head of data: the length of a description in 11 digits, a line's end, and the
 * description, filled up with blanks so that numbers can follow. */
void put_head(struct printed *to, const char *json);

/* viewer.c: a page from its parts. Put an element of its data: a text in JSON, or bytes in base64
 * (RFC 4648); put_packed deflates them before (RFC 1950). */
void put_json(struct printed *to, const char *id, const char *json);
void put_base64(struct printed *to, const char *id, const unsigned char *bytes, size_t length);
bool put_packed(struct printed *to, const char *id, const void *bytes, size_t length,
                struct error *err);
void put_module(struct printed *to); /* live.c: if this has_live_pages */
enum page_kind { PAGE_STILL, PAGE_STACK, PAGE_LIVE };
/* Writes a page with these data, which it ends. outputs get it: see output_pass. */
bool page_write(enum page_kind kind, struct printed *data, const char *path, size_t *bytes,
                struct outputs *outputs, struct error *err);

#endif
