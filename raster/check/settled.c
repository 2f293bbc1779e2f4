/* SPDX-License-Identifier: MIT */
/* Judges the pixels with a single candidate, which are nearly all, by stretches of a row. */
#include <math.h>
#include <string.h>

#include "raster/check/inside.h"

/* ---- stretches ---- */

/* Returns the pixels from `first` on, within the row and a block, that show its surface without
 * ambiguity. */
static struct stretch stretch_from(const struct chunk *chunk, size_t first)
{
    const size_t width = (size_t)chunk->picture.at.width, row_end = (first / width + 1) * width,
                 last = row_end - first < BLOCK ? row_end : first + BLOCK;
    size_t at = first;
    while (at < last && !chunk->is_ambiguous[at] &&
           chunk->picture.surface[at] == chunk->picture.surface[first])
        at++;
    return (struct stretch){(uint32_t)first, (uint32_t)(at - first)};
}

/* Lists the stretches unless `out` is NULL. Returns how many there are. */
static size_t list_stretches(const struct chunk *chunk, struct stretch *out)
{
    size_t n = 0;
    for (size_t first = 0; first < chunk_pixels(chunk);) {
        const struct stretch stretch = stretch_from(chunk, first);
        if (out && stretch.n > 0)
            out[n] = stretch;
        n += stretch.n > 0;
        first += stretch.n > 0 ? stretch.n : 1;
    }
    return n;
}

bool settled_find(struct check *check, struct error *err)
{
    const size_t n = list_stretches(check->chunk, NULL);
    if (!MAKE_ARRAY(check->stretches, n, err, "the check of %zu runs of pixels", n))
        return false;
    check->n_stretches = list_stretches(check->chunk, check->stretches);
    return true;
}

/* Returns the run of a block that begins with a pixel. */
static struct run run_of(const struct check *check, size_t first, struct block *block)
{
    const struct chunk *chunk = check->chunk;
    const int32_t surface = chunk->picture.surface[first];
    return (struct run){.shaded = surface < 0 ? NULL : check->scene->lit->bounds[surface].shaded,
                        .rows = chunk->picture.rows + first,
                        .errors = chunk->errors + first,
                        .own = chunk->own + first,
                        .stride = chunk_pixels(chunk),
                        .n = block->n,
                        .textured = block->textured};
}

/* Returns whether the bounds of a run are sums over terms alone. */
static bool is_plain(const struct check *check, const struct run *run)
{
    return run->shaded && fit_of(&check->scene->fit, run)->plain;
}

/* ---- floors ---- */

/* Raises the floors of a block's pixels to those of its samples. */
VECTORIZED static void raise_floors(const struct block *block, float *restrict floor,
                                    float *restrict alone)
{
    for (size_t i = 0; i < block->n; i++) {
        const float of_band = band_floor(block, i);
        floor[i] = floor[i] < block->bound[i] ? block->bound[i] : floor[i];
        alone[i] = alone[i] < of_band ? of_band : alone[i];
    }
}

void settled_floors(struct check *check)
{
    struct block block;
    for (size_t s = 0; s < check->n_stretches; s++) {
        const size_t first = check->stretches[s].first;
        block.n = check->stretches[s].n;
        const struct run run = run_of(check, first, &block);
        const struct material_fit *of =
            is_plain(check, &run) ? fit_of(&check->scene->fit, &run) : NULL;
        for (int i = 0; of && i < of->n_floors; i++) {
            fit_bounds(&check->scene->fit, &run, of->floors[i], block.bound, &block.fit);
            raise_floors(&block, check->floor + first, check->band_floor + first);
        }
    }
}

/* ---- samples ---- */

static void learn_stretch(struct check *check, size_t stretch, int band, struct block *block)
{
    const size_t first = check->stretches[stretch].first;
    struct run run = run_of(check, first, block);
    run_learn(check, &run, band, block, check->estimates + first);
}

/* Raises the ratios of a block's pixels to those of its samples, within bounds or not. */
static void raise_ratios(float *ratio, const struct block *block)
{
    for (size_t i = 0; i < block->n; i++) {
        float plain = block->bound[i] > 0 ? fabsf(block->difference[i]) / block->bound[i] : 0,
              alone = block->fit.limit[i] > 0 ? rest_size(block, i) / block->fit.limit[i] : 0;
        ratio[i] = fmaxf(ratio[i], fmaxf(plain, alone));
    }
}

/* Keeps what the fit leaves of the first pixel that failed. */
static void keep_rest(struct check *check, size_t first, int band, const struct block *block)
{
    const size_t i = check->first_failed - first;
    if (!check->verdict.first.found || i >= block->n || !block->fitted)
        return;
    check->rests[band] = block->difference[i] - block->fit.explained[i];
    check->limits[band] = block->fit.limit[i];
}

void find_limits(struct check *check)
{
    const size_t pixel = check->first_failed;
    struct block block;
    block.n = 1;
    const struct run run = run_of(check, pixel, &block);
    for (int band = 0; band < check->verdict.first.band; band++) {
        run_expect(check, &run, band, &block);
        if (fit_explain(&check->scene->fit, &run, band, check->estimates + pixel, block.bound,
                        &block.fit))
            check->limits[band] = block.fit.limit[0];
    }
}

static void judge_stretch(struct check *check, size_t stretch, int band, struct block *block)
{
    const size_t first = check->stretches[stretch].first;
    struct check_failure failure;
    struct run run = run_of(check, first, block);
    const bool plain = is_plain(check, &run);
    bool within =
        run_compare(check, &run, band, check->estimates + first, &check->verdict.samples, block);
    if (!plain)
        raise_floors(block, check->floor + first, check->band_floor + first);
    if (check->ratio)
        raise_ratios(check->ratio + first, block);
    for (size_t i = 0; i < block->n && !within; i++)
        if (is_outside(block, i, band, &failure))
            check_fail(check, first + i, &failure);
    keep_rest(check, first, band, block);
}

VECTORIZED static void split_channels(const float *pixels, size_t n, float seen[][BLOCK])
{
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < BANDS_PER_PASS; c++)
            seen[c][i] = pixels[4 * i + c];
}

void settled_pass(struct check *check, int first_band, int n_channels, const float *pixels,
                  size_t stride, bool learns)
{
    const size_t width = (size_t)check->chunk->picture.at.width;
    float seen[BANDS_PER_PASS][BLOCK];
    struct block block;
    for (size_t s = 0; s < check->n_stretches; s++) {
        const size_t first = check->stretches[s].first;
        const float *from = pixels + (first / width * stride + first % width) * 4;
        block.n = check->stretches[s].n;
        split_channels(from, block.n, seen);
        for (int c = 0; c < n_channels; c++) {
            block.seen = seen[c];
            (learns ? learn_stretch : judge_stretch)(check, s, first_band + c, &block);
        }
    }
}
