/* SPDX-License-Identifier: MIT */
/* Draws some rows of a tile by the reference. With a check every pixel then gets bounds on OpenGL's
 * error. A pixel that may show several triangles gets candidates, each with its own bounds. */
#include <math.h>
#include <stdlib.h>

#include "data/maths/maths.h"
#include "data/terms/terms.h"
#include "data/tiff/tiff.h"
#include "raster/candidates/candidates.h"
#include "raster/plan/plan.h"

/* Bound on OpenGL's error in one attribute of a clipped triangle: see bound_colour. */
struct attribute_bound {
    float constant, fixed, per_d, slope;
};

/* The attributes of a pixel, with bounds on OpenGL's errors, and on the change of the attributes
 * within a pixel's width. */
struct bounded_pixel {
    const struct bounded_triangle *triangle;
    const struct surface *surface;
    const struct shaded_material *shaded;
    const float *corner[3], *provoking; /* errors of the triangle's vertices */
    double *attributes;                 /* these four arrays have room for any surface */
    float *errors, *interpolation, *slopes;
    struct texel_point place; /* in its texture, and the value there unless the texture is varied */
    double value;
};

/* The state of a chunk while its pixels get their bounds. */
struct bounding {
    struct fragments fragments;
    struct chunk *chunk;
    struct attribute_bound *bounds; /* [clipped triangle][max_attributes], computed when needed */
    bool *bounded;                  /* [clipped triangle] */
    size_t max_attributes;          /* of any surface */
    struct bounded_pixel pixel;
    size_t capacity[4]; /* of the arrays of the chunk that grow */
};

/* ---- bounds of attributes ---- */

/* Returns whether an attribute is constant over a triangle. Flat shading takes the weights of one
 * vertex; texture coordinates still vary. */
static bool is_flat(const struct bounding *bounding, const struct surface *surface,
                    size_t attribute)
{
    return bounding->fragments.lit->plan->view.shading == FLAT &&
           attribute < (size_t)surface->instance->n_terms;
}

/* Roundings of an attribute that six planes may cut: a difference, a product and a sum for each
 * plane. */
enum { CUT_ROUNDINGS = 18 };

/* Bounds the error of one attribute in one clipped triangle: the error of its interpolation, and
 * the amount by which position errors magnify the errors of its vertices. In a triangle without a
 * bound the bound is the range of the attribute's values. */
static struct colour_bound clipped_bound(const struct bounded_pixel *pixel,
                                         const struct clipped_triangle *clipped, size_t attribute)
{
    const struct screen_triangle *screen = &pixel->triangle->screen;
    const struct surface *surface = pixel->surface;
    double values[3] = {0, 0, 0}, e_vertex = 0, largest = 0, magnification = clipped->magnification;
    for (int j = 0; j < 3; j++) {
        size_t at = surface_attributes(surface, screen->vertex[j], screen->side) + attribute;
        for (int c = 0; c < 3; c++)
            values[c] += clipped->share[c][j] * surface->weights[at];
        e_vertex = fmax(e_vertex, (double)pixel->corner[j][attribute]);
        largest = fmax(largest, fabs(surface->weights[at]));
    }
    double e_cut = pixel->triangle->straddles ? roundings(CUT_ROUNDINGS) * largest : 0;
    if (!(magnification < HUGE_VAL))
        return (struct colour_bound){.constant = most_of(values) - least_of(values)};
    struct colour_bound bound = bound_colour(clipped, values);
    bound.constant = magnification * (bound.constant + e_cut) + (magnification - 1) * e_vertex;
    bound.fixed *= magnification;
    bound.per_d *= magnification;
    return bound;
}

/* Returns the bounds of all attributes in clipped triangle `index` of the pixel's triangle. */
static const struct attribute_bound *attribute_bounds(struct bounding *bounding, int32_t index)
{
    const struct bounded_pixel *pixel = &bounding->pixel;
    const struct surface *surface = pixel->surface;
    size_t at = (size_t)(pixel->triangle->first_clipped + index);
    struct attribute_bound *bounds = bounding->bounds + at * bounding->max_attributes;
    for (size_t a = 0; a < (size_t)surface->n_attributes && !bounding->bounded[at]; a++) {
        struct colour_bound bound = {.constant = 0};
        if (!is_flat(bounding, surface, a))
            bound = clipped_bound(pixel, &bounding->fragments.clipped[at], a);
        bounds[a] = (struct attribute_bound){(float)bound.constant, (float)bound.fixed,
                                             (float)bound.per_d, (float)bound.slope};
    }
    bounding->bounded[at] = true;
    return bounds;
}

