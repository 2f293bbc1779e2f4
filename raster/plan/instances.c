/* SPDX-License-Identifier: MIT */
/* Objects become instances: each mesh is built once, parted by material and cut in half where a
 * material has a metameric partner, moved to its centre and placed. Objects that show the same mesh
 * share it. */
#include "raster/plan/inside.h"

/* The part of a whole that is shown, -1: all; on which side of x = 0, -1: both. */
struct cutting {
    int whole, part, side;
};
struct instance_maker {
    struct plan *plan;
    struct plan_mesh *wholes; /* as their shapes describe them, before they are parted and moved */
    int n_wholes;
    struct index shapes, cuttings; /* wholes by their shape, and meshes of the plan by cutting */
    struct index places;           /* instances by mesh and place */
};

/* ---- whole meshes ---- */

/* Returns whether a texture may repeat on an object: some material of it has one. */
static bool repeats(const struct scene *scene, const struct object *object)
{
    const int n = object->material < 0 ? object->n_assignments : 1;
    const double *repeat = object->shape.repeat;
    bool textured = false;
    for (int i = 0; i < n; i++) {
        const struct material *of = &scene->materials[object->material < 0
                                                          ? object->assignments[i].material
                                                          : object->material],
                              *partner = scene_partner(scene, of);
        textured = textured || of->texture || (partner && partner->texture);
    }
    return textured && (object->shape.kind == SHAPE_MESH || repeat[0] != 1 || repeat[1] != 1);
}

/* Prints the key of a shape: shapes of one key have one mesh. */
static void print_key(const struct shape *shape, bool repeated, struct printed *key)
{
    const bool is_mesh = shape->kind == SHAPE_MESH;
    const int words[] = {(int)shape->kind, shape->planar, is_mesh && shape->unitize, repeated,
                         shape->relief != NULL};
    const double crease_deg = shape->crease_deg + 0; /* -0 becomes 0 */
    print_bytes(key, words, sizeof words);
    if (repeated)
        print_bytes(key, shape->repeat, sizeof shape->repeat);
    if (shape->relief) {
        print_bytes(key, shape->repeat, sizeof shape->repeat);
        print_bytes(key, &shape->relief_height, sizeof shape->relief_height);
        print_bytes(key, shape->relief, strlen(shape->relief) + 1);
    }
    if (is_mesh) {
        print_bytes(key, &crease_deg, sizeof crease_deg);
        print_text(key, shape->path);
    } else {
        print_bytes(key, shape->parameter, sizeof shape->parameter);
    }
}

/* Fills in the centre of the mesh's box, and the power of two next to the largest distance from it
 * along an axis. */
static void find_centre(struct plan_mesh *whole)
{
    struct vector low, high;
    int exponent;
    mesh_box(&whole->mesh, &low, &high);
    whole->centre = vector_add(vector_scale(low, 0.5), vector_scale(high, 0.5));
    const double largest = fmax(vector_reach(vector_subtract(low, whole->centre)),
                                vector_reach(vector_subtract(high, whole->centre)));
    frexp(largest, &exponent);
    whole->unit = largest > 0 ? ldexp(1, exponent) : 1;
}

static bool add_whole(struct instance_maker *maker, const struct shape *shape, bool repeated,
                      struct error *err)
{
    /* A solid that folds through itself shows backs. */
    struct plan_mesh whole = {.shape = *shape,
                              .solid = shape_is_solid(shape->kind) && !shape->relief};
    bool done = shape_build(shape, &whole.mesh, err);
    for (int i = maker->plan->options.halvings; done && shape->kind == SHAPE_MESH && i > 0; i--)
        done = mesh_halve(&whole.mesh, err);
    if (done && shape->planar)
        mesh_planar(&whole.mesh);
    done = done && (!shape->relief || relief_apply(&whole, err));
    done = done && (!repeated || mesh_repeat_texture(&whole.mesh, shape->repeat, err));
    if (done) {
        find_centre(&whole);
        done = array_add(&maker->wholes, &maker->n_wholes, &whole, sizeof whole, err);
    }
    if (!done)
        mesh_free(&whole.mesh);
    return done;
}

