/* SPDX-License-Identifier: MIT */
/* What the files of raster/ share: plan, reference, OpenGL, verdict, reports. */
#ifndef RASTER_H
#define RASTER_H

#include "data/base/base.h"
#include "data/chart/chart.h"
#include "data/colour/colour.h"
#include "data/compare/compare.h"
#include "data/develop/develop.h"
#include "data/material/material.h"
#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "data/pages/pages.h"
#include "data/probe/probe.h"
#include "data/record/record.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/spectra/spectra.h"
#include "data/stack/stack.h"
#include "data/text/text.h"
#include "data/tiff/tiff.h"
#include "spectral.h"

/* ---- raster/plan.c: what a scene calls for, decided once ---- */

enum { LIGHTS_PER_PASS = 8, BANDS_PER_PASS = TEXTURE_PLANES };

/* Radiance at a point is a sum over terms of weight(point) x spectrum(wavelength) (local
 * illumination is linear), times the texture there: weights depend on geometry only, spectra on
 * light and material. */
enum term_kind {
    TERM_CONSTANT, /* ambient light and emission; its weight is 1 */
    TERM_DIFFUSE,
    TERM_SPECULAR
};
struct term {
    enum term_kind kind;
    int light;   /* index into plan.lights of the first light of its spectrum; -1: none */
    double peak; /* the largest value of its own spectrum */
};
/* A material under the lights of the scene. Lights of one spectrum share their terms, and terms
 * whose spectrum is 0 in all bands are left out. */
struct finish {
    const struct material *material;
    struct texture *texture; /* NULL: none */
    int n_terms, n_colours;  /* colours: those that OpenGL adds up, a term's one for each light */
    struct term *terms;
    double *spectra; /* n_terms rows of n_bands radiances */
    bool ambient, emits, fluoresces;
};

/* A mesh, or a part of one, that is drawn: re-centred and brought to a common size, so that single
 * precision spends its digits on the shape and not on where it stands. */
struct plan_mesh {
    struct mesh mesh;
    struct vector centre; /* of the whole mesh */
    double unit;          /* what its lengths are measured in: a power of two, about its size */
    bool textured;        /* some body of it is */
};
/* An object, or a part of one, as it will be drawn: transform and camera composed in double. */
struct body {
    const struct object *object;
    int mesh, finish; /* indices into the plan */
    bool mirrored;    /* the transform turns outsides clockwise */
    bool twin;        /* an earlier body is the same in the same place, and hides it */
    struct matrix model_view;
    struct matrix normal_matrix;
};
struct plan_light {
    const struct light *light;
    struct vector eye_position; /* for a directional light the unit vector towards it */
    struct vector eye_spot;     /* unit vector along the axis of a spot */
    double spot_cosine;         /* of the cutoff */
    bool attenuated, spot;      /* whether the distance counts; whether it is a spot */
    double attenuation[3];      /* of a distance in eye space */
    int first;                  /* light of the same spectrum; perhaps this one */
    double share;               /* of this light's radiation in that one's */
};
struct plan_effect {
    const char *name;
    bool used;
    char reason[160];
};
enum { MAX_EFFECTS = 18 };
/* Counted where it is done. */
struct plan_work {
    long materials_loaded, textures_loaded, excitation_integrals, terms;
};

