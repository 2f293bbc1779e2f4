/* SPDX-License-Identifier: MIT */
/* What each pixel looks like: weights by perspective-correct interpolation between vertices, as
 * Gouraud interpolates colours, textures upon them, and the same for every other fragment that
 * OpenGL may show. In phong shading positions and normals are interpolated, and lit at each pixel.
 */
#include <math.h>
#include <stdlib.h>

#include "coverage.h"
#include "light.h"

/* Bound on OpenGL's error in an attribute of a piece of a facet: see bound_colour. */
struct attribute_bound {
    float constant, fixed, per_d, slope;
};

/* A chunk whose coverage is known, while its pixels go by. */
struct shading {
    struct coverage coverage;
    struct attribute_bound *bounds; /* [piece][max_attributes], filled when first needed */
    bool *bounded;                  /* [piece] */
    size_t max_attributes;          /* of a surface */
    struct light_work work;         /* of phong shading */
    double *weights;                /* of one pixel: max_attributes each, before its texture */
    float *errors, *interpolation, *slopes;
};

/* ---- interpolation ---- */

/* Barycentric coordinates of a pixel centre in the whole triangle, perspective-correct; returns 1 /
 * w there. Outside the facet they extrapolate; where it has no area they are those of its middle.
 */
static double shares_at(const struct facet *facet, double px, double py, double out[3])
{
    static const double none[3] = {0, 0, 0};
    struct edge_values edges;
    double share[3], sum = 0;
    edges_at(facet->x, facet->y, px, py, none, &edges);
    for (int i = 0; i < 3; i++) {
        share[i] = facet->twice_area > 0 ? edges.e[i] * facet->inverse_w[i] : 1;
        sum += share[i];
    }
    for (int j = 0; j < 3; j++) {
        out[j] = 0;
        for (int i = 0; i < 3; i++)
            out[j] += share[i] / sum * facet->share[i][j];
    }
    return sum / (facet->twice_area > 0 ? facet->twice_area : 3);
}

/* In flat shading one vertex colours the whole triangle; its texture is smooth all the same. */
static bool is_flat(const struct shading *shading, const struct facet *facet, size_t attribute)
{
    return shading->coverage.plan->scene->shading == SHADING_FLAT &&
           attribute < (size_t)shading->coverage.surfaces[facet->surface].finish->n_terms;
}

/* Of an attribute where six planes may cut: a difference, a product and a sum each. */
enum { CUT_ROUNDINGS = 18 };

/* The bound of one attribute in one piece: of its interpolation, and by how much position errors
 * magnify those of its vertices. Where the piece has no bound, its values' range. */
static struct colour_bound piece_bound(const struct shading *shading, const struct facet *facet,
                                       const struct piece *piece, size_t attribute)
{
    const struct surface *surface = &shading->coverage.surfaces[facet->surface];
    double values[3] = {0, 0, 0}, e_vertex = 0, largest = 0, magnification = piece->magnification;
    for (int j = 0; j < 3; j++) {
        size_t at = surface_attributes(surface, facet->vertex[j], facet->side) + attribute;
        for (int c = 0; c < 3; c++)
            values[c] += piece->share[c][j] * surface->weights[at];
        e_vertex = fmax(e_vertex, (double)surface->errors[at]);
        largest = fmax(largest, fabs(surface->weights[at]));
    }
    double e_cut = facet->straddles ? CUT_ROUNDINGS * largest / 16777216 : 0;
    if (!(magnification < HUGE_VAL))
        return (struct colour_bound){.constant = fmax(values[0], fmax(values[1], values[2])) -
                                                 fmin(values[0], fmin(values[1], values[2]))};
    struct colour_bound bound = bound_colour(&piece->outline, values);
    bound.constant = magnification * (bound.constant + e_cut) + (magnification - 1) * e_vertex;
    bound.fixed *= magnification;
    bound.per_d *= magnification;
    return bound;
}

