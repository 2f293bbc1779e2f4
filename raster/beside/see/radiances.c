/* SPDX-License-Identifier: MIT */
/* The radiances of a region of a scene by the reference, tile after tile, band after band. */
#include "raster/beside/see/inside.h"

/* Bands of a tile that load their textures together, as those of an OpenGL pass. */
struct tile_bands {
    const struct radiances *of;
    const struct tile *tile;
    float *radiance; /* of a band: [pixel of the tile] */
    int first, end;
    struct counter undefined; /* samples that are not finite */
};

static void use_chunk(void *context, int i)
{
    struct tile_bands *bands = context;
    const struct lit_scene *lit = bands->tile->lit;
    const struct picture *picture = &bands->tile->chunks[i].picture;
    const struct rectangle above = {0, 0, picture->at.width, i * lit->plan->chunk_rows},
                           before = plan_pixels(lit->plan, &above);
    float *radiance = bands->radiance + (size_t)before.width * (size_t)before.height;
    struct drawn_band drawn = {picture, plan_pixels(lit->plan, &picture->at), bands->first,
                               radiance};
    for (; drawn.band < bands->end; drawn.band++) {
        const struct stored_band stored = {lit, drawn.band, radiance};
        counter_add(&bands->undefined, store_reference(&stored, 1, picture).undefined);
        bands->of->use(bands->of->context, &drawn);
    }
}

static bool use_tile(void *context, const struct tile *tile, struct error *err)
{
    const struct radiances *of = context;
    const struct plan *plan = tile->lit->plan;
    const struct rectangle pixels = plan_pixels(plan, &tile->at);
    struct tile_bands bands = {.of = of, .tile = tile, .undefined = COUNTER};
    bool done = MAKE_ARRAY(bands.radiance, (size_t)pixels.width * (size_t)pixels.height, err,
                           "a tile of a picture");
    for (; done && bands.first < plan->n_bands; bands.first = bands.end) {
        const int end = bands.first + BANDS_PER_PASS;
        bands.end = end < plan->n_bands ? end : plan->n_bands;
        done = plan_load_textures(plan, bands.first, err);
        if (done)
            threads_each(of->threads, tile->n_chunks, use_chunk, &bands);
        if (bands.undefined.n > 0)
            done = error_usage(err, "%s: a radiance is not finite", plan->scene->path);
    }
    free(bands.radiance);
    return done;
}

bool radiances_each(const struct lit_scene *lit, const struct rectangle *pixels,
                    struct radiances *of, struct error *err)
{
    const int side = lit->plan->scene->positions;
    const struct rectangle positions = {side * pixels->x, side * pixels->y, side * pixels->width,
                                        side * pixels->height};
    return tiles_each(lit, &positions, use_tile, of, err);
}
