/* SPDX-License-Identifier: MIT */
/* Which facets cover each pixel of a chunk: the reference's own fragment, and every other one that
 * OpenGL may show there without being wrong.
 *
 * With p the pixel centre and a, b two corners minus p, the edge function a x b is twice the area
 * of the triangle (p, a, b). Swapping a and b changes exactly its sign in floating point too, so
 * that two triangles with a common edge never both own, nor both miss, a pixel. Moving a and b by
 * up to e in x and y changes a x b by at most e (|a|_1 + |b|_1) + 2 e^2: the slack. A fragment
 * whose three edge functions exceed their slack is definite, one within it is possible. */
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

static void drop_hidden(struct coverage *coverage, struct pixel *pixel)
{
    int32_t *link = &pixel->head;
    while (*link >= 0) {
        struct fragment *fragment = &coverage->fragments[*link];
        if (fragment->nearest <= pixel->limit) {
            link = &fragment->next;
            continue;
        }
        int32_t dropped = *link;
        *link = fragment->next;
        fragment->next = coverage->unused;
        coverage->unused = dropped;
    }
}

/* Adds a possible or definite fragment to a pixel's candidates. One of any depth is loose. */
static bool add_fragment(struct coverage *coverage, struct pixel *pixel, int32_t facet,
                         double depth, double error, bool definite)
{
    if (depth - error > pixel->limit)
        return true;
    if (definite && depth + error < pixel->limit) {
        pixel->limit = depth + error;
        drop_hidden(coverage, pixel);
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
    coverage->fragments[place] =
        (struct fragment){facet, pixel->head, error == HUGE_VAL, depth - error};
    pixel->head = place;
    return true;
}

static double cross(double ax, double ay, double bx, double by)
{
    return ax * by - bx * ay;
}

void edges_at(const double x[3], const double y[3], double px, double py, double error,
              struct edge_values *out)
{
    double dx[3], dy[3], reach[3];
    for (int i = 0; i < 3; i++) {
        dx[i] = x[i] - px;
        dy[i] = y[i] - py;
        reach[i] = fabs(dx[i]) + fabs(dy[i]);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out->e[i] = cross(dx[j], dy[j], dx[k], dy[k]);
        out->slack[i] = error * (reach[j] + reach[k]) + 2 * error * error;
    }
}

/* A centre exactly on an edge belongs to the triangle whose edge runs this way, not to the one
 * whose edge runs back. */
static bool owns_edge(const struct facet *facet, int edge)
{
    int j = (edge + 1) % 3, k = (edge + 2) % 3;
    double dx = facet->x[k] - facet->x[j], dy = facet->y[k] - facet->y[j];
    return dy < 0 || (dy == 0 && dx > 0);
}

static bool covers(const struct facet *facet, const struct edge_values *edges)
{
    for (int i = 0; i < 3; i++)
        if (edges->e[i] < 0 || (edges->e[i] == 0 && !owns_edge(facet, i)))
            return false;
    return facet->twice_area > 0;
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

/* Notes the pieces that have no bound, so that only pixels upon them go without. */
static bool note_thin_pieces(struct coverage *coverage, struct facet *facet)
{
    struct piece pieces[CLIP_CORNERS - 2];
    int n = facet_pieces(coverage->plan, coverage->surfaces, coverage->tile, facet, pieces);
    facet->first_thin = (int32_t)coverage->n_thin;
    for (int i = 0; i < n; i++) {
        if (bound_magnification(&pieces[i].outline) < HUGE_VAL)
            continue;
        if (!array_grow(&coverage->thin, &coverage->thin_capacity, coverage->n_thin + 1,
                        sizeof *coverage->thin))
            return false;
        coverage->thin[coverage->n_thin++] = pieces[i].outline;
        facet->n_thin++;
    }
    return true;
}

static double least(const double v[3])
{
    return fmin(v[0], fmin(v[1], v[2]));
}

static double most(const double v[3])
{
    return fmax(v[0], fmax(v[1], v[2]));
}

/* Whether OpenGL may show a triangle at a point. One without area touches its longest edge only. */
static bool touches(const struct outline *outline, double px, double py)
{
    const double *x = outline->x, *y = outline->y, error = outline->slack_px + SNAP_PX;
    struct edge_values edges;
    edges_at(x, y, px, py, error, &edges);
    double turn = edges.e[0] + edges.e[1] + edges.e[2] < 0 ? -1 : 1;
    bool inside = least(x) - error <= px && px <= most(x) + error && least(y) - error <= py &&
                  py <= most(y) + error;
    for (int i = 0; i < 3; i++)
        inside = inside && turn * edges.e[i] >= -edges.slack[i];
    return inside;
}

static bool is_thin_at(const struct coverage *coverage, const struct facet *facet, double px,
                       double py)
{
    for (int32_t i = 0; i < facet->n_thin; i++)
        if (touches(&coverage->thin[facet->first_thin + i], px, py))
            return true;
    return false;
}

static bool visit_pixel(struct coverage *coverage, int32_t index, int x, int y, double error)
{
    const struct facet *facet = &coverage->facets[index];
    struct edge_values edges;
    edges_at(facet->x, facet->y, x + 0.5, y + 0.5, error, &edges);
    bool possible = true, definite = true;
    for (int i = 0; i < 3; i++) {
        possible = possible && edges.e[i] >= -edges.slack[i];
        definite = definite && edges.e[i] > edges.slack[i];
    }
    if (!possible)
        return true;
    struct pixel *pixel =
        &coverage->pixels[(size_t)(y - coverage->rows.y) * (size_t)coverage->rows.width +
                          (size_t)(x - coverage->rows.x)];
    double depth = depth_at(facet, &edges);
    if (depth >= 0 && depth < 1 && depth < pixel->winner_depth && covers(facet, &edges)) {
        pixel->winner = index;
        pixel->winner_depth = depth;
    }
    if (!coverage->plan->options.check)
        return true;
    bool thin = is_thin_at(coverage, facet, x + 0.5, y + 0.5);
    double depth_error = thin ? HUGE_VAL : facet->depth_error;
    definite = definite && depth > depth_error && depth < 1 - depth_error;
    return add_fragment(coverage, pixel, index, depth, depth_error, definite);
}

static int clamp_to(double value, int low, int high)
{
    return value < low ? low : value > high ? high : (int)value;
}

static bool scan_facet(struct coverage *coverage, int32_t index)
{
    const struct facet *facet = &coverage->facets[index];
    const struct tile *rows = &coverage->rows;
    double error = facet->slack_px + SNAP_PX;
    int left = clamp_to(floor(least(facet->x) - error - 0.5), rows->x, rows->x + rows->width);
    int right = clamp_to(ceil(most(facet->x) + error + 0.5), rows->x, rows->x + rows->width);
    int top = clamp_to(floor(least(facet->y) - error - 0.5), rows->y, rows->y + rows->height);
    int bottom = clamp_to(ceil(most(facet->y) + error + 0.5), rows->y, rows->y + rows->height);
    for (int y = top; y < bottom; y++)
        for (int x = left; x < right; x++)
            if (!visit_pixel(coverage, index, x, y, error))
                return false;
    return true;
}

static bool cover_triangle(struct coverage *coverage, int surface, int triangle)
{
    struct facet facets[FACETS_PER_TRIANGLE];
    int n = facets_of(coverage->plan, coverage->surfaces, surface, triangle, coverage->tile,
                      &coverage->rows, facets);
    for (int i = 0; i < n; i++) {
        if (!array_grow(&coverage->facets, &coverage->facet_capacity, coverage->n_facets + 1,
                        sizeof *coverage->facets))
            return false;
        if (facets[i].thin && !note_thin_pieces(coverage, &facets[i]))
            return false;
        coverage->facets[coverage->n_facets] = facets[i];
        if (!scan_facet(coverage, (int32_t)coverage->n_facets++))
            return false;
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
        coverage->pixels[i] = (struct pixel){-1, -1, HUGE_VAL, HUGE_VAL};
    for (int s = 0; s < coverage->plan->n_bodies; s++) {
        if (!surface_reaches(&coverage->surfaces[s], &coverage->rows))
            continue;
        int n_triangles = coverage->surfaces[s].mesh->n_triangles;
        for (int t = 0; t < n_triangles; t++)
            if (!cover_triangle(coverage, s, t))
                return false;
    }
    return true;
}

void coverage_free(struct coverage *coverage)
{
    free(coverage->pixels);
    free(coverage->facets);
    free(coverage->fragments);
    free(coverage->thin);
}
