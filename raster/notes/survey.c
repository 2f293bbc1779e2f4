/* SPDX-License-Identifier: MIT */
/* Surveys a lit scene before its picture: how large each surface is in view, how bright its
 * vertices are, and how much of the area in view is how bright. Nothing hides anything here. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "raster/notes/notes.h"
#include "raster/radiance/radiance.h"

/* ---- classes of brightness ---- */

/* A class is an eighth of the way from a power of two to the next. The first and the last hold all
 * that is darker or brighter. */
enum { EIGHTHS = 8, LEAST_EXPONENT = -128, EXPONENTS = 256, CLASSES = EXPONENTS * EIGHTHS };

static int class_of(double brightness)
{
    int exponent;
    const double half = frexp(brightness, &exponent); /* from 0.5 to below 1 */
    if (!(brightness > 0))
        return 0;
    if (!isfinite(brightness))
        return CLASSES - 1;
    if (exponent < LEAST_EXPONENT)
        return 0;
    return exponent >= LEAST_EXPONENT + EXPONENTS
               ? CLASSES - 1
               : (exponent - LEAST_EXPONENT) * EIGHTHS + (int)((half - 0.5) * 2 * EIGHTHS);
}

/* Returns the upper end of a class. */
static double class_end(int class)
{
    if (class == CLASSES - 1)
        return HUGE_VAL;
    return ldexp(0.5 + (class % EIGHTHS + 1) / (2.0 * EIGHTHS), class / EIGHTHS + LEAST_EXPONENT);
}

double survey_exceeded(const struct scene_survey *survey, double share)
{
    double left = share * survey->area;
    int class = CLASSES - 1;
    while (class > 0 && survey->areas[class] <= left)
        left -= survey->areas[class --];
    return class_end(class);
}

/* ---- areas in the picture ---- */

static unsigned planes_outside(const double clip[4])
{
    unsigned planes = 0;
    for (int axis = 0; axis < 3; axis++) {
        planes |= (unsigned)(clip[axis] < -clip[3]) << (2 * axis);
        planes |= (unsigned)(clip[axis] > clip[3]) << (2 * axis + 1);
    }
    return planes;
}

/* Returns true for a point inside the view, not on its border. */
static bool is_inside(const double clip[4])
{
    return fabs(clip[0]) < clip[3] && fabs(clip[1]) < clip[3] && fabs(clip[2]) < clip[3];
}

/* Twice the area, positive if the corners run clockwise. y runs downwards. */
static double twice_area(const struct window_vertex *a, const struct window_vertex *b,
                         const struct window_vertex *c)
{
    return (b->x - a->x) * (c->y - a->y) - (c->x - a->x) * (b->y - a->y);
}

/* Returns twice the area of the part of a triangle that lies inside the view. */
static double clipped_area(const struct view *view, const struct surface *surface,
                           const int32_t vertex[3])
{
    static const struct clip_plane planes[VIEW_PLANES] = {
        [VIEW_LEFT] = {{1, 0, 0, 1}, 0},  [VIEW_RIGHT] = {{-1, 0, 0, 1}, 0},
        [VIEW_BELOW] = {{0, 1, 0, 1}, 0}, [VIEW_ABOVE] = {{0, -1, 0, 1}, 0},
        [VIEW_NEAR] = {{0, 0, 1, 1}, 0},  [VIEW_FAR] = {{0, 0, -1, 1}, 0}};
    struct corner corners[2][CLIP_CORNERS];
    struct window_vertex window[CLIP_CORNERS];
    double area = 0;
    int n = 3;
    whole_corners(surface, vertex, corners[0]);
    for (int p = 0; p < VIEW_PLANES; p++)
        n = clip_polygon(&planes[p], corners[p % 2], n, corners[1 - p % 2]);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < 4; j++)
            window[i].clip[j] = corners[VIEW_PLANES % 2][i].clip[j];
        window[i].clip[3] = fmax(window[i].clip[3], DBL_MIN); /* 0 in the eye itself */
        window_place(view, &window[i]);
    }
    for (int i = 2; i < n; i++)
        area += twice_area(&window[0], &window[i - 1], &window[i]);
    return area;
}

/* ---- surfaces ---- */

/* A surface that is surveyed. */
struct surveyed {
    const struct view *view;
    const struct surface *surface;
    double *brightest;      /* [vertex][side] */
    unsigned char *outside; /* of each vertex: a set of planes */
    double noise;           /* a smaller radiance comes from roundings of cosines */
    bool backs_hidden;      /* triangles whose backs are turned to the eye lie behind others */
};

double survey_vertex(const struct lit_scene *lit, int surface, int vertex, int side)
{
    const struct surface *of = &lit->surfaces[surface];
    const struct shaded_material *shaded = lit->bounds[surface].shaded;
    const double *weights = of->weights + surface_attributes(of, vertex, side);
    double radiance = 0;
    for (int t = 0; t < shaded->n_terms; t++)
        radiance += weights[t] * shaded->made.terms[t].peak;
    return shaded->texture ? radiance * shaded->texture->largest : radiance;
}

