/* SPDX-License-Identifier: MIT */
/* A triangle at a pixel: the attributes that the reference computes there, and bounds on OpenGL's
 * errors. An error is common to all bands where geometry makes it: positions, lighting, 1 / w and
 * places in a texture are computed once for all of them. Each band's own roundings come on top. */
#include <math.h>
#include <string.h>

#include "raster/candidates/inside.h"

bool pixel_open(const struct fragments *fragments, struct bounded_pixel *out)
{
    const struct lit_scene *lit = fragments->tile->lit;
    size_t most = (size_t)lit->plan->max_rows + 2, n = fragments->n_clipped;
    *out = (struct bounded_pixel){.fragments = fragments,
                                  .lit = lit,
                                  .flat = lit->plan->view.shading == FLAT,
                                  .max_attributes = most};
    if (!memory_make(&out->bounds, n * most, sizeof *out->bounds) ||
        !memory_make(&out->bounded, n, sizeof *out->bounded) ||
        !memory_make(&out->attributes, most, sizeof *out->attributes) ||
        !memory_make(&out->common, 4 * most, sizeof *out->common))
        return false;
    out->interpolation = out->common + most;
    out->own = out->common + 2 * most;
    out->slopes = out->common + 3 * most;
    return true;
}

void pixel_close(struct bounded_pixel *pixel)
{
    FREE_ALL(pixel->bounds, pixel->bounded, pixel->attributes, pixel->common);
}

/* ---- bounds of attributes ---- */

/* Returns whether an attribute is constant over a triangle. Flat shading takes the weights of one
 * vertex; texture coordinates still vary. */
static bool is_flat(const struct bounded_pixel *pixel, size_t attribute)
{
    return pixel->flat && attribute < (size_t)pixel->surface->instance->n_terms;
}

/* A cut starts at the end of the edge that is nearer to the plane, and adds at most half of the
 * edge's difference, which is rounded and multiplied: 2 roundings of half the largest value, and
 * one of the sum. */
enum { CUT_ROUNDINGS = 2 };

/* The values of an attribute at the corners of a clipped triangle. */
struct corner_values {
    double at[3], largest; /* largest: of any vertex of the whole triangle */
};

/* Cuts the values at the vertices: the reference's weights, or the part of a group of lights. */
static struct corner_values cut_values(const struct bounded_pixel *pixel,
                                       const struct clipped_triangle *clipped, size_t attribute,
                                       const float *parts)
{
    const struct screen_triangle *screen = &pixel->triangle->screen;
    const struct surface *surface = pixel->surface;
    struct corner_values out = {.largest = 0};
    for (int j = 0; j < 3; j++) {
        size_t at = surface_attributes(surface, screen->vertex[j], screen->side) + attribute;
        double value = parts ? (double)parts[at] : surface->weights[at];
        for (int c = 0; c < 3; c++)
            out.at[c] += clipped->screen.share[c][j] * value;
        out.largest = fmax(out.largest, fabs(value));
    }
    return out;
}

/* Sums the roundings of the groups of lights: each is a picture of its own, and gradients that
 * cancel in the sum of the pictures do not cancel in their roundings. */
static void add_groups(const struct bounded_pixel *pixel, const struct clipped_triangle *clipped,
                       size_t attribute, struct colour_bound *out)
{
    const struct surface_bounds *bounds = bounds_of(pixel->lit, &pixel->triangle->screen);
    out->own_constant = out->own_fixed = 0;
    for (int group = 0; group < pixel->lit->plan->n_light_groups; group++) {
        const float *parts = group_weights(pixel->surface, bounds, group);
        struct corner_values values = cut_values(pixel, clipped, attribute, parts);
        struct colour_bound bound = bound_colour(clipped, values.at);
        out->own_constant += bound.own_constant;
        out->own_fixed += bound.own_fixed;
    }
}

/* Adds the bounds of the jumps at gated corners. Bounds add up as values do, so that the sum holds
 * for every choice of gates. */
