/* SPDX-License-Identifier: MIT */
/* The things in a scene: materials by name, shapes with their transforms, and the thesis's grid of
 * one object a material. Materials may be used before they are defined, so that they are found and
 * read when the whole scene is known; those that nothing uses are never opened. */
#include "scene.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- definitions ---- */

static int find_material(const struct scene *scene, int n, const char *name)
{
    for (int i = 0; i < n; i++)
        if (strcmp(scene->materials[i].name, name) == 0)
            return i;
    return -1;
}

/* Takes over what *material owns, even if this fails. */
static bool add_material(struct scene *scene, struct material *material, struct error *err)
{
    struct material *grown = array_more(scene->materials, scene->n_materials, sizeof *grown, err);
    if (grown == NULL) {
        material_free(material);
        return false;
    }
    scene->materials = grown;
    grown[scene->n_materials++] = *material;
    return true;
}

static bool check_name(const struct scene *scene, const struct word *word, const char *name,
                       struct error *err)
{
    int first = find_material(scene, scene->n_materials, name);
    if (word_is(word, "{"))
        return error_at(err, word->place, "expected a name before the {");
    if (first < 0)
        return true;
    return error_at(err, word->place, "there is a material '%.100s' already, in line %d of %.200s",
                    name, scene->materials[first].place.line, scene->materials[first].place.path);
}

/* What follows the name: the words in braces, or a file that is only noted. */
static bool read_content(struct text *text, struct material *out, struct error *err)
{
    struct word word;
    if (!text_expect(text, &word, "a material file or {", err))
        return false;
    if (word_is(&word, "{")) {
        if (!material_read_words(text, out, err))
            return false;
    } else {
        if (!word.quoted && word.start[0] == '{')
            return error_at(err, word.place, "a { stands alone, between blanks");
        out->path = word_path(&word, err);
        if (out->path == NULL)
            return false;
    }
    out->place = word.place;
    return text_end(text, "a material", err);
}

bool definition_read(struct scene_reader *reader, struct text *text, struct place place,
                     struct error *err)
{
    struct material material = {0};
    struct word word;
    char *name;
    (void)place;
    if (!text_expect(text, &word, "a name for the material", err))
        return false;
    name = word_copy(&word);
    if (name == NULL)
        return error_memory(err);
    if (!check_name(reader->scene, &word, name, err) || !read_content(text, &material, err)) {
        material_free(&material);
        free(name);
        return false;
    }
    material.name = name;
    return add_material(reader->scene, &material, err);
}

/* ---- shapes ---- */

/* A length lies above 0 and has highest 0; any other parameter is a whole number. */
struct parameter {
    const char *name;
    int lowest, highest;
};
enum { MOST_FACETS = 4096, MOST_DIVISIONS = 64 };

/* In the order of enum shape_kind. */
static const char *const shape_names[] = {"sphere", "torus", "box",    "plane", "cylinder",
                                          "cone",   "disk",  "teapot", "mesh",  NULL};
static const struct parameter shape_parameters[][4] = {
    {{"radius", 0, 0}, {"slices", 3, MOST_FACETS}, {"stacks", 2, MOST_FACETS}},
    {{"tube", 0, 0}, {"ring", 0, 0}, {"sides", 3, MOST_FACETS}, {"rings", 3, MOST_FACETS}},
    {{"width", 0, 0}, {"height", 0, 0}, {"depth", 0, 0}},
    {{"width", 0, 0}, {"height", 0, 0}},
    {{"radius", 0, 0}, {"height", 0, 0}, {"slices", 3, MOST_FACETS}, {"stacks", 1, MOST_FACETS}},
    {{"radius", 0, 0}, {"height", 0, 0}, {"slices", 3, MOST_FACETS}, {"stacks", 1, MOST_FACETS}},
    {{"radius", 0, 0}, {"slices", 3, MOST_FACETS}},
    {{"size", 0, 0}, {"divisions", 1, MOST_DIVISIONS}},
    {{NULL, 0, 0}}};

const char *shape_name(enum shape_kind kind)
{
    return shape_names[kind];
}

