/* SPDX-License-Identifier: MIT */
/* The sums of a tile as bytes. One function names all members, for both directions. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "raster/verdict/verdict.h"

/* Bytes that are written or read, from the first to the last. */
struct packed {
    unsigned char *to;         /* NULL: they are read */
    const unsigned char *from; /* NULL: they are written */
    size_t length, at;
    bool failed; /* there are too few bytes, or a number is impossible */
};

static void pass(struct packed *packed, void *member, size_t size)
{
    if (packed->failed || size > packed->length - packed->at) {
        packed->failed = true;
        return;
    }
    if (packed->from)
        memcpy(member, packed->from + packed->at, size);
    else
        memcpy(packed->to + packed->at, member, size);
    packed->at += size;
}

/* Passes a whole number from lowest to highest. */
static void pass_int(struct packed *packed, int *number, int lowest, int highest)
{
    pass(packed, number, sizeof *number);
    packed->failed = packed->failed || *number < lowest || *number > highest;
}

/* A long has as many bytes as the machine likes. */
static void pass_long(struct packed *packed, long *number)
{
    int64_t wide = *number;
    pass(packed, &wide, sizeof wide);
    packed->failed = packed->failed || wide < 0 || wide > LONG_MAX;
    *number = packed->failed ? 0 : (long)wide;
}

static void pass_samples(struct packed *packed, struct check_samples *samples)
{
    pass(packed, &samples->n, sizeof samples->n);
    pass(packed, &samples->exact, sizeof samples->exact);
    pass(packed, &samples->within_1, sizeof samples->within_1);
    pass(packed, &samples->largest, sizeof samples->largest);
    pass(packed, &samples->sum, sizeof samples->sum);
    pass(packed, &samples->sum_of_squares, sizeof samples->sum_of_squares);
    pass(packed, &samples->worst_ratio, sizeof samples->worst_ratio);
    pass(packed, &samples->worst_fit_ratio, sizeof samples->worst_fit_ratio);
}

static void pass_floor(struct packed *packed, struct check_floor *floor)
{
    pass(packed, &floor->n, sizeof floor->n);
    pass(packed, floor->bins, sizeof floor->bins);
    pass(packed, floor->within, sizeof floor->within);
    pass(packed, &floor->worst, sizeof floor->worst);
}

static void pass_failure(struct packed *packed, const struct plan *plan,
                         struct check_failure *failure)
{
    int found = failure->found, kind = (int)failure->kind;
    pass_int(packed, &found, 0, 1);
    failure->found = found;
    if (packed->failed || !found)
        return;
    pass_int(packed, &kind, 0, FAILURE_FRAGMENTS);
    failure->kind = (enum failure_kind)kind;
    pass_int(packed, &failure->x, 0, plan->view.width - 1);
    pass_int(packed, &failure->y, 0, plan->view.height - 1);
    pass_int(packed, &failure->surface, -1, plan->n_instances - 1);
    pass(packed, &failure->shown.surface, sizeof failure->shown.surface);
    pass(packed, &failure->shown.triangle, sizeof failure->shown.triangle);
    pass(packed, &failure->shown.depth, sizeof failure->shown.depth);
    pass(packed, &failure->shown.fragments, sizeof failure->shown.fragments);
    pass_int(packed, &failure->band, 0, plan->n_bands - 1);
    pass(packed, &failure->seen, sizeof failure->seen);
    pass(packed, &failure->expected, sizeof failure->expected);
    pass(packed, &failure->bound, sizeof failure->bound);
}

/* Passes what verdict_add adds. */
static void pass_verdict(struct packed *packed, const struct plan *plan,
                         struct check_verdict *verdict)
{
    pass_samples(packed, &verdict->samples);
    pass(packed, &verdict->pixels, sizeof verdict->pixels);
    pass(packed, &verdict->ambiguous, sizeof verdict->ambiguous);
    pass(packed, &verdict->unexplained, sizeof verdict->unexplained);
    pass(packed, &verdict->objects, sizeof verdict->objects);
    pass(packed, &verdict->unbounded, sizeof verdict->unbounded);
    pass(packed, &verdict->unchecked, sizeof verdict->unchecked);
    pass(packed, &verdict->edge_holes, sizeof verdict->edge_holes);
    pass(packed, &verdict->edge_doubles, sizeof verdict->edge_doubles);
    pass(packed, &verdict->worst_depth_ratio, sizeof verdict->worst_depth_ratio);
    pass_floor(packed, &verdict->floor);
    pass_floor(packed, &verdict->smooth_floor);
    pass_floor(packed, &verdict->band_floor);
    pass_failure(packed, plan, &verdict->first);
}

/* Passes the triangles that the tile shows, each with its sum. */
static void pass_shown(struct packed *packed, struct check_totals *totals)
{
    uint64_t n = totals->n_shown;
    pass(packed, &n, sizeof n);
    packed->failed = packed->failed || n > totals->most_shown;
    for (uint64_t i = 0; i < n && !packed->failed; i++) {
        uint64_t shown = totals->shown[i];
        pass(packed, &shown, sizeof shown);
        if (packed->failed || shown >= totals->n_triangles) {
            packed->failed = true;
            return;
        }
        totals->shown[i] = (size_t)shown;
        pass(packed, &totals->varying[shown], sizeof *totals->varying);
    }
    totals->n_shown = packed->failed ? 0 : (size_t)n;
}

static void pass_totals(struct packed *packed, struct check_totals *totals)
{
    const struct plan *plan = totals->scene->lit->plan;
    pass_verdict(packed, plan, &totals->verdict);
    pass(packed, &totals->shared, sizeof totals->shared);
    pass(packed, totals->unchecked, (size_t)plan->n_instances * sizeof *totals->unchecked);
    pass_shown(packed, totals);
}

static void pass_sums(struct packed *packed, struct tile_sums *sums)
{
    pass(packed, &sums->odd.clipped, sizeof sums->odd.clipped);
    pass(packed, &sums->odd.undefined, sizeof sums->odd.undefined);
    pass_long(packed, &sums->light.points_lit);
    pass_long(packed, &sums->light.specular_vertices);
    pass_long(packed, &sums->light.power_functions);
    if (sums->totals.scene)
        pass_totals(packed, &sums->totals);
}

void sums_add(struct tile_sums *picture, struct tile_sums *tile)
{
    picture->odd.clipped += tile->odd.clipped;
    picture->odd.undefined += tile->odd.undefined;
    picture->light.points_lit += tile->light.points_lit;
    picture->light.specular_vertices += tile->light.specular_vertices;
    picture->light.power_functions += tile->light.power_functions;
    tile->odd = (struct odd_samples){0, 0};
    tile->light = (struct light_work){.points_lit = 0};
    if (tile->totals.scene)
        totals_add(&picture->totals, &tile->totals);
}

bool sums_pack(struct tile_sums *sums, unsigned char **out, size_t *length, struct error *err)
{
    const struct check_totals *totals = &sums->totals;
    size_t most = sizeof *sums;
    if (totals->scene)
        most += (size_t)totals->scene->lit->plan->n_instances * sizeof *totals->unchecked +
                totals->n_shown * (sizeof(uint64_t) + sizeof(double));
    struct packed packed = {.to = malloc(most), .length = most};
    if (!packed.to)
        return error_memory(err);
    pass_sums(&packed, sums);
    *out = packed.to;
    *length = packed.at;
    return true;
}

bool sums_unpack(const unsigned char *bytes, size_t length, struct tile_sums *out)
{
    struct packed packed = {.from = bytes, .length = length};
    pass_sums(&packed, out);
    return !packed.failed && packed.at == length;
}
