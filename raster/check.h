/* SPDX-License-Identifier: MIT */
/* What the files of the verdict share: counts.c says what a sample should be, tally.c how samples
 * compare with that, check.c what it means for a pixel. Nobody else includes this but a test. */
#ifndef CHECK_H
#define CHECK_H

#include "raster/raster.h"

/* ---- raster/counts.c ---- */

/* Pixels evaluated together, few enough to stay in the first-level cache. */
enum { BLOCK = 256 };
enum { FULL_COUNT = 65535 };

/* How a run of pixels of one surface keeps its finish_rows, `stride` apart. */
struct rows {
    const double *weights;
    const float *errors; /* NULL: no bounds are wanted */
    size_t stride;
};
/* Counts of a run of n <= BLOCK pixels in one band, before rounding, and bounds on OpenGL's error
 * where errors are given; what has no finite bound gets -1, which explains nothing. */
void counts_expect(const struct plan *plan, const struct finish *finish, const struct rows *rows,
                   size_t n, int band, double full_scale, double *expected, float *bound);
/* As stored: clamped and rounded; NaN becomes 0. Here, so that loops over samples take it in. */
static inline double counts_clamp(double counts)
{
    double positive = counts > 0 ? counts : 0;
    return positive < FULL_COUNT ? positive : FULL_COUNT;
}
static inline int counts_round(double counts)
{
    return (int)(counts_clamp(counts) + 0.5);
}

/* ---- raster/tally.c ---- */

/* Samples together with what is expected of them. */
struct block {
    size_t n;
    double seen[BLOCK], expected[BLOCK];
    float bound[BLOCK], difference[BLOCK];
};
/* Adds a block to a comparison, and fills the magnitudes of its differences; false when any is
 * outside its bound. */
bool samples_compare(struct check_samples *samples, struct block *block);
void samples_add(struct check_samples *to, const struct check_samples *from);
void floor_note(struct check_floor *to, double counts);
void tally_add(struct check_tally *to, const struct check_tally *from);

#endif