struct plan_options {
    double full_scale;  /* 0: the largest vertex radiance */
    bool check, use_gl; /* whether the reference and OpenGL are needed */
    int buffer_bits;    /* of a channel of OpenGL's colour buffer: 8, 16, or 32 of floats; 0: 32 */
    const char *gl_driver; /* "llvmpipe" or "softpipe"; NULL: whatever there is */
    bool strict;           /* pixels without a bound, and edges that leak, are differences */
    bool store_raster;     /* the stored pixels are the reference's */
    int bits;              /* of a page's sample: 8 or 16 of counts, 32 of floats; 0: 16 */
    bool exchangeable; /* lights may be exchanged afterwards: every light and every term is kept,
                          each by itself, also what is dark */
    int threads;       /* 0: as many as OpenMP offers; the plan holds the number */
    char *const *recorded; /* options for the stack's record, each one word; not owned */
    int n_recorded;        /* at most MAX_RECORD_OPTIONS */
};
struct plan {
    const struct scene *scene;
    struct plan_options options;
    int n_bands, n_passes; /* n_passes: groups of bands */
    double unit; /* of lengths in eye space: a power of two, 1/1024 of the picture's size */
    double near; /* distance of the near plane, in that unit */
    bool tiled;  /* there is more than one tile */
    struct matrix view, projection;
    struct plan_mesh *meshes;
    struct finish *finishes;
    struct texture *textures;
    struct body *bodies;
    struct plan_light *lights; /* those that shine */
    int n_meshes, n_finishes, n_textures, n_bodies, n_lights;
    int n_light_groups; /* passes that a group of bands takes: 1, or more beyond LIGHTS_PER_PASS */
    int max_rows;       /* largest finish_rows of a finish */
    int tile_width, tile_height; /* the last column and row of tiles may be smaller */
    uint64_t file_bytes, tile_bytes;
    int map_bytes; /* of a number in the object map; 0: there is none */
    struct plan_effect effects[MAX_EFFECTS];
    int n_effects;
    struct plan_work work;
    long n_vertices, n_triangles; /* as drawn: a mesh counts once for every body */
};
/* Reads meshes and textures, composes matrices, multiplies spectra; draws nothing. Refuses, at its
 * place, what cannot be drawn. The scene must outlive the plan. */
bool plan_make(const struct scene *scene, const struct plan_options *options, struct plan *out,
               struct error *err);
/* A part of the picture, such as OpenGL draws at once; in pixels from the top left. */
struct tile {
    int x, y, width, height;
};
/* A region is drawn in so many tiles of the plan's size or smaller, row by row. */
struct tile plan_picture(const struct plan *plan); /* the whole picture */
int plan_tiles(const struct plan *plan, const struct tile *region);
struct tile plan_tile(const struct plan *plan, const struct tile *region, int index);
/* Numbers that a pixel of this finish keeps: a weight for each term, and where its texture differs
 * from band to band the place in it (u and v, in texels). */
int finish_rows(const struct finish *finish);
/* What a finish of the plan fluoresces in each of its bands, under a light of intensity 1 that
 * shines on it squarely. */
bool finish_luminescence(const struct plan *plan, const struct finish *finish,
                         const struct spectrum *light, double *out, struct error *err);
/* Loads what spectral textures show in the bands of a pass. */
bool plan_load_textures(const struct plan *plan, int first_band, struct error *err);
void plan_free(struct plan *plan);

/* ---- raster/products.c: the spectra that a scene's pixels are made of ---- */

/* Spectra of all lights and of every term of every material that an object uses, at every nm of the
 * scene's range. Opens no mesh and no texture. */
bool scene_spectra(const struct scene *scene, struct fine_spectra *out, struct error *err);
/* Samples the scene by a method from now on: sets its sampling and wavelengths. Refuses what
 * sampling_make refuses, and spectral textures under basis, rgb and xyz. */
bool scene_sample(struct scene *scene, const struct sampling_method *method, const char *detector,
                  struct error *err);

/* ---- raster/effects.c: the plan in words ---- */

/* Fills the plan's effects, each with the reason why it is simulated or not. */
void plan_effects(struct plan *plan);
void plan_print(const struct plan *plan, FILE *to);

/* ---- raster/driver.c: what is known of OpenGL's implementations ---- */