/* The index of an object's mesh, which is built when it is first asked for; -1 after an error. A
 * built-in shape whose edges are halved has twice as many slices, stacks, ... */
static int find_whole(struct instance_maker *maker, const struct object *object, struct error *err)
{
    const struct scene *scene = maker->plan->scene;
    const struct shape shape = shape_tessellated(
        &object->shape, ldexp(scene->tessellation, maker->plan->options.halvings));
    const bool repeated = repeats(scene, object);
    struct printed printed = {.text = NULL};
    print_key(&shape, repeated, &printed);
    const size_t length = printed.length;
    char *key = printed_take(&printed, err);
    if (!key)
        return -1;
    int found = index_find(&maker->shapes, key, length);
    if (found < 0 && add_whole(maker, &shape, repeated, err) &&
        index_add(&maker->shapes, key, length, maker->n_wholes - 1, err))
        found = maker->n_wholes - 1;
    free(key);
    return found;
}

/* ---- meshes as they are drawn ---- */

/* Adds a mesh to the plan, which takes it over: *mesh is empty then. Moves it by the centre of the
 * whole: halves and parts that meet have the same numbers where they do. */
static bool add_mesh(struct instance_maker *maker, struct cutting cutting, struct mesh *mesh,
                     struct error *err)
{
    struct plan *plan = maker->plan;
    struct plan_mesh added = maker->wholes[cutting.whole];
    added.mesh = *mesh;
    added.solid = added.solid && cutting.side < 0;
    for (int i = 0; i < mesh->n_vertices; i++)
        mesh->vertices[i].position =
            vector_scale(vector_subtract(mesh->vertices[i].position, added.centre), 1 / added.unit);
    if (!index_add(&maker->cuttings, &cutting, sizeof cutting, plan->n_meshes, err) ||
        !array_add(&plan->meshes, &plan->n_meshes, &added, sizeof added, err))
        return false;
    *mesh = (struct mesh){.n_vertices = 0};
    return true;
}

static bool add_sides(struct instance_maker *maker, struct cutting cutting, const struct mesh *part,
                      struct error *err)
{
    struct mesh halves = {.n_vertices = 0}, half = {.n_vertices = 0};
    bool done = mesh_cut(part, &halves, err);
    for (cutting.side = 0; done && cutting.side < 2; cutting.side++)
        done = mesh_part(&halves, cutting.side, &half, err) && add_mesh(maker, cutting, &half, err);
    mesh_free(&half);
    mesh_free(&halves);
    return done;
}

/* Takes out what a cutting shows; both of its sides, where it asks for one. */
static bool cut_out(struct instance_maker *maker, struct cutting cutting, struct error *err)
{
    struct mesh part;
    const bool done = mesh_part(&maker->wholes[cutting.whole].mesh, cutting.part, &part, err) &&
                      (cutting.side < 0 ? add_mesh(maker, cutting, &part, err)
                                        : add_sides(maker, cutting, &part, err));
    mesh_free(&part);
    return done;
}

/* The index of the mesh in the plan, which is made when it is first asked for; -1 after an error.
 */
static int find_mesh(struct instance_maker *maker, struct cutting wanted, struct error *err)
{
    int known = index_find(&maker->cuttings, &wanted, sizeof wanted);
    if (known < 0 && cut_out(maker, wanted, err))
        known = index_find(&maker->cuttings, &wanted, sizeof wanted);
    return known;
}

/* ---- instances ---- */

/* True if Mesa can invert the upper 3x3 and use it on normals: in single precision its determinant
 * must be a number above 1e-25 (m_matrix.c), and above its own rounding error, 16 of its terms; and
 * so must be the square of what its inverse, cofactors over the determinant, makes of a normal.
 * *mirrored: the matrix then turns left into right. */
