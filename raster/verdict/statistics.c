/* SPDX-License-Identifier: MIT */
/* Samples beside their expected values and bounds, and sums over many samples. */
#include <float.h>
#include <math.h>

#include "raster/verdict/verdict.h"

/* ---- samples ---- */

/* Sums over a block are kept in lanes, which the compiler can do together. A block is filled up to
 * whole lanes with samples that are 0 and expected to be 0. More lanes do not fit in the
 * registers. */
enum { LANES = 4 };

static size_t fill_lanes(struct block *block)
{
    size_t n = block->n;
    for (; n % LANES != 0; n++) {
        block->seen[n] = block->expected[n] = 0;
        block->bound[n] = 0;
    }
    return n;
}

/* Finds the magnitudes of the differences. */
static void differ(struct check_samples *samples, struct block *block, size_t all)
{
    double sums[LANES] = {0}, squares[LANES] = {0};
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++) {
            double difference = block->seen[i + k] - block->expected[i + k];
            block->difference[i + k] = (float)fabs(difference);
            sums[k] += difference;
            squares[k] += difference * difference;
        }
    for (size_t k = 0; k < LANES; k++) {
        samples->sum += sums[k];
        samples->sum_of_squares += squares[k];
    }
}

/* NaN never counts as larger. (gcc 12 for ARM cannot compile this with fmax.) */
static float largest_difference(const struct block *block, size_t all)
{
    float most[LANES] = {0}, largest = 0;
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++)
            most[k] = most[k] < block->difference[i + k] ? block->difference[i + k] : most[k];
    for (size_t k = 0; k < LANES; k++)
        largest = largest < most[k] ? most[k] : largest;
    return largest;
}

/* Returns whether all values can be stored without being clamped; NaN cannot. */
static bool are_counts(const double *values, size_t all)
{
    const double middle = 0.5 * FULL_COUNT;
    double odd[LANES] = {0}, sum = 0;
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++)
            odd[k] += fabs(values[i + k] - middle) <= middle ? 0 : 1;
    for (size_t k = 0; k < LANES; k++)
        sum += odd[k];
    return sum < 1;
}

/* Values that need no clamping, and are at most half a count apart, need only be rounded. */
static int exact_of_close(const struct block *block)
{
    int exact = 0;
    for (size_t i = 0; i < block->n; i++)
        exact += (int)(block->seen[i] + 0.5) == (int)(block->expected[i] + 0.5);
    return exact;
}

static void count_equal(struct check_samples *samples, const struct block *block, bool close)
{
    int exact = close ? exact_of_close(block) : 0, within_1 = close ? (int)block->n : 0;
    for (size_t i = 0; i < block->n && !close; i++) {
        int apart = counts_round(block->seen[i]) - counts_round(block->expected[i]);
        exact += apart == 0;
        within_1 += apart >= -1 && apart <= 1;
    }
    samples->n += block->n;
    samples->exact += (uint64_t)exact;
    samples->within_1 += (uint64_t)within_1;
}

/* Returns whether all values are at most `factor` times their bounds; NaN is not. */
static bool are_within(const float *values, const float *bounds, float factor, size_t all)
{
    int above[LANES] = {0};
    int sum = 0;
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++)
            above[k] |= !(values[i + k] <= factor * bounds[i + k]);
    for (size_t k = 0; k < LANES; k++)
        sum |= above[k];
    return sum == 0;
}

/* Raises the worst ratio of those values that are within their bounds, and returns whether all are.
 * Looks closer only where a ratio may be larger. A bound of 0 has no ratio. */
static bool raise_ratio(double *worst, const float *values, const float *bounds, size_t n,
                        size_t all)
{
    if (are_within(values, bounds, (float)*worst, all)) /* which is at most 1 */
        return true;
    for (size_t i = 0; i < n; i++) {
        double value = (double)values[i], bound = (double)bounds[i];
        if (value <= bound && bound > 0 && value > *worst * bound)
            *worst = value / bound;
    }
    return are_within(values, bounds, 1, all);
}

bool samples_compare(struct check_samples *samples, struct block *block)
{
    size_t all = fill_lanes(block);
    differ(samples, block, all);
    const float largest = largest_difference(block, all);
    samples->largest = fmax(samples->largest, (double)largest);
    count_equal(samples, block, largest < 0.5F && are_counts(block->seen, all));
    return raise_ratio(&samples->worst_ratio, block->difference, block->bound, block->n, all);
}

bool samples_compare_fit(struct check_samples *samples, struct block *block)
{
    size_t all = fill_lanes(block);
    for (size_t i = block->n; i < all; i++)
        block->fit.explained[i] = block->fit.limit[i] = 0;
    for (size_t i = 0; i < all; i++)
        block->rest[i] =
            (float)fabs(block->seen[i] - block->expected[i] - (double)block->fit.explained[i]);
    return raise_ratio(&samples->worst_fit_ratio, block->rest, block->fit.limit, block->n, all);
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
    to->unexplained += from->unexplained;
    to->edge_holes += from->edge_holes;
    to->edge_doubles += from->edge_doubles;
    to->worst_depth_ratio = fmax(to->worst_depth_ratio, from->worst_depth_ratio);
    if (!to->first.found)
        to->first = from->first;
}
