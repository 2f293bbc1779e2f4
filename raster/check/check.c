/* SPDX-License-Identifier: MIT */
/* The verdict on each pixel. OpenGL names the triangle that it shows there: this triangle must be a
 * candidate. Its depth must be within the candidate's bound, the number of fragments must be
 * possible, and OpenGL's radiance must be that of this one triangle: in each band within the band's
 * bound, and in all bands together with one set of weights. */
#include <math.h>

#include "raster/check/inside.h"

struct run settled_run(const struct lit_scene *lit, const struct chunk *chunk, size_t first,
                       size_t end, struct textured_sample *textured)
{
    const int32_t surface = chunk->picture.surface[first];
    size_t n = 0;
    while (n < BLOCK && first + n < end && !chunk->is_ambiguous[first + n] &&
           chunk->picture.surface[first + n] == surface)
        n++;
    return (struct run){.shaded = surface < 0 ? NULL : lit->bounds[surface].shaded,
                        .rows = chunk->rows + first,
                        .errors = chunk->errors + first,
                        .own = chunk->own + first,
                        .stride = chunk_pixels(chunk),
                        .n = n,
                        .textured = textured};
}

struct run candidate_run(const struct lit_scene *lit, const struct chunk *chunk,
                         const struct candidate *candidate, struct textured_sample *textured)
{
    if (!candidate)
        return (struct run){.n = 1};
    return (struct run){.shaded = lit->bounds[candidate->surface].shaded,
                        .rows = chunk->candidate_rows + candidate->first,
                        .errors = chunk->candidate_errors + candidate->first,
                        .own = chunk->candidate_own + candidate->first,
                        .stride = 1,
                        .n = 1,
                        .textured = textured};
}

void check_fail(struct check *check, size_t pixel, const struct check_failure *failure)
{
    const struct rectangle *rows = &check->chunk->picture.at;
    check->failed[pixel] = true;
    if (check->verdict.first.found)
        return;
    check->first_failed = pixel;
    check->verdict.first = *failure;
    check->verdict.first.found = true;
    check->verdict.first.x = rows->x + (int)pixel % rows->width;
    check->verdict.first.y = rows->y + (int)pixel / rows->width;
    check->verdict.first.surface = check->chunk->picture.surface[pixel];
}

/* ---- samples ---- */

/* Learns what a pilot band says of the weights of a run. */
static void learn(const struct check *check, const struct run *run, int band, struct block *block,
                  float *estimates)
{
    double difference[BLOCK];
    expect_counts(check->scene->lit, run, band, block->expected, block->bound);
    for (size_t i = 0; i < block->n; i++)
        difference[i] = (double)block->seen[i] * FULL_COUNT - block->expected[i];
    if (run->shaded)
        fit_add(&check->scene->fit, run, band, difference, estimates);
}

/* Compares the samples of a run with the reference, and with the weights that the other bands call
 * for. Returns false where one is outside of a bound. */
static bool compare(const struct check *check, const struct run *run, int band,
                    const float *estimates, struct check_samples *samples, struct block *block)
{
    expect_counts(check->scene->lit, run, band, block->expected, block->bound);
    block->fitted = run->shaded && fit_explain(&check->scene->fit, run, band, estimates,
                                               block->bound, &block->fit);
    for (size_t i = 0; i < block->n && !block->fitted; i++) {
        block->fit.explained[i] = 0;
        block->fit.limit[i] = block->fit.floor[i] = HUGE_VALF;
    }
    return samples_compare(samples, block);
}

/* The magnitude of the rest that the fit leaves of a difference. */
static float rest_size(const struct block *block, size_t i)
{
    return fabsf(block->difference[i] - block->fit.explained[i]);
}

/* Returns whether sample i of a block is outside of a bound; *failure names the bound. */
static bool is_outside(const struct block *block, size_t i, int band, struct check_failure *failure)
{
    *failure = (struct check_failure){.kind = FAILURE_RADIANCE,
                                      .band = band,
                                      .seen = (double)block->seen[i] * FULL_COUNT,
                                      .expected = block->expected[i],
                                      .bound = (double)block->bound[i]};
    if (!(fabsf(block->difference[i]) <= block->bound[i]))
        return true;
    failure->kind = FAILURE_BANDS;
    failure->expected += (double)block->fit.explained[i];
    failure->bound = (double)block->fit.limit[i];
    return !(rest_size(block, i) <= block->fit.limit[i]);
}

