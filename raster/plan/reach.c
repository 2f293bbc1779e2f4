/* SPDX-License-Identifier: MIT */
/* Finds the instances in view, the materials and textures that these show, and the lights that
 * reach them. OpenGL gets nothing else. Margins here exceed all bounds of single precision, so that
 * in doubt an instance is in view, and a light reaches it. */
#include "raster/plan/inside.h"

/* ---- instances in view ---- */

/* A coordinate in clip space takes at most 31 roundings of the magnitudes that it is made of (see
 * bounds/vertex.c); a vertex in the window that lies so many pixels off may not come back. */
enum { PLACE_ROUNDINGS = 128, MARGIN_PX = 8 };

void matrix_magnitudes(const struct matrix *m, const double v[4], double out[4])
{
    for (int i = 0; i < 4; i++) {
        out[i] = 0;
        for (int j = 0; j < 4; j++)
            out[i] += fabs(m->row[i][j]) * fabs(v[j]);
    }
}

unsigned planes_outside(const struct plan *plan, const struct instance *instance, int vertex)
{
    const struct vector p = instance->vertices[vertex].position,
                        eye = matrix_point(&instance->model_view, p);
    const double at[4] = {eye.x, eye.y, eye.z, 1}, from[4] = {p.x, p.y, p.z, 1};
    double clip[4] = {0}, magnitude[4], m[4]; /* m: the magnitudes of the clip coordinates */
    matrix_magnitudes(&instance->model_view, from, magnitude);
    matrix_magnitudes(&plan->view.projection, magnitude, m);
    for (int i = 0; i < 16; i++)
        clip[i / 4] += plan->view.projection.row[i / 4][i % 4] * at[i % 4];
    const double w = clip[3], size[2] = {plan->view.width, plan->view.height},
                 error = roundings(PLACE_ROUNDINGS), depth_error = error * (m[2] + m[3]);
    unsigned planes = (unsigned)(clip[2] < -w - depth_error) << VIEW_NEAR |
                      (unsigned)(clip[2] > w + depth_error) << VIEW_FAR;
    if (!(w > error * m[3]))
        return planes;
    const double largest = fmax(size[0], size[1]),
                 sum = m[0] + m[1] + m[3] * (1 + (fabs(clip[0]) + fabs(clip[1])) / w);
    for (int axis = 0; axis < 2; axis++) {
        const double margin = (2 * MARGIN_PX * w + error * largest * sum) / size[axis];
        planes |= (unsigned)(clip[axis] < -w - margin) << 2 * axis |
                  (unsigned)(clip[axis] > w + margin) << (2 * axis + 1);
    }
    return planes;
}

static enum view_plane plane_outside(const struct plan *plan, const struct instance *instance)
{
    unsigned planes = (1U << VIEW_PLANES) - 1;
    int plane = 0;
    for (int i = 0; i < instance->n_vertices && planes; i++)
        planes &= planes_outside(plan, instance, i);
    while (plane < VIEW_PLANES && !(planes >> plane & 1))
        plane++;
    return (enum view_plane)plane;
}

/* ---- lights that reach an instance in view ---- */

/* OpenGL's cosines are off by less than this where is_well_placed. */
static const double cosine_error = 1e-3;

/* Returns whether OpenGL turns a normal by less than a quarter of cosine_error; bounds/light.c says
 * how it turns one. */
static bool is_well_turned(const struct instance *instance, const struct cofactors *cofactors,
                           struct vector normal, double length)
{
    const double n[3] = {fabs(normal.x), fabs(normal.y), fabs(normal.z)};
    double sum = 0, columns = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            sum += cofactors->magnitude[i][j] * n[j];
            columns += instance->model_view.row[i][j] * instance->model_view.row[i][j] / 3;
        }
    return roundings(32) * sum < cosine_error / 8 * length && 12e-6 < cosine_error / 8 * columns;
}

/* Returns whether OpenGL may add anything but exactly 0 of the light to a vertex. The factor that
 * distance leaves must be a number, and not 1 / 0. */