/* Whose the pixels are whose centres lie exactly on an edge. */
enum fill_rule { FILL_ANY, FILL_LEFT_BOTTOM };
struct driver {
    const char *name; /* what GL_RENDERER begins with; "unknown": the worst of all others */
    double grid_px;   /* corners are moved to a grid before edges are followed: by up to this */
    double edge_roundings;  /* of the largest window coordinate, while an edge is followed */
    double depth_roundings; /* of a depth of 1, while it is stored: half is a step of 24 bits */
    bool watertight;        /* a pixel where triangles meet belongs to exactly one of them */
    enum fill_rule fill_rule;
};
/* NULL stands for an unknown one. */
const struct driver *driver_of(const char *gl_renderer);

/* ---- raster/exact.c: where single precision makes no error ---- */

/* Whether a sum of terms is exact in single precision in whatever order it is made: all are
 * multiples of a power of two, and the sum of their magnitudes is at most 2^24 times that. */
bool exact_sum(const double *terms, int n);
/* Whether single precision holds both matrices, and their product without any rounding. */
bool exact_product(const struct matrix *a, const struct matrix *b);
/* Whether a row of a matrix times a vector is exact in single precision. */
bool exact_row(const double row[4], const double v[4]);

/* ---- raster/surface.c: the reference's vertices, and how far GL may be off there ---- */

enum { CLIP_XY, CLIP_Z, CLIP_W };
/* Window coordinates of a vertex in double, with bounds on OpenGL's single-precision error. */
struct lit_vertex {
    double clip[4]; /* homogeneous clip coordinates */
    double x, y, z; /* window, valid if w > 0: pixels from the top left, depth 0..1 */
    double inverse_w;
    float slack_px;    /* bound on GL's error in x and in y, before it snaps to its grid */
    float slack_depth; /* bound on GL's error in z */
    float slack_w;     /* relative bound on GL's error in w */
    float e_clip[3];   /* bounds on GL's errors in clip coordinates: CLIP_XY, CLIP_Z, CLIP_W */
    bool exact;        /* GL makes no error in x and y, and they lie on a grid of 1/256 pixel */
};
struct surface {
    const struct driver *driver;
    const struct body *body;
    const struct mesh *mesh;
    const struct finish *finish;
    struct lit_vertex *vertices;
    int n_sides;                     /* 2: the back is lit by its own normals */
    int n_attributes;                /* terms, and s and t where there is a texture */
    double *weights;                 /* [vertex][side][attribute] */
    float *errors;                   /* the same: bound on |GL's attribute - attribute| */
    double left, top, right, bottom; /* window bounds; everything where a vertex is not in front */
};
struct light_work {
    long vertices_lit, points_lit; /* phong shading lights points, one a pixel, and no vertices */
    long specular_vertices, power_functions;
};
/* One surface per body, in drawing order; *out is allocated. Refuses NaN and infinity by object. */
bool surfaces_light(const struct plan *plan, const struct driver *driver, struct surface **out,
                    struct light_work *work, struct error *err);
/* The full scale that is asked for, or the largest vertex radiance over all surfaces and
 * wavelengths; not below 2^-100 of the light, which would be too much for single precision beside
 * it, and 1 for an all-black scene. Refuses radiances that are not finite, by object.
 *
 * Phong shading may be brighter between vertices: there it is an upper bound, with every surface
 * turned squarely to every light, in the middle of its highlight, and as near as it comes to it. A
 * light that a surface touches, and that has no constant attenuation, has none: refused, unless a
 * full scale is asked for.
 *
 * `clips` tells that a vertex is brighter than the full scale. */
bool surfaces_full_scale(const struct plan *plan, const struct surface *surfaces, double *out,
                         bool *clips, struct error *err);
/* Where the attributes of a vertex begin in weights and errors. */
size_t surface_attributes(const struct surface *surface, int vertex, int side);
/* False where nothing of the surface can be in the tile. */
bool surface_reaches(const struct surface *surface, const struct tile *tile);
void surfaces_free(const struct plan *plan, struct surface *surfaces);

/* ---- raster/texel.c: a texture at a point ---- */