/* ---- pixels with a single candidate ---- */

/* Raises the ratios of a block's pixels to those of its samples, within bounds or not. */
static void raise_ratios(float *ratio, const struct block *block)
{
    for (size_t i = 0; i < block->n; i++) {
        float plain = block->bound[i] > 0 ? fabsf(block->difference[i]) / block->bound[i] : 0,
              alone = block->fit.limit[i] > 0 ? rest_size(block, i) / block->fit.limit[i] : 0;
        ratio[i] = fmaxf(ratio[i], fmaxf(plain, alone));
    }
}

/* Raises the floors of a block's pixels to those of its samples; alone: to the largest error that
 * could pass in this band alone. */
VECTORIZED static void raise_floors(const struct block *block, float *restrict floor,
                                    float *restrict alone)
{
    for (size_t i = 0; i < block->n; i++) {
        const float bound = block->bound[i], fitted = block->fit.floor[i],
                    of_band = fitted < bound ? fitted : bound;
        floor[i] = floor[i] < bound ? bound : floor[i];
        alone[i] = alone[i] < of_band ? of_band : alone[i];
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

/* Finds the limits of the first pixel that failed in the bands before. */
static void find_limits(struct check *check)
{
    const size_t pixel = check->first_failed;
    struct block block;
    block.n = 1;
    const struct run run =
        settled_run(check->scene->lit, check->chunk, pixel, pixel + 1, block.textured);
    for (int band = 0; band < check->verdict.first.band; band++) {
        expect_counts(check->scene->lit, &run, band, block.expected, block.bound);
        if (fit_explain(&check->scene->fit, &run, band, check->estimates + pixel, block.bound,
                        &block.fit))
            check->limits[band] = block.fit.limit[0];
    }
}

/* Learns from the samples of a run, or judges them. */
static void treat_run(struct check *check, const struct run *run, size_t first, int band,
                      struct block *block, bool learns)
{
    struct check_failure failure;
    if (learns) {
        learn(check, run, band, block, check->estimates + first);
        return;
    }
    const bool within =
        compare(check, run, band, check->estimates + first, &check->verdict.samples, block);
    raise_floors(block, check->floor + first, check->band_floor + first);
    if (check->ratio)
        raise_ratios(check->ratio + first, block);
    for (size_t i = 0; i < block->n && !within; i++)
        if (is_outside(block, i, band, &failure))
            check_fail(check, first + i, &failure);
    keep_rest(check, first, band, block);
}

/* ---- ambiguous pixels ---- */

/* Returns the candidate of a hypothesis; NULL: the background. */
static const struct candidate *candidate_of(const struct chunk *chunk, size_t hypothesis)
{
    return hypothesis < chunk->n_candidates ? &chunk->candidates[hypothesis] : NULL;
}

/* Learns from a sample what a living hypothesis makes of it, or judges it. A candidate without a
 * bound explains everything, NaN too. */
static void try_hypothesis(struct check *check, size_t number, int band, float seen, bool learns)
{
    const struct chunk *chunk = check->chunk;
    const struct candidate *candidate = candidate_of(chunk, number);
    struct hypothesis *hypothesis = &check->hypotheses[number];
    struct block single;
    const struct run run = candidate_run(check->scene->lit, chunk, candidate, single.textured);
    float *estimates = NULL;
    if (!hypothesis->alive)
        return;
    single.n = 1;
    single.seen = &seen;
    if (candidate)
        estimates = check->candidate_estimates + number * (size_t)fit_rows(check->scene->lit->plan);
    if (learns) {
        learn(check, &run, band, &single, estimates);
        return;
    }
    hypothesis->band = band;
    hypothesis->alive = compare(check, &run, band, estimates, &hypothesis->samples, &single);
    raise_floors(&single, &hypothesis->floor, &hypothesis->band_floor);
    if (!hypothesis->alive)
        is_outside(&single, 0, band, &hypothesis->failure);
    if (candidate && candidate->loose && !hypothesis->alive) { /* any other explains better */
        hypothesis->alive = true;
        hypothesis->samples.worst_ratio = HUGE_VAL;
    }
}

static void treat_ambiguous(struct check *check, size_t index, int band, float seen, bool learns)
{
    const struct chunk *chunk = check->chunk;
    const struct ambiguous_pixel *pixel = &chunk->ambiguous[index];
    for (int c = pixel->first; c < pixel->first + pixel->count; c++)
        try_hypothesis(check, (size_t)c, band, seen, learns);
    try_hypothesis(check, chunk->n_candidates + index, band, seen, learns);
}

/* Returns the hypothesis that explains best: the living one with the smallest ratio of error to
 * bound; of dead ones the one that lived longest. */
static const struct hypothesis *best_hypothesis(const struct hypothesis *a,
                                                const struct hypothesis *b)
{
    if (a->alive != b->alive)
        return a->alive ? a : b;
    if (a->alive)
        return a->samples.worst_ratio <= b->samples.worst_ratio ? a : b;
    return a->band >= b->band ? a : b;
}

/* ---- what OpenGL may show as well ---- */

/* Finds the chunk of a neighbour of a pixel, number 0 to 3, and its pixel there. NULL: it lies
 * outside of the tile. */
static const struct chunk *neighbour(const struct tile *tile, const struct chunk *chunk,
                                     size_t *pixel, int number)
{
    const int width = tile->at.width, rows = tile->lit->plan->chunk_rows,
              x = (int)*pixel % width + (number == 1) - (number == 2),
              y = chunk->picture.at.y - tile->at.y + (int)*pixel / width + (number == 0) -
                  (number == 3);
    *pixel = (size_t)(y % rows * width + x);
    return x < 0 || x >= width || y < 0 || y >= tile->at.height ? NULL : &tile->chunks[y / rows];
}

/* Radiance in counts. */
static double in_counts(const struct check *check, float radiance)
{
    return (double)radiance / check->scene->lit->full_scale * FULL_COUNT;
}

/* Returns whether two neighbours of a pixel leave nothing open, at least: what it leaves open is
 * then the place of an edge by a rounding, and not what a region shows. */
static bool is_between(const struct check *check, const struct tile *tile, size_t pixel)
{
    int n = 0;
    for (int i = 0; i < 4; i++) {
        size_t at = pixel;
        const struct chunk *of = neighbour(tile, check->chunk, &at, i);
        n += of && in_counts(check, of->pixels[at].open) <= checked_counts(check->scene->lit->plan);
    }
    return n >= 2;
}

/* Adds what its rivals may show to the floor of an ambiguous pixel that shows a candidate, and
 * counts it. Returns what bounds its mean. */
static struct mean_bound note_open(struct check *check, const struct tile *tile,
                                   const struct ambiguous_pixel *ambiguous,
                                   const struct candidate *of)
{
    const size_t pixel = (size_t)ambiguous->pixel;
    const double limit = checked_counts(check->scene->lit->plan);
    const bool was_checked = (double)check->floor[pixel] <= limit;
    struct mean_bound mean = of->mean;
    bool is_edge = ambiguous->background;
    for (int c = ambiguous->first; c < ambiguous->first + ambiguous->count; c++)
        is_edge = is_edge || check->chunk->candidates[c].triangle != of->triangle ||
                  check->chunk->candidates[c].surface != of->surface;
    check->floor[pixel] += (float)in_counts(check, of->open);
    if (was_checked && (double)check->floor[pixel] > limit) {
        mean.cause = is_between(check, tile, pixel) ? CAUSE_EDGE : of->open_cause;
        check->verdict.open++;
    } else {
        check->verdict.edges += is_edge;
    }
    return mean;
}

/* Keeps the best hypothesis of an ambiguous pixel. */
static void settle(struct check *check, const struct tile *tile, size_t index,
                   struct check_totals *totals)
{
    const struct chunk *chunk = check->chunk;
    const struct ambiguous_pixel *ambiguous = &chunk->ambiguous[index];
    const struct hypothesis *best = &check->hypotheses[chunk->n_candidates + index];
    const size_t pixel = (size_t)ambiguous->pixel;
    for (int c = ambiguous->first; c < ambiguous->first + ambiguous->count; c++)
        best = best_hypothesis(&check->hypotheses[c], best);
    const struct candidate *candidate = candidate_of(chunk, (size_t)(best - check->hypotheses));
    /* the depth buffer may have lost the triangle that the reference shows */
    const bool lost = ambiguous->may_vanish && !candidate;
    struct check_samples samples = best->samples;
    if (candidate && candidate->loose) { /* counted, but no measure of OpenGL's errors */
        samples.largest = samples.sum = samples.sum_of_squares = 0;
        samples.worst_ratio = samples.worst_fit_ratio = -1;
    }
    check->verdict.ambiguous++;
    samples_add(&check->verdict.samples, &samples);
    if (!best->alive)
        check_fail(check, pixel, &best->failure);
    check->floor[pixel] = !candidate ? -1 : candidate->loose ? HUGE_VALF : best->floor;
    check->band_floor[pixel] =
        candidate && !candidate->loose ? best->band_floor : check->floor[pixel];
    if (check->ratio)
        check->ratio[pixel] = (float)fmax(samples.worst_ratio, samples.worst_fit_ratio);
    if (lost) {
        const struct mean_bound none = {.cause = is_between(check, tile, pixel) ? CAUSE_EDGE
                                                                                : CAUSE_DEPTH};
        check->verdict.open++;
        check->floor[pixel] = check->band_floor[pixel] = HUGE_VALF;
        totals_note(totals, chunk->picture.surface[pixel], chunk->picture.triangle[pixel], HUGE_VAL,
                    &none);
    } else if (candidate) {
        const struct mean_bound mean = note_open(check, tile, ambiguous, candidate);
        totals_note(totals, candidate->surface, candidate->triangle, (double)check->floor[pixel],
                    &mean);
    }
}

/* ---- floors ---- */

/* Returns whether a pixel and its neighbours in the tile lie inside one surface, and the pixel's
 * radiance changes little. */
static bool is_smooth(const struct check *check, const struct tile *tile, size_t pixel)
{
    const struct chunk *chunk = check->chunk;
    bool inside = (double)chunk->pixels[pixel].steepness * FULL_COUNT <=
                  SMOOTH_COUNTS * check->scene->lit->full_scale;
    for (int i = 0; i < 4 && inside; i++) {
        size_t at = pixel;
        const struct chunk *of = neighbour(tile, chunk, &at, i);
        inside = !of || (!of->is_ambiguous[at] &&
                         of->picture.surface[at] == chunk->picture.surface[pixel]);
    }
    return inside;
}

/* Counts the pixels that are not explained, and notes the floor of each one that shows an object
 * and has a bound. */
static void note_pixels(struct check *check, const struct tile *tile)
{
    const struct chunk *chunk = check->chunk;
    check->verdict.pixels = chunk_pixels(chunk);
    for (size_t i = 0; i < check->verdict.pixels; i++) {
        const double floor = (double)check->floor[i];
        check->verdict.unexplained += check->failed[i];
        if (!(floor >= 0 && floor < HUGE_VAL))
            continue;
        floor_note(&check->verdict.floor, floor);
        floor_note(&check->verdict.band_floor, (double)check->band_floor[i]);
        if (!chunk->is_ambiguous[i] && is_smooth(check, tile, i))
            floor_note(&check->verdict.smooth_floor, floor);
    }
}

/* ---- a chunk ---- */

void check_free(struct check *check)
{
    FREE_ALL(check->failed, check->ratio, check->floor, check->band_floor, check->hypotheses,
             check->estimates, check->candidate_estimates, check->rests, check->limits);
    *check = (struct check){.scene = NULL};
}

static bool allocate(const struct chunk *chunk, struct check *out, struct error *err)
{
    const size_t n = chunk_pixels(chunk), n_rows = (size_t)fit_rows(out->scene->lit->plan),
                 n_candidates = chunk->n_candidates,
                 n_hypotheses = n_candidates + chunk->n_ambiguous;
    const int n_bands = out->scene->lit->plan->n_bands;
    return MAKE_ARRAY(out->failed, n, err, "the check of %zu pixels", n) &&
           MAKE_ARRAY(out->floor, n, err, "the check of %zu pixels", n) &&
           MAKE_ARRAY(out->band_floor, n, err, "the check of %zu pixels", n) &&
           MAKE_ARRAY(out->hypotheses, n_hypotheses, err, "%zu candidates", n_hypotheses) &&
           MAKE_ARRAY(out->estimates, n * n_rows, err, "the check of %zu pixels", n) &&
           MAKE_ARRAY(out->candidate_estimates, n_candidates * n_rows, err, "%zu candidates",
                      n_candidates) &&
           MAKE_ARRAY(out->rests, n_bands, err, "the check of %d bands", n_bands) &&
           MAKE_ARRAY(out->limits, n_bands, err, "the check of %d bands", n_bands) &&
           (!out->scene->mapped || MAKE_ARRAY(out->ratio, n, err, "a map of %zu pixels", n));
}

bool check_open(const struct check_scene *scene, const struct chunk *chunk, struct check *out,
                struct error *err)
{
    *out = (struct check){.scene = scene, .chunk = chunk, .verdict = empty_verdict};
    if (!allocate(chunk, out, err))
        return false;
    const size_t n = chunk->n_candidates;
    for (size_t i = 0; i < n + chunk->n_ambiguous; i++)
        out->hypotheses[i] =
            (struct hypothesis){.alive = i < n || chunk->ambiguous[i - n].background,
                                .samples = empty_verdict.samples,
                                .band = -1};
    return true;
}

void check_pass(struct check *check, int first_band, const float *pixels, size_t stride,
                bool learns)
{
    const struct chunk *chunk = check->chunk;
    const size_t width = (size_t)chunk->picture.at.width;
    const int n_channels = pass_bands(check->scene->lit->plan, first_band);
    float seen[BANDS_PER_PASS][BLOCK];
    struct block block;
    for (size_t first = 0; first < chunk_pixels(chunk); first += block.n ? block.n : 1) {
        const float *from = pixels + (first / width * stride + first % width) * 4;
        const struct run run = settled_run(check->scene->lit, chunk, first,
                                           (first / width + 1) * width, block.textured);
        block.n = run.n;
        for (size_t i = 0; i < block.n; i++)
            for (size_t c = 0; c < BANDS_PER_PASS; c++)
                seen[c][i] = from[4 * i + c];
        for (int c = 0; c < n_channels && block.n > 0; c++) {
            block.seen = seen[c];
            treat_run(check, &run, first, first_band + c, &block, learns);
        }
    }
    for (size_t i = 0; i < chunk->n_ambiguous; i++) {
        const size_t at = (size_t)chunk->ambiguous[i].pixel, x = at % width, y = at / width;
        for (int c = 0; c < n_channels; c++)
            treat_ambiguous(check, i, first_band + c, pixels[(y * stride + x) * 4 + (size_t)c],
                            learns);
    }
}

void check_settle(struct check *check, const struct tile *tile, struct check_totals *totals)
{
    const struct chunk *chunk = check->chunk;
    const struct picture *picture = &chunk->picture;
    const struct check_failure *first = &check->verdict.first;
    if (first->found && first->kind == FAILURE_BANDS && check->limits[first->band] > 0) {
        find_limits(check);
        find_odd_bands(check);
    }
    for (size_t i = 0; i < chunk_pixels(chunk); i++) {
        if (chunk->is_ambiguous[i])
            continue;
        if (picture->surface[i] < 0)
            check->floor[i] = check->band_floor[i] = -1;
        else
            totals_note(totals, picture->surface[i], picture->triangle[i], (double)check->floor[i],
                        &chunk->pixels[i].mean);
    }
    for (size_t i = 0; i < chunk->n_ambiguous; i++)
        settle(check, tile, i, totals);
    note_pixels(check, tile);
    verdict_add(&totals->verdict, &check->verdict);
}

enum check_class check_class(const struct check *check, size_t pixel)
{
    const double limit = checked_counts(check->scene->lit->plan);
    return check->failed[pixel]                  ? CLASS_DIFFERS
           : (double)check->floor[pixel] > limit ? CLASS_NOT_CHECKED
           : check->chunk->is_ambiguous[pixel]   ? CLASS_AMBIGUOUS
                                                 : CLASS_CHECKED;
}
