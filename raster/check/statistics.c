/* SPDX-License-Identifier: MIT */
/* Samples beside their expected values and bounds, and sums over many samples. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "raster/check/inside.h"

/* ---- samples ---- */

/* Returns whether all samples are within these limits; NaN is not. worst: the largest magnitude of
 * a difference; ratios: the largest error / bound, rest / limit. */
VECTORIZED static bool are_within(const struct block *block, float worst, float ratio,
                                  float fit_ratio)
{
    int odd = 0;
    for (size_t i = 0; i < block->n; i++) {
        const float difference = block->difference[i], rest = difference - block->fit.explained[i],
                    most = ratio * block->bound[i], limit = most < worst ? most : worst;
        odd |= !(fabsf(difference) <= limit) | !(fabsf(rest) <= fit_ratio * block->fit.limit[i]);
    }
    return odd == 0;
}

/* Counts the samples that are stored as they are expected, and those at most a count beside. */
VECTORIZED static void count_equal(struct check_samples *samples, const struct block *block)
{
    int exact = 0, within_1 = 0;
    for (size_t i = 0; i < block->n; i++) {
        const int apart =
            counts_round((double)block->seen[i] * FULL_COUNT) - counts_round(block->expected[i]);
        exact += apart == 0;
        within_1 += abs(apart) <= 1;
    }
    samples->exact += (uint64_t)exact;
    samples->within_1 += (uint64_t)within_1;
}

/* Raises the worst ratio to that of a value within its bound. Returns whether it is within; NaN is
 * not. A bound of 0 has no ratio. */
static bool raise_ratio(double *worst, float value, float bound)
{
    const double size = fabs((double)value);
    if (!(size <= (double)bound))
        return false;
    if (bound > 0 && size > *worst * (double)bound)
        *worst = size / (double)bound;
    return true;
}

/* Looks at each sample by itself. Returns whether all are within their bounds. */
static bool look_closer(struct check_samples *samples, const struct block *block)
{
    bool within = true;
    for (size_t i = 0; i < block->n; i++) {
        const float difference = block->difference[i];
        if (samples->largest < fabs((double)difference)) /* NaN never counts as larger */
            samples->largest = fabs((double)difference);
        within = raise_ratio(&samples->worst_ratio, difference, block->bound[i]) && within;
        if (block->fitted)
            within = raise_ratio(&samples->worst_fit_ratio, difference - block->fit.explained[i],
                                 block->fit.limit[i]) &&
                     within;
    }
    return within;
}

/* Nearly all blocks are within what others were. */
bool samples_compare(struct check_samples *samples, struct block *block)
{
    const float worst = (float)samples->largest,
                ratio = (float)samples->worst_ratio, /* beyond 1: of a candidate without a bound */
        fit_ratio = block->fitted ? (float)samples->worst_fit_ratio : 1;
    double sum = 0, sum_of_squares = 0;
    for (size_t i = 0; i < block->n; i++) {
        const double apart = (double)block->seen[i] * FULL_COUNT - block->expected[i];
        block->difference[i] = (float)apart;
        sum += apart;
        sum_of_squares += apart * apart;
    }
    samples->n += block->n;
    samples->sum += sum;
    samples->sum_of_squares += sum_of_squares;
    count_equal(samples, block);
    return are_within(block, worst, ratio, fit_ratio) || look_closer(samples, block);
}

void samples_add(struct check_samples *to, const struct check_samples *from)
{
    to->n += from->n;
    to->exact += from->exact;
    to->within_1 += from->within_1;
    to->largest = fmax(to->largest, from->largest);
    to->sum += from->sum;
    to->sum_of_squares += from->sum_of_squares;
    to->worst_ratio = fmax(to->worst_ratio, from->worst_ratio);
    to->worst_fit_ratio = fmax(to->worst_fit_ratio, from->worst_fit_ratio);
}

/* ---- floors ---- */

/* Bins are an eighth of an octave wide, the first one ends at 2^-16 counts. */
enum { BINS_PER_OCTAVE = 8, FIRST_OCTAVE = -16 };

void floor_note(struct check_floor *to, double counts)
{
    int exponent, bin = counts > 0 ? FLOOR_BINS - 1 : 0;
    double fraction = frexp(counts, &exponent); /* counts = fraction x 2^exponent, from 0.5 to 1 */
    if (counts > 0 && counts <= DBL_MAX)
        bin = (exponent - FIRST_OCTAVE) * BINS_PER_OCTAVE +
              (int)(2 * BINS_PER_OCTAVE * (fraction - 0.5));
    to->bins[bin < 0 ? 0 : bin < FLOOR_BINS ? bin : FLOOR_BINS - 1]++;
    to->n++;
    to->within[0] += counts <= 1;
    to->within[1] += counts <= 8;
    to->within[2] += counts <= CHECKED_COUNTS;
    to->worst = fmax(to->worst, counts);
}

double floor_quantile(const struct check_floor *of, double part)
{
    uint64_t below = 0;
    int bin = 0;
    while (bin < FLOOR_BINS - 1 && (double)(below + of->bins[bin]) < part * (double)of->n)
        below += of->bins[bin++];
    double upper = ldexp(0.5 + (bin % BINS_PER_OCTAVE + 1) / (2.0 * BINS_PER_OCTAVE),
                         bin / BINS_PER_OCTAVE + FIRST_OCTAVE);
    return fmin(upper, of->worst);
}

static void floor_add(struct check_floor *to, const struct check_floor *from)
{
    for (int i = 0; i < FLOOR_BINS; i++)
        to->bins[i] += from->bins[i];
    for (int i = 0; i < FLOOR_LEVELS; i++)
        to->within[i] += from->within[i];
    to->n += from->n;
    to->worst = fmax(to->worst, from->worst);
}

/* ---- all of it ---- */

void verdict_add(struct check_verdict *to, const struct check_verdict *from)
{
    samples_add(&to->samples, &from->samples);
    floor_add(&to->floor, &from->floor);
    floor_add(&to->smooth_floor, &from->smooth_floor);
    floor_add(&to->band_floor, &from->band_floor);
    to->pixels += from->pixels;
    to->ambiguous += from->ambiguous;
    to->edges += from->edges;
    to->open += from->open;
    to->between += from->between;
    to->unexplained += from->unexplained;
    to->objects += from->objects;
    to->unbounded += from->unbounded;
    to->unchecked += from->unchecked;
    to->edge_holes += from->edge_holes;
    to->edge_doubles += from->edge_doubles;
    to->worst_depth_ratio = fmax(to->worst_depth_ratio, from->worst_depth_ratio);
    if (!to->first.found)
        to->first = from->first;
}