/* Adds to the errors of the pixel the largest bound of the clipped triangles there, and notes the
 * largest slopes. */
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
        const struct attribute_bound *bounds = attribute_bounds(bounding, i);
        /* a fragment is loose if 1 / w may not be positive */
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

/* Makes a triangle the pixel's. Neighbouring pixels mostly show the same triangle, so this is
 * called rarely. */
static void take_triangle(struct bounding *bounding, const struct bounded_triangle *triangle)
{
    const struct screen_triangle *screen = &triangle->screen;
    const struct surface *surface = screen->surface;
    const struct surface_bounds *bounds = bounds_of(bounding->fragments.lit, screen);
    const float *errors = bounds->errors;
    struct bounded_pixel *pixel = &bounding->pixel;
    pixel->triangle = triangle;
    pixel->surface = surface;
    pixel->shaded = bounds->shaded;
    for (int j = 0; j < 3; j++)
        pixel->corner[j] = errors + surface_attributes(surface, screen->vertex[j], screen->side);
    pixel->provoking = errors + surface_attributes(surface, screen->provoking, screen->side);
}

/* Interpolates the errors of the vertices as the attributes are interpolated. */
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

/* Computes the attributes of a triangle at a pixel by the reference, and their bounds. The bounds
 * of weights need the weights only if there is a texture; otherwise the weights are computed only
 * if weights_matter. */
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

/* Makes a place in the texture the pixel's. */
static void take_place(struct bounded_pixel *pixel, const struct texel_point *place)
{
    const struct instance *instance = pixel->surface->instance;
    pixel->place = *place;
    pixel->value =
        instance->textured && !instance->varied ? texel_at(&instance->texels, place->place) : 1;
}

/* Returns a bound on the change of radiance within a pixel's width, at any wavelength. Neighbouring
 * texels of a spectral texture may differ by the texture's largest value. */
static double steepness(const struct bounded_pixel *pixel)
{
    const struct instance *instance = pixel->surface->instance;
    const struct spectral_term *terms = pixel->shaded->made.terms;
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
    double largest = pixel->shaded->texture->largest;
    if (instance->varied)
        return (step + whole * (double)(near.e_place[0] + near.e_place[1])) * largest;
    return step * pixel->value + whole * texel_error(&instance->texels, &near, largest);
}

/* Writes bounds on the errors of the rows of a pixel: see put_rows. */
static void put_errors(const struct bounded_pixel *pixel, float *errors, size_t stride)
{
    const struct instance *instance = pixel->surface->instance;
    double e_value = 0;
    size_t n_terms = (size_t)instance->n_terms;
    if (instance->textured && !instance->varied)
        e_value = texel_error(&instance->texels, &pixel->place, pixel->shaded->texture->largest);
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

/* Returns a bound on OpenGL's error relative to a depth that is stored in single precision. */
static float stored_depth_error(double error, double depth)
{
    return (float)(error + roundings(1) * fabs(depth));
}

/* Finds the places in the texture that OpenGL may sample for the pixel. Returns their number: 1 if
 * there is no texture. */
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

/* Adds a triangle that may be visible at a pixel: one candidate for each place in the texture that
 * OpenGL may sample. */
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
        put_errors(&bounding->pixel, out->candidate_errors + first, 1);
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

/* Returns whether some triangle must cover the pixel: triangles meet there without a gap, and the
 * driver is watertight. */
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

/* Returns whether a pixel is settled: it has one candidate, which is definite, bounded and shown by
 * the reference; or it has no candidate, and the reference shows the background. */
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

/* Stores the bounds of a settled pixel. Returns whether OpenGL may sample several places of its
 * texture. */
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
    out->steepness[index] = (float)steepness(&bounding->pixel);
    put_errors(&bounding->pixel, out->errors + index, n_pixels);
    return n > 1;
}

/* Returns how many fragments a pixel may have. */
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

/* Returns the rectangle of a chunk of the tile. */
static struct rectangle chunk_rows(const struct rectangle *tile, int index)
{
    struct rectangle rows = *tile;
    rows.y += index * CHUNK_ROWS;
    rows.height = tile->height - index * CHUNK_ROWS;
    if (rows.height > CHUNK_ROWS)
        rows.height = CHUNK_ROWS;
    return rows;
}

bool chunk_draw(const struct lit_scene *lit, const struct rectangle *tile, int index,
                struct chunk *out)
{
    const struct plan *plan = lit->plan;
    const struct rectangle rows = chunk_rows(tile, index);
    *out = (struct chunk){.picture = {.at = rows}};
    if (!plan->options.check && !plan->options.store_raster)
        return true;
    return picture_draw(&plan->view, lit->surfaces, plan->n_instances, &rows, plan->max_rows,
                        &out->picture) &&
           (!plan->options.check || find_candidates(lit, tile, out));
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
