/* SPDX-License-Identifier: MIT */
/* The reference rasterizer: which fragment covers each pixel, its weights by perspective-correct
 * interpolation, and every other fragment that OpenGL may show there without being wrong.
 *
 * With p the pixel centre and a, b two corners minus p, the edge function a x b is twice the area
 * of the triangle (p, a, b). Swapping a and b changes exactly its sign in floating point too, so
 * that two triangles with a common edge never both own, nor both miss, a pixel. Moving a and b by
 * up to e in x and y changes a x b by at most e (|a|_1 + |b|_1) + 2 e^2: the slack. A fragment
 * whose three edge functions exceed their slack is definite, one within it is possible. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "spectral.h"

/* OpenGL may snap corners to a grid of 1/256 pixel before it tests coverage: half a step, plus the
 * rounding of the coordinate itself, which place_vertex has counted. */
static const double snap_px = 1.0 / 512;

/* ---- the state of a chunk while facets go by ---- */

/* A fragment kept for a pixel: a link in the pixel's list. */
struct fragment {
    int32_t facet, next;
    double nearest; /* lower bound on its depth in OpenGL */
};
struct pixel {
    int32_t winner; /* facet of the reference's own fragment; -1: none */
    int32_t head;   /* first fragment of the list of candidates; -1: empty */
    double winner_depth;
    double limit; /* upper bound on the depth of the nearest definite fragment; HUGE_VAL: none */
};
struct coverage {
    const struct plan *plan;
    const struct surface *surfaces;
    const struct tile *tile; /* as OpenGL draws it */
    struct tile rows;        /* this chunk's part */
    struct pixel *pixels;
    struct facet *facets;
    struct fragment *fragments;
    size_t n_facets, n_fragments, facet_capacity, fragment_capacity;
    int32_t unused; /* list of fragments to use again */
    float *bounds;  /* [facet][1 + max_terms], filled when first needed */
    bool *bounded;
};

static bool grow(void *array, size_t *capacity, size_t needed, size_t size)
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

/* Adds a possible or definite fragment to a pixel's candidates. */
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
        if (!grow(&coverage->fragments, &coverage->fragment_capacity, coverage->n_fragments + 1,
                  sizeof *coverage->fragments))
            return false;
        place = (int32_t)coverage->n_fragments++;
    }
    coverage->fragments[place] = (struct fragment){facet, pixel->head, depth - error};
    pixel->head = place;
    return true;
}

/* Edge functions at a pixel centre; corner i is opposite to edge i. */
struct edge_values {
    double e[3];
    double slack[3];
};

static double cross(double ax, double ay, double bx, double by)
{
    return ax * by - bx * ay;
}

