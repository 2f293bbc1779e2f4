/* SPDX-License-Identifier: MIT */
/* Some rows of a tile: the reference draws them; with a check, every pixel then gets the bounds on
 * OpenGL's error, or where several triangles may be seen the candidates with theirs. */
#include <math.h>
#include <stdlib.h>

#include "data/maths/maths.h"
#include "data/terms/terms.h"
#include "data/tiff/tiff.h"
#include "raster/bounds/bounds.h"
#include "raster/candidates/candidates.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "spectral.h"

/* Bound on OpenGL's error in an attribute of a clipped triangle: see bound_colour. */
struct attribute_bound {
    float constant, fixed, per_d, slope;
};

/* A pixel's attributes, with bounds on OpenGL's errors and on their change within a pixel's width.
 */
struct bounded_pixel {
    const struct bounded_triangle *triangle;
    const struct surface *surface;
    const float *corner[3], *provoking; /* errors of its vertices */
    double *attributes;                 /* these four have room for those of any surface */
    float *errors, *interpolation, *slopes;
    struct texel_point place; /* in its texture, and the value there where that is not varied */
    double value;
};

/* A chunk whose fragments are known, while its pixels go by. */
struct bounding {
    struct fragments fragments;
    struct chunk *chunk;
    struct attribute_bound *bounds; /* [clipped triangle][max_attributes], when first needed */
    bool *bounded;                  /* [clipped triangle] */
    size_t max_attributes;          /* of a surface */
    struct bounded_pixel pixel;
    size_t capacity[4]; /* of the chunk's growing arrays */
};

/* ---- bounds of attributes ---- */

/* In flat shading one vertex colours the whole triangle; its texture is smooth all the same. */
static bool is_flat(const struct bounding *bounding, const struct surface *surface,
                    size_t attribute)
{
    return bounding->fragments.lit->plan->view.shading == FLAT &&
           attribute < (size_t)surface->instance->n_terms;
}

/* An attribute's roundings where six planes may cut: a difference, a product and a sum each. */
enum { CUT_ROUNDINGS = 18 };

/* The bound of one attribute in one clipped triangle: of its interpolation, and by how much
 * position errors magnify those of its vertices. Where the triangle has no bound, its values'
 * range. */
static struct colour_bound clipped_bound(const struct bounding *bounding,
                                         const struct bounded_triangle *triangle,
                                         const struct clipped_triangle *clipped, size_t attribute)
{
    const struct screen_triangle *screen = &triangle->screen;
    const struct surface *surface = screen->surface;
    const float *errors = bounds_of(bounding->fragments.lit, screen)->errors;
    double values[3] = {0, 0, 0}, e_vertex = 0, largest = 0, magnification = clipped->magnification;
    for (int j = 0; j < 3; j++) {
        size_t at = surface_attributes(surface, screen->vertex[j], screen->side) + attribute;
        for (int c = 0; c < 3; c++)
            values[c] += clipped->share[c][j] * surface->weights[at];
        e_vertex = fmax(e_vertex, (double)errors[at]);
        largest = fmax(largest, fabs(surface->weights[at]));
    }
    double e_cut = triangle->straddles ? roundings(CUT_ROUNDINGS) * largest : 0;
    if (!(magnification < HUGE_VAL))
        return (struct colour_bound){.constant = most_of(values) - least_of(values)};
    struct colour_bound bound = bound_colour(clipped, values);
    bound.constant = magnification * (bound.constant + e_cut) + (magnification - 1) * e_vertex;
    bound.fixed *= magnification;
    bound.per_d *= magnification;
    return bound;
}

/* Bounds of all attributes in clipped triangle `index` of a triangle. */
static const struct attribute_bound *
attribute_bounds(struct bounding *bounding, const struct bounded_triangle *triangle, int32_t index)
{
    const struct surface *surface = bounding->pixel.surface;
    size_t at = (size_t)(triangle->first_clipped + index);
    struct attribute_bound *bounds = bounding->bounds + at * bounding->max_attributes;
    for (size_t a = 0; a < (size_t)surface->n_attributes && !bounding->bounded[at]; a++) {
        struct colour_bound bound = {.constant = 0};
        if (!is_flat(bounding, surface, a))
            bound = clipped_bound(bounding, triangle, &bounding->fragments.clipped[at], a);
        bounds[a] = (struct attribute_bound){(float)bound.constant, (float)bound.fixed,
                                             (float)bound.per_d, (float)bound.slope};
    }
    bounding->bounded[at] = true;
    return bounds;
}