static bool reaches_vertex(const struct eye_light *light, const struct instance *instance,
                           const struct cofactors *cofactors, int index)
{
    const struct vector p = instance->vertices[index].position,
                        normal = instance->vertices[index].normal,
                        turned = matrix_direction(&instance->normal_matrix, normal);
    const struct incidence incidence = incidence_at(light, matrix_point(&instance->model_view, p));
    const double from[4] = {p.x, p.y, p.z, 1},
                 cosine = vector_dot(vector_normalise(turned), incidence.towards),
                 in_spot = -vector_dot(light->axis, incidence.towards);
    double e_path = roundings(32) * vector_length(light->position); /* far above its error */
    for (int i = 0; i < 12; i++)
        e_path += roundings(32) * fabs(instance->model_view.row[i / 4][i % 4] * from[i % 4]);
    if (!light->directional && !(e_path < cosine_error / 4 * incidence.distance))
        return true;
    if (light->attenuated && !(incidence.divisor > 1e-18 && incidence.divisor < 1e18))
        return true;
    return !(light->spot && in_spot < light->cutoff_cosine - cosine_error) &&
           (instance->two_sided || !(cosine < -cosine_error) ||
            !is_well_turned(instance, cofactors, normal, vector_length(turned)));
}

bool reflects(const struct instance *instance, const struct eye_light *light)
{
    for (int t = 0; t < instance->n_terms; t++)
        if (instance->terms[t].light == light->first)
            return true;
    return false;
}

static bool reaches_instance(const struct eye_light *light, const struct instance *instance)
{
    struct cofactors cofactors;
    if (!reflects(instance, light))
        return false;
    matrix_cofactors(&instance->model_view, &cofactors);
    for (int i = 0; i < instance->n_vertices; i++)
        if (reaches_vertex(light, instance, &cofactors, i))
            return true;
    return false;
}

/* ---- all of it ---- */

bool reach_find(struct plan *plan, struct error *err)
{
    if (!MAKE_ARRAY(plan->is_idle, plan->n_lights, err, "%d lights", plan->n_lights))
        return false;
    for (int i = 0; i < plan->n_instances; i++) {
        struct placed_instance *placed = &plan->instances[i];
        struct shaded_material *shaded = &plan->materials[placed->shaded];
        placed->outside = plane_outside(plan, &placed->instance);
        placed->in_view = placed->outside == VIEW_PLANES;
        plan->work.unseen_instances += !placed->in_view;
        shaded->shown = shaded->shown || placed->in_view;
        if (shaded->shown && shaded->texture)
            shaded->texture->shown = true;
    }
    for (int i = 0; i < plan->n_textures; i++)
        plan->work.undrawn_textures += !plan->textures[i].shown;
    if (!casters_find(plan, err))
        return false;
    for (int i = 0; i < plan->n_lights; i++) {
        bool reaches = plan->options.exchangeable || plan->view.shading == PHONG;
        for (int k = 0; k < plan->n_instances && !reaches; k++)
            reaches = plan->instances[k].in_view &&
                      reaches_instance(&plan->lights[i], &plan->instances[k].instance);
        plan->is_idle[i] = !reaches;
        plan->work.idle_lights += !reaches;
    }
    for (int group = 0; group < plan->n_light_groups; group++)
        plan->work.idle_groups += !group_is_drawn(plan, group);
    return true;
}

bool group_is_drawn(const struct plan *plan, int group)
{
    const struct light_group lights = light_group(plan, group);
    for (int i = 0; i < lights.n; i++)
        if (!plan->is_idle[lights.first + i])
            return true;
    return group == 0;
}

bool plan_has_mipmaps(const struct plan *plan)
{
    bool has = false;
    for (int i = 0; i < plan->n_textures; i++)
        has = has || (plan->textures[i].shown && plan->textures[i].n_levels > 1);
    return has;
}

bool checks_other_rows(const struct plan *plan)
{
    return plan->options.store_raster && plan->options.check && plan_has_mipmaps(plan);
}