static bool has_inverse(const struct matrix *m, bool *mirrored)
{
    struct cofactors cofactors;
    double determinant = 0, magnitude = 0, largest = 0;
    if (!matrix_cofactors(m, &cofactors))
        return false;
    const double scale = ldexp(1, 2 * cofactors.exponent);
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, scale * fabs(cofactors.value[i / 3][i % 3]));
    for (int i = 0; i < 3; i++) {
        determinant += scale * (m->row[0][i] * cofactors.value[0][i]);
        magnitude += scale * (fabs(m->row[0][i]) * cofactors.magnitude[0][i]);
    }
    *mirrored = determinant < 0;
    determinant = fabs(determinant);
    return determinant > 2e-25 && determinant > roundings(16) * magnitude && magnitude < 1e37 &&
           largest < 1e18 * determinant;
}

/* Finds whether an earlier instance has the same mesh in the same place, to the last bit. OpenGL
 * shows the first of them: the second is as deep, and not nearer. */
static bool find_twin(struct instance_maker *maker, struct placed_instance *placed,
                      struct error *err)
{
    const struct matrix *place = &placed->instance.model_view;
    double key[17] = {placed->mesh};
    memcpy(key + 1, place, sizeof *place);
    placed->twin = index_find(&maker->places, key, sizeof key) >= 0;
    return placed->twin || index_add(&maker->places, key, sizeof key, 0, err);
}

static bool add_instance(struct instance_maker *maker, const struct object *object,
                         struct cutting cutting, const struct material *material, struct error *err)
{
    struct plan *plan = maker->plan;
    struct placed_instance placed = {.object = object, .mesh = find_mesh(maker, cutting, err)};
    if (placed.mesh < 0)
        return false;
    const struct plan_mesh *mesh = &plan->meshes[placed.mesh];
    if (mesh->mesh.n_triangles == 0) /* all of it lies on the other side */
        return true;
    if (!shaded_material_find(plan, material, &placed.shaded, err))
        return false;
    const struct vector units = {mesh->unit, mesh->unit, mesh->unit};
    placed.instance.model_view =
        matrix_product(object->background ? plan->background_to_eye
                                          : matrix_product(plan->world_to_eye, object->transform),
                       matrix_product(matrix_translation(mesh->centre), matrix_scaling(units)));
    if (!matrix_normal(&placed.instance.model_view, &placed.instance.normal_matrix) ||
        !has_inverse(&placed.instance.model_view, &placed.instance.mirrored))
        return error_at(err, object->place,
                        "the object's transform is singular or not finite, or the object is too "
                        "small, too large or too flat beside the picture for single precision");
    plan->n_vertices += mesh->mesh.n_vertices;
    plan->n_triangles += mesh->mesh.n_triangles;
    return find_twin(maker, &placed, err) &&
           array_add(&plan->instances, &plan->n_instances, &placed, sizeof placed, err);
}

/* A mesh, or a part of it, of one material: in two halves if that has a partner. */
static bool add_halves(struct instance_maker *maker, const struct object *object,
                       struct cutting cutting, const struct material *material, struct error *err)
{
    const struct material *partner = scene_partner(maker->plan->scene, material);
    if (!partner)
        return add_instance(maker, object, cutting, material, err);
    const struct cutting left = {cutting.whole, cutting.part, 0},
                         right = {cutting.whole, cutting.part, 1};
    return add_instance(maker, object, left, material, err) &&
           add_instance(maker, object, right, partner, err);
}

/* ---- several materials on one mesh ---- */

/* Finds the line of the map for each part; use[part] NULL: there is none. A line for a usemtl that
 * the mesh does not have is a mistake. */