/* Widens the errors of the pixel by the worst that the clipped triangles there may add to them, and
 * notes how steep they are. */
static void add_bounds(struct bounding *bounding, double inverse_w, double px, double py)
{
    struct bounded_pixel *pixel = &bounding->pixel;
    size_t n_attributes = (size_t)pixel->surface->n_attributes;
    unsigned clipped = pixel->triangle->n_clipped == 1
                           ? 1
                           : clipped_at(&bounding->fragments, pixel->triangle, px, py);
    float d = (float)inverse_w;
    for (size_t a = 0; a < n_attributes; a++)
        pixel->interpolation[a] = pixel->slopes[a] = 0;
    for (int32_t i = 0; i < pixel->triangle->n_clipped; i++) {
        const struct colour_bound *of_d =
            &bounding->fragments.clipped[pixel->triangle->first_clipped + i].inverse_w_bound;
        if (!(clipped >> i & 1))
            continue;
        const struct attribute_bound *bounds = attribute_bounds(bounding, pixel->triangle, i);
        /* where 1 / w is not known to be positive the fragment is loose */
        double least = inverse_w * (1 - of_d->per_d) - of_d->fixed;
        float over = least > 0 ? (float)(1 / least) : 0;
        for (size_t a = 0; a < n_attributes; a++) {
            float bound = bounds[a].constant + over * (bounds[a].fixed + d * bounds[a].per_d);
            pixel->interpolation[a] = fmaxf(pixel->interpolation[a], bound);
            pixel->slopes[a] = fmaxf(pixel->slopes[a], bounds[a].slope / d);
        }
    }
    for (size_t a = 0; a < n_attributes; a++)
        pixel->errors[a] += pixel->interpolation[a];
}

/* Neighbouring pixels mostly show the same triangle. */
static void take_triangle(struct bounding *bounding, const struct bounded_triangle *triangle)
{
    const struct screen_triangle *screen = &triangle->screen;
    const struct surface *surface = screen->surface;
    const float *errors = bounds_of(bounding->fragments.lit, screen)->errors;
    struct bounded_pixel *pixel = &bounding->pixel;
    pixel->triangle = triangle;
    pixel->surface = surface;
    for (int j = 0; j < 3; j++)
        pixel->corner[j] = errors + surface_attributes(surface, screen->vertex[j], screen->side);
    pixel->provoking = errors + surface_attributes(surface, screen->provoking, screen->side);
}

/* The errors of the vertices, interpolated as the attributes are. */
static void interpolate_errors(struct bounding *bounding, const double share[3])
{
    struct bounded_pixel *pixel = &bounding->pixel;
    const float *const *corner = pixel->corner;
    for (size_t a = 0; a < (size_t)pixel->surface->n_attributes; a++) {
        double error = 0;
        for (int j = 0; j < 3; j++)
            error += fabs(share[j]) * (double)corner[j][a];
        pixel->errors[a] =
            is_flat(bounding, pixel->surface, a) ? pixel->provoking[a] : (float)error;
    }
}

/* The attributes of a triangle at a pixel, by the reference, and their bounds. The bounds of
 * weights do not need the weights themselves, unless there is a texture. */
static void bound_pixel(struct bounding *bounding, const struct bounded_triangle *triangle, int x,
                        int y, bool weights_matter)
{
    const struct lit_scene *lit = bounding->fragments.lit;
    const struct screen_triangle *screen = &triangle->screen;
    const struct surface *surface = screen->surface;
    struct bounded_pixel *pixel = &bounding->pixel;
    struct light_work none = {0};
    double share[3], inverse_w = shares_at(screen, x + 0.5, y + 0.5, share);
    if (pixel->triangle != triangle)
        take_triangle(bounding, triangle);
    if (weights_matter || surface->instance->textured)
        shade(&lit->plan->view, screen, share, pixel->attributes, &none);
    interpolate_errors(bounding, share);
    add_bounds(bounding, inverse_w, x + 0.5, y + 0.5);
    size_t n_terms = (size_t)surface->instance->n_terms;
    if (surface->instance->textured)
        pixel->place = texel_point(&surface->instance->texels, pixel->attributes + n_terms,
                                   pixel->errors + n_terms);
}

/* ---- textures ---- */

/* Takes a place in the texture for the pixel's. */
static void take_place(struct bounded_pixel *pixel, const struct texel_point *place)
{
    const struct instance *instance = pixel->surface->instance;
    pixel->place = *place;
    pixel->value =
        instance->textured && !instance->varied ? texel_at(&instance->texels, place->place) : 1;
}