/* In texels from the lower left corner of the texture, which repeats without end; with bounds on
 * OpenGL's error. */
struct texel_point {
    double u, v;
    float e_u, e_v;
};
/* Of texture coordinates and their bounds. */
struct texel_point texel_point(const struct texture *texture, double s, double t, float e_s,
                               float e_t);
/* The places that OpenGL may take for this one: the nearest texels, if several lie within the
 * bounds, each at its centre without error; otherwise the place itself. Returns how many. */
enum { TEXEL_CHOICES = 4 };
int texel_choices(const struct texture *texture, struct texel_point at,
                  struct texel_point out[TEXEL_CHOICES]);
/* The value of a plane there, and a bound on OpenGL's error unless error is NULL. */
double texel_value(const struct texture *texture, int plane, struct texel_point at, double *error);

/* ---- raster/gouraud.c: coverage, visibility and interpolation in double ---- */

/* A surface that may be what OpenGL shows at a pixel. */
struct candidate {
    int32_t surface, triangle;
    float depth, depth_error;
    bool loose;   /* its error has no bound here */
    size_t first; /* of its finish_rows numbers in candidate_weights and candidate_errors */
};
/* How many fragments OpenGL may draw at a pixel, hidden ones too; modulo 256, as it counts them. */
struct overdraw {
    uint8_t least, spread; /* least .. least + spread; a spread of 255 or more is kept as 255 */
    uint8_t meant;         /* by the reference */
    bool closed;           /* an edge near the centre always has a triangle on either side */
};
/* A pixel with more than one candidate, or a loose one. */
struct contest {
    int32_t pixel;        /* within the chunk, row by row */
    int32_t first, count; /* candidates */
    bool background;      /* whether nothing at all may be there as well */
};
/* Some rows of a tile, the unit of work of a thread. */
struct chunk {
    struct tile rows;
    int32_t *surface, *triangle; /* of the reference's own fragment; -1: background */
    float *depth, *depth_error;  /* of the same; NULL without a check, as all bounds */
    struct overdraw *overdraw;
    float *steepness; /* bound on how radiance changes within a pixel's width, in any wavelength */
    bool *contested;
    struct light_work work; /* of phong shading */
    double *weights;        /* [max_rows][pixel], of a grey texture's value the product with it */
    float *errors;          /* the same: bounds on OpenGL's error */
    struct contest *contests;
    struct candidate *candidates;
    double *candidate_weights;
    float *candidate_errors;
    size_t n_contests, n_candidates, n_numbers;
};
enum { CHUNK_ROWS = 16 };
int chunk_count(const struct tile *tile);
/* Does `work` of each chunk of a tile, by so many threads; fails with the first that fails. */
bool chunks_each(const struct tile *tile, int threads,
                 bool (*work)(void *context, const struct tile *tile, int index, struct error *err),
                 void *context, struct error *err);
/* The rows of a tile's chunk: CHUNK_ROWS of them, fewer in the last one. */
struct tile chunk_rows(const struct tile *tile, int index);
/* Rasterizes a chunk. Results do not depend on how a picture is cut into chunks. */
bool chunk_rasterize(const struct plan *plan, const struct surface *surfaces,
                     const struct tile *tile, int index, struct chunk *out, struct error *err);
void chunk_free(struct chunk *chunk);

/* ---- raster/mesa.c: the same picture through OSMesa ---- */

struct gl;
struct gl_work {
    long passes, draw_calls;
};
/* Uploads the geometry once. EXIT_SYSTEM when there is no usable OpenGL. */
bool gl_open(const struct plan *plan, struct gl **out, struct error *err);
const char *gl_renderer(const struct gl *gl);
const char *gl_version(const struct gl *gl);
/* Aims at a tile of the picture; surfaces that do not reach it will not be drawn. */
void gl_aim(struct gl *gl, const struct surface *surfaces, const struct tile *tile);
/* Draws bands first .. first + BANDS_PER_PASS - 1 (those that exist) of the aimed tile, radiances
 * divided by full_scale, and brought by a colour buffer of counts to the nearest one. Returns 4
 * floats a pixel, row by row from the top, rows of tile_width. */
