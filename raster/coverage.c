/* SPDX-License-Identifier: MIT */
/* Which facets cover each pixel of a chunk: the reference's own fragment, every other one that
 * OpenGL may show there without being wrong, and how many there may be, hidden ones included. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "coverage.h"

bool array_grow(void *array, size_t *capacity, size_t needed, size_t size)
{
    void *old;
    memcpy(&old, array, sizeof old);
    if (needed <= *capacity)
        return true;
    size_t larger = *capacity * 2 > needed ? *capacity * 2 : needed + 256;
    if (larger > SIZE_MAX / size || larger > INT32_MAX)
        return false;
    void *moved = realloc(old, larger * size);
    if (!moved)
        return false;
    memcpy(array, &moved, sizeof moved);
    *capacity = larger;
    return true;
}

/* ---- visibility ---- */

/* Rids a pixel's list of what lies behind its limit. */
static void drop_hidden(struct coverage *coverage, struct pixel *pixel)
{
    int32_t *link = &pixel->head;
    while (*link >= 0) {
        struct fragment *fragment = &coverage->fragments[*link];
        if (fragment->depth - fragment->depth_error <= pixel->limit) {
            link = &fragment->next;
            continue;
        }
        int32_t dropped = *link;
        pixel->n_candidates--;
        *link = fragment->next;
        fragment->next = coverage->unused;
        coverage->unused = dropped;
    }
}

/* Adds a possible or definite fragment to a pixel's candidates. */
static bool add_fragment(struct coverage *coverage, struct pixel *pixel,
                         const struct fragment *fragment, bool definite)
{
    if (fragment->depth - fragment->depth_error > pixel->limit)
        return true;
    if (definite)
        pixel->limit = fmin(pixel->limit, fragment->depth + fragment->depth_error);
    if (pixel->n_candidates >= 2 * pixel->n_pruned) { /* seldom enough that time stays linear */
        drop_hidden(coverage, pixel);
        pixel->n_pruned = pixel->n_candidates + 1;
    }
    int32_t place = coverage->unused;
    if (place >= 0) {
        coverage->unused = coverage->fragments[place].next;
    } else {
        if (!array_grow(&coverage->fragments, &coverage->fragment_capacity,
                        coverage->n_fragments + 1, sizeof *coverage->fragments))
            return false;
        place = (int32_t)coverage->n_fragments++;
    }
    coverage->fragments[place] = *fragment;
    coverage->fragments[place].next = pixel->head;
    pixel->head = place;
    pixel->n_candidates++;
    return true;
}

/* ---- how many fragments there are ---- */

/* Scatters bits (the finalizer of SplitMix64: Steele, Lea and Flood 2014). */
static uint64_t scatter(uint64_t bits)
{
    bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9u;
    bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebu;
    return bits ^ (bits >> 31);
}

static uint64_t corner_number(const struct facet *facet, int i, uint64_t object)
{
    uint64_t x, y;
    memcpy(&x, &facet->x[i], sizeof x);
    memcpy(&y, &facet->y[i], sizeof y);
    return scatter(scatter(scatter(object) + x) + y);
}

/* Adds the edges that OpenGL may put on either side of the centre. Triangles of one object that
 * meet have corners of the same bits there. */
static void add_edges(const struct coverage *coverage, const struct facet *facet,
                      const struct edge_values *edges, struct pixel *pixel)
{
    const struct scene *scene = coverage->plan->scene;
    uint64_t object = (uint64_t)(coverage->surfaces[facet->surface].body->object - scene->objects);
    for (int i = 0; i < 3; i++) {
        if (edges->e[i] > edges->slack[i])
            continue;
        uint64_t from = corner_number(facet, (i + 1) % 3, object),
                 to = corner_number(facet, (i + 2) % 3, object);
        pixel->edge_sum[facet->clockwise] += scatter(from + 2 * to) - scatter(to + 2 * from);
    }
}

static void count_fragment(const struct coverage *coverage, const struct facet *facet,
                           const struct edge_values *edges, enum presence presence, bool covered,
                           struct pixel *pixel)
{
    if (facet->other_side) /* counted as the one that it is */
        return;
    pixel->n_possible++;
    if (presence == DEFINITE) {
        pixel->n_definite++;
        return;
    }
    pixel->n_covered += covered;
    pixel->open = pixel->open || facet->edge_on || facet->cut;
    add_edges(coverage, facet, edges, pixel);
}

/* Depth is linear in the window. Sums of edge functions, not the area, make shares add up to 1. */
static double depth_at(const struct facet *facet, const struct edge_values *edges)
{
    double sum = edges->e[0] + edges->e[1] + edges->e[2];
    if (!(sum > 0))
        return facet->z[0];
    return (edges->e[0] * facet->z[0] + edges->e[1] * facet->z[1] + edges->e[2] * facet->z[2]) /
           sum;
}