static bool read_parameters(struct text *text, struct shape *out, struct error *err)
{
    const struct parameter *parameters = shape_parameters[out->kind];
    for (int i = 0; i < 4 && parameters[i].name != NULL; i++) {
        const struct parameter *p = &parameters[i];
        long count = 0;
        if (p->highest == 0) {
            /* DBL_MIN, the least: above 0 */
            if (!text_number(text, p->name, DBL_MIN, HUGE_VAL, &out->parameter[i], err))
                return false;
        } else {
            if (!text_integer(text, p->name, p->lowest, p->highest, &count, err))
                return false;
            out->parameter[i] = (double)count;
        }
    }
    return true;
}

static bool read_mesh(struct text *text, struct shape *out, struct error *err)
{
    struct word word;
    if (!text_expect(text, &word, "a mesh file", err))
        return false;
    out->place = word.place;
    out->crease_deg = 90;
    out->path = word_path(&word, err);
    return out->path != NULL;
}

static bool read_shape(struct text *text, struct shape *out, struct error *err)
{
    struct word word;
    int kind;
    if (!text_expect(text, &word, "a shape", err))
        return false;
    kind = word_choose(&word, shape_names, "shape", err);
    if (kind < 0)
        return false;
    out->kind = (enum shape_kind)kind;
    out->place = word.place;
    return out->kind == SHAPE_MESH ? read_mesh(text, out, err) : read_parameters(text, out, err);
}

static bool copy_shape(const struct shape *from, struct shape *out, struct error *err)
{
    *out = *from;
    out->path = from->path != NULL ? strdup(from->path) : NULL;
    return from->path == NULL || out->path != NULL || error_memory(err);
}

/* ---- transforms ---- */

static bool begins_number(const struct word *word)
{
    return !word->quoted && strchr("0123456789+-.", word->start[0]) != NULL;
}

static bool read_factor(struct text *text, double *out, struct error *err)
{
    struct word word;
    if (!text_expect(text, &word, "a scale factor", err) ||
        !word_number(&word, "scale factor", -HUGE_VAL, HUGE_VAL, out, err))
        return false;
    return *out != 0 ||
           error_at(err, word.place, "scale factor 0 flattens the object; it must not be 0");
}

/* One factor or three: two numbers are a mistake. */
static bool read_scale(struct text *text, struct matrix *out, struct error *err)
{
    struct vector by;
    struct text after;
    struct word word;
    if (!read_factor(text, &by.x, err))
        return false;
    by.y = by.z = by.x;
    after = *text;
    if (text_word(&after, &word) && begins_number(&word) &&
        (!read_factor(text, &by.y, err) || !read_factor(text, &by.z, err)))
        return false;
    *out = matrix_scaling(by);
    return true;
}

static bool read_rotation(struct text *text, struct matrix *out, struct error *err)
{
    struct vector axis;
    double angle;
    if (!text_number(text, "angle", -HUGE_VAL, HUGE_VAL, &angle, err) ||
        !text_direction(text, "axis", &axis, err))
        return false;
    *out = matrix_rotation(angle, axis);
    return true;
}

static bool read_translation(struct text *text, struct matrix *out, struct error *err)
{
    struct vector by;
    if (!text_vector(text, "translation", &by, NULL, err))
        return false;
    *out = matrix_translation(by);
    return true;
}

static bool read_transform(struct text *text,
                           bool (*read)(struct text *, struct matrix *, struct error *),
                           struct object *object, struct error *err)
{
    struct matrix next;
    if (!read(text, &next, err))
        return false;
    object->transform = matrix_product(next, object->transform);
    return true;
}

/* ---- objects ---- */

/* An object as its line says it. The material is a word until all materials are known. */
struct description {
    struct object object;
    struct word material;
    struct place material_place, crease_place, unitize_place;
    bool listed; /* a list gives the materials */
};

static bool read_material_word(struct text *text, struct place place, bool map,
                               struct description *out, struct error *err)
{
    struct shape *shape = &out->object.shape;
    if (out->listed)
        return error_at(err, place, "the materials of a checker come from its list");
    if (map && shape->kind != SHAPE_MESH)
        return error_at(err, place, "only a mesh has several materials");
    if (!place_once(out->material_place, place, "material", err) ||
        !text_expect(text, &out->material, map ? "a material map" : "a material", err))
        return false;
    out->material_place = place;
    if (!map)
        return true;
    shape->material_map = word_path(&out->material, err);
    return shape->material_map != NULL;
}