static void add_jumps(const struct bounded_pixel *pixel, const struct clipped_triangle *clipped,
                      size_t attribute, struct colour_bound *out)
{
    for (int j = 0; j < 3; j++) {
        double values[3];
        if (!pixel->jumps[j])
            continue;
        for (int c = 0; c < 3; c++)
            values[c] = clipped->screen.share[c][j] * (double)pixel->jumps[j][attribute];
        struct colour_bound jump = bound_colour(clipped, values);
        out->constant += jump.constant;
        out->fixed += jump.fixed;
        out->per_d += jump.per_d;
        out->own_constant += jump.own_constant;
        out->own_fixed += jump.own_fixed;
    }
}

/* The largest error of an attribute at the vertices of the triangle. */
static double vertex_error(const struct bounded_pixel *pixel, size_t attribute)
{
    double largest = 0;
    for (int j = 0; j < 3; j++)
        largest = fmax(largest, (double)pixel->corner[j][attribute]);
    return largest;
}

/* Bounds the error of one attribute in one clipped triangle: the error of its interpolation, and
 * the amount by which position errors magnify the errors of its vertices. In a triangle without a
 * bound the bound is the range of the attribute's values. */
static struct colour_bound clipped_bound(const struct bounded_pixel *pixel,
                                         const struct clipped_triangle *clipped, size_t attribute)
{
    const struct instance *instance = pixel->surface->instance;
    const struct corner_values values = cut_values(pixel, clipped, attribute, NULL);
    const double magnification = clipped->magnification;
    const double e_vertex = vertex_error(pixel, attribute),
                 e_cut = roundings(CUT_ROUNDINGS * clipped->cuts) * values.largest;
    if (!(magnification < HUGE_VAL))
        return (struct colour_bound){.constant = most_of(values.at) - least_of(values.at)};
    struct colour_bound bound = bound_colour(clipped, values.at);
    if (attribute < (size_t)instance->n_terms) { /* a weight */
        if (pixel->lit->plan->n_light_groups > 1 &&
            instance->terms[attribute].reflection != CONSTANT)
            add_groups(pixel, clipped, attribute, &bound);
        add_jumps(pixel, clipped, attribute, &bound);
    }
    bound.constant = magnification * bound.constant + (magnification - 1) * e_vertex;
    bound.fixed *= magnification;
    bound.per_d *= magnification;
    bound.own_constant = magnification * (bound.own_constant + e_cut);
    bound.own_fixed *= magnification;
    return bound;
}

/* Raises the interpolation's errors and the slopes to those of clipped triangle `index` of the
 * pixel's triangle. */
static void raise_bounds(struct bounded_pixel *pixel, int32_t index, double inverse_w)
{
    const size_t at = (size_t)(pixel->triangle->first_clipped + index);
    const struct colour_bound *of_d = &pixel->fragments->clipped[at].inverse_w_bound;
    struct colour_bound *bounds = pixel->bounds + at * pixel->max_attributes;
    for (size_t a = 0; a < (size_t)pixel->surface->n_attributes && !pixel->bounded[at]; a++)
        if (!is_flat(pixel, a)) /* the bounds of others are 0 */
            bounds[a] = clipped_bound(pixel, &pixel->fragments->clipped[at], a);
    pixel->bounded[at] = true;
    /* a fragment is loose if 1 / w may not be positive */
    double least = inverse_w * (1 - of_d->per_d) - of_d->fixed;
    float over = least > 0 ? (float)(1 / least) : 0, d = (float)inverse_w;
    for (size_t a = 0; a < (size_t)pixel->surface->n_attributes; a++) {
        const struct colour_bound *of = &bounds[a];
        float common = (float)of->constant + over * ((float)of->fixed + d * (float)of->per_d),
              own = (float)of->own_constant + over * (float)of->own_fixed;
        pixel->interpolation[a] = fmaxf(pixel->interpolation[a], common);
        pixel->own[a] = fmaxf(pixel->own[a], own);
        pixel->slopes[a] = fmaxf(pixel->slopes[a], (float)of->slope / d);
    }
}

/* Adds to the errors of the pixel the largest bound of these clipped triangles, and notes the
 * largest slopes. */