bool gl_draw(struct gl *gl, int first_band, double full_scale, const float **pixels,
             struct error *err);
/* False in a program without OpenGL, of which no picture can be asked. */
bool gl_is_built(void);
/* Name, version and driver of the OSMesa in use. */
void gl_library(char *out, size_t capacity);
struct gl_work gl_work(const struct gl *gl);
void gl_close(struct gl *gl);

/* ---- raster/identify.c: which triangle OpenGL shows ---- */

/* What OpenGL shows at a pixel. */
struct shown {
    int32_t surface, triangle; /* -1: background */
    uint32_t depth;            /* in steps of 1 / (2^24 - 1) */
    uint8_t fragments;         /* drawn there, hidden ones too, modulo 256 */
};
/* Draws the numbers of surfaces and triangles of the aimed tile instead of their colours. */
bool gl_identify(struct gl *gl, struct error *err);
/* Of the last gl_identify, before the next gl_draw; x and y within the tile. */
struct shown gl_shown(const struct gl *gl, int x, int y);

/* ---- raster/tally.c: how samples compare ---- */

/* How samples compare with the candidate that explains them; in counts, before rounding. */
struct check_samples {
    uint64_t n, exact, within_1;
    double largest;             /* |OpenGL - reference| */
    double sum, sum_of_squares; /* of OpenGL - reference */
    double worst_ratio;         /* largest |OpenGL - reference| / bound */
};
/* The detectability floor: of each pixel of a surface the largest bound over all wavelengths, in
 * counts. An error of twice that is always seen, one below the bound may be not. */
enum { FLOOR_BINS = 320 };
struct check_floor {
    uint64_t n, bins[FLOOR_BINS];
    double worst;
};
/* What `part` of the pixels have at most; too high by an eighth at most. */
double floor_quantile(const struct check_floor *of, double part);

enum failure_kind {
    FAILURE_RADIANCE,
    FAILURE_TRIANGLE,
    FAILURE_DEPTH,
    FAILURE_FRAGMENTS,
    FAILURE_UNBOUNDED
};
/* The first pixel that no candidate explains. */
struct check_failure {
    bool found;
    enum failure_kind kind;
    int x, y;
    int surface;                  /* the reference's; -1: background */
    struct shown shown;           /* FAILURE_TRIANGLE: what OpenGL shows */
    int band;                     /* FAILURE_RADIANCE */
    double seen, expected, bound; /* counts; depths; fragments */
};
/* A pixel inside a surface is smooth if its radiance changes by no more than this within a pixel's
 * width, in any wavelength: one step of a picture of 8 bits. */
enum { SMOOTH_COUNTS = 256 };
struct check_tally {
    struct check_samples samples;
    uint64_t pixels, ambiguous, unexplained, unbounded;
    /* pixels where triangles meet, with too few or too many fragments */
    uint64_t edge_holes, edge_doubles;
    double worst_depth_ratio;
    struct check_floor floor, smooth_floor;
    struct check_failure first;
};

/* ---- raster/check.c: the verdict on each pixel ---- */

/* The state of a chunk while its bands go by. */
struct check {
    const struct plan *plan;
    const struct surface *surfaces;
    const struct chunk *chunk;
    double full_scale;
    bool tight_edges; /* fragments lost or doubled where triangles meet are failures */
    struct check_tally tally;
    struct check_trial *trials; /* one a candidate, then one a contest for its background */
    bool *failed;               /* pixels that are not explained */
    float *floor;               /* the largest bound of each pixel that is not contested */
};
/* Opens the check of a chunk, whose memory the check does not own. */
bool check_open(const struct plan *plan, const struct surface *surfaces, const struct chunk *chunk,
                double full_scale, struct check *out, struct error *err);