static bool read_mesh_option(struct text *text, struct place place, bool crease,
                             struct description *out, struct error *err)
{
    const char *what = crease ? "crease" : "unitize";
    struct place *given = crease ? &out->crease_place : &out->unitize_place;
    struct shape *shape = &out->object.shape;
    if (shape->kind != SHAPE_MESH)
        return error_at(err, place, "%s is for a mesh, not for a %s", what,
                        shape_name(shape->kind));
    if (!place_once(*given, place, what, err))
        return false;
    *given = place;
    if (crease)
        return text_number(text, "crease", 0, 180, &shape->crease_deg, err);
    shape->unitize = true;
    return true;
}

static bool read_option(struct text *text, const struct word *word, struct description *out,
                        struct error *err)
{
    static const char *const words[] = {"material",  "materials", "scale",  "rotate",
                                        "translate", "unitize",   "crease", NULL};
    struct object *object = &out->object;
    switch (word_choose(word, words, "word for an object", err)) {
    case 0:
        return read_material_word(text, word->place, false, out, err);
    case 1:
        return read_material_word(text, word->place, true, out, err);
    case 2:
        return read_transform(text, read_scale, object, err);
    case 3:
        return read_transform(text, read_rotation, object, err);
    case 4:
        return read_transform(text, read_translation, object, err);
    case 5:
        return read_mesh_option(text, word->place, false, out, err);
    case 6:
        return read_mesh_option(text, word->place, true, out, err);
    default:
        return false;
    }
}

/* The shape and all words after it. */
static bool read_description(struct text *text, struct place place, struct description *out,
                             struct error *err)
{
    struct word word;
    out->object.place = place;
    out->object.material = -1;
    out->object.transform = matrix_identity();
    if (!read_shape(text, &out->object.shape, err))
        return false;
    while (text_word(text, &word))
        if (!read_option(text, &word, out, err))
            return false;
    return out->listed || out->material_place.line > 0 ||
           error_at(err, place, "the object has no material; write material and its name");
}

void shape_free(struct shape *shape)
{
    free(shape->path);
    free(shape->material_map);
    shape->path = shape->material_map = NULL;
}

/* Takes over what *object owns, even if this fails. */
static bool add_object(struct scene_reader *reader, struct object *object,
                       const struct word *material, bool listed, struct error *err)
{
    struct scene *scene = reader->scene;
    struct object *objects = array_more(scene->objects, scene->n_objects, sizeof *objects, err);
    struct material_use *uses;
    if (objects == NULL) {
        shape_free(&object->shape);
        return false;
    }
    scene->objects = objects;
    objects[scene->n_objects++] = *object;
    if (object->shape.material_map != NULL)
        return true;
    uses = array_more(reader->uses, reader->n_uses, sizeof *uses, err);
    if (uses == NULL)
        return false;
    reader->uses = uses;
    uses[reader->n_uses++] = (struct material_use){scene->n_objects - 1, *material, listed};
    return true;
}

bool object_read(struct scene_reader *reader, struct text *text, struct place place,
                 struct error *err)
{
    struct description description = {.listed = false};
    if (read_description(text, place, &description, err))
        return add_object(reader, &description.object, &description.material, false, err);
    shape_free(&description.object.shape);
    return false;
}

/* ---- the thesis's grid ---- */

/* Where object i of n stands: rows by the number of objects, filled from the top left, 6 units
 * apart before scaling. */
static struct matrix grid_place(int i, int n)
{
    int rows = n <= 3 ? 1 : n <= 8 ? 2 : n <= 15 ? 3 : 4;
    double scale = rows == 1 ? 1 : rows == 2 ? 0.66 : rows == 3 ? 0.5 : 0.333;
    int columns = n / rows + (n % rows != 0);
    struct vector size = {scale, scale, scale};
    struct vector at = {6.0 * (i % columns) - 3.0 * (columns - 1),
                        3.0 * (rows - 1) - 6.0 * (i / columns), 0};
    return matrix_product(matrix_scaling(size), matrix_translation(at));
}

/* One material file a line, each the material of a copy of the pattern. */
static bool add_listed(struct scene_reader *reader, struct text *list, const struct object *pattern,
                       struct error *err)
{
    struct word word;
    while (text_next_line(list)) {
        struct object object = *pattern;
        struct text before = *list;
        if (!text_word(list, &word))
            continue;
        *list = before;
        if (!text_expect(list, &word, "a material file", err) ||
            !text_end(list, "a line of a list", err) ||
            !copy_shape(&pattern->shape, &object.shape, err) ||
            !add_object(reader, &object, &word, true, err))
            return false;
    }
    return true;
}