static const struct texture *texture_of(const struct bounding *bounding)
{
    const struct lit_scene *lit = bounding->fragments.lit;
    return bounds_of(lit, &bounding->pixel.triangle->screen)->shaded->texture;
}

/* Bound on how much the radiance of the pixel changes within a pixel's width, in any wavelength.
 * The texels of a spectral texture may differ by all there is. */
static double steepness(const struct bounding *bounding)
{
    const struct bounded_pixel *pixel = &bounding->pixel;
    const struct instance *instance = pixel->surface->instance;
    const struct lit_scene *lit = bounding->fragments.lit;
    const struct spectral_term *terms =
        bounds_of(lit, &pixel->triangle->screen)->shaded->made.terms;
    double step = 0, whole = 0;
    for (int t = 0; t < instance->n_terms; t++)
        step += (double)pixel->slopes[t] * terms[t].peak;
    if (!instance->textured)
        return step;
    for (int t = 0; t < instance->n_terms; t++)
        whole += pixel->attributes[t] * terms[t].peak;
    struct texel_point near = pixel->place;
    near.e_place[0] = pixel->slopes[instance->n_terms] * (float)instance->texels.width;
    near.e_place[1] = pixel->slopes[instance->n_terms + 1] * (float)instance->texels.height;
    double largest = texture_of(bounding)->largest;
    if (instance->varied)
        return (step + whole * (double)(near.e_place[0] + near.e_place[1])) * largest;
    return step * pixel->value + whole * texel_error(&instance->texels, &near, largest);
}

/* Bounds on the errors of the rows of a pixel: see put_rows. */
static void put_errors(const struct bounding *bounding, float *errors, size_t stride)
{
    const struct bounded_pixel *pixel = &bounding->pixel;
    const struct instance *instance = pixel->surface->instance;
    double e_value = 0;
    size_t n_terms = (size_t)instance->n_terms;
    if (instance->textured && !instance->varied)
        e_value = texel_error(&instance->texels, &pixel->place, texture_of(bounding)->largest);
    for (size_t t = 0; t < n_terms; t++) {
        double error = (double)pixel->errors[t] * (pixel->value + e_value);
        if (instance->textured)
            error += fabs(pixel->attributes[t]) * e_value;
        errors[t * stride] = (float)error;
    }
    for (size_t i = 0; i < 2 && instance->varied; i++)
        errors[(n_terms + i) * stride] = pixel->place.e_place[i];
}

/* ---- ambiguous pixels ---- */

/* Bound on OpenGL's error in a depth that is kept in single precision. */
static float stored_depth_error(double error, double depth)
{
    return (float)(error + roundings(1) * fabs(depth));
}

/* The places in a texture that OpenGL may take for the pixel's; one place where there is none. */
static int choices_of(const struct bounded_pixel *pixel, struct texel_point out[TEXEL_CHOICES])
{
    out[0] = pixel->place;
    return pixel->surface->instance->textured
               ? texel_choices(&pixel->surface->instance->texels, &pixel->place, out)
               : 1;
}

static bool has_room(struct bounding *bounding, size_t n_rows)
{
    struct chunk *out = bounding->chunk;
    size_t *capacity = bounding->capacity;
    return array_grow(&out->candidates, &capacity[1], out->n_candidates + 1,
                      sizeof *out->candidates) &&
           array_grow(&out->candidate_rows, &capacity[2], out->n_numbers + n_rows,
                      sizeof *out->candidate_rows) &&
           array_grow(&out->candidate_errors, &capacity[3], out->n_numbers + n_rows,
                      sizeof *out->candidate_errors);
}

/* A triangle that may be seen at a pixel: one candidate, or as many as OpenGL may take texels. */
static bool add_candidates(struct bounding *bounding, const struct fragment *fragment, int x, int y)
{
    struct chunk *out = bounding->chunk;
    struct texel_point choices[TEXEL_CHOICES];
    const struct bounded_triangle *triangle = &bounding->fragments.triangles[fragment->triangle];
    bound_pixel(bounding, triangle, x, y, true);
    const struct instance *instance = bounding->pixel.surface->instance;
    size_t n_rows = (size_t)pixel_rows(instance);
    int n = choices_of(&bounding->pixel, choices);
    for (int i = 0; i < n; i++) {
        size_t first = out->n_numbers;
        if (!has_room(bounding, n_rows))
            return false;
        take_place(&bounding->pixel, &choices[i]);
        put_rows(instance, bounding->pixel.attributes, choices[i].place,
                 out->candidate_rows + first, 1);
        put_errors(bounding, out->candidate_errors + first, 1);
        out->candidates[out->n_candidates++] = (struct candidate){
            .surface = (int32_t)(triangle->screen.surface - bounding->fragments.lit->surfaces),
            .triangle = triangle->screen.triangle,
            .depth = (float)fragment->depth,
            .depth_error = stored_depth_error(fragment->depth_error, fragment->depth),
            .loose = fragment->loose,
            .first = first};
        out->n_numbers += n_rows;
    }
    return true;
}