/* Bounds of all attributes in a piece of a facet. */
static const struct attribute_bound *bounds_of(struct shading *shading, const struct facet *facet,
                                               int32_t index)
{
    const struct surface *surface = &shading->coverage.surfaces[facet->surface];
    size_t piece = (size_t)(facet->first_piece + index);
    struct attribute_bound *bounds = shading->bounds + piece * shading->max_attributes;
    for (size_t a = 0; a < (size_t)surface->n_attributes && !shading->bounded[piece]; a++) {
        struct colour_bound bound = {.constant = 0};
        if (!is_flat(shading, facet, a))
            bound = piece_bound(shading, facet, &shading->coverage.pieces[piece], a);
        bounds[a] = (struct attribute_bound){(float)bound.constant, (float)bound.fixed,
                                             (float)bound.per_d, (float)bound.slope};
    }
    shading->bounded[piece] = true;
    return bounds;
}

/* Widens the errors of the shading's numbers by the worst that the pieces at a pixel may add to
 * them, and notes how steep they are. */
static void add_bounds(struct shading *shading, const struct facet *facet, double inverse_w, int x,
                       int y)
{
    size_t n_attributes = (size_t)shading->coverage.surfaces[facet->surface].n_attributes;
    unsigned pieces = pieces_at(&shading->coverage, facet, x + 0.5, y + 0.5);
    float d = (float)inverse_w;
    for (size_t a = 0; a < n_attributes; a++)
        shading->interpolation[a] = shading->slopes[a] = 0;
    for (int32_t i = 0; i < facet->n_pieces; i++) {
        const struct piece *piece = &shading->coverage.pieces[facet->first_piece + i];
        if (!(pieces >> i & 1))
            continue;
        const struct attribute_bound *bounds = bounds_of(shading, facet, i);
        /* where 1 / w is not known to be positive the fragment is loose */
        double least =
            inverse_w * (1 - piece->inverse_w_bound.per_d) - piece->inverse_w_bound.fixed;
        float over = least > 0 ? (float)(1 / least) : 0;
        for (size_t a = 0; a < n_attributes; a++) {
            float bound = bounds[a].constant + over * (bounds[a].fixed + d * bounds[a].per_d);
            shading->interpolation[a] = fmaxf(shading->interpolation[a], bound);
            shading->slopes[a] = fmaxf(shading->slopes[a], bounds[a].slope / d);
        }
    }
    for (size_t a = 0; a < n_attributes; a++)
        shading->errors[a] += shading->interpolation[a];
}

/* Phong shading (Bui Tuong Phong 1975): what lies between the vertices of a facet, lit as a vertex
 * is. It has no bounds. */
static void light_between(struct shading *shading, const struct facet *facet,
                          const struct surface *surface, const double share[3])
{
    struct vertex point = {.s = 0};
    for (int j = 0; j < 3; j++) {
        const struct vertex *vertex = &surface->mesh->vertices[facet->vertex[j]];
        point.position = vector_add(point.position, vector_scale(vertex->position, share[j]));
        point.normal = vector_add(point.normal, vector_scale(vertex->normal, share[j]));
        point.s += share[j] * vertex->s;
        point.t += share[j] * vertex->t;
    }
    light_point(shading->coverage.plan, surface, &point, facet->side, shading->weights,
                shading->errors, &shading->work);
}

/* All attributes at a pixel and bounds on OpenGL's error, into the shading's numbers. */
static void interpolate(struct shading *shading, int32_t index, int x, int y)
{
    static const double all = 1;
    const struct facet *facet = &shading->coverage.facets[index];
    const struct surface *surface = &shading->coverage.surfaces[facet->surface];
    double share[3], inverse_w = shares_at(facet, x + 0.5, y + 0.5, share);
    if (shading->coverage.plan->scene->shading == SHADING_PHONG) {
        light_between(shading, facet, surface, share);
        return;
    }
    for (size_t a = 0; a < (size_t)surface->n_attributes; a++) {
        bool flat = is_flat(shading, facet, a);
        const int32_t *vertex = flat ? &facet->provoking : facet->vertex;
        const double *part = flat ? &all : share;
        double weight = 0, error = 0;
        for (int j = 0; j < (flat ? 1 : 3); j++) {
            size_t at = surface_attributes(surface, vertex[j], facet->side) + a;
            weight += part[j] * surface->weights[at];
            error += fabs(part[j]) * (double)surface->errors[at];
        }
        shading->weights[a] = weight;
        shading->errors[a] = (float)error;
    }
    if (shading->coverage.plan->options.check)
        add_bounds(shading, facet, inverse_w, x, y);
}

