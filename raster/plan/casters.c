/* SPDX-License-Identifier: MIT */
/* Finds the lights that throw shadows into view, and the instances that throw them. Only these cost
 * anything: each such light is drawn by itself, and its shadows beside it. */
#include "raster/plan/inside.h"

/* Returns the planes of the view that a direction leads away from, or along: a set of 1 << plane.
 */
static unsigned planes_behind(const struct plan *plan, struct vector direction)
{
    const double d[3] = {direction.x, direction.y, direction.z};
    double clip[4] = {0, 0, 0, 0};
    unsigned planes = 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 3; j++)
            clip[i] += plan->view.projection.row[i][j] * d[j];
    for (int axis = 0; axis < 3; axis++)
        planes |= (unsigned)(clip[axis] + clip[3] <= 0) << 2 * axis |
                  (unsigned)(clip[axis] - clip[3] >= 0) << (2 * axis + 1);
    return planes;
}

/* Returns whether the shadow of an instance may reach the view: the hull of its vertices, and of
 * the directions from the light through them, is not outside of one plane. */
static bool throws_into_view(const struct plan *plan, const struct placed_instance *placed,
                             const struct eye_light *light)
{
    const struct instance *instance = &placed->instance;
    unsigned planes = (1U << VIEW_PLANES) - 1;
    if (placed->object->casts_none || placed->object->background)
        return false;
    for (int i = 0; i < instance->n_vertices && planes; i++) {
        const struct vector at =
            matrix_point(&instance->model_view, instance->vertices[i].position);
        planes &= planes_outside(plan, instance, i);
        planes &= planes_behind(plan, light->directional ? vector_scale(light->position, -1)
                                                         : vector_subtract(at, light->position));
    }
    return planes == 0;
}

/* Finds the objects that throw shadows of a light into view, and gives all their instances, which
 * follow each other, its bit. */
static bool find_casters(struct plan *plan, const struct eye_light *light, int bit)
{
    struct placed_instance *list = plan->instances;
    bool any = false;
    for (int first = 0, end; first < plan->n_instances; first = end) {
        bool throws = false;
        for (end = first; end < plan->n_instances && list[end].object == list[first].object; end++)
            throws = throws || throws_into_view(plan, &list[end], light);
        for (int i = first; i < end; i++)
            list[i].casts |= (uint32_t)throws << bit;
        any = any || throws;
    }
    return any;
}

/* Brings those lights to the end of the list. */
bool casters_find(struct plan *plan, struct error *err)
{
    struct eye_light lights[MOST_SHADOWED];
    const struct light *sources[MOST_SHADOWED];
    int n = 0, n_shadowed = 0;
    for (int i = 0; i < plan->n_lights; i++) {
        const struct light *source = plan->sources[i];
        if (source->shadows && n_shadowed == MOST_SHADOWED)
            return error_at(err, source->place, "more than %d lights throw shadows into view",
                            MOST_SHADOWED);
        if (source->shadows && find_casters(plan, &plan->lights[i], n_shadowed)) {
            lights[n_shadowed] = plan->lights[i];
            sources[n_shadowed++] = source;
        } else {
            plan->lights[n] = plan->lights[i];
            plan->sources[n++] = source;
        }
    }
    memcpy(plan->lights + n, lights, (size_t)n_shadowed * sizeof *lights);
    memcpy(plan->sources + n, sources, (size_t)n_shadowed * sizeof *sources);
    plan->view.n_shadowed = n_shadowed;
    plan->n_light_groups = group_of(plan, n - 1) + 1 + n_shadowed;
    return true;
}

/* ---- groups of lights ---- */

struct light_group light_group(const struct plan *plan, int group)
{
    const int n = plan->n_lights - plan->view.n_shadowed, first = group * LIGHTS_PER_PASS,
              shadowed = group - (plan->n_light_groups - plan->view.n_shadowed);
    if (shadowed >= 0)
        return (struct light_group){n + shadowed, 1, shadowed};
    return (struct light_group){first, n - first < LIGHTS_PER_PASS ? n - first : LIGHTS_PER_PASS,
                                -1};
}

int group_of(const struct plan *plan, int light)
{
    const int n = plan->n_lights - plan->view.n_shadowed,
              groups = n > 0 ? (n - 1) / LIGHTS_PER_PASS + 1 : 1;
    return light < n ? (light > 0 ? light / LIGHTS_PER_PASS : 0) : groups + light - n;
}
