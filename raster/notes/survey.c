/* SPDX-License-Identifier: MIT */
/* Surveys a lit scene before its picture: how large each surface is in view, how bright its
 * vertices are, and how much of the area in view is how bright. Nothing hides anything here. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "raster/notes/notes.h"

/* ---- classes of brightness ---- */

/* A class is an eighth of the way from a power of two to the next. The first and the last hold all
 * that is darker or brighter. */
enum { EIGHTHS = 8, LEAST_EXPONENT = -128, EXPONENTS = 256, CLASSES = EXPONENTS * EIGHTHS };

static int class_of(double brightness)
{
    int exponent;
    const double half = frexp(brightness, &exponent); /* from 0.5 to below 1 */
    if (!(brightness > 0) || exponent < LEAST_EXPONENT)
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

static double window_area(const struct window_vertex *a, const struct window_vertex *b,
                          const struct window_vertex *c)
{
    return 0.5 * fabs((b->x - a->x) * (c->y - a->y) - (c->x - a->x) * (b->y - a->y));
}

/* The area of the part of a triangle that lies inside the view. */
static double clipped_area(const struct scene_survey *survey, const struct surface *surface,
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
        window_place(&survey->lit->plan->view, &window[i]);
    }
    for (int i = 2; i < n; i++)
        area += window_area(&window[0], &window[i - 1], &window[i]);
    return area;
}

/* ---- surfaces ---- */

/* The vertices of a surface. */
struct vertices {
    double *brightest;
    unsigned char *outside; /* a set of planes */
};

double survey_vertex(const struct lit_scene *lit, int surface, int vertex)
{
    const struct surface *of = &lit->surfaces[surface];
    const struct shaded_material *shaded = lit->bounds[surface].shaded;
    double brightest = 0;
    for (int side = 0; side < of->n_sides; side++) {
        const double *weights = of->weights + surface_attributes(of, vertex, side);
        double radiance = 0;
        for (int t = 0; t < shaded->n_terms; t++)
            radiance += weights[t] * shaded->made.terms[t].peak;
        brightest = fmax(brightest, radiance);
    }
    return shaded->texture ? brightest * shaded->texture->largest : brightest;
}

static double triangle_area(const struct scene_survey *survey, const struct surface *surface,
                            const struct vertices *vertices, const int32_t at[3])
{
    const unsigned char *outside = vertices->outside;
    const struct window_vertex *window = surface->vertices;
    if (outside[at[0]] & outside[at[1]] & outside[at[2]])
        return 0;
    if (outside[at[0]] | outside[at[1]] | outside[at[2]])
        return clipped_area(survey, surface, at);
    return window_area(&window[at[0]], &window[at[1]], &window[at[2]]);
}

static void survey_surface(struct scene_survey *survey, int index, const struct vertices *vertices)
{
    const struct surface *surface = &survey->lit->surfaces[index];
    const struct instance *instance = surface->instance;
    struct surface_survey out = {.outside = (1U << VIEW_PLANES) - 1};
    for (int i = 0; i < instance->n_vertices; i++) {
        vertices->brightest[i] = survey_vertex(survey->lit, index, i);
        vertices->outside[i] = (unsigned char)planes_outside(surface->vertices[i].clip);
        out.brightest = fmax(out.brightest, vertices->brightest[i]);
        out.outside &= vertices->outside[i];
        out.reaches = out.reaches || is_inside(surface->vertices[i].clip);
    }
    for (int i = 0; i < instance->n_triangles && !out.outside; i++) {
        const int32_t *at = instance->triangles[i];
        const double area = triangle_area(survey, surface, vertices, at);
        double brightest = 0;
        for (int j = 0; j < 3; j++)
            brightest = fmax(brightest, vertices->brightest[at[j]]);
        survey->areas[class_of(brightest)] += area;
        out.area += area;
    }
    survey->surfaces[index] = out;
    survey->brightest = fmax(survey->brightest, out.brightest);
    survey->area += out.area;
}

bool survey_make(const struct lit_scene *lit, struct scene_survey *out, struct error *err)
{
    const size_t n = (size_t)lit->plan->n_vertices + 1;
    struct vertices vertices = {malloc(n * sizeof *vertices.brightest), malloc(n)};
    *out = (struct scene_survey){
        .lit = lit,
        .surfaces = calloc((size_t)lit->plan->n_instances + 1, sizeof *out->surfaces),
        .areas = calloc(CLASSES, sizeof *out->areas)};
    const bool done = (vertices.brightest && vertices.outside && out->surfaces && out->areas) ||
                      error_memory(err);
    for (int i = 0; done && i < lit->plan->n_instances; i++)
        survey_surface(out, i, &vertices);
    free(vertices.brightest);
    free(vertices.outside);
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
