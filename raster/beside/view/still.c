/* SPDX-License-Identifier: MIT */
/* Writes the picture of a scene as a person sees it: what render --renderer raster and develop make
 * without options, but without a stack between them. Each pixel is summed in the order of the
 * bands, so that tiles and threads do not change its bits. */
#include <stdlib.h>
#include <string.h>

#include "raster/beside/view/inside.h"
#include "raster/counts/counts.h"

static const char detector_name[] = "cie1931";
enum { STILL_BITS = 8 };

struct still {
    struct plan plan; /* a copy of the caller's; samples are radiances */
    struct lit_scene lit;
    double *weights;  /* from radiances to linear RGB: [channel * n_bands + band]; owned */
    float *radiance;  /* [pixel of the tile], of a band; owned */
    double (*rgb)[3]; /* [pixel of the tile], linear; owned */
    uint8_t (*codes)[3];
    struct picture_writer picture;
    struct counter out_of_gamut; /* pixels with a clipped channel */
    /* Bands that are added to the pixels of a tile. */
    const struct tile *tile;
    int band, end;
    struct counter undefined; /* samples that are not finite */
};

/* ---- a tile ---- */

static void add_bands(void *context, int i)
{
    struct still *still = context;
    const struct picture *picture = &still->tile->chunks[i].picture;
    const int n_bands = still->plan.n_bands;
    const struct rectangle above = {0, 0, picture->at.width, i * CHUNK_ROWS},
                           before = plan_pixels(&still->plan, &above),
                           pixels = plan_pixels(&still->plan, &picture->at);
    const size_t first = (size_t)before.width * (size_t)before.height,
                 n = (size_t)pixels.width * (size_t)pixels.height;
    float *radiance = still->radiance + first;
    double(*rgb)[3] = still->rgb + first;
    uint64_t undefined = 0;
    for (int band = still->band; band < still->end; band++) {
        const struct stored_band stored = {&still->lit, band, radiance};
        undefined += store_reference(&stored, 1, picture).undefined;
        for (size_t k = 0; k < n; k++)
            for (int channel = 0; channel < 3; channel++)
                rgb[k][channel] += still->weights[channel * n_bands + band] * (double)radiance[k];
    }
    counter_add(&still->undefined, undefined);
}

/* Sums all bands of the tile. */
static bool sum_tile(struct still *still, struct error *err)
{
    const int n_bands = still->plan.n_bands;
    for (still->band = 0; still->band < n_bands; still->band = still->end) {
        still->end =
            still->band + BANDS_PER_PASS < n_bands ? still->band + BANDS_PER_PASS : n_bands;
        if (!plan_load_textures(&still->plan, still->band, err))
            return false;
        threads_each(still->plan.options.threads, still->tile->n_chunks, add_bands, still);
        if (still->undefined.n > 0)
            return error_usage(err, "%s: a radiance is not finite", still->plan.scene->path);
    }
    return true;
}

enum { BLOCK_PIXELS = 1024 }; /* that a thread takes at a time */

static void store_pixels(void *context, size_t first, size_t end)
{
    struct still *still = context;
    uint64_t clipped = 0;
    for (size_t i = first; i < end; i++)
        clipped += display_store(DISPLAY_SRGB, STILL_BITS, still->rgb[i], still->codes[i]);
    counter_add(&still->out_of_gamut, clipped);
}

static bool put_tile(void *context, const struct tile *tile, struct error *err)
{
    struct still *still = context;
    const struct rectangle at = plan_pixels(&still->plan, &tile->at);
    const struct picture_rectangle to = {at.x, at.y, at.width, at.height};
    const size_t n = (size_t)at.width * (size_t)at.height;
    memset(still->rgb, 0, n * sizeof *still->rgb);
    still->tile = tile;
    if (!sum_tile(still, err))
        return false;
    threads_blocks(still->plan.options.threads, n, BLOCK_PIXELS, store_pixels, still);
    return picture_put(&still->picture, &to, still->codes, err);
}

/* ---- the picture ---- */

static bool find_weights(struct still *still, struct error *err)
{
    const struct plan *plan = &still->plan;
    struct detector detector = {.name = NULL};
    double m[3][3];
    const bool done = detector_read(detector_name, &detector, err);
    if (done) {
        detector_weights(&detector, plan->scene->wavelengths_nm, plan->n_bands, still->weights);
        display_matrix(DISPLAY_SRGB, m);
        tristimulus_apply_all(m, plan->n_bands, still->weights);
    }
    detector_free(&detector);
    return done;
}

static bool prepare(struct still *still, struct error *err)
{
    const struct plan *plan = &still->plan;
    const size_t n = (size_t)plan->tile_width * (size_t)plan->tile_height;
    return MAKE_ARRAY(still->weights, 3 * (size_t)plan->n_bands, err, "the weights of a picture") &&
           MAKE_ARRAY(still->radiance, n, err, "a tile of a picture") &&
           MAKE_ARRAY(still->rgb, n, err, "a tile of a picture") &&
           MAKE_ARRAY(still->codes, n, err, "a tile of a picture") && find_weights(still, err) &&
           lit_make(plan, driver_of(NULL), &still->lit, err);
}

static bool open_picture(struct still *still, const char *path, struct error *err)
{
    const struct scene *scene = still->plan.scene;
    struct printed printed = {.text = NULL};
    print(&printed,
          "drawn by          " PROGRAM "\nscene             %s\ndetector          %s\n"
          "adaptation        none\ndisplay           %s\nexposure          1\n",
          scene->path, detector_name, display_names[DISPLAY_SRGB]);
    char *description = picture_text(printed_take(&printed, err));
    const struct picture_options options = {.width = scene->width,
                                            .height = scene->height,
                                            .bits = 8,
                                            .srgb = true,
                                            .description = description};
    const bool done = description && picture_open(&still->picture, path, &options, err);
    free(description);
    return done;
}

bool still_write(struct viewing *view, struct error *err)
{
    struct still still = {.plan = *view->plan, .out_of_gamut = COUNTER, .undefined = COUNTER};
    const struct rectangle picture = plan_picture(view->plan);
    still.plan.options.bits = 32;
    const bool done = prepare(&still, err) &&
                      notes_make(&still.lit, SOME_PIXELS, view->notes, err) &&
                      open_picture(&still, view->options->output, err) &&
                      tiles_each(&still.lit, &picture, put_tile, &still, err) &&
                      picture_commit(&still.picture, &view->options->outputs, err);
    view->out_of_gamut = still.out_of_gamut.n;
    picture_discard(&still.picture);
    lit_free(&still.lit);
    FREE_ALL(still.weights, still.radiance, still.rgb, still.codes);
    return done;
}