/* Judges what gl_identify drew of the tile; to be called before the first pass. */
void check_identity(struct check *check, const struct gl *gl, const struct tile *tile);
/* Judges the bands of one GL pass. `pixels` is the chunk's first pixel, 4 floats each, rows
 * `stride` pixels apart, in units of full_scale. */
void check_pass(struct check *check, int first_band, const float *pixels, size_t stride);
/* Settles contested pixels, adds the chunk's tally to *total and frees the check. */
void check_close(struct check *check, struct check_tally *total);

/* ---- raster/counts.c: radiance into counts ---- */

/* Steps of a channel of OpenGL's colour buffer, from 0 to full scale; 0: floats. */
int buffer_steps(const struct plan *plan);
/* Bound on what it rounds off a sample, in counts; 0 of floats, whose roundings are OpenGL's. */
double buffer_rounding(const struct plan *plan);
/* Samples that a file cannot hold as they are. */
struct odd_samples {
    uint64_t clipped;   /* above full_scale, stored as 65535 (or 255) */
    uint64_t undefined; /* NaN, infinite, or too large for a float page; stored as 0 */
};
/* One band of a chunk as stored: uint8_t or uint16_t counts, or float radiances, as the plan says;
 * the reference's, or those of one channel of a GL pass. Where something `clips`, what fills a
 * colour buffer of counts may have been cut off there: it is counted as clipped. */
struct odd_samples counts_of_reference(const struct plan *plan, const struct surface *surfaces,
                                       const struct chunk *chunk, int band, double full_scale,
                                       void *out);
struct odd_samples counts_of_gl(const struct plan *plan, const struct tile *rows, int channel,
                                double full_scale, bool clips, const float *pixels, size_t stride,
                                void *out);

/* ---- raster/render.c: the loop over tiles and passes ---- */

struct render_seconds {
    double read, plan, gl, raster, check, write, total;
};
struct render_result {
    double full_scale;
    bool clips; /* a vertex is brighter than that */
    char gl_renderer[128], gl_version[128];
    const struct driver *driver;
    struct gl_work gl;
    struct light_work light;
    struct check_tally check;
    struct odd_samples odd;
    struct stack_difference difference; /* from the stack that was to be made again */
    struct render_seconds seconds;
};
struct render_output {
    const char *path;  /* of the stack; NULL: none is written */
    const char *again; /* the stack that it shall be the same as, to the last byte; NULL: none */
    bool keep;         /* also what failed its check, or is not the same, is stored */
    bool discard;      /* nothing is stored: the stack is only compared with the other */
};
/* Called between passes with done of all steps. */
struct render_progress {
    void (*step)(void *context, long done, long all);
    void *context;
};
/* Seconds of a clock that only goes forward. */
double render_clock(void);
/* Renders into a stack. True also if the picture failed its check, or is not the same: the result
 * tells, and render_agreed. */
bool render(const struct plan *plan, const struct render_output *output,
            const struct render_progress *progress, struct render_result *out, struct error *err);
bool render_agreed(const struct render_result *result);
/* Whose pixels are stored: "raster", or OpenGL's GL_RENDERER. */
const char *render_stored(const struct plan *plan, const struct render_result *result);

/* ---- raster/report.c: results in words and as JSON ---- */

/* Of a page: "450 nm", or the label of a component. */
enum { PAGE_NAME = 32 };
void page_name(const struct scene *scene, int page, char out[PAGE_NAME]);
/* The name of a surface: that of its material; or "background" for -1. */
const char *object_name(const struct plan *plan, int surface);

/* The verdict in one line of ASCII, for the stack. */
void report_verdict(const struct plan *plan, const struct check_tally *tally, char *out,
                    size_t capacity);
/* Returns false with EXIT_DIFFERENT: where the pictures first differ, and `then` what follows from
 * it. */