static bool find_uses(const struct object *object, const struct mesh *mesh,
                      const struct material_assignment **use, struct error *err)
{
    const struct material_assignment *others = NULL;
    struct index parts = {0};
    bool done = true;
    for (int part = 0; done && part < mesh->n_parts; part++)
        done = index_add(&parts, mesh->part_names[part], strlen(mesh->part_names[part]), part, err);
    for (int i = 0; done && i < object->n_assignments; i++) {
        const struct material_assignment *line = &object->assignments[i];
        const int part = index_find(&parts, line->name, strlen(line->name));
        const bool star = strcmp(line->name, "*") == 0;
        if (star)
            others = line;
        if (part >= 0)
            use[part] = line;
        else if (!star && object->material_map)
            done = error_at(err, line->place, "no face of %.300s has usemtl '%.100s'",
                            object->shape.path, line->name);
    }
    index_free(&parts);
    for (int part = 0; part < mesh->n_parts; part++)
        use[part] = use[part] ? use[part] : others;
    return done;
}

static bool add_part(struct instance_maker *maker, const struct object *object,
                     struct cutting cutting, const struct material_assignment *use,
                     struct error *err)
{
    const char *name = maker->wholes[cutting.whole].mesh.part_names[cutting.part];
    if (!use)
        return error_at(err, object->place,
                        "%s%.100s of %.300s has no %s %.300s; in a material map a line for * "
                        "stands for all others",
                        name[0] ? "usemtl " : "the part before the first usemtl", name,
                        object->shape.path, object->material_map ? "line in" : "entry in its",
                        object->material_map ? object->material_map : "mtllib");
    return add_halves(maker, object, cutting, &maker->plan->scene->materials[use->material], err);
}

static bool add_parts(struct instance_maker *maker, const struct object *object, int whole,
                      struct error *err)
{
    const struct mesh *mesh = &maker->wholes[whole].mesh;
    const int n_parts = mesh->n_parts;
    const struct material_assignment **use;
    bool done = MAKE_ARRAY(use, n_parts, err, "%d parts of a mesh", n_parts) &&
                find_uses(object, mesh, use, err);
    for (int part = 0; done && part < n_parts; part++)
        done = add_part(maker, object, (struct cutting){whole, part, -1}, use[part], err);
    free(use);
    return done;
}

static bool add_object(struct instance_maker *maker, const struct object *object, struct error *err)
{
    int whole = find_whole(maker, object, err);
    if (whole < 0)
        return false;
    if (object->material < 0)
        return add_parts(maker, object, whole, err);
    return add_halves(maker, object, (struct cutting){whole, -1, -1},
                      &maker->plan->scene->materials[object->material], err);
}

/* Fills in the reference's view of an instance; to be called when no array moves any more. */
static void fill_instance(struct plan *plan, struct placed_instance *placed)
{
    const struct mesh *mesh = &plan->meshes[placed->mesh].mesh;
    const struct shaded_material *shaded = &plan->materials[placed->shaded];
    struct instance *out = &placed->instance;
    out->vertices = mesh->vertices;
    out->triangles = (const int32_t(*)[3])mesh->triangles;
    out->n_vertices = mesh->n_vertices;
    out->n_triangles = mesh->n_triangles;
    out->two_sided = placed->object->two_sided;
    out->terms = shaded->terms;
    out->n_terms = shaded->n_terms;
    out->gloss = shaded->material->gloss;
    out->textured = shaded->texture != NULL;
    if (shaded->texture) {
        out->texels = plan_texels(shaded->texture, 0);
        out->varied = shaded->texture->spectral || plan->options.untextured;
    }
    if (pixel_rows(out) > plan->max_rows)
        plan->max_rows = pixel_rows(out);
}

bool instances_make(struct plan *plan, struct error *err)
{
    struct instance_maker maker = {.plan = plan};
    bool done = true;
    for (int i = 0; i < plan->scene->n_objects && done; i++)
        done = add_object(&maker, &plan->scene->objects[i], err);
    for (int i = 0; i < maker.n_wholes; i++)
        mesh_free(&maker.wholes[i].mesh);
    free(maker.wholes);
    index_free(&maker.shapes);
    index_free(&maker.cuttings);
    index_free(&maker.places);
    for (int i = 0; done && i < plan->n_instances; i++)
        fill_instance(plan, &plan->instances[i]);
    return done;
}