/* Where triangles meet without a gap one of them must be there, if the driver is watertight. */
static bool is_surely_covered(const struct bounding *bounding, const struct seam *seam)
{
    return is_closed(seam) && seam->n_covered > 0 && bounding->fragments.lit->driver->watertight;
}

static bool add_ambiguous(struct bounding *bounding, size_t index, int x, int y)
{
    const struct fragment_list *pixel = &bounding->fragments.pixels[index];
    struct chunk *out = bounding->chunk;
    if (!array_grow(&out->ambiguous, &bounding->capacity[0], out->n_ambiguous + 1,
                    sizeof *out->ambiguous))
        return false;
    struct ambiguous_pixel *ambiguous = &out->ambiguous[out->n_ambiguous++];
    *ambiguous = (struct ambiguous_pixel){
        .pixel = (int32_t)index,
        .first = (int32_t)out->n_candidates,
        .background = pixel->limit == HUGE_VAL &&
                      !is_surely_covered(bounding, &bounding->fragments.seams[index])};
    for (int32_t f = pixel->head; f >= 0; f = bounding->fragments.fragments[f].next)
        if (!add_candidates(bounding, &bounding->fragments.fragments[f], x, y))
            return false;
    ambiguous->count = (int32_t)out->n_candidates - ambiguous->first;
    return true;
}

/* ---- settled pixels ---- */

/* A pixel is settled when its one candidate is definite and bounded, and the reference shows it, or
 * when it has none. */
static bool is_settled(const struct bounding *bounding, size_t index)
{
    const struct fragment_list *pixel = &bounding->fragments.pixels[index];
    const struct picture *picture = &bounding->chunk->picture;
    if (pixel->head < 0)
        return picture->surface[index] < 0;
    const struct fragment *only = &bounding->fragments.fragments[pixel->head];
    const struct screen_triangle *screen = &bounding->fragments.triangles[only->triangle].screen;
    return only->next < 0 && pixel->limit < HUGE_VAL && !only->loose &&
           picture->surface[index] == screen->surface - bounding->fragments.lit->surfaces &&
           picture->triangle[index] == screen->triangle;
}

/* The bounds of a settled pixel; returns whether its texture leaves OpenGL a choice. */
static bool settle(struct bounding *bounding, size_t index, int x, int y)
{
    struct chunk *out = bounding->chunk;
    const struct fragment_list *list = &bounding->fragments.pixels[index];
    size_t n_pixels = (size_t)out->picture.at.width * (size_t)out->picture.at.height;
    struct texel_point choices[TEXEL_CHOICES];
    if (list->head < 0)
        return false;
    const struct bounded_triangle *triangle =
        &bounding->fragments.triangles[bounding->fragments.fragments[list->head].triangle];
    bound_pixel(bounding, triangle, x, y, false);
    int n = choices_of(&bounding->pixel, choices);
    take_place(&bounding->pixel, n == 1 ? &choices[0] : &bounding->pixel.place);
    out->depth_error[index] = stored_depth_error(triangle->depth_error, out->picture.depth[index]);
    out->steepness[index] = (float)steepness(bounding);
    put_errors(bounding, out->errors + index, n_pixels);
    return n > 1;
}

/* How many fragments a pixel may have. */
static struct overdraw overdraw_of(const struct fragment_list *pixel, const struct seam *seam)
{
    uint32_t spread = pixel->n_possible - pixel->n_definite;
    return (struct overdraw){.least = (uint8_t)pixel->n_definite,
                             .spread = spread < UINT8_MAX ? (uint8_t)spread : UINT8_MAX,
                             .meant = (uint8_t)(pixel->n_definite + seam->n_covered),
                             .closed = is_closed(seam)};
}