static bool is_watertight(const struct coverage *coverage, const struct facet *facet)
{
    return coverage->surfaces[facet->surface].driver->watertight;
}

static bool note_pieces(struct coverage *coverage, struct facet *facet)
{
    if (!array_grow(&coverage->pieces, &coverage->piece_capacity, coverage->n_pieces + CLIP_CORNERS,
                    sizeof *coverage->pieces))
        return false;
    facet->first_piece = (int32_t)coverage->n_pieces;
    facet->n_pieces = facet_pieces(coverage->plan, coverage->surfaces, coverage->tile, facet,
                                   coverage->pieces + coverage->n_pieces);
    coverage->n_pieces += (size_t)facet->n_pieces;
    return true;
}

/* Whether a point lies where OpenGL sets two pieces of a facet side by side. */
static bool is_on_seam(const struct coverage *coverage, const struct facet *facet, double px,
                       double py)
{
    for (int32_t i = 0; i < facet->n_pieces && facet->n_pieces > 1; i++)
        if (outline_presence(&coverage->pieces[facet->first_piece + i].outline, px, py) == POSSIBLE)
            return true;
    return false;
}

static unsigned count_bits(unsigned bits)
{
    unsigned n = 0;
    for (; bits != 0; bits &= bits - 1)
        n++;
    return n;
}

unsigned pieces_at(const struct coverage *coverage, const struct facet *facet, double px, double py)
{
    unsigned all = (1u << facet->n_pieces) - 1, some = 0;
    if (facet->n_pieces == 1)
        return all;
    for (int32_t i = 0; i < facet->n_pieces; i++)
        if (outline_presence(&coverage->pieces[facet->first_piece + i].outline, px, py) !=
            IMPOSSIBLE)
            some |= 1u << i;
    return some == 0 && facet->cut ? all : some;
}

/* Whether OpenGL's error has no bound at a point: upon a piece that is too thin for one, where
 * depth has none either, or so far away that roundings of 1 / w, made where it is larger, may be
 * nearly all of it. */
static bool is_loose(const struct coverage *coverage, const struct facet *facet,
                     const struct edge_values *edges, unsigned pieces, bool *thin)
{
    double sum = 0, inverse_w = 0;
    bool far = false;
    for (int i = 0; i < 3; i++) {
        sum += edges->e[i];
        inverse_w += edges->e[i] * facet->inverse_w[i];
    }
    *thin = false;
    for (int32_t i = 0; i < facet->n_pieces; i++) {
        const struct piece *piece = &coverage->pieces[facet->first_piece + i];
        const struct inverse_w_bound *bound = &piece->inverse_w_bound;
        if (!(pieces >> i & 1))
            continue;
        *thin = *thin || !(piece->magnification < HUGE_VAL);
        far = far || !(1.125 * (bound->fixed * sum + bound->per_d * inverse_w) <= inverse_w);
    }
    return *thin || far;
}

/* A fragment of a facet that OpenGL has, or may have. */
static bool judge_fragment(struct coverage *coverage, int32_t index,
                           const struct edge_values *edges, enum presence presence, unsigned pieces,
                           bool covered, struct pixel *pixel)
{
    const struct facet *facet = &coverage->facets[index];
    struct fragment fragment = {.facet = index, .depth = depth_at(facet, edges)};
    bool thin;
    fragment.loose = is_loose(coverage, facet, edges, pieces, &thin);
    fragment.depth_error = thin ? HUGE_VAL : facet->depth_error;
    /* the near or the far plane may cut it off */
    if (!(fragment.depth > fragment.depth_error && fragment.depth < 1 - fragment.depth_error)) {
        presence = POSSIBLE;
        pixel->open = true;
    }
    count_fragment(coverage, facet, edges, presence, covered, pixel);
    return coverage->surfaces[facet->surface].body->twin ||
           add_fragment(coverage, pixel, &fragment, presence == DEFINITE);
}

/* *any: whether there may be a fragment. */
static bool visit_pixel(struct coverage *coverage, int32_t index, int x, int y, bool *any)
{
    const struct facet *facet = &coverage->facets[index];
    struct edge_values edges;
    edges_at(facet->x, facet->y, x + 0.5, y + 0.5, facet->edge_px, &edges);
    enum presence presence = edges_presence(facet, &edges);
    if (presence == IMPOSSIBLE)
        return true;
    struct pixel *pixel =
        &coverage->pixels[(size_t)(y - coverage->rows.y) * (size_t)coverage->rows.width +
                          (size_t)(x - coverage->rows.x)];
    double depth = depth_at(facet, &edges);
    bool covered = depth >= 0 && depth < 1 && (presence == DEFINITE || edges_cover(facet, &edges));
    if (covered && depth < pixel->winner_depth) {
        pixel->winner = index;
        pixel->winner_depth = depth;
    }
    *any = true;
    if (!coverage->plan->options.check)
        return true;
    unsigned pieces = pieces_at(coverage, facet, x + 0.5, y + 0.5);
    if (pieces == 0)
        return true;
    if (!is_watertight(coverage, facet) && is_on_seam(coverage, facet, x + 0.5, y + 0.5)) {
        presence = POSSIBLE;
        if (!facet->other_side) /* a fragment by each piece */
            pixel->n_possible += count_bits(pieces) - 1;
    }
    return judge_fragment(coverage, index, &edges, presence, pieces, covered, pixel);
}

