/* SPDX-License-Identifier: MIT */
/* Pixels that another program drew, as a renderer: a folder with the colours of each pass and
 * perhaps numbers of triangles and depths, or a TIFF of float pages with colours only. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "data/images/images.h"
#include "raster/beside/verify/inside.h"
#include "raster/bounds/bounds.h"
#include "raster/counts/counts.h"
#include "raster/reference/reference.h"

enum { MOST_BUFFERS = 16 };
struct drawn {
    struct renderer renderer; /* the first member */
    const struct plan *plan;
    const char *folder;   /* NULL: the pixels are those of the image */
    char path[4096 + 32]; /* of drawn.txt */
    struct drawn_words words;
    struct image image;
    float *buffers[MOST_BUFFERS];
    float *numbers;   /* 4 floats a pixel; NULL: there are none */
    uint32_t *depths; /* NULL: there are none */
};

static size_t count_pixels(const struct plan *plan)
{
    return (size_t)plan->view.width * (size_t)plan->view.height;
}

/* ---- a folder ---- */

/* Reads a file with n numbers of each pixel; *out stays NULL where it is missing.
 */
static bool read_optional(const struct drawn *of, const char *name, size_t n, void **out,
                          struct error *err)
{
    const size_t length = count_pixels(of->plan) * n * 4;
    char *bytes;
    bool found = false;
    const bool done = MAKE_ARRAY(bytes, length, err, "%s", name) &&
                      drawn_read_file(of->folder, name, length, bytes, &found, err);
    *out = found && done ? bytes : NULL;
    if (!*out)
        free(bytes);
    return done;
}

/* Refuses the pixels of another scene. */
static bool drawn_take_scene(struct renderer *renderer, const struct lit_scene *lit,
                             struct error *err)
{
    const struct drawn *of = (struct drawn *)renderer;
    char id[DIGEST_TEXT];
    double full_scale;
    bool clips;
    if (!of->folder)
        return true;
    return find_full_scale(lit, &full_scale, &clips, err) &&
           scene_describe(of->plan, full_scale, NULL, id, err) &&
           (strcmp(id, of->words.id) == 0 ||
            error_at(err, of->words.place,
                     "these pixels were drawn of another scene: expected id %s, found %s (give "
                     "judge the scene and the options of export)",
                     id, of->words.id));
}

static bool draw_folder(const struct drawn *of, float *out, int first_band, struct error *err)
{
    char name[FILE_NAME];
    snprintf(name, sizeof name, "colours-%d.bin", first_band);
    return drawn_read_file(of->folder, name, count_pixels(of->plan) * 4 * sizeof *out, out, NULL,
                           err);
}

/* ---- a TIFF ---- */

/* Refuses a picture of another size, other bands, or counts. */
static bool check_image(const struct drawn *of, struct error *err)
{
    const struct image *image = &of->image;
    const struct plan *plan = of->plan;
    const struct place place = {image->path, 0, 0};
    if (plan->scene->positions > 1)
        return error_at(err, place,
                        "a TIFF has no positions within pixels; judge --samples from a "
                        "folder");
    if (image->width != plan->view.width || image->height != plan->view.height)
        return error_at(err, place, "expected %d x %d pixels, found %d x %d", plan->view.width,
                        plan->view.height, image->width, image->height);
    if (!image_is_float(image))
        return error_at(err, place, "expected pages of 32-bit floats, found counts");
    if (image->n_pages != plan->n_bands)
        return error_at(err, place, "expected %d pages, found %d", plan->n_bands, image->n_pages);
    for (int i = 0; i < plan->n_bands && image->wavelengths_nm && !has_components(plan); i++)
        if (image->wavelengths_nm[i] != plan->scene->wavelengths_nm[i])
            return error_at(err, place, "page %d: expected %.10g nm, found %.10g nm", i + 1,
                            plan->scene->wavelengths_nm[i], image->wavelengths_nm[i]);
    return true;
}

/* Radiances become parts of full scale. A power of two makes this exact. */
static bool draw_image(struct drawn *of, float *out, int first_band, double full_scale,
                       struct error *err)
{
    const size_t n = count_pixels(of->plan);
    int exponent;
    float *page;
    bool done = MAKE_ARRAY(page, n, err, "a page of %s", of->image.path);
    if (done && frexp(full_scale, &exponent) != 0.5)
        done = error_usage(err,
                           "the radiances of a TIFF need a full scale that is a power of two, "
                           "by which they are divided without rounding; add --full-scale %g",
                           ldexp(1, exponent));
    memset(out, 0, n * 4 * sizeof *out);
    for (int c = 0; c < BANDS_PER_PASS && first_band + c < of->plan->n_bands && done; c++) {
        done = image_read(&of->image, first_band + c, 0, of->plan->view.height, page, err);
        for (size_t i = 0; i < n && done; i++)
            out[4 * i + (size_t)c] = (float)((double)page[i] / full_scale);
    }
    free(page);
    return done;
}