static bool resolve_pixel(struct bounding *bounding, size_t index)
{
    struct chunk *out = bounding->chunk;
    const struct rectangle *at = &out->picture.at;
    int x = at->x + (int)index % at->width, y = at->y + (int)index / at->width;
    bool settled = is_settled(bounding, index);
    out->overdraw[index] =
        overdraw_of(&bounding->fragments.pixels[index], &bounding->fragments.seams[index]);
    if (settled)
        settled = !settle(bounding, index, x, y);
    out->is_ambiguous[index] = !settled;
    return settled || add_ambiguous(bounding, index, x, y);
}

/* ---- a chunk ---- */

static bool allocate(struct bounding *bounding)
{
    struct chunk *out = bounding->chunk;
    const struct plan *plan = bounding->fragments.lit->plan;
    size_t n_pixels = (size_t)out->picture.at.width * (size_t)out->picture.at.height,
           n_clipped = bounding->fragments.n_clipped, most = (size_t)plan->max_rows + 2;
    bounding->max_attributes = most;
    bounding->bounds = calloc(n_clipped * most + 1, sizeof *bounding->bounds);
    bounding->bounded = calloc(n_clipped + 1, sizeof *bounding->bounded);
    bounding->pixel.attributes = malloc(most * sizeof *bounding->pixel.attributes);
    bounding->pixel.errors = malloc(3 * most * sizeof *bounding->pixel.errors);
    out->errors = malloc(n_pixels * (size_t)plan->max_rows * sizeof *out->errors + 1);
    out->depth_error = malloc(n_pixels * sizeof *out->depth_error + 1);
    out->overdraw = malloc(n_pixels * sizeof *out->overdraw + 1);
    out->steepness = malloc(n_pixels * sizeof *out->steepness + 1);
    out->is_ambiguous = malloc(n_pixels * sizeof *out->is_ambiguous + 1);
    return bounding->bounds && bounding->bounded && bounding->pixel.attributes &&
           bounding->pixel.errors && out->errors && out->depth_error && out->overdraw &&
           out->steepness && out->is_ambiguous;
}

static bool resolve_all(struct bounding *bounding)
{
    const struct rectangle *at = &bounding->chunk->picture.at;
    size_t n_pixels = (size_t)at->width * (size_t)at->height;
    if (!allocate(bounding))
        return false;
    bounding->pixel.interpolation = bounding->pixel.errors + bounding->max_attributes;
    bounding->pixel.slopes = bounding->pixel.interpolation + bounding->max_attributes;
    for (size_t i = 0; i < n_pixels; i++)
        if (!resolve_pixel(bounding, i))
            return false;
    return true;
}

static bool find_candidates(const struct lit_scene *lit, const struct rectangle *tile,
                            struct chunk *chunk)
{
    struct bounding bounding = {.chunk = chunk,
                                .fragments = {.lit = lit, .tile = tile, .rows = chunk->picture.at}};
    bool done = fragments_find(&bounding.fragments) && resolve_all(&bounding);
    fragments_free(&bounding.fragments);
    free(bounding.bounds);
    free(bounding.bounded);
    free(bounding.pixel.attributes);
    free(bounding.pixel.errors);
    return done;
}

int chunk_count(const struct rectangle *tile)
{
    return (tile->height + CHUNK_ROWS - 1) / CHUNK_ROWS;
}

struct rectangle chunk_rows(const struct rectangle *tile, int index)
{
    struct rectangle rows = *tile;
    rows.y += index * CHUNK_ROWS;
    rows.height = tile->height - index * CHUNK_ROWS;
    if (rows.height > CHUNK_ROWS)
        rows.height = CHUNK_ROWS;
    return rows;
}

bool chunks_each(const struct rectangle *tile, int threads,
                 bool (*work)(void *context, const struct rectangle *tile, int index,
                              struct error *err),
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

bool chunk_draw(const struct lit_scene *lit, const struct rectangle *tile, int index,
                struct chunk *out, struct error *err)
{
    const struct plan *plan = lit->plan;
    const struct rectangle rows = chunk_rows(tile, index);
    *out = (struct chunk){.errors = NULL};
    return (picture_draw(&plan->view, lit->surfaces, plan->n_instances, &rows, plan->max_rows,
                         &out->picture) &&
            (!plan->options.check || find_candidates(lit, tile, out))) ||
           error_memory(err);
}

void chunk_free(struct chunk *chunk)
{
    picture_free(&chunk->picture);
    free(chunk->errors);
    free(chunk->depth_error);
    free(chunk->overdraw);
    free(chunk->steepness);
    free(chunk->is_ambiguous);
    free(chunk->ambiguous);
    free(chunk->candidates);
    free(chunk->candidate_rows);
    free(chunk->candidate_errors);
    *chunk = (struct chunk){.errors = NULL};
}
