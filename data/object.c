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

static int find_material(const struct scene *scene, const struct word *word)
{
    for (int i = 0; i < scene->n_materials; i++) {
        const char *name = scene->materials[i].name;
        if (name != NULL && strncmp(name, word->start, word->length) == 0 &&
            name[word->length] == '\0')
            return i;
    }
    return -1;
}

/* Takes over what *material owns, unless this fails. */
static bool add_material(struct scene *scene, const struct material *material, struct error *err)
{
    struct material *grown = array_more(scene->materials, scene->n_materials, sizeof *grown, err);
    if (grown == NULL)
        return false;
    scene->materials = grown;
    grown[scene->n_materials++] = *material;
    return true;
}

static bool check_name(const struct scene *scene, const struct word *word, struct error *err)
{
    int first = find_material(scene, word);
    if (word_is(word, "{"))
        return error_at(err, word->place, "expected a name before the {");
    if (first < 0)
        return true;
    return error_at(err, word->place, "there is a material '%.100s' already, in line %d of %.200s",
                    scene->materials[first].name, scene->materials[first].place.line,
                    scene->materials[first].place.path);
}

/* What follows the name: the words in braces, or a file that is only noted. */
static bool read_content(struct text *text, struct material *out, struct error *err)
{
    struct word word;
    if (!text_expect(text, &word, "a material file or {", err))
        return false;
    if (word_is(&word, "{"))
        return material_read_words(text, out, err) && text_end(text, "a material", err);
    if (!word.quoted && word.start[0] == '{')
        return error_at(err, word.place, "a { stands alone, between blanks");
    out->place = word.place;
    return word_path(&word, &out->path, err) && text_end(text, "a material", err);
}

bool definition_read(struct scene_reader *reader, struct error *err)
{
    struct material material = {0};
    struct word word;
    if (text_expect(reader->text, &word, "a name for the material", err) &&
        check_name(reader->scene, &word, err) && read_content(reader->text, &material, err)) {
        material.name = word_copy(&word);
        if (material.name == NULL)
            error_memory(err);
        else if (add_material(reader->scene, &material, err))
            return true;
    }
    material_free(&material);
    return false;
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
    const struct parameter *p = shape_parameters[out->kind];
    for (int i = 0; i < 4 && p[i].name != NULL; i++) {
        double *value = &out->parameter[i];
        long count;
        if (p[i].highest == 0) {
            if (!text_number(text, p[i].name, DBL_MIN, HUGE_VAL, value, err))
                return false;
        } else {
            if (!text_integer(text, p[i].name, p[i].lowest, p[i].highest, &count, err))
                return false;
            *value = (double)count;
        }
    }
    return true;
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
    *out = (struct shape){.kind = (enum shape_kind)kind, .crease_deg = 90, .place = word.place};
    if (out->kind != SHAPE_MESH)
        return read_parameters(text, out, err);
    if (!text_expect(text, &word, "a mesh file", err))
        return false;
    out->place = word.place;
    return word_path(&word, &out->path, err);
}

/* ---- transforms ---- */

/* One factor or three: two numbers are a mistake. */
static bool read_scale(struct text *text, struct vector *out, struct error *err)
{
    double factor[3];
    struct word word;
    int n = 0;
    do {
        if (!text_expect(text, &word, "a scale factor", err) ||
            !word_number(&word, "scale factor", -HUGE_VAL, HUGE_VAL, &factor[n], err))
            return false;
        if (factor[n] == 0)
            return error_at(err, word.place,
                            "scale factor 0 flattens the object; it must not be 0");
        n++;
    } while (n == 2 || (n == 1 && text_peek(*text, &word) && word_begins_number(&word)));
    *out = (struct vector){factor[0], factor[n == 3 ? 1 : 0], factor[n == 3 ? 2 : 0]};
    return true;
}

enum object_option {
    OBJECT_MATERIAL,
    OBJECT_MATERIALS,
    OBJECT_SCALE,
    OBJECT_ROTATE,
    OBJECT_TRANSLATE,
    OBJECT_UNITIZE,
    OBJECT_CREASE
};
static const char *const option_words[] = {"material",  "materials", "scale",  "rotate",
                                           "translate", "unitize",   "crease", NULL};