static void edges_at(const struct facet *facet, double px, double py, double error,
                     struct edge_values *out)
{
    double x[3], y[3], reach[3];
    for (int i = 0; i < 3; i++) {
        x[i] = facet->x[i] - px;
        y[i] = facet->y[i] - py;
        reach[i] = fabs(x[i]) + fabs(y[i]);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out->e[i] = cross(x[j], y[j], x[k], y[k]);
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

static bool visit_pixel(struct coverage *coverage, int32_t index, int x, int y, double error)
{
    const struct facet *facet = &coverage->facets[index];
    struct edge_values edges;
    edges_at(facet, x + 0.5, y + 0.5, error, &edges);
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
    definite = definite && depth > facet->depth_error && depth < 1 - facet->depth_error;
    return add_fragment(coverage, pixel, index, depth, facet->depth_error, definite);
}

static int clamp_to(double value, int low, int high)
{
    return value < low ? low : value > high ? high : (int)value;
}

static double least(const double v[3])
{
    return fmin(v[0], fmin(v[1], v[2]));
}

static double most(const double v[3])
{
    return fmax(v[0], fmax(v[1], v[2]));
}

static bool scan_facet(struct coverage *coverage, int32_t index)
{
    const struct facet *facet = &coverage->facets[index];
    const struct tile *rows = &coverage->rows;
    double error = facet->slack_px + snap_px;
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
        if (!grow(&coverage->facets, &coverage->facet_capacity, coverage->n_facets + 1,
                  sizeof *coverage->facets))
            return false;
        coverage->facets[coverage->n_facets] = facets[i];
        if (!scan_facet(coverage, (int32_t)coverage->n_facets++))
            return false;
    }
    return true;
}

static bool cover_all(struct coverage *coverage)
{
    size_t n_pixels = (size_t)coverage->rows.width * (size_t)coverage->rows.height;
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

/* ---- interpolation ---- */

/* Barycentric coordinates of a pixel centre in the whole triangle, perspective-correct. Outside the
 * facet they extrapolate; where it has no area they are those of its middle. */
static void shares_at(const struct facet *facet, double px, double py, double out[3])
{
    struct edge_values edges;
    double share[3], sum = 0;
    edges_at(facet, px, py, 0, &edges);
    for (int i = 0; i < 3; i++) {
        share[i] = facet->twice_area > 0 ? edges.e[i] * facet->inverse_w[i] : 1;
        sum += share[i];
    }
    for (int j = 0; j < 3; j++) {
        out[j] = 0;
        for (int i = 0; i < 3; i++)
            out[j] += share[i] / sum * facet->share[i][j];
    }
}

/* A term's weight (row 0: the constant part, which is 1) at a corner of a piece. */
static double weight_at(const struct coverage *coverage, const struct facet *facet,
                        const double share[3], size_t row)
{
    const struct surface *surface = &coverage->surfaces[facet->surface];
    size_t n_terms = (size_t)surface->finish->n_terms;
    double weight = 0;
    for (int j = 0; j < 3; j++)
        weight += share[j] * surface->weights[(size_t)facet->vertex[j] * n_terms + row - 1];
    return weight;
}

/* The bound of one term in one piece: of its interpolation, and by how much position errors magnify
 * those of its vertices. Where the piece has no bound, its values' range. */
static double piece_bound(const struct coverage *coverage, const struct facet *facet,
                          const struct piece *piece, size_t row)
{
    const struct surface *surface = &coverage->surfaces[facet->surface];
    size_t n_terms = (size_t)surface->finish->n_terms;
    double values[3] = {1, 1, 1}, e_vertex = 0,
           magnification = bound_magnification(&piece->outline);
    for (int c = 0; c < 3 && row > 0; c++) {
        size_t at = (size_t)facet->vertex[c] * n_terms + row - 1;
        values[c] = weight_at(coverage, facet, piece->share[c], row);
        e_vertex = fmax(e_vertex, (double)surface->errors[at]);
    }
    if (magnification < HUGE_VAL)
        return magnification * bound_colour(&piece->outline, values) +
               (magnification - 1) * e_vertex;
    return most(values) - least(values);
}

/* Bounds of all terms that hold in the whole facet: the worst of the pieces that OpenGL sets up. */
static const float *bounds_of(struct coverage *coverage, int32_t index)
{
    size_t n_rows = 1 + (size_t)coverage->plan->max_terms;
    float *bounds = coverage->bounds + (size_t)index * n_rows;
    if (coverage->bounded[index])
        return bounds;
    coverage->bounded[index] = true;
    const struct facet *facet = &coverage->facets[index];
    struct piece pieces[CLIP_CORNERS - 2];
    int n = facet_pieces(coverage->plan, coverage->surfaces, coverage->tile, facet, pieces);
    size_t n_terms = (size_t)coverage->surfaces[facet->surface].finish->n_terms;
    for (size_t row = 0; row <= n_terms; row++) {
        double worst = 0;
        for (int i = 0; i < n; i++)
            worst = fmax(worst, piece_bound(coverage, facet, &pieces[i], row));
        bounds[row] = (float)worst;
    }
    return bounds;
}

/* Weights of all terms at a pixel, and bounds on OpenGL's error at vertices and between. */
static void interpolate(struct coverage *coverage, int32_t index, int x, int y, double *weights,
                        size_t weight_stride, float *errors, size_t error_stride)
{
    const struct facet *facet = &coverage->facets[index];
    const struct surface *surface = &coverage->surfaces[facet->surface];
    size_t n_terms = (size_t)surface->finish->n_terms;
    const float *bounds = errors ? bounds_of(coverage, index) : NULL;
    double share[3];
    shares_at(facet, x + 0.5, y + 0.5, share);
    if (errors)
        errors[0] = bounds[0];
    for (size_t t = 0; t < n_terms; t++) {
        double weight = 0, error = 0;
        for (int j = 0; j < 3; j++) {
            size_t at = (size_t)facet->vertex[j] * n_terms + t;
            weight += share[j] * surface->weights[at];
            error += fabs(share[j]) * (double)surface->errors[at];
        }
        weights[t * weight_stride] = weight;
        if (errors)
            errors[(1 + t) * error_stride] = (float)error + bounds[1 + t];
    }
}

/* ---- the finished chunk ---- */

/* Candidates of one pixel: weights, then errors, in the chunk's numbers. */
static bool add_candidate(struct coverage *coverage, struct chunk *out, int32_t index, int x, int y,
                          size_t capacity[3])
{
    const struct facet *facet = &coverage->facets[index];
    size_t n_terms = (size_t)coverage->surfaces[facet->surface].finish->n_terms;
    float errors[1 + 2 * MAX_GL_LIGHTS];
    if (!grow(&out->candidates, &capacity[1], out->n_candidates + 1, sizeof *out->candidates) ||
        !grow(&out->numbers, &capacity[2], out->n_numbers + 2 * n_terms + 1, sizeof *out->numbers))
        return false;
    double *numbers = out->numbers + out->n_numbers;
    interpolate(coverage, index, x, y, numbers, 1, errors, 1);
    for (size_t i = 0; i <= n_terms; i++)
        numbers[n_terms + i] = (double)errors[i];
    out->candidates[out->n_candidates++] =
        (struct candidate){facet->surface, facet->loose, out->n_numbers};
    out->n_numbers += 2 * n_terms + 1;
    return true;
}

static bool add_contest(struct coverage *coverage, struct chunk *out, int32_t index,
                        size_t capacity[3])
{
    const struct pixel *pixel = &coverage->pixels[index];
    if (!grow(&out->contests, &capacity[0], out->n_contests + 1, sizeof *out->contests))
        return false;
    struct contest *contest = &out->contests[out->n_contests++];
    *contest = (struct contest){.pixel = index,
                                .first = (int32_t)out->n_candidates,
                                .background = pixel->limit == HUGE_VAL};
    int x = out->rows.x + index % out->rows.width, y = out->rows.y + index / out->rows.width;
    for (int32_t f = pixel->head; f >= 0; f = coverage->fragments[f].next) {
        if (!add_candidate(coverage, out, coverage->fragments[f].facet, x, y, capacity))
            return false;
        contest->count++;
    }
    return true;
}

/* A pixel is settled when its one candidate is definite and bounded, or when it has none. */
static bool is_contested(const struct coverage *coverage, const struct pixel *pixel)
{
    if (pixel->head < 0)
        return false;
    const struct fragment *only = &coverage->fragments[pixel->head];
    return only->next >= 0 || pixel->limit == HUGE_VAL || coverage->facets[only->facet].loose ||
           pixel->winner != only->facet;
}

static bool resolve_pixel(struct coverage *coverage, struct chunk *out, int32_t index,
                          size_t capacity[3])
{
    const struct pixel *pixel = &coverage->pixels[index];
    size_t n_pixels = (size_t)out->rows.width * (size_t)out->rows.height;
    int x = out->rows.x + index % out->rows.width, y = out->rows.y + index / out->rows.width;
    bool check = coverage->plan->options.check;
    out->surface[index] = -1;
    if (pixel->winner >= 0) {
        out->surface[index] = coverage->facets[pixel->winner].surface;
        interpolate(coverage, pixel->winner, x, y, out->weights + index, n_pixels,
                    check ? out->errors + index : NULL, n_pixels);
    }
    out->contested[index] = check && is_contested(coverage, pixel);
    return !out->contested[index] || add_contest(coverage, out, index, capacity);
}

static bool chunk_alloc(const struct plan *plan, const struct tile *rows, struct chunk *out)
{
    size_t n_pixels = (size_t)rows->width * (size_t)rows->height;
    size_t n_terms = (size_t)plan->max_terms;
    *out = (struct chunk){.rows = *rows};
    out->surface = malloc(n_pixels * sizeof *out->surface);
    out->contested = malloc(n_pixels * sizeof *out->contested);
    out->weights = malloc(n_pixels * n_terms * sizeof *out->weights + 1);
    out->errors =
        plan->options.check ? malloc(n_pixels * (1 + n_terms) * sizeof *out->errors) : NULL;
    return out->surface && out->contested && out->weights && (out->errors || !plan->options.check);
}

static bool resolve_all(struct coverage *coverage, struct chunk *out)
{
    size_t n_pixels = (size_t)out->rows.width * (size_t)out->rows.height, capacity[3] = {0, 0, 0};
    size_t n_rows = 1 + (size_t)coverage->plan->max_terms;
    coverage->bounds = malloc((coverage->n_facets * n_rows + 1) * sizeof *coverage->bounds);
    coverage->bounded = calloc(coverage->n_facets + 1, sizeof *coverage->bounded);
    if (!coverage->bounds || !coverage->bounded)
        return false;
    for (size_t i = 0; i < n_pixels; i++)
        if (!resolve_pixel(coverage, out, (int32_t)i, capacity))
            return false;
    return true;
}

struct tile chunk_rows(const struct tile *tile, int index)
{
    struct tile rows = *tile;
    rows.y += index * CHUNK_ROWS;
    rows.height = tile->height - index * CHUNK_ROWS;
    if (rows.height > CHUNK_ROWS)
        rows.height = CHUNK_ROWS;
    return rows;
}

bool chunk_rasterize(const struct plan *plan, const struct surface *surfaces,
                     const struct tile *tile, int index, struct chunk *out, struct error *err)
{
    struct coverage coverage = {.plan = plan,
                                .surfaces = surfaces,
                                .tile = tile,
                                .rows = chunk_rows(tile, index),
                                .unused = -1};
    coverage.pixels = malloc((size_t)coverage.rows.width * (size_t)coverage.rows.height *
                             sizeof *coverage.pixels);
    bool done = chunk_alloc(plan, &coverage.rows, out) && coverage.pixels && cover_all(&coverage) &&
                resolve_all(&coverage, out);
    free(coverage.pixels);
    free(coverage.facets);
    free(coverage.fragments);
    free(coverage.bounds);
    free(coverage.bounded);
    return done || error_memory(err);
}

void chunk_free(struct chunk *chunk)
{
    free(chunk->surface);
    free(chunk->contested);
    free(chunk->weights);
    free(chunk->errors);
    free(chunk->contests);
    free(chunk->candidates);
    free(chunk->numbers);
    *chunk = (struct chunk){0};
}
