/* SPDX-License-Identifier: MIT */
/* Points of the surfaces that meshes approximate. */
#include "raster/beside/accuracy/inside.h"

/* Returns whether the outside of a point of the mesh is turned to the eye. */
static bool is_front(const struct judged_surface *of, const struct vertex *point)
{
    const struct instance *instance = of->surface->instance;
    const struct vector eye = matrix_point(&instance->model_view, point->position),
                        normal = matrix_direction(&instance->normal_matrix, point->normal),
                        far_away = {0, 0, 1};
    const bool perspective = of->lit->plan->view.projection.row[3][2] != 0;
    return vector_dot(normal, perspective ? vector_scale(eye, -1) : far_away) > 0;
}

/* ---- points of a built-in shape ---- */

/* Finds the point of parameters u and v in the mesh, and places it in the window; false if it is
 * not in front of the eye. */
static bool place_point(const struct judged_surface *of, int patch, const double u_v[2],
                        struct vertex *out, struct window_vertex *window)
{
    double u = u_v[0], v = u_v[1];
    patch_enter(of->patches->shape, &u, &v);
    *out = patch_vertex(of->patches, patch, u, v);
    out->position =
        vector_scale(vector_subtract(out->position, of->mesh->centre), 1 / of->mesh->unit);
    const struct vector eye = matrix_point(&of->surface->instance->model_view, out->position);
    for (int r = 0; r < 4; r++) {
        const double *row = of->lit->plan->view.projection.row[r];
        window->clip[r] = row[0] * eye.x + row[1] * eye.y + row[2] * eye.z + row[3];
    }
    if (!(window->clip[3] > 0))
        return false;
    window_place(&of->lit->plan->view, window);
    return true;
}

/* Parts of a cell, by which parameters are moved to find how the window changes. */
static const double nudge = 1.0 / 64;
/* The first steps stay in the plane of the triangle. */
enum { MOST_STEPS = 8, PLANE_STEPS = 3 };
/* A point of the surface is found when it is so near to the wanted place. Fine textures change by
 * some 50 CIEDE2000 in a pixel, and so by 0.05 in this part of it. */
static const double near_enough_px = 1.0 / 1024;

/* One step of Newton's method towards the place `at` of the window. Returns false where the surface
 * is seen edge-on, or leaves the view. */
static bool step(const struct judged_surface *of, int patch, const double at[2], double u_v[2],
                 const struct window_vertex *from)
{
    struct vertex ignored;
    struct window_vertex moved[2];
    for (int k = 0; k < 2; k++) {
        double other[2] = {u_v[0], u_v[1]};
        other[k] += nudge;
        if (!place_point(of, patch, other, &ignored, &moved[k]))
            return false;
    }
    const double xu = (moved[0].x - from->x) / nudge, yu = (moved[0].y - from->y) / nudge,
                 xv = (moved[1].x - from->x) / nudge, yv = (moved[1].y - from->y) / nudge,
                 dx = at[0] - from->x, dy = at[1] - from->y, determinant = xu * yv - xv * yu;
    const double du = (dx * yv - dy * xv) / determinant, dv = (xu * dy - yu * dx) / determinant;
    if (!(fabs(du) < 2 && fabs(dv) < 2))
        return false;
    u_v[0] += du;
    u_v[1] += dv;
    return true;
}

/* Finds the parameters that a triangle has at a place with these barycentric coordinates. */
static void parameters_at(const struct judged_surface *of, const struct screen_triangle *triangle,
                          const double share[3], double u_v[2])
{
    u_v[0] = u_v[1] = 0;
    for (int j = 0; j < 3; j++) {
        const struct parameters *corner = &of->mesh->mesh.parameters[triangle->vertex[j]];
        u_v[0] += share[j] * corner->u / PARAMETER_CELL;
        u_v[1] += share[j] * corner->v / PARAMETER_CELL;
    }
}

/* Finds the point of a curved patch that the window shows at a place of the triangle, with its
 * barycentric coordinates there. First it moves a place in the triangle's plane by as much as its
 * point lies beside the wanted place: near the surface this converges, and needs no derivatives. */