static void add_bounds(struct bounded_pixel *pixel, double inverse_w, unsigned clipped)
{
    const size_t n_attributes = (size_t)pixel->surface->n_attributes;
    for (size_t a = 0; a < n_attributes; a++)
        pixel->interpolation[a] = pixel->own[a] = pixel->slopes[a] = 0;
    for (int32_t i = 0; i < pixel->triangle->n_clipped; i++)
        if (clipped >> i & 1)
            raise_bounds(pixel, i, inverse_w);
    for (size_t a = 0; a < n_attributes; a++)
        pixel->common[a] += pixel->interpolation[a];
}

/* Makes a triangle the pixel's. Neighbouring pixels mostly show the same triangle, so this is
 * called rarely. Roundings of a colour: its spectrum in single precision (1), weight times spectrum
 * (1), and a texture's value and its product (2); two more for the arithmetic of the bound itself.
 * Materials are white, so that their products are exact. Each colour and each pass that is added
 * rounds once. */
static void take_triangle(struct bounded_pixel *pixel, const struct bounded_triangle *triangle)
{
    const struct screen_triangle *screen = &triangle->screen;
    const struct surface *surface = screen->surface;
    const struct surface_bounds *bounds = bounds_of(pixel->lit, screen);
    const float *errors = bounds->errors;
    pixel->triangle = triangle;
    pixel->surface = surface;
    pixel->shaded = bounds->shaded;
    for (int j = 0; j < 3; j++)
        pixel->corner[j] = errors + surface_attributes(surface, screen->vertex[j], screen->side);
    pixel->provoking = errors + surface_attributes(surface, screen->provoking, screen->side);
    pixel->brightest = shaded_brightest(pixel->shaded);
    pixel->rounding = roundings(4 + 2 * surface->instance->textured + pixel->shaded->n_colours +
                                pixel->lit->plan->n_light_groups);
    /* a flat triangle has one vertex that counts, taken for its first */
    const bool flat = pixel->flat;
    pixel->n_gated = 0;
    for (int j = 0; j < 3; j++) {
        const int vertex = flat ? screen->provoking : screen->vertex[j];
        const bool gated = bounds->vertices[vertex].gated[screen->side] && (j == 0 || !flat);
        pixel->jumps[j] =
            gated ? bounds->jumps + surface_attributes(surface, vertex, screen->side) : NULL;
        pixel->n_gated += gated;
    }
}

/* ---- the level of detail ---- */

/* Bounds the error of an attribute's step from pixel to pixel of a rule, in any triangle that
 * OpenGL may have set up. */
static double step_error(const struct bounded_pixel *pixel, const struct fragment *fragment,
                         size_t attribute, const struct detail_pixels *at, int to)
{
    const double from_px[2] = {at->x[0] + 0.5, at->y[0] + 0.5},
                 to_px[2] = {at->x[to] + 0.5, at->y[to] + 0.5};
    const double e_vertex = vertex_error(pixel, attribute);
    double out = 0;
    for (int32_t i = 0; i < pixel->triangle->n_clipped; i++) {
        const struct clipped_triangle *clipped =
            &pixel->fragments->clipped[pixel->triangle->first_clipped + i];
        const struct corner_values values = cut_values(pixel, clipped, attribute, NULL);
        const double e_cut = roundings(CUT_ROUNDINGS * clipped->cuts) * values.largest;
        if (fragment->clipped >> i & 1)
            out = fmax(out, bound_step(clipped, values.at, e_vertex + e_cut, from_px, to_px));
    }
    return out;
}

/* Bounds the errors of the steps of a rule, in texels. */
static void step_errors(const struct bounded_pixel *pixel, const struct fragment *fragment,
                        const struct detail_pixels *at, double out[2][2])
{
    const struct instance *instance = pixel->surface->instance;
    const int size[2] = {instance->texels.width, instance->texels.height};
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < 2; c++)
            out[i][c] =
                size[c] * step_error(pixel, fragment, (size_t)(instance->n_terms + c), at, i + 1);
}