static bool add_grid(struct scene_reader *reader, struct text *list, const struct object *pattern,
                     struct error *err)
{
    struct scene *scene = reader->scene;
    int first = scene->n_objects, n;
    if (!add_listed(reader, list, pattern, err))
        return false;
    n = scene->n_objects - first;
    for (int i = 0; i < n; i++) {
        struct matrix *transform = &scene->objects[first + i].transform;
        *transform = matrix_product(grid_place(i, n), *transform);
    }
    return n > 0 || error_at(err, text_whole(list), "no materials; a list names at least one");
}

static bool open_list(struct scene_reader *reader, const struct word *word, struct text *out,
                      struct error *err)
{
    char *path;
    bool done;
    if (reader->list != NULL) {
        *out = *reader->list;
        return true;
    }
    path = word_path(word, err);
    if (path == NULL)
        return false;
    done = text_open(out, path, word->place, err) && scene_keep(reader->scene, out, err);
    free(path);
    return done;
}

bool checker_read(struct scene_reader *reader, struct text *text, struct place place,
                  struct error *err)
{
    struct description description = {.listed = true};
    struct text list;
    struct word word;
    bool done = text_expect(text, &word, "a list of material files", err) &&
                open_list(reader, &word, &list, err) &&
                read_description(text, place, &description, err) &&
                add_grid(reader, &list, &description.object, err);
    shape_free(&description.object.shape);
    return done;
}

/* ---- materials of objects ---- */

static bool refuse_unknown(const struct scene *scene, int n_named, struct place place,
                           const char *name, struct error *err)
{
    char list[512] = "";
    size_t used = 0;
    for (int i = 0; i < n_named && used < sizeof list; i++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%.40s", i > 0 ? ", " : "",
                                 scene->materials[i].name);
    return error_at(err, place, "no material '%.100s'; the scene's materials are: %s", name,
                    n_named > 0 ? list : "none");
}

/* Reads a material file; its name and place stay the scene's. */
static bool load(struct material *material, struct error *err)
{
    struct material fresh;
    char *name;
    if (material->diffuse.kind != SPECTRUM_NONE)
        return true;
    if (!material_read(material->path, material->place, &fresh, err))
        return false;
    name = fresh.name;
    fresh.name = material->name;
    fresh.place = material->place;
    material->name = name;
    material_free(material);
    *material = fresh;
    return true;
}

/* Finds a named material, reads it and, where it is cut in half, the partner that it names. */
static bool use_named(struct scene *scene, int n_named, const char *name, struct place place,
                      int *out, struct error *err)
{
    const struct material *material;
    int partner;
    *out = find_material(scene, n_named, name);
    if (*out < 0)
        return refuse_unknown(scene, n_named, place, name, err);
    if (!load(&scene->materials[*out], err))
        return false;
    material = &scene->materials[*out];
    if (material->partner_name == NULL)
        return true;
    partner = find_material(scene, n_named, material->partner_name);
    if (partner < 0)
        return refuse_unknown(scene, n_named, material->partner_place, material->partner_name, err);
    return load(&scene->materials[partner], err);
}

/* Listed materials have no name in the scene; the same file is the same material. */
static bool use_listed(struct scene *scene, int n_named, const struct word *word, int *out,
                       struct error *err)
{
    struct material material = {0};
    char *path = word_path(word, err);
    if (path == NULL)
        return false;
    for (*out = n_named; *out < scene->n_materials; ++*out)
        if (strcmp(scene->materials[*out].path, path) == 0) {
            free(path);
            return true;
        }
    if (!material_read(path, word->place, &material, err)) {
        free(path);
        return false;
    }
    free(path);
    material.place = word->place;
    return add_material(scene, &material, err);
}

static bool use_material(struct scene *scene, int n_named, const struct material_use *use,
                         struct error *err)
{
    int *out = &scene->objects[use->object].material;
    char *name;
    bool done;
    if (use->listed)
        return use_listed(scene, n_named, &use->word, out, err);
    name = word_copy(&use->word);
    if (name == NULL)
        return error_memory(err);
    done = use_named(scene, n_named, name, use->word.place, out, err);
    free(name);
    return done;
}

bool uses_resolve(struct scene_reader *reader, struct error *err)
{
    int n_named = reader->scene->n_materials;
    for (int i = 0; i < reader->n_uses; i++)
        if (!use_material(reader->scene, n_named, &reader->uses[i], err))
            return false;
    return true;
}