static bool read_transform(struct text *text, int option, struct matrix *out, struct error *err)
{
    struct matrix next;
    struct vector by;
    double angle;
    if (option == OBJECT_SCALE) {
        if (!read_scale(text, &by, err))
            return false;
        next = matrix_scaling(by);
    } else if (option == OBJECT_ROTATE) {
        if (!text_number(text, "angle", -HUGE_VAL, HUGE_VAL, &angle, err) ||
            !text_direction(text, "axis", &by, err))
            return false;
        next = matrix_rotation(angle, by);
    } else {
        if (!text_vector(text, "translation", &by, err))
            return false;
        next = matrix_translation(by);
    }
    *out = matrix_product(next, *out);
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

static bool read_material(struct text *text, struct place place, bool map, struct description *out,
                          struct error *err)
{
    struct shape *shape = &out->object.shape;
    struct word word;
    if (out->listed)
        return error_at(err, place, "the materials of a checker come from its list");
    if (map && shape->kind != SHAPE_MESH)
        return error_at(err, place, "only a mesh has several materials");
    if (!place_once(&out->material_place, place, "material", err) ||
        !text_expect(text, &word, map ? "a material map" : "a material", err))
        return false;
    if (map)
        return word_path(&word, &shape->material_map, err);
    out->material = word;
    return true;
}

static bool read_option(struct text *text, const struct word *word, struct description *out,
                        struct error *err)
{
    struct shape *shape = &out->object.shape;
    int option = word_choose(word, option_words, "word for an object", err);
    if (option < 0)
        return false;
    if (option <= OBJECT_MATERIALS)
        return read_material(text, word->place, option == OBJECT_MATERIALS, out, err);
    if (option <= OBJECT_TRANSLATE)
        return read_transform(text, option, &out->object.transform, err);
    if (shape->kind != SHAPE_MESH)
        return error_at(err, word->place, "%s is for a mesh, not for a %s", option_words[option],
                        shape_name(shape->kind));
    if (option == OBJECT_CREASE)
        return place_once(&out->crease_place, word->place, "crease", err) &&
               text_number(text, "crease", 0, 180, &shape->crease_deg, err);
    shape->unitize = true;
    return place_once(&out->unitize_place, word->place, "unitize", err);
}

/* The shape and all words after it. */
static bool read_description(struct scene_reader *reader, struct description *out,
                             struct error *err)
{
    struct word word;
    out->object.place = reader->place;
    out->object.material = -1;
    out->object.transform = matrix_identity();
    if (!read_shape(reader->text, &out->object.shape, err))
        return false;
    while (text_word(reader->text, &word))
        if (!read_option(reader->text, &word, out, err))
            return false;
    return out->listed || out->material_place.line > 0 ||
           error_at(err, reader->place, "the object has no material; write material and its name");
}

void shape_free(struct shape *shape)
{
    free(shape->path);
    free(shape->material_map);
    shape->path = shape->material_map = NULL;
}

/* Copies what the description owns. */
static bool add_object(struct scene_reader *reader, const struct description *description,
                       struct error *err)
{
    const struct shape *from = &description->object.shape;
    struct scene *scene = reader->scene;
    int n = scene->n_objects;
    struct object *objects = array_more(scene->objects, n, sizeof *objects, err);
    struct word *uses;
    if (objects == NULL)
        return false;
    scene->objects = objects;
    uses = array_more(reader->uses, n, sizeof *uses, err);
    if (uses == NULL)
        return false;
    reader->uses = uses;
    uses[n] = description->material;
    objects[n] = description->object;
    objects[n].shape.material_map = NULL;
    scene->n_objects++;
    return string_copy(from->path, &objects[n].shape.path, err) &&
           string_copy(from->material_map, &objects[n].shape.material_map, err);
}

bool object_read(struct scene_reader *reader, struct error *err)
{
    struct description description = {.listed = false};
    bool done =
        read_description(reader, &description, err) && add_object(reader, &description, err);
    shape_free(&description.object.shape);
    return done;
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

/* Listed materials have no name until they are read; the same file is the same material. */
static bool add_file(struct scene *scene, const struct word *word, int *out, struct error *err)
{
    struct material material = {.place = word->place};
    int i = 0;
    if (!word_path(word, &material.path, err))
        return false;
    while (i < scene->n_materials && (scene->materials[i].name != NULL ||
                                      strcmp(scene->materials[i].path, material.path) != 0))
        i++;
    *out = i;
    if (i == scene->n_materials && add_material(scene, &material, err))
        return true;
    material_free(&material);
    return i < scene->n_materials;
}

/* One material file a line, each the material of a copy of the pattern. */
static bool add_listed(struct scene_reader *reader, struct text *list, struct description *pattern,
                       struct error *err)
{
    struct word word;
    while (text_next_line(list))
        if (text_peek(*list, &word) &&
            (!text_expect(list, &word, "a material file", err) ||
             !text_end(list, "a line of a list", err) ||
             !add_file(reader->scene, &word, &pattern->object.material, err) ||
             !add_object(reader, pattern, err)))
            return false;
    return true;
}

static bool add_grid(struct scene_reader *reader, struct text *list, struct description *pattern,
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

bool checker_read(struct scene_reader *reader, struct error *err)
{
    struct description description = {.listed = true};
    struct text list = reader->list;
    struct word word;
    bool done = text_expect(reader->text, &word, "a list of material files", err) &&
                (list.path != NULL || scene_open(reader->scene, &word, &list, err)) &&
                read_description(reader, &description, err) &&
                add_grid(reader, &list, &description, err);
    shape_free(&description.object.shape);
    return done;
}

/* ---- materials of objects ---- */

static bool refuse_unknown(const struct scene *scene, const struct word *name, struct error *err)
{
    char list[LIST_SIZE] = "";
    for (int i = 0; i < scene->n_materials; i++)
        if (scene->materials[i].name != NULL)
            list_add(list, scene->materials[i].name, 40);
    return error_at(err, name->place, "no material '%.*s'; the scene's materials are: %s",
                    word_shown(name), name->start, list[0] != '\0' ? list : "none");
}

/* Reads a material file; name and place stay the scene's. */
static bool load(struct material *material, struct error *err)
{
    struct material fresh;
    char *name = material->name;
    if (material->diffuse.kind != SPECTRUM_NONE)
        return true;
    if (!material_read(material->path, material->place, &fresh, err))
        return false;
    if (name != NULL) {
        material->name = fresh.name;
        fresh.name = name;
    }
    fresh.place = material->place;
    material_free(material);
    *material = fresh;
    return true;
}

static bool use_named(struct scene *scene, const struct word *name, int *out, struct error *err)
{
    *out = find_material(scene, name);
    return *out >= 0 ? load(&scene->materials[*out], err) : refuse_unknown(scene, name, err);
}

/* A material that is cut in half names its partner. */
static bool use_partner(struct scene *scene, const struct material *material, struct error *err)
{
    struct word name = {.start = material->partner_name, .place = material->partner_place};
    int partner;
    if (name.start == NULL)
        return true;
    name.length = strlen(name.start);
    return use_named(scene, &name, &partner, err);
}

bool uses_resolve(struct scene_reader *reader, struct error *err)
{
    struct scene *scene = reader->scene;
    for (int i = 0; i < scene->n_objects; i++) {
        int *out = &scene->objects[i].material;
        if (reader->uses[i].start != NULL && (!use_named(scene, &reader->uses[i], out, err) ||
                                              !use_partner(scene, &scene->materials[*out], err)))
            return false;
    }
    /* Reading names the listed ones, which nothing finds by that. */
    for (int i = 0; i < scene->n_objects; i++)
        if (reader->uses[i].start == NULL && scene->objects[i].material >= 0 &&
            !load(&scene->materials[scene->objects[i].material], err))
            return false;
    return true;
}