/* Returns the area of a triangle in view; it is negative if the triangle's back is seen. */
static double area_in_view(const struct surveyed *of, int triangle)
{
    const int32_t *at = of->surface->instance->triangles[triangle];
    const unsigned char *outside = of->outside;
    const struct window_vertex *window = of->surface->vertices;
    if (outside[at[0]] & outside[at[1]] & outside[at[2]])
        return 0;
    const double area = outside[at[0]] | outside[at[1]] | outside[at[2]]
                            ? clipped_area(of->view, of->surface, at)
                            : twice_area(&window[at[0]], &window[at[1]], &window[at[2]]);
    return (of->surface->instance->mirrored ? 0.5 : -0.5) * area;
}

/* Returns true if the surface is closed, or almost: all backs lie behind fronts, unless the eye is
 * inside. As much of a closed surface in view shows its back as its front; a hole of a millionth of
 * that is no matter. Two-sided meshes are meant to show their backs. */
static bool hides_backs(const struct surveyed *of, const struct object *object, unsigned cut)
{
    static const bool solids[] = {
        [SHAPE_SPHERE] = true,   [SHAPE_TORUS] = true, [SHAPE_BOX] = true,
        [SHAPE_CYLINDER] = true, [SHAPE_CONE] = true,  [SHAPE_MESH] = false};
    double front = 0, back = 0;
    for (int i = 0; i < of->surface->instance->n_triangles; i++) {
        const double area = area_in_view(of, i);
        front += fmax(area, 0);
        back += fmax(-area, 0);
    }
    return front > 0 && (solids[object->shape.kind]
                             ? !(cut & 1U << VIEW_NEAR)
                             : !cut && !object->two_sided && fabs(front - back) < 1e-6 * front);
}

/* Adds the triangles that are seen. */
static void survey_triangles(struct scene_survey *survey, const struct surveyed *of,
                             struct surface_survey *out)
{
    const struct instance *instance = of->surface->instance;
    const int n_sides = of->surface->n_sides;
    for (int i = 0; i < instance->n_triangles; i++) {
        const double area = area_in_view(of, i);
        const int side = n_sides == 2 && area < 0;
        double brightest = 0;
        if (area == 0 || (area < 0 && of->backs_hidden))
            continue;
        for (int j = 0; j < 3; j++)
            brightest = fmax(brightest, of->brightest[instance->triangles[i][j] * n_sides + side]);
        survey->areas[class_of(brightest)] += fabs(area);
        out->area += fabs(area);
        out->dark_area += brightest <= of->noise ? fabs(area) : 0;
        out->brightest_in_view = fmax(out->brightest_in_view, brightest);
    }
}

static void survey_surface(struct scene_survey *survey, int index, struct surveyed *of)
{
    const struct surface *surface = &survey->lit->surfaces[index];
    struct surface_survey out = {.outside = (1U << VIEW_PLANES) - 1};
    unsigned cut = 0;
    of->surface = surface;
    for (int i = 0; i < surface->instance->n_vertices; i++) {
        for (int side = 0; side < surface->n_sides; side++) {
            const double brightest = survey_vertex(survey->lit, index, i, side);
            of->brightest[i * surface->n_sides + side] = brightest;
            out.brightest = fmax(out.brightest, brightest);
        }
        of->outside[i] = (unsigned char)planes_outside(surface->vertices[i].clip);
        out.outside &= of->outside[i];
        out.reaches = out.reaches || is_inside(surface->vertices[i].clip);
        cut |= of->outside[i];
    }
    of->noise = NOISE_ROUNDINGS * DOUBLE_ROUNDOFF * out.brightest;
    of->backs_hidden = hides_backs(of, survey->lit->bounds[index].placed->object, cut);
    survey_triangles(survey, of, &out);
    survey->surfaces[index] = out;
    survey->brightest = fmax(survey->brightest, out.brightest);
    survey->area += out.area;
    survey->dark_area += out.dark_area;
}

bool survey_make(const struct lit_scene *lit, struct scene_survey *out, struct error *err)
{
    const size_t n = (size_t)lit->plan->n_vertices + 1;
    struct surveyed of = {.view = &lit->plan->view,
                          .brightest = malloc(2 * n * sizeof *of.brightest),
                          .outside = malloc(n)};
    *out = (struct scene_survey){
        .lit = lit,
        .surfaces = calloc((size_t)lit->plan->n_instances + 1, sizeof *out->surfaces),
        .areas = calloc(CLASSES, sizeof *out->areas)};
    const bool done =
        (of.brightest && of.outside && out->surfaces && out->areas) || error_memory(err);
    for (int i = 0; done && i < lit->plan->n_instances; i++)
        survey_surface(out, i, &of);
    free(of.brightest);
    free(of.outside);
    return done;
}

void survey_free(struct scene_survey *survey)
{
    free(survey->surfaces);
    free(survey->areas);
    *survey = (struct scene_survey){.lit = NULL};
}

bool begins_object(const struct plan *plan, int surface)
{
    return surface == 0 || plan->instances[surface].object != plan->instances[surface - 1].object;
}

/* Half a count of the full scale, which is not below the brightest vertex's largest term. Floats
 * hold all but 0. */
double survey_black(const struct scene_survey *survey)
{
    const struct plan *plan = survey->lit->plan;
    const double terms = plan->max_rows > 1 ? plan->max_rows : 1;
    const double scale =
        plan->options.full_scale > 0 ? plan->options.full_scale : survey->brightest / terms;
    return plan->options.bits == 32 ? 0 : 0.5 / FULL_COUNT * scale;
}
