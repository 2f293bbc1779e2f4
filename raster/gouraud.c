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

/* ---- the state of a chunk while facets go by ---- */

/* A fragment kept for a pixel: a link in the pixel's list. */
struct fragment {
    int32_t facet, next;
    bool loose;     /* on a piece too thin for a bound */
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
    struct outline *thin; /* pieces of facets that are too thin for a bound */
    size_t n_facets, n_fragments, n_thin, facet_capacity, fragment_capacity, thin_capacity;
    int32_t unused; /* list of fragments to use again */
    float *bounds;  /* [facet][max_attributes], filled when first needed */
    bool *bounded;
    size_t max_attributes; /* of a surface */
    double *raw_weights;   /* of one pixel: max_attributes each */
    float *raw_errors;
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
        if (!grow(&coverage->fragments, &coverage->fragment_capacity, coverage->n_fragments + 1,
                  sizeof *coverage->fragments))
            return false;
        place = (int32_t)coverage->n_fragments++;
    }
    coverage->fragments[place] =
        (struct fragment){facet, pixel->head, error == HUGE_VAL, depth - error};
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

/* Notes the pieces that have no bound, so that only pixels upon them go without. */
static bool note_thin_pieces(struct coverage *coverage, struct facet *facet)
{
    struct piece pieces[CLIP_CORNERS - 2];
    int n = facet_pieces(coverage->plan, coverage->surfaces, coverage->tile, facet, pieces);
    facet->first_thin = (int32_t)coverage->n_thin;
    for (int i = 0; i < n; i++) {
        if (bound_magnification(&pieces[i].outline) < HUGE_VAL)
            continue;
        if (!grow(&coverage->thin, &coverage->thin_capacity, coverage->n_thin + 1,
                  sizeof *coverage->thin))
            return false;
        coverage->thin[coverage->n_thin++] = pieces[i].outline;
        facet->n_thin++;
    }
    return true;
}