/* ---- textures ---- */

/* Where the pixel just interpolated lies in its texture. */
static struct texel_point texture_place(const struct shading *shading, const struct finish *finish)
{
    const double *s_t = shading->weights + finish->n_terms;
    const float *e_s_t = shading->errors + finish->n_terms;
    return texel_point(finish->texture, s_t[0], s_t[1], e_s_t[0], e_s_t[1]);
}

/* Bound on how much the radiance of the pixel just interpolated changes within a pixel's width, in
 * any wavelength. A spectral texture's texels may differ by all there is. */
static double steepness(const struct shading *shading, const struct finish *finish,
                        const struct texel_point *place)
{
    double step = 0, whole = 0, change;
    for (int t = 0; t < finish->n_terms; t++) {
        step += (double)shading->slopes[t] * finish->terms[t].peak;
        whole += shading->weights[t] * finish->terms[t].peak;
    }
    if (!place)
        return step;
    struct texel_point near = *place;
    near.e_u = shading->slopes[finish->n_terms] * (float)finish->texture->image.width;
    near.e_v = shading->slopes[finish->n_terms + 1] * (float)finish->texture->image.height;
    if (finish->texture->spectral)
        return (step + whole * (double)(near.e_u + near.e_v)) * finish->texture->largest;
    double value = texel_value(finish->texture, 0, near, &change);
    return step * value + whole * change;
}

/* Gives out the rows of a pixel: of a grey texture its products with the weights, of a spectral one
 * the place in it. errors may be NULL. */