static int clamp_to(double value, int low, int high)
{
    return value < low ? low : value > high ? high : (int)value;
}

/* Leaves of a row's pixels, from *left up to *right, those that all edges may have inside, and a
 * few more. Edge functions are linear along a row; `slack` is above that of all its pixels. */
static void narrow_row(const struct facet *facet, int y, double slack, int *left, int *right)
{
    double py = y + 0.5, px = *left + 0.5;
    int first = *left, last = *right;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double p = (facet->x[j] - px) * (facet->y[k] - py),
               q = (facet->x[k] - px) * (facet->y[j] - py), step = facet->y[j] - facet->y[k];
        double inside = p - q + slack + 1e-15 * (fabs(p) + fabs(q)), pixels = -inside / step;
        if (step > 0 && pixels > 2)
            *left = clamp_to(fmax(*left, first + pixels - 2), first, last);
        if (step < 0 && pixels < last - first)
            *right = clamp_to(fmin(*right, first + pixels + 2), first, last);
    }
}

/* *any: whether there may be a fragment of the facet. */
static bool scan_facet(struct coverage *coverage, int32_t index, bool *any)
{
    const struct facet *facet = &coverage->facets[index];
    const struct tile *rows = &coverage->rows;
    double error = most_of(facet->edge_px);
    int left = clamp_to(floor(least_of(facet->x) - error - 0.5), rows->x, rows->x + rows->width);
    int right = clamp_to(ceil(most_of(facet->x) + error + 0.5), rows->x, rows->x + rows->width);
    int top = clamp_to(floor(least_of(facet->y) - error - 0.5), rows->y, rows->y + rows->height);
    int bottom = clamp_to(ceil(most_of(facet->y) + error + 0.5), rows->y, rows->y + rows->height);
    double reach =
        most_of(facet->x) - least_of(facet->x) + most_of(facet->y) - least_of(facet->y) + 2;
    double slack = 2 * error * (reach + 3 * error);
    for (int y = top; y < bottom; y++) {
        int first = left, last = right;
        narrow_row(facet, y, slack, &first, &last);
        for (int x = first; x < last; x++)
            if (!visit_pixel(coverage, index, x, y, any))
                return false;
    }
    return true;
}

/* Facets without a fragment are forgotten at once: there may be thousands to a pixel. */
static bool cover_triangle(struct coverage *coverage, int surface, int triangle)
{
    struct facet facets[FACETS_PER_TRIANGLE];
    int n = facets_of(coverage->plan, coverage->surfaces, surface, triangle, coverage->tile,
                      &coverage->rows, facets);
    for (int i = 0; i < n; i++) {
        bool any = false;
        size_t n_pieces = coverage->n_pieces;
        if (!array_grow(&coverage->facets, &coverage->facet_capacity, coverage->n_facets + 1,
                        sizeof *coverage->facets))
            return false;
        if (coverage->plan->options.check && !note_pieces(coverage, &facets[i]))
            return false;
        coverage->facets[coverage->n_facets] = facets[i];
        if (!scan_facet(coverage, (int32_t)coverage->n_facets, &any))
            return false;
        if (any)
            coverage->n_facets++;
        else
            coverage->n_pieces = n_pieces;
    }
    return true;
}

bool coverage_fill(struct coverage *coverage)
{
    size_t n_pixels = (size_t)coverage->rows.width * (size_t)coverage->rows.height;
    coverage->unused = -1;
    coverage->pixels = malloc(n_pixels * sizeof *coverage->pixels);
    if (!coverage->pixels)
        return false;
    for (size_t i = 0; i < n_pixels; i++)
        coverage->pixels[i] =
            (struct pixel){.winner = -1, .head = -1, .winner_depth = HUGE_VAL, .limit = HUGE_VAL};
    for (int s = 0; s < coverage->plan->n_bodies; s++) {
        if (!surface_reaches(&coverage->surfaces[s], &coverage->rows))
            continue;
        int n_triangles = coverage->surfaces[s].mesh->n_triangles;
        for (int t = 0; t < n_triangles; t++)
            if (!cover_triangle(coverage, s, t))
                return false;
    }
    for (size_t i = 0; i < n_pixels; i++)
        drop_hidden(coverage, &coverage->pixels[i]);
    return true;
}

void coverage_free(struct coverage *coverage)
{
    free(coverage->pixels);
    free(coverage->facets);
    free(coverage->fragments);
    free(coverage->pieces);
}
