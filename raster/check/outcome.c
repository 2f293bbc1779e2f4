/* SPDX-License-Identifier: MIT */
/* The verdict on the picture: how much of it was checked, and whether it agrees on average. */
#include <float.h>
#include <math.h>

#include "data/stack/stack.h"
#include "raster/check/inside.h"

/* ---- totals ---- */

const struct check_verdict empty_verdict = {.samples = {.worst_ratio = -1, .worst_fit_ratio = -1},
                                            .worst_depth_ratio = -1};

bool totals_open(const struct check_scene *scene, struct check_totals *out, struct error *err)
{
    const struct plan *plan = scene->lit->plan;
    const int n = plan->n_instances;
    *out = (struct check_totals){.scene = scene, .verdict = empty_verdict};
    if (!MAKE_ARRAY(out->first, n, err, "%d objects", n) ||
        !MAKE_ARRAY(out->unchecked, n, err, "%d objects", n))
        return false;
    for (int s = 0; s < n; s++) {
        out->first[s] = out->n_triangles;
        out->n_triangles += (size_t)plan->instances[s].instance.n_triangles;
    }
    return MAKE_ARRAY(out->varying, out->n_triangles, err, "%zu triangles", out->n_triangles);
}

void totals_free(struct check_totals *totals)
{
    FREE_ALL(totals->first, totals->unchecked, totals->varying);
    *totals = (struct check_totals){.scene = NULL};
}

double checked_counts(const struct plan *plan)
{
    return CHECKED_COUNTS + buffer_rounding(plan);
}

void totals_note(struct check_totals *totals, int surface, int triangle, double floor,
                 const struct mean_bound *mean)
{
    const double counts = shaded_brightest(totals->scene->lit->bounds[surface].shaded) /
                          totals->scene->lit->full_scale * FULL_COUNT;
    const bool bounded = floor < FULL_COUNT,
               checked = floor <= checked_counts(totals->scene->lit->plan);
    totals->verdict.objects++;
    totals->verdict.unbounded += !bounded;
    totals->verdict.unchecked += !checked;
    totals->verdict.between += !checked && mean->cause == CAUSE_EDGE;
    totals->unchecked[surface][mean->cause] += !checked;
    if (!(floor < HUGE_VAL)) /* its samples are in no sum */
        return;
    /* a float below the least normal number may have lost its digits */
    totals->shared += ((double)mean->shared + (double)FLT_MIN) * counts;
    totals->varying[totals->first[surface] + (size_t)triangle] += (double)mean->varying * counts;
}

/* ---- the mean residual ---- */

double mean_residual(const struct check_samples *samples)
{
    return samples->n ? samples->sum / (double)samples->n : (double)NAN;
}

static const double chance = 21.4164; /* ln(2 x 10^9) */

/* Errors that follow from the vertices may be the same at all pixels of an object, in all objects:
 * their bounds add up. Errors of positions and interpolation are taken to be as often positive as
 * negative, and to be independent from triangle to triangle, but not within one. A sum of
 * independent errors e_i with a mean of 0, each at most b_i, exceeds s with a probability of at
 * most 2 exp(-s^2 / (2 sum b_i^2)) (Hoeffding 1963). The limit leaves 10^-9 for that: s^2 is 2 ln(2
 * x 10^9) sum b_i^2. A colour buffer of steps that cuts samples off leaves no limit. */
static double mean_limit(const struct check_totals *totals)
{
    const struct plan *plan = totals->scene->lit->plan;
    if (totals->scene->lit->clips && buffer_steps(plan) > 0)
        return HUGE_VAL;
    const double pixels = (double)totals->verdict.pixels;
    double squares = 0;
    for (size_t i = 0; i < totals->n_triangles; i++)
        squares += totals->varying[i] * totals->varying[i];
    return (totals->shared + sqrt(2 * chance * squares)) / pixels + buffer_rounding(plan) +
           FLUSHED_COUNTS;
}

bool is_biased(const struct check_verdict *verdict)
{
    return fabs(mean_residual(&verdict->samples)) > verdict->mean_limit;
}

/* ---- the verdict ---- */

uint64_t check_unchecked(const struct check_verdict *verdict)
{
    const struct stack_verdict sums = {
        .unchecked = verdict->unchecked, .objects = verdict->objects, .edges = verdict->between};
    return stack_unchecked(&sums, verdict->most_unchecked);
}

/* Finds the surface with most of the unchecked pixels that decide, and the cause of most of those.
 */
static void find_unchecked(struct check_totals *totals)
{
    const struct plan *plan = totals->scene->lit->plan;
    const bool besides_edges = check_unchecked(&totals->verdict) < totals->verdict.unchecked;
    const int n_causes = besides_edges ? CAUSE_EDGE : BOUND_CAUSES;
    uint64_t most = 0, largest = 0;
    totals->verdict.unchecked_surface = -1;
    for (int s = 0; s < plan->n_instances; s++) {
        uint64_t sum = 0;
        for (int c = 0; c < n_causes; c++)
            sum += totals->unchecked[s][c];
        if (sum > most) {
            most = sum;
            totals->verdict.unchecked_surface = s;
        }
    }
    for (int c = 0; c < n_causes && most > 0; c++) {
        uint64_t n = totals->unchecked[totals->verdict.unchecked_surface][c];
        if (n > largest) {
            largest = n;
            totals->verdict.unchecked_cause = (enum bound_cause)c;
        }
    }
}

void totals_finish(struct check_totals *totals)
{
    totals->verdict.mean_limit = mean_limit(totals);
    totals->verdict.most_unchecked = totals->scene->limits->unchecked;
    find_unchecked(totals);
}

enum check_outcome check_outcome(const struct check_verdict *verdict)
{
    if (verdict->unexplained > 0 || is_biased(verdict))
        return OUTCOME_DIFFERS;
    return (double)check_unchecked(verdict) > verdict->most_unchecked * (double)verdict->objects
               ? OUTCOME_NOT_VERIFIED
               : OUTCOME_AGREED;
}