static void put_rows(const struct shading *shading, const struct finish *finish,
                     const struct texel_point *place, double *weights, float *errors, size_t stride)
{
    double value = 1, e_value = 0;
    size_t n_terms = (size_t)finish->n_terms;
    bool spectral = place && finish->texture->spectral;
    if (place && !spectral)
        value = texel_value(finish->texture, 0, *place, errors ? &e_value : NULL);
    for (size_t t = 0; t < n_terms; t++) {
        double weight = shading->weights[t], error = (double)shading->errors[t];
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

/* Bound on OpenGL's error in a depth that is kept in single precision. */
static float stored_depth_error(double error, double depth)
{
    return (float)(error + fabs(depth) / 16777216);
}

/* A surface that may be seen at a pixel: one candidate, or as many as OpenGL may take texels. */
static bool add_candidates(struct shading *shading, struct chunk *out,
                           const struct fragment *fragment, int x, int y, size_t capacity[4])
{
    int32_t index = fragment->facet;
    const struct facet *facet = &shading->coverage.facets[index];
    const struct finish *finish = shading->coverage.surfaces[facet->surface].finish;
    size_t n_rows = (size_t)finish_rows(finish);
    struct texel_point choices[TEXEL_CHOICES];
    interpolate(shading, index, x, y);
    int n = 1;
    if (finish->texture)
        n = texel_choices(finish->texture, texture_place(shading, finish), choices);
    for (int i = 0; i < n; i++) {
        size_t first = out->n_numbers;
        if (!array_grow(&out->candidates, &capacity[1], out->n_candidates + 1,
                        sizeof *out->candidates) ||
            !array_grow(&out->candidate_weights, &capacity[2], first + n_rows,
                        sizeof *out->candidate_weights) ||
            !array_grow(&out->candidate_errors, &capacity[3], first + n_rows,
                        sizeof *out->candidate_errors))
            return false;
        put_rows(shading, finish, finish->texture ? &choices[i] : NULL,
                 out->candidate_weights + first, out->candidate_errors + first, 1);
        out->candidates[out->n_candidates++] = (struct candidate){
            .surface = facet->surface,
            .triangle = facet->triangle,
            .depth = (float)fragment->depth,
            .depth_error = stored_depth_error(fragment->depth_error, fragment->depth),
            .loose = fragment->loose,
            .first = first};
        out->n_numbers += n_rows;
    }
    return true;
}

static bool is_closed(const struct pixel *pixel)
{
    return !pixel->open && pixel->edge_sum[0] == 0 && pixel->edge_sum[1] == 0;
}

/* Where triangles meet without a gap one of them must be there, if the driver is watertight. */
static bool is_surely_covered(const struct shading *shading, const struct pixel *pixel)
{
    return is_closed(pixel) && pixel->n_covered > 0 &&
           shading->coverage.surfaces[0].driver->watertight;
}

static bool add_contest(struct shading *shading, struct chunk *out, int32_t index, int x, int y,
                        size_t capacity[4])
{
    const struct pixel *pixel = &shading->coverage.pixels[index];
    if (!array_grow(&out->contests, &capacity[0], out->n_contests + 1, sizeof *out->contests))
        return false;
    struct contest *contest = &out->contests[out->n_contests++];
    *contest = (struct contest){.pixel = index,
                                .first = (int32_t)out->n_candidates,
                                .background =
                                    pixel->limit == HUGE_VAL && !is_surely_covered(shading, pixel)};
    for (int32_t f = pixel->head; f >= 0; f = shading->coverage.fragments[f].next)
        if (!add_candidates(shading, out, &shading->coverage.fragments[f], x, y, capacity))
            return false;
    contest->count = (int32_t)out->n_candidates - contest->first;
    return true;
}

/* A pixel is settled when its one candidate is definite and bounded, or when it has none. */
static bool is_contested(const struct shading *shading, const struct pixel *pixel)
{
    if (pixel->head < 0)
        return false;
    const struct fragment *only = &shading->coverage.fragments[pixel->head];
    return only->next >= 0 || pixel->limit == HUGE_VAL || only->loose ||
           pixel->winner != only->facet;
}

/* The reference's own fragment; returns whether its texture leaves OpenGL a choice. */
static bool put_winner(struct shading *shading, struct chunk *out, int32_t index, int x, int y)
{
    const struct pixel *pixel = &shading->coverage.pixels[index];
    size_t n_pixels = (size_t)out->rows.width * (size_t)out->rows.height;
    int32_t surface = shading->coverage.facets[pixel->winner].surface;
    const struct finish *finish = shading->coverage.surfaces[surface].finish;
    struct texel_point choices[TEXEL_CHOICES], place;
    int n = 1;
    out->surface[index] = surface;
    if (out->errors) {
        const struct facet *facet = &shading->coverage.facets[pixel->winner];
        out->triangle[index] = facet->triangle;
        out->depth[index] = (float)pixel->winner_depth;
        out->depth_error[index] = stored_depth_error(facet->depth_error, pixel->winner_depth);
    }
    interpolate(shading, pixel->winner, x, y);
    if (finish->texture) {
        place = texture_place(shading, finish);
        n = texel_choices(finish->texture, place, choices);
        if (n == 1)
            place = choices[0];
    }
    if (out->errors)
        out->steepness[index] = (float)steepness(shading, finish, finish->texture ? &place : NULL);
    put_rows(shading, finish, finish->texture ? &place : NULL, out->weights + index,
             out->errors ? out->errors + index : NULL, n_pixels);
    return n > 1;
}

/* What the fragments of a pixel add up to. */
static struct overdraw overdraw_of(const struct pixel *pixel)
{
    uint32_t spread = pixel->n_possible - pixel->n_definite;
    return (struct overdraw){.least = (uint8_t)pixel->n_definite,
                             .spread = spread < UINT8_MAX ? (uint8_t)spread : UINT8_MAX,
                             .meant = (uint8_t)(pixel->n_definite + pixel->n_covered),
                             .closed = is_closed(pixel)};
}

static bool resolve_pixel(struct shading *shading, struct chunk *out, int32_t index,
                          size_t capacity[4])
{
    const struct pixel *pixel = &shading->coverage.pixels[index];
    int x = out->rows.x + index % out->rows.width, y = out->rows.y + index / out->rows.width;
    bool open = is_contested(shading, pixel);
    out->surface[index] = -1;
    if (out->overdraw)
        out->overdraw[index] = overdraw_of(pixel);
    if (pixel->winner >= 0)
        open = put_winner(shading, out, index, x, y) || open;
    out->contested[index] = shading->coverage.plan->options.check && open;
    return !out->contested[index] || add_contest(shading, out, index, x, y, capacity);
}

static bool chunk_alloc(const struct plan *plan, const struct tile *rows, struct chunk *out)
{
    size_t n_pixels = (size_t)rows->width * (size_t)rows->height;
    size_t n_numbers = n_pixels * (size_t)plan->max_rows;
    *out = (struct chunk){.rows = *rows};
    out->surface = malloc(n_pixels * sizeof *out->surface);
    out->contested = malloc(n_pixels * sizeof *out->contested);
    out->weights = malloc(n_numbers * sizeof *out->weights + 1);
    if (!out->surface || !out->contested || !out->weights)
        return false;
    if (!plan->options.check)
        return true;
    out->errors = malloc(n_numbers * sizeof *out->errors + 1);
    out->triangle = malloc(n_pixels * sizeof *out->triangle);
    out->depth = malloc(n_pixels * sizeof *out->depth);
    out->depth_error = malloc(n_pixels * sizeof *out->depth_error);
    out->overdraw = malloc(n_pixels * sizeof *out->overdraw);
    out->steepness = malloc(n_pixels * sizeof *out->steepness);
    return out->errors && out->triangle && out->depth && out->depth_error && out->overdraw &&
           out->steepness;
}

static bool resolve_all(struct shading *shading, struct chunk *out)
{
    size_t n_pixels = (size_t)out->rows.width * (size_t)out->rows.height, capacity[4] = {0};
    size_t n_attributes = (size_t)shading->coverage.plan->max_rows + 2;
    shading->max_attributes = n_attributes;
    size_t n_pieces = shading->coverage.n_pieces;
    shading->bounds = calloc(n_pieces * n_attributes + 1, sizeof *shading->bounds);
    shading->bounded = calloc(n_pieces + 1, sizeof *shading->bounded);
    shading->weights = malloc(n_attributes * sizeof *shading->weights);
    shading->errors = malloc(3 * n_attributes * sizeof *shading->errors);
    if (!shading->bounds || !shading->bounded || !shading->weights || !shading->errors)
        return false;
    shading->interpolation = shading->errors + n_attributes;
    shading->slopes = shading->interpolation + n_attributes;
    for (size_t i = 0; i < n_pixels; i++)
        if (!resolve_pixel(shading, out, (int32_t)i, capacity))
            return false;
    return true;
}

int chunk_count(const struct tile *tile)
{
    return (tile->height + CHUNK_ROWS - 1) / CHUNK_ROWS;
}

bool chunks_each(const struct tile *tile, int threads,
                 bool (*work)(void *context, const struct tile *tile, int index, struct error *err),
                 void *context, struct error *err)
{
    const int n = chunk_count(tile);
    bool failed = false;
    (void)threads; /* without OpenMP */
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (int i = 0; i < n; i++) {
        struct error own = {.status = EXIT_AGREED};
        if (work(context, tile, i, &own))
            continue;
#pragma omp critical
        {
            if (!failed)
                *err = own;
            failed = true;
        }
    }
    return !failed;
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
    struct shading shading = {
        .coverage = {
            .plan = plan, .surfaces = surfaces, .tile = tile, .rows = chunk_rows(tile, index)}};
    bool done = chunk_alloc(plan, &shading.coverage.rows, out) &&
                coverage_fill(&shading.coverage) && resolve_all(&shading, out);
    out->work = shading.work;
    coverage_free(&shading.coverage);
    free(shading.bounds);
    free(shading.bounded);
    free(shading.weights);
    free(shading.errors);
    return done || error_memory(err);
}

void chunk_free(struct chunk *chunk)
{
    free(chunk->surface);
    free(chunk->triangle);
    free(chunk->depth);
    free(chunk->depth_error);
    free(chunk->overdraw);
    free(chunk->steepness);
    free(chunk->contested);
    free(chunk->weights);
    free(chunk->errors);
    free(chunk->contests);
    free(chunk->candidates);
    free(chunk->candidate_weights);
    free(chunk->candidate_errors);
    *chunk = (struct chunk){0};
}
