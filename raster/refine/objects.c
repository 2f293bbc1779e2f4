/* SPDX-License-Identifier: MIT */
/* The meshes that are refined: one for each object, or one for several objects in the same place.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "raster/refine/refine.h"

int object_of(const struct plan *plan, int instance)
{
    return (int)(plan->instances[instance].object - plan->scene->objects);
}

static bool is_in_front(const struct plan *plan, const struct refined *refined)
{
    const double *z = plan->view.projection.row[2], *w = plan->view.projection.row[3];
    bool in_front = true;
    for (int i = 0; i < refined->mesh.n_vertices && in_front; i++) {
        const struct vector eye =
            matrix_point(&refined->model_view, refined->mesh.vertices[i].position);
        const double clip_w = w[0] * eye.x + w[1] * eye.y + w[2] * eye.z + w[3];
        in_front = clip_w > 0 && z[0] * eye.x + z[1] * eye.y + z[2] * eye.z + z[3] > -clip_w;
    }
    return in_front;
}

void judgements_forget(const struct refined *refined)
{
    for (int i = 0; i < refined->mesh.n_triangles; i++)
        refined->judged[i] = (struct judgement){.shading = HUGE_VALF};
}

static bool add_refined(struct refinement *of, int object, struct error *err)
{
    const struct plan *plan = of->plan;
    const struct object *described = &plan->scene->objects[object];
    struct refined *new = &of->list[of->n++];
    of->of_object[object] = of->n - 1;
    *new = (struct refined){
        .object = object, .shape = shape_tessellated(&described->shape, plan->scene->tessellation)};
    if (!patches_open(&new->shape, &new->patches, err) || !plan_whole(&new->shape, &new->mesh, err))
        return false;
    new->before = new->mesh.n_triangles;
    new->model_view = matrix_product(plan->world_to_eye, described->transform);
    new->in_front = is_in_front(plan, new);
    new->settled = calloc((size_t) new->mesh.n_triangles + 1, sizeof *new->settled);
    new->judged = calloc((size_t) new->mesh.n_triangles + 1, sizeof *new->judged);
    if (!matrix_normal(&new->model_view, &new->normal_matrix) || !new->settled || !new->judged)
        return error_memory(err);
    judgements_forget(new);
    return true;
}

/* Returns the object of an instance that is in the same place, and hides this one; -1: none. */
static int twin_of(const struct plan *plan, int instance)
{
    const struct placed_instance *placed = &plan->instances[instance];
    for (int i = 0; placed->twin && i < instance; i++) {
        const struct placed_instance *other = &plan->instances[i];
        if (other->mesh == placed->mesh && !other->twin &&
            memcmp(&other->instance.model_view, &placed->instance.model_view,
                   sizeof other->instance.model_view) == 0)
            return object_of(plan, i);
    }
    return -1;
}

/* Returns whether the outline of a shape may be refined. */
static bool has_round_outline(const struct shape *shape)
{
    return shape->kind == SHAPE_DISK || !(shape->kind == SHAPE_MESH || shape_is_flat(shape->kind));
}

bool objects_list(struct refinement *of, bool round, struct error *err)
{
    const struct plan *plan = of->plan;
    const size_t n = (size_t)plan->scene->n_objects;
    of->list = calloc(n + 1, sizeof *of->list);
    of->of_object = malloc((n + 1) * sizeof *of->of_object);
    if (!of->list || !of->of_object)
        return error_memory(err);
    for (size_t i = 0; i < n; i++)
        of->of_object[i] = -1;
    for (int i = 0; i < plan->n_instances; i++) {
        const int object = object_of(plan, i), twin = twin_of(plan, i);
        if (!plan->instances[i].in_view || of->of_object[object] >= 0 ||
            (round && !has_round_outline(&plan->scene->objects[object].shape)))
            continue;
        if (twin >= 0)
            of->of_object[object] = of->of_object[twin];
        else if (!add_refined(of, object, err))
            return false;
    }
    return true;
}

static void free_refined(struct refined *refined)
{
    patches_close(&refined->patches);
    mesh_free(&refined->mesh);
    free(refined->settled);
    free(refined->judged);
    free(refined->ends);
}

void objects_free(struct refinement *of)
{
    for (int i = 0; i < of->n; i++)
        free_refined(&of->list[i]);
    free(of->list);
    free(of->of_object);
    of->list = NULL;
    of->of_object = NULL;
    of->n = 0;
}