static bool is_thin_at(const struct coverage *coverage, const struct facet *facet, double px,
                       double py)
{
    for (int32_t i = 0; i < facet->n_thin; i++)
        if (outline_touches(&coverage->thin[facet->first_thin + i], px, py))
            return true;
    return false;
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
    bool thin = is_thin_at(coverage, facet, x + 0.5, y + 0.5);
    double depth_error = thin ? HUGE_VAL : facet->depth_error;
    definite = definite && depth > depth_error && depth < 1 - depth_error;
    return add_fragment(coverage, pixel, index, depth, depth_error, definite);
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
        if (!grow(&coverage->facets, &coverage->facet_capacity, coverage->n_facets + 1,
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

/* In flat shading one vertex colours the whole triangle; its texture is smooth all the same. */
static bool is_flat(const struct coverage *coverage, const struct facet *facet, size_t attribute)
{
    return coverage->plan->scene->flat_shading &&
           attribute < (size_t)coverage->surfaces[facet->surface].finish->n_terms;
}

/* The bound of one attribute in one piece: of its interpolation, and by how much position errors
 * magnify those of its vertices. Where the piece has no bound, its values' range. */
static double piece_bound(const struct coverage *coverage, const struct facet *facet,
                          const struct piece *piece, size_t attribute)
{
    const struct surface *surface = &coverage->surfaces[facet->surface];
    double values[3] = {0, 0, 0}, e_vertex = 0,
           magnification = bound_magnification(&piece->outline);
    for (int j = 0; j < 3; j++) {
        size_t at = surface_attributes(surface, facet->vertex[j], facet->side) + attribute;
        for (int c = 0; c < 3; c++)
            values[c] += piece->share[c][j] * surface->weights[at];
        e_vertex = fmax(e_vertex, (double)surface->errors[at]);
    }
    if (magnification < HUGE_VAL)
        return magnification * bound_colour(&piece->outline, values) +
               (magnification - 1) * e_vertex;
    return most(values) - least(values);
}

/* Bounds of all attributes that hold in the whole facet: the worst of the pieces that OpenGL sets
 * up, but for those too thin for a bound. */
static const float *bounds_of(struct coverage *coverage, int32_t index)
{
    float *bounds = coverage->bounds + (size_t)index * coverage->max_attributes;
    if (coverage->bounded[index])
        return bounds;
    coverage->bounded[index] = true;
    const struct facet *facet = &coverage->facets[index];
    struct piece pieces[CLIP_CORNERS - 2];
    int n = facet_pieces(coverage->plan, coverage->surfaces, coverage->tile, facet, pieces);
    size_t n_attributes = (size_t)coverage->surfaces[facet->surface].n_attributes;
    for (size_t attribute = 0; attribute < n_attributes; attribute++) {
        double worst = 0;
        for (int i = 0; i < n && !is_flat(coverage, facet, attribute); i++)
            if (facet->n_thin == n || bound_magnification(&pieces[i].outline) < HUGE_VAL)
                worst = fmax(worst, piece_bound(coverage, facet, &pieces[i], attribute));
        bounds[attribute] = (float)worst;
    }
    return bounds;
}

/* All attributes at a pixel and bounds on OpenGL's error, into the coverage's raw numbers. */
static void interpolate(struct coverage *coverage, int32_t index, int x, int y)
{
    static const double all = 1;
    const struct facet *facet = &coverage->facets[index];
    const struct surface *surface = &coverage->surfaces[facet->surface];
    const float *bounds = coverage->plan->options.check ? bounds_of(coverage, index) : NULL;
    double share[3];
    shares_at(facet, x + 0.5, y + 0.5, share);
    for (size_t a = 0; a < (size_t)surface->n_attributes; a++) {
        bool flat = is_flat(coverage, facet, a);
        const int32_t *vertex = flat ? &facet->provoking : facet->vertex;
        const double *part = flat ? &all : share;
        double weight = 0, error = 0;
        for (int j = 0; j < (flat ? 1 : 3); j++) {
            size_t at = surface_attributes(surface, vertex[j], facet->side) + a;
            weight += part[j] * surface->weights[at];
            error += fabs(part[j]) * (double)surface->errors[at];
        }
        coverage->raw_weights[a] = weight;
        coverage->raw_errors[a] = bounds ? (float)error + bounds[a] : 0;
    }
}

/* ---- textures ---- */

/* Where the pixel just interpolated lies in its texture. */
static struct texel_point texture_place(const struct coverage *coverage,
                                        const struct finish *finish)
{
    const double *s_t = coverage->raw_weights + finish->n_terms;
    const float *e_s_t = coverage->raw_errors + finish->n_terms;
    return texel_point(finish->texture, s_t[0], s_t[1], e_s_t[0], e_s_t[1]);
}

/* Gives out the rows of a pixel: of a grey texture its products with the weights, of a spectral one
 * the place in it. errors may be NULL. */
static void put_rows(const struct coverage *coverage, const struct finish *finish,
                     const struct texel_point *place, double *weights, float *errors, size_t stride)
{
    double value = 1, e_value = 0;
    size_t n_terms = (size_t)finish->n_terms;
    bool spectral = place && finish->texture->spectral;
    if (place && !spectral)
        value = texel_value(finish->texture, 0, *place, errors ? &e_value : NULL);
    for (size_t t = 0; t < n_terms; t++) {
        double weight = coverage->raw_weights[t], error = (double)coverage->raw_errors[t];
        weights[t * stride] = weight * value;
        if (errors)
            errors[t * stride] = (float)(error * (value + e_value) + fabs(weight) * e_value);
    }
    for (size_t i = 0; i < 2 && spectral; i++) {
        weights[(n_terms + i) * stride] = i == 0 ? place->u : place->v;
        if (errors)
            errors[(n_terms + i) * stride] = i == 0 ? place->e_u : place->e_v;
    }
}

/* ---- the finished chunk ---- */

/* A surface that may be seen at a pixel: one candidate, or as many as OpenGL may take texels. */
static bool add_candidates(struct coverage *coverage, struct chunk *out,
                           const struct fragment *fragment, int x, int y, size_t capacity[4])
{
    int32_t index = fragment->facet;
    const struct facet *facet = &coverage->facets[index];
    const struct finish *finish = coverage->surfaces[facet->surface].finish;
    size_t n_rows = (size_t)finish_rows(finish);
    struct texel_point choices[TEXEL_CHOICES];
    interpolate(coverage, index, x, y);
    int n = 1;
    if (finish->texture)
        n = texel_choices(finish->texture, texture_place(coverage, finish), choices);
    for (int i = 0; i < n; i++) {
        size_t first = out->n_numbers;
        if (!grow(&out->candidates, &capacity[1], out->n_candidates + 1, sizeof *out->candidates) ||
            !grow(&out->candidate_weights, &capacity[2], first + n_rows,
                  sizeof *out->candidate_weights) ||
            !grow(&out->candidate_errors, &capacity[3], first + n_rows,
                  sizeof *out->candidate_errors))
            return false;
        put_rows(coverage, finish, finish->texture ? &choices[i] : NULL,
                 out->candidate_weights + first, out->candidate_errors + first, 1);
        out->candidates[out->n_candidates++] =
            (struct candidate){facet->surface, fragment->loose, first};
        out->n_numbers += n_rows;
    }
    return true;
}

static bool add_contest(struct coverage *coverage, struct chunk *out, int32_t index,
                        size_t capacity[4])
{
    const struct pixel *pixel = &coverage->pixels[index];
    if (!grow(&out->contests, &capacity[0], out->n_contests + 1, sizeof *out->contests))
        return false;
    struct contest *contest = &out->contests[out->n_contests++];
    *contest = (struct contest){.pixel = index,
                                .first = (int32_t)out->n_candidates,
                                .background = pixel->limit == HUGE_VAL};
    int x = out->rows.x + index % out->rows.width, y = out->rows.y + index / out->rows.width;
    for (int32_t f = pixel->head; f >= 0; f = coverage->fragments[f].next)
        if (!add_candidates(coverage, out, &coverage->fragments[f], x, y, capacity))
            return false;
    contest->count = (int32_t)out->n_candidates - contest->first;
    return true;
}

/* A pixel is settled when its one candidate is definite and bounded, or when it has none. */
static bool is_contested(const struct coverage *coverage, const struct pixel *pixel)
{
    if (pixel->head < 0)
        return false;
    const struct fragment *only = &coverage->fragments[pixel->head];
    return only->next >= 0 || pixel->limit == HUGE_VAL || only->loose ||
           pixel->winner != only->facet;
}

/* The reference's own fragment; returns whether its texture leaves OpenGL a choice. */
static bool put_winner(struct coverage *coverage, struct chunk *out, int32_t index, int x, int y)
{
    const struct pixel *pixel = &coverage->pixels[index];
    size_t n_pixels = (size_t)out->rows.width * (size_t)out->rows.height;
    int32_t surface = coverage->facets[pixel->winner].surface;
    const struct finish *finish = coverage->surfaces[surface].finish;
    struct texel_point choices[TEXEL_CHOICES], place;
    int n = 1;
    out->surface[index] = surface;
    interpolate(coverage, pixel->winner, x, y);
    if (finish->texture) {
        place = texture_place(coverage, finish);
        n = texel_choices(finish->texture, place, choices);
        if (n == 1)
            place = choices[0];
    }
    put_rows(coverage, finish, finish->texture ? &place : NULL, out->weights + index,
             out->errors ? out->errors + index : NULL, n_pixels);
    return n > 1;
}

static bool resolve_pixel(struct coverage *coverage, struct chunk *out, int32_t index,
                          size_t capacity[4])
{
    const struct pixel *pixel = &coverage->pixels[index];
    int x = out->rows.x + index % out->rows.width, y = out->rows.y + index / out->rows.width;
    bool open = is_contested(coverage, pixel);
    out->surface[index] = -1;
    if (pixel->winner >= 0)
        open = put_winner(coverage, out, index, x, y) || open;
    out->contested[index] = coverage->plan->options.check && open;
    return !out->contested[index] || add_contest(coverage, out, index, capacity);
}

static bool chunk_alloc(const struct plan *plan, const struct tile *rows, struct chunk *out)
{
    size_t n_pixels = (size_t)rows->width * (size_t)rows->height;
    size_t n_numbers = n_pixels * (size_t)plan->max_rows;
    *out = (struct chunk){.rows = *rows};
    out->surface = malloc(n_pixels * sizeof *out->surface);
    out->contested = malloc(n_pixels * sizeof *out->contested);
    out->weights = malloc(n_numbers * sizeof *out->weights + 1);
    out->errors = plan->options.check ? malloc(n_numbers * sizeof *out->errors + 1) : NULL;
    return out->surface && out->contested && out->weights && (out->errors || !plan->options.check);
}

static bool resolve_all(struct coverage *coverage, struct chunk *out)
{
    size_t n_pixels = (size_t)out->rows.width * (size_t)out->rows.height, capacity[4] = {0};
    size_t n_attributes = (size_t)coverage->plan->max_rows + 2;
    coverage->max_attributes = n_attributes;
    coverage->bounds = malloc((coverage->n_facets * n_attributes + 1) * sizeof *coverage->bounds);
    coverage->bounded = calloc(coverage->n_facets + 1, sizeof *coverage->bounded);
    coverage->raw_weights = malloc(n_attributes * sizeof *coverage->raw_weights);
    coverage->raw_errors = malloc(n_attributes * sizeof *coverage->raw_errors);
    if (!coverage->bounds || !coverage->bounded || !coverage->raw_weights || !coverage->raw_errors)
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
    free(coverage.thin);
    free(coverage.bounds);
    free(coverage.bounded);
    free(coverage.raw_weights);
    free(coverage.raw_errors);
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
    free(chunk->candidate_weights);
    free(chunk->candidate_errors);
    *chunk = (struct chunk){0};
}
