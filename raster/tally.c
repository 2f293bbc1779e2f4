/* SPDX-License-Identifier: MIT */
/* How samples compare with what is expected of them, and the sums over many of them. */
#include <float.h>
#include <math.h>

#include "check.h"

/* ---- samples ---- */

/* Sums over a block are kept in lanes, which the compiler can do together. A block is filled up to
 * whole lanes with samples that are 0 and expected to be 0. */
enum { LANES = 4 };

static size_t fill_lanes(struct block *block)
{
    size_t n = block->n;
    for (; n % LANES != 0; n++)
        block->seen[n] = block->expected[n] = block->bound[n] = 0;
    return n;
}

static double lane_sum(const double lanes[LANES])
{
    return lanes[0] + lanes[1] + lanes[2] + lanes[3];
}

/* Fills the magnitudes of differences. */
static void differ(struct check_samples *samples, struct block *block, size_t all)
{
    double sums[LANES] = {0}, squares[LANES] = {0};
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++) {
            double difference = block->seen[i + k] - block->expected[i + k];
            block->difference[i + k] = fabs(difference);
            sums[k] += difference;
            squares[k] += difference * difference;
        }
    samples->sum += lane_sum(sums);
    samples->sum_of_squares += lane_sum(squares);
}

/* How many values are above factor x limits (NaN is above all). */
static double count_above(const double *values, double factor, const double *limits, size_t all)
{
    double above[LANES] = {0};
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++)
            above[k] += values[i + k] <= factor * limits[i + k] ? 0.0 : 1.0;
    return lane_sum(above);
}

/* The largest of the values and what is known already; looks closer only where one is larger. */
static void raise_to(double *largest, const double *values, size_t n, size_t all)
{
    double above[LANES] = {0};
    for (size_t i = 0; i < all; i += LANES)
        for (size_t k = 0; k < LANES; k++)
            above[k] += values[i + k] <= *largest ? 0.0 : 1.0;
    for (size_t i = 0; i < n && lane_sum(above) > 0; i++)
        *largest = fmax(*largest, values[i]);
}

static void raise_ratio(double *worst, const struct block *block, size_t all)
{
    if (count_above(block->difference, *worst, block->bound, all) == 0)
        return;
    for (size_t i = 0; i < block->n; i++)
        if (block->difference[i] <= block->bound[i] &&
            block->difference[i] > *worst * block->bound[i])
            *worst = block->difference[i] / block->bound[i];
}

bool samples_compare(struct check_samples *samples, struct block *block)
{
    size_t all = fill_lanes(block);
    int exact = 0, within_1 = 0;
    differ(samples, block, all);
    for (size_t i = 0; i < block->n; i++) {
        int apart = counts_round(block->seen[i]) - counts_round(block->expected[i]);
        exact += apart == 0;
        within_1 += apart >= -1 && apart <= 1;
    }
    samples->n += block->n;
    samples->exact += (uint64_t)exact;
    samples->within_1 += (uint64_t)within_1;
    raise_to(&samples->largest, block->difference, block->n, all);
    raise_ratio(&samples->worst_ratio, block, all);
    return count_above(block->difference, 1, block->bound, all) == 0;
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
    to->n += from->n;
    to->worst = fmax(to->worst, from->worst);
}

/* ---- all of it ---- */

void tally_add(struct check_tally *to, const struct check_tally *from)
{
    samples_add(&to->samples, &from->samples);
    floor_add(&to->floor, &from->floor);
    floor_add(&to->smooth_floor, &from->smooth_floor);
    to->pixels += from->pixels;
    to->ambiguous += from->ambiguous;
    to->unexplained += from->unexplained;
    to->unbounded += from->unbounded;
    to->edge_holes += from->edge_holes;
    to->edge_doubles += from->edge_doubles;
    to->worst_depth_ratio = fmax(to->worst_depth_ratio, from->worst_depth_ratio);
    if (!to->first.found)
        to->first = from->first;
}
