/* SPDX-License-Identifier: MIT */
/* A set of edges, with open addressing: an edge lies in the first free slot from its own on. */
#include <math.h>
#include <stdlib.h>

#include "data/index/index.h"
#include "raster/refine/refine.h"

/* Eye space measures the visible part of the scene 1024 to 2048: so places of 2^-24 of it are one.
 */
static const double grid = 0x1p14;

uint64_t edge_end(struct vector eye)
{
    uint64_t hash = hash_bits((uint64_t)(int64_t)floor(eye.x * grid + 0.5));
    hash = hash_bits(hash + (uint64_t)(int64_t)floor(eye.y * grid + 0.5));
    return hash_bits(hash + (uint64_t)(int64_t)floor(eye.z * grid + 0.5));
}

uint64_t edge_between(uint64_t a, uint64_t b)
{
    const uint64_t edge = a < b ? hash_bits(a) ^ b : hash_bits(b) ^ a;
    return edge > 0 ? edge : 1;
}

static struct edge_slot *slot_of(const struct edge_set *set, uint64_t edge)
{
    size_t i = (size_t)edge & (set->n_slots - 1);
    while (set->slots[i].edge > 0 && set->slots[i].edge != edge)
        i = (i + 1) & (set->n_slots - 1);
    return &set->slots[i];
}

/* Gives the set so many slots, and its edges new places. */
static bool resize(struct edge_set *set, size_t n_slots, struct error *err)
{
    struct edge_set larger = {calloc(n_slots, sizeof *larger.slots), n_slots, set->n};
    if (!larger.slots)
        return error_memory(err);
    for (size_t i = 0; i < set->n_slots; i++)
        if (set->slots[i].edge > 0)
            *slot_of(&larger, set->slots[i].edge) = set->slots[i];
    free(set->slots);
    *set = larger;
    return true;
}

bool edges_add(struct edge_set *set, uint64_t edge, float error, struct error *err)
{
    enum { FEWEST_SLOTS = 1024 };
    if (2 * set->n >= set->n_slots &&
        !resize(set, set->n_slots > 0 ? 2 * set->n_slots : FEWEST_SLOTS, err))
        return false;
    struct edge_slot *slot = slot_of(set, edge);
    set->n += slot->edge == 0;
    *slot = (struct edge_slot){edge, fmaxf(error, slot->error)};
    return true;
}

bool edges_have(const struct edge_set *set, uint64_t edge)
{
    return set->n > 0 && slot_of(set, edge)->edge > 0;
}

float edges_error(const struct edge_set *set, uint64_t edge)
{
    return slot_of(set, edge)->error;
}

static int compare_errors(const void *a, const void *b)
{
    const float one = *(const float *)a, two = *(const float *)b;
    return (one < two) - (one > two);
}

bool edges_keep_worst(struct edge_set *set, size_t most, struct error *err)
{
    struct edge_set kept = {.slots = NULL};
    float *errors = malloc((set->n + 1) * sizeof *errors);
    size_t n = 0;
    if (!errors)
        return error_memory(err);
    for (size_t i = 0; i < set->n_slots; i++)
        if (set->slots[i].edge > 0)
            errors[n++] = set->slots[i].error;
    qsort(errors, n, sizeof *errors, compare_errors);
    const float least = most < n ? errors[most] : 0;
    bool done = true;
    for (size_t i = 0; done && i < set->n_slots; i++)
        if (set->slots[i].edge > 0 && set->slots[i].error > least)
            done = edges_add(&kept, set->slots[i].edge, set->slots[i].error, err);
    free(errors);
    edges_free(set);
    *set = kept;
    return done;
}

void edges_free(struct edge_set *set)
{
    free(set->slots);
    *set = (struct edge_set){.slots = NULL};
}