/* A driver whose rule is not known may begin at any corner of a quad, however quads pair rows. */
static void add_corners(const struct bounded_pixel *pixel, const struct fragment *fragment, int x,
                        int y, struct bounded_steps *out)
{
    for (int corner = 0; corner < 8; corner++) {
        const struct detail_rule rule = {
            .quad = true, .right = corner & 1, .lower = corner >> 1 & 1, .first_row = corner >> 2};
        const struct detail_pixels at = detail_pixels(&rule, x, y);
        double other[2][2], e_other[2][2];
        detail_steps(&rule, &pixel->triangle->screen, x, y, other);
        step_errors(pixel, fragment, &at, e_other);
        for (int i = 0; i < 2; i++)
            for (int c = 0; c < 2; c++)
                out->errors[i][c] =
                    fmax(out->errors[i][c],
                         fabs(fabs(other[i][c]) - fabs(out->steps[i][c])) + e_other[i][c]);
    }
}

/* The pixels of a quad mostly have the same steps. */
static void bound_detail(struct bounded_pixel *pixel, const struct fragment *fragment, int x, int y)
{
    const struct driver *driver = pixel->lit->driver;
    const struct detail_pixels at = detail_pixels(&driver->detail, x, y);
    struct bounded_steps *last = &pixel->steps;
    if (last->triangle != pixel->triangle || last->clipped != fragment->clipped ||
        memcmp(&last->at, &at, sizeof at) != 0) {
        *last = (struct bounded_steps){pixel->triangle, fragment->clipped, at, {{0}}, {{0}}};
        detail_steps(&driver->detail, &pixel->triangle->screen, x, y, last->steps);
        step_errors(pixel, fragment, &at, last->errors);
        if (driver->detail_error < 0)
            add_corners(pixel, fragment, x, y, last);
    }
    texel_detail(&pixel->surface->instance->texels, driver, last->steps, last->errors,
                 &pixel->place);
}

void pixel_bound(struct bounded_pixel *pixel, const struct fragment *fragment, int x, int y,
                 bool weights_matter)
{
    const struct bounded_triangle *triangle = &pixel->fragments->triangles[fragment->triangle];
    const struct screen_triangle *screen = &triangle->screen;
    const struct instance *instance = screen->surface->instance;
    struct light_work none = {0};
    double *share = pixel->share, inverse_w = shares_at(screen, x + 0.5, y + 0.5, share);
    if (pixel->triangle != triangle)
        take_triangle(pixel, triangle);
    if (weights_matter || instance->textured)
        shade(&pixel->lit->plan->view, screen, share, pixel->attributes, &none);
    for (size_t a = 0; a < (size_t)pixel->surface->n_attributes; a++) {
        double error = 0; /* of the vertices, interpolated as the attributes are */
        for (int j = 0; j < 3; j++)
            error += fabs(share[j]) * (double)pixel->corner[j][a];
        pixel->common[a] = is_flat(pixel, a) ? pixel->provoking[a] : (float)error;
    }
    add_bounds(pixel, inverse_w, fragment->clipped);
    if (!instance->textured)
        return;
    float e_place[2];
    for (int i = 0; i < 2; i++)
        e_place[i] = pixel->common[instance->n_terms + i] + pixel->own[instance->n_terms + i];
    pixel->place = texel_point(&instance->texels, pixel->lit->driver,
                               pixel->attributes + instance->n_terms, e_place);
    if (instance->texels.n_levels > 1)
        bound_detail(pixel, fragment, x, y);
}

/* ---- textures ---- */

void pixel_take_place(struct bounded_pixel *pixel, const struct texel_point *place)
{
    const struct instance *instance = pixel->surface->instance;
    pixel->place = *place;
    pixel->value =
        instance->textured && !instance->varied ? texel_at(&instance->texels, place->place) : 1;
}

/* Neighbouring texels of a spectral texture may differ by the texture's largest value. */
double pixel_steepness(const struct bounded_pixel *pixel)
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
    struct texel_value value;
    texel_value(&instance->texels, &near, largest, &value);
    return step * pixel->value + whole * value.error;
}

/* Each bit of `gates` stands for a gated corner. */
void pixel_turn_gates(struct bounded_pixel *pixel, unsigned gates)
{
    for (int j = 0; j < 3; j++) {
        if (!pixel->jumps[j])
            continue;
        for (int t = 0; t < pixel->surface->instance->n_terms && (gates & 1) != 0; t++)
            pixel->attributes[t] +=
                (pixel->flat ? 1 : pixel->share[j]) * (double)pixel->jumps[j][t];
        gates >>= 1;
    }
}

