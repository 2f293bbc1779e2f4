/* SPDX-License-Identifier: MIT */
/* A scene in its parts: each part of a mesh with one material is an object of its own. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster/verify/verify.h"

/* ---- how an object is placed ---- */

/* Returns the line of a text of the scene, from its beginning; NULL: there is none. */
static const char *line_at(const struct scene *scene, struct place place)
{
    for (int i = 0; i < scene->n_files; i++) {
        const char *at = scene->files[i].bytes;
        if (scene->files[i].path != place.path)
            continue;
        for (int line = 1; at && line < place.line; line++)
            if ((at = strchr(at, '\n')) != NULL)
                at++;
        return at;
    }
    return NULL;
}

/* Copies the words that place an object, as they are written, so that the case gives OpenGL the
 * same matrix. *out stays NULL where none can be copied: the object is one of a checker. */
static bool copy_placement(const struct scene *scene, struct place place, char **out,
                           struct error *err)
{
    static const char *const placing[] = {"scale", "rotate", "translate", NULL};
    const char *line = line_at(scene, place);
    char *copy = line ? malloc(strcspn(line, "\n") + 1) : NULL;
    struct printed printed = {.text = NULL};
    struct text text;
    struct word word;
    bool copies = false;
    if (!line)
        return true;
    if (!copy)
        return error_memory(err);
    snprintf(copy, strcspn(line, "\n") + 1, "%s", line);
    bool done = text_open_line(&text, "the object", copy, err);
    const bool is_object = done && text_word(&text, &word) && word_is(&word, "object");
    while (is_object && text_word(&text, &word)) {
        for (int i = 0; placing[i] && !word_begins_number(&word); i++)
            if ((copies = word_is(&word, placing[i])))
                break;
        if (copies)
            print(&printed, " %.*s", (int)word.length, word.start);
    }
    if (done)
        text_free(&text);
    free(copy);
    if (!is_object)
        return done;
    print_text(&printed, "");
    *out = printed_end(&printed);
    return *out || error_memory(err);
}

/* Places the vertices of a mesh by a matrix, and turns the triangles where it mirrors. A singular
 * one leaves the normals: a plan refuses it. */
static void place_mesh(struct mesh *mesh, const struct matrix *m)
{
    struct matrix normals = *m;
    struct cofactors cofactors;
    const bool mirrors = matrix_cofactors(m, &cofactors) && cofactors.determinant < 0;
    matrix_normal(m, &normals);
    for (int i = 0; i < mesh->n_vertices; i++) {
        struct vertex *vertex = &mesh->vertices[i];
        vertex->position = matrix_point(m, vertex->position);
        vertex->normal = vector_normalise(matrix_direction(&normals, vertex->normal));
    }
    for (int i = 0; i < mesh->n_triangles && mirrors; i++) {
        const int32_t kept = mesh->triangles[i][1];
        mesh->triangles[i][1] = mesh->triangles[i][2];
        mesh->triangles[i][2] = kept;
    }
}

/* ---- objects ---- */

/* The material of a part of a mesh; -1: it has none, and is not drawn. */
static int material_of(const struct object *object, const struct mesh *mesh, int part)
{
    int any = -1;
    if (object->n_assignments == 0)
        return object->material;
    for (int i = 0; i < object->n_assignments; i++) {
        const char *name = object->assignments[i].name;
        if (mesh->part_names && strcmp(name, mesh->part_names[part]) == 0)
            return object->assignments[i].material;
        if (strcmp(name, "*") == 0)
            any = object->assignments[i].material;
    }
    return any;
}

static bool add_part(struct reduced *to, const struct object *object, struct mesh *whole, int part,
                     struct error *err)
{
    struct reduced_object added = {.material = material_of(object, whole, part < 0 ? 0 : part),
                                   .two_sided = object->two_sided};
    if (added.material < 0)
        return true;
    bool done = mesh_part(whole, part, &added.mesh, err) &&
                copy_placement(to->scene, object->place, &added.placement, err);
    if (done && !added.placement)
        place_mesh(&added.mesh, &object->transform);
    done = done && array_add(&to->objects, &to->n_objects, &added, sizeof added, err);
    if (!done) {
        mesh_free(&added.mesh);
        free(added.placement);
    }
    return done;
}

static bool add_object(struct reduced *to, const struct object *object, struct error *err)
{
    const struct shape shape = shape_tessellated(&object->shape, to->scene->tessellation);
    struct mesh whole = {.n_triangles = 0};
    bool done = shape_build(&shape, &whole, err);
    if (done && shape.planar)
        mesh_planar(&whole);
    shape_repeat_texture(&shape, &whole);
    const int n_parts = whole.part && object->n_assignments > 0 ? whole.n_parts : 0;
    for (int part = 0; part < n_parts && done; part++)
        done = add_part(to, object, &whole, part, err);
    if (done && n_parts == 0)
        done = add_part(to, object, &whole, -1, err);
    mesh_free(&whole);
    return done;
}

static bool keep_all(struct reduced *out, struct error *err)
{
    for (int i = 0; i < out->n_objects; i++)
        out->n[REDUCED_TRIANGLES] += out->objects[i].mesh.n_triangles;
    out->n[REDUCED_BANDS] = out->scene->n_wavelengths;
    out->n[REDUCED_OBJECTS] = out->n_objects;
    out->n[REDUCED_LIGHTS] = out->scene->n_lights;
    out->n[REDUCED_AMBIENTS] = out->scene->n_ambients;
    for (int kind = 0; kind < REDUCED_KINDS; kind++) {
        out->kept[kind] = malloc((size_t)out->n[kind] + 1);
        if (!out->kept[kind])
            return error_memory(err);
        memset(out->kept[kind], true, (size_t)out->n[kind]);
    }
    out->width = out->scene->width;
    out->height = out->scene->height;
    return true;
}

bool reduced_open(const struct scene *scene, struct reduced *out, struct error *err)
{
    *out = (struct reduced){.scene = scene};
    for (int i = 0; i < scene->n_objects; i++)
        if (!add_object(out, &scene->objects[i], err))
            return false;
    return keep_all(out, err);
}

void reduced_free(struct reduced *of)
{
    for (int i = 0; i < of->n_objects; i++) {
        mesh_free(&of->objects[i].mesh);
        free(of->objects[i].placement);
    }
    for (int kind = 0; kind < REDUCED_KINDS; kind++)
        free(of->kept[kind]);
    free(of->objects);
    *of = (struct reduced){.scene = NULL};
}