bool report_difference(const struct plan *plan, const struct check_tally *tally, const char *then,
                       struct error *err);
/* The same for a stack made again that is not the same; `made` is how the one at `path` was made.
 */
bool report_not_again(const struct plan *plan, const struct render_result *result, const char *path,
                      const struct record *made, const char *then, struct error *err);
void report_print(const struct plan *plan, const struct render_result *result, FILE *to);
/* One JSON object, allocated; NULL: no memory. output and sha256 may be NULL. */
char *report_json(const struct plan *plan, const struct render_result *result, const char *output,
                  const char *sha256, uint64_t peak_bytes);

/* ---- raster/cost.c: what accuracy costs in time ---- */

/* How configurations are run: `words` are options of render, e.g. "--sampling=gauss:8". */
struct cost_program {
    /* Renders the scene with the words (and all that the command line said) to a stack. */
    bool (*render)(void *context, char *const *words, int n_words, const char *output,
                   struct error *err);
    /* Reads it as render would, sampled too. */
    bool (*read)(void *context, char *const *words, int n_words, struct scene *out,
                 struct error *err);
    void *context;
};
enum { COST_WORDS = 8 };
struct cost_entry {
    char name[128];
    char *words[COST_WORDS]; /* owned */
    int n_words;
    bool spectral;                     /* its pages are radiances at wavelengths */
    double seconds, fastest, slowest;  /* median and extremes of the runs: the whole render, in a
                                          process of its own */
    double mean, quantile_95, largest; /* CIEDE2000 from the reference, over all pixels in which
                                          either picture shows an object */
    double radiance_error; /* rms of the radiance's error at every nm, relative to its rms; NaN: no
                              radiances */
    bool best, uncertain;  /* on the frontier of seconds and quantile_95; within noise of that */
};
struct cost_options {
    const char *observer;
    char *const *given; /* what the command line changes of the scene, for the reader */
    int n_given;
    int runs, threads;
    void (*progress)(void *context, long done, long all); /* NULL: none */
    void *progress_context;
};
struct cost {
    char *scene, *observer; /* owned */
    int width, height, runs, n;
    struct cost_entry *entries; /* by seconds; owned */
    char **notes; /* what the scene suggests, and which configurations it has not, and why; owned */
    int n_notes;
    double reference_seconds;
};
/* Runs all configurations that make sense for the scene. */
bool cost_measure(const struct cost_program *program, const struct cost_options *options,
                  struct cost *out, struct error *err);
void cost_print(const struct cost *cost, FILE *to);
void cost_print_csv(const struct cost *cost, FILE *to);
char *cost_svg(const struct cost *cost); /* allocated; NULL: no memory */
/* The cheapest entry whose quantile_95 is within the tolerance; NULL: none is. spectral: only of
 * those whose pages are radiances. */
const struct cost_entry *cost_within(const struct cost *cost, double tolerance, bool spectral);
/* The most accurate one within the time, likewise. */
const struct cost_entry *cost_affordable(const struct cost *cost, double seconds, bool spectral);
void cost_free(struct cost *cost);

/* ---- raster/inspect.c: how a pixel's spectrum comes about ---- */

/* The reference's radiance of a region, and the curves that make it: the lights, ambient lights,
 * and, if the region shows one object, its reflectance, specular reflectance, excitation, emission,
 * and glow. The plan's picture is what x and y refer to. */
bool probe_scene(const struct plan *plan, const struct probe_options *options, struct probe *out,
                 struct error *err);

/* ---- raster/viewer.c: an interactive viewer in one HTML file ---- */

struct viewer_result {
    size_t bytes;
    int n_objects, n_lights, n_illuminants, n_detectors;
};
/* Rasterizes once and writes the page; the plan must be of exchangeable lights. */
bool viewer_write(const struct plan *plan, const char *path, struct viewer_result *out,
                  struct error *err);

#endif