void pixel_put(const struct bounded_pixel *pixel, double *rows, size_t stride)
{
    const struct instance *instance = pixel->surface->instance;
    put_rows(instance, pixel->attributes, pixel->place.place, rows, stride);
    lights_darken(&pixel->lit->plan->view, instance, pixel->dark, rows, stride);
}

/* The errors of a pixel's weights, added up: see struct mean_bound. */
struct error_sums {
    double light, rounding, position, texture;
};

/* Sorts the error of one weight by its causes. */
static void sort_error(const struct bounded_pixel *pixel, size_t t, double value, double e_value,
                       double weight, struct error_sums *sums)
{
    const double mean = pixel->shaded->made.terms[t].mean / pixel->brightest,
                 spectrum = mean * value;
    sums->light += (double)(pixel->common[t] - pixel->interpolation[t]) * spectrum;
    sums->rounding += pixel->rounding * fabs(weight) * spectrum;
    sums->position += (double)(pixel->interpolation[t] + pixel->own[t]) * spectrum;
    sums->texture += fabs(weight) * e_value * mean;
}

/* Bounds the error of the texture's value at the pixel. *largest becomes the largest value there:
 * of a texture that differs from band to band, its largest one. */
static double value_error(const struct bounded_pixel *pixel, double *largest)
{
    const struct instance *instance = pixel->surface->instance;
    const struct texture *texture = pixel->shaded->texture;
    const float *e_place = pixel->place.e_place;
    double e_value = 0;
    *largest = 1;
    if (instance->varied) {
        *largest = texture->largest;
        e_value = (double)e_place[PLACE_ACROSS] + (double)e_place[PLACE_UP];
        e_value += instance->texels.n_levels > 1 ? (double)e_place[PLACE_DETAIL] : 0;
        e_value = fmin(1, e_value) * *largest;
    } else if (instance->textured) {
        struct texel_value value;
        texel_value(&instance->texels, &pixel->place, texture->largest, &value);
        e_value = value.error;
        *largest = pixel->value + e_value;
    }
    return e_value;
}

/* A texture that all bands have in common has one value for all of them, error included. */
struct mean_bound pixel_errors(const struct bounded_pixel *pixel, const double *rows, size_t stride,
                               float *errors, float *own)
{
    const struct instance *instance = pixel->surface->instance;
    const size_t n_terms = (size_t)instance->n_terms;
    struct error_sums sums = {0, 0, 0, 0};
    double largest, e_value = value_error(pixel, &largest);
    for (size_t t = 0; t < n_terms; t++) {
        if ((light_bit(&pixel->lit->plan->view, &instance->terms[t]) & pixel->dark) != 0) {
            errors[t * stride] = own[t * stride] = 0;
            continue;
        }
        double weight = fabs(instance->textured ? pixel->attributes[t] : rows[t * stride]),
               common = (double)pixel->common[t], alone = (double)pixel->own[t];
        if (instance->textured && !instance->varied) {
            common = common * largest + weight * e_value;
            alone *= largest;
        }
        alone += pixel->rounding * (fabs(rows[t * stride]) + common);
        errors[t * stride] = (float)(common + alone);
        own[t * stride] = (float)alone;
        sort_error(pixel, t, largest, e_value, weight, &sums);
    }
    for (size_t i = n_terms; i < (size_t)pixel_rows(instance); i++) {
        errors[i * stride] = pixel->place.e_place[i - n_terms];
        own[i * stride] = 0;
    }
    const double shared = sums.light + sums.rounding,
                 most = fmax(shared, fmax(sums.position, sums.texture));
    return (struct mean_bound){.shared = (float)shared,
                               .varying = (float)(sums.position + sums.texture),
                               .cause = most <= sums.position  ? CAUSE_POSITION
                                        : most <= sums.texture ? CAUSE_TEXTURE
                                                               : CAUSE_LIGHT};
}

int pixel_choices(const struct bounded_pixel *pixel, struct texel_point out[TEXEL_CHOICES])
{
    out[0] = pixel->place;
    return pixel->surface->instance->textured
               ? texel_choices(&pixel->surface->instance->texels, &pixel->place, out)
               : 1;
}