/* ---- the renderer ---- */

static void drawn_aim(struct renderer *renderer, const struct rectangle *tile)
{
    (void)renderer, (void)tile; /* there is one */
}

static bool drawn_draw(struct renderer *renderer, int buffer, int first_band, double full_scale,
                       struct error *err)
{
    struct drawn *of = (struct drawn *)renderer;
    return of->folder ? draw_folder(of, of->buffers[buffer], first_band, err)
                      : draw_image(of, of->buffers[buffer], first_band, full_scale, err);
}

static const float *drawn_pixels(const struct renderer *renderer, int buffer)
{
    return ((const struct drawn *)renderer)->buffers[buffer];
}

static bool drawn_identify(struct renderer *renderer, struct error *err)
{
    (void)renderer, (void)err; /* read already */
    return true;
}

static struct shown drawn_shown(const struct renderer *renderer, int x, int y)
{
    static const float background[3];
    const struct drawn *of = (const struct drawn *)renderer;
    const size_t at = (size_t)y * (size_t)of->plan->view.width + (size_t)x;
    return shown_of(of->plan->n_instances, of->numbers ? of->numbers + 4 * at : background,
                    of->depths ? of->depths[at] : 0);
}

static void drawn_close(struct renderer *renderer)
{
    struct drawn *of = (struct drawn *)renderer;
    for (int i = 0; i < MOST_BUFFERS; i++)
        free(of->buffers[i]);
    FREE_ALL(of->numbers, of->depths);
    image_close(&of->image);
    free(of);
}

/* ---- opening ---- */

static bool open_folder(struct drawn *of, struct error *err)
{
    void *numbers = NULL, *depths = NULL;
    snprintf(of->path, sizeof of->path, "%.4095s/drawn.txt", of->folder);
    const bool done = drawn_read_words(of->path, &of->words, err) &&
                      read_optional(of, "numbers.bin", 4, &numbers, err) &&
                      read_optional(of, "depths.bin", 1, &depths, err);
    of->numbers = numbers;
    of->depths = depths;
    of->renderer.names = of->words.names;
    return done;
}

static bool open_pixels(struct drawn *of, const struct drawn_names *names, struct error *err)
{
    struct stat status;
    if (stat(names->pixels, &status) == 0 && S_ISDIR(status.st_mode)) {
        of->folder = names->pixels;
        return open_folder(of, err);
    }
    return image_open(names->pixels, (struct place){NULL, 0, 0}, tags_read, &of->image, err) &&
           check_image(of, err);
}

static void complete_names(struct renderer_names *names)
{
    snprintf(names->library, sizeof names->library, "another program");
    if (!names->renderer[0])
        snprintf(names->renderer, sizeof names->renderer, "an unnamed renderer");
    if (!names->version[0])
        snprintf(names->version, sizeof names->version, "unknown version");
}

static bool allocate(struct drawn *of, int n_buffers, struct error *err)
{
    const struct plan *plan = of->plan;
    if (plan->tiled)
        return error_usage(err,
                           "the pixels of another program are judged in one piece, of at most "
                           "%d x %d pixels here; choose a smaller --size",
                           plan->tile_width, plan->tile_height);
    for (int i = 0; i < n_buffers; i++)
        if (!MAKE_ARRAY(of->buffers[i], 4 * count_pixels(plan), err, "the pixels of a pass"))
            return false;
    return true;
}

bool drawn_open(const struct drawn_names *names, const struct plan *plan, int n_buffers,
                struct renderer **out, struct error *err)
{
    static const struct renderer_kind kind = {.take_scene = drawn_take_scene,
                                              .aim = drawn_aim,
                                              .draw = drawn_draw,
                                              .pixels = drawn_pixels,
                                              .identify = drawn_identify,
                                              .shown = drawn_shown,
                                              .close = drawn_close};
    struct drawn *of;
    *out = NULL;
    if (!MAKE_ARRAY(of, 1, err, "the pixels of another program"))
        return false;
    *out = &of->renderer;
    of->renderer.kind = &kind;
    of->plan = plan;
    if (!allocate(of, n_buffers, err) || !open_pixels(of, names, err))
        return false;
    complete_names(&of->renderer.names);
    of->renderer.driver = *driver_of(names->driver ? names->driver : of->renderer.names.renderer);
    of->renderer.lacks = (struct renderer_lacks){!of->numbers, !of->depths};
    return true;
}