static bool find_point(const struct judged_surface *of, const struct screen_triangle *triangle,
                       const double at[2], const double share[3], struct vertex *out)
{
    const int patch = of->mesh->mesh.parameters[triangle->vertex[0]].patch;
    struct window_vertex window;
    double u_v[2], place[2] = {at[0], at[1]}, moved[3];
    parameters_at(of, triangle, share, u_v);
    for (int i = 0; i < MOST_STEPS && place_point(of, patch, u_v, out, &window); i++) {
        const double dx = at[0] - window.x, dy = at[1] - window.y;
        if (vector_length((struct vector){dx, dy, 0}) < near_enough_px)
            return is_front(of, out) == (triangle->clockwise == of->surface->instance->mirrored);
        if (i < PLANE_STEPS) {
            place[0] += dx;
            place[1] += dy;
            shares_at(triangle, place[0], place[1], moved);
            parameters_at(of, triangle, moved, u_v);
        } else if (!step(of, patch, at, u_v, &window))
            return false;
    }
    return false;
}

/* ---- any point ---- */

/* Sets the texture coordinates of a point of a curved patch. Planar ones are those of the facet. */
static void place_texture(const struct judged_surface *of, const struct screen_triangle *triangle,
                          const double share[3], struct vertex *point)
{
    const struct shape *shape = of->patches->shape;
    point->s *= shape->repeat[0];
    point->t *= shape->repeat[1];
    if (!shape->planar)
        return;
    point->s = point->t = 0;
    for (int j = 0; j < 3; j++) {
        const struct vertex *corner = &of->surface->instance->vertices[triangle->vertex[j]];
        point->s += share[j] * corner->s;
        point->t += share[j] * corner->t;
    }
}

/* Finds the attributes of the point of the true surface. */
static bool exact_attributes(const struct judged_surface *of,
                             const struct screen_triangle *triangle, const double at[2],
                             const double share[3], double *attributes)
{
    const struct parameters *parameters = of->mesh->mesh.parameters;
    struct light_work ignored = {0};
    struct view phong = of->lit->plan->view;
    struct vertex point;
    if (!parameters || patch_is_flat(of->patches->shape, parameters[triangle->vertex[0]].patch)) {
        phong.shading = PHONG;
        shade(&phong, triangle, share, attributes, &ignored);
        return true;
    }
    if (!find_point(of, triangle, at, share, &point))
        return false;
    place_texture(of, triangle, share, &point);
    light_point(&of->lit->plan->view, of->surface->instance, &point, triangle->side, attributes,
                &ignored);
    return true;
}

/* ---- both points ---- */

/* Returns the value of the texture at a point, with the level of detail of the pixel there; of a
 * spectral one, whose planes are not loaded yet, the middle of all its values; 1: there is none. */
static double texel_of(const struct judged_surface *of, const struct screen_triangle *triangle,
                       const double at[2], const double *attributes)
{
    const struct instance *instance = of->surface->instance;
    const struct texture *texture = of->lit->plan->materials[of->placed->shaded].texture;
    const struct view *view = &of->lit->plan->view;
    double place[TEXEL_PLACE] = {0};
    if (!instance->textured)
        return 1;
    if (instance->varied)
        return 0.5 * (texture->smallest + texture->largest);
    texel_place(&instance->texels, attributes + instance->n_terms, place);
    if (instance->texels.n_levels > 1)
        place[PLACE_DETAIL] = view->find_detail(triangle, (int)floor(at[0]), (int)floor(at[1]));
    return texel_at(&instance->texels, place);
}

/* Takes from both points the lights whose shadow the drawn one lies in. */
static void darken(const struct judged_surface *of, const struct screen_triangle *triangle,
                   const double share[3], double *drawn, double *exact)
{
    const struct view *view = &of->lit->plan->view;
    const struct instance *instance = of->surface->instance;
    struct seen_point point = seen_point(of->lit->surfaces, triangle, share);
    point.asked = UINT32_MAX;
    lights_block(&of->lit->occluders, view, &point, 1);
    lights_darken(view, instance, point.dark, drawn, 1);
    lights_darken(view, instance, point.dark, exact, 1);
}

bool compare_point(const struct judged_surface *of, const struct screen_triangle *triangle,
                   const double at[2], double *attributes, struct shaded_point out[2])
{
    double *drawn = attributes, *exact = drawn + of->lit->plan->max_rows + 2, share[3];
    struct light_work ignored = {0};
    shares_at(triangle, at[0], at[1], share);
    if (!exact_attributes(of, triangle, at, share, exact))
        return false;
    shade(&of->lit->plan->view, triangle, share, drawn, &ignored);
    if (of->lit->plan->view.n_shadowed > 0)
        darken(of, triangle, share, drawn, exact);
    out[0] = (struct shaded_point){drawn, texel_of(of, triangle, at, drawn)};
    out[1] = (struct shaded_point){exact, texel_of(of, triangle, at, exact)};
    return true;
}
