/* SPDX-License-Identifier: MIT */
/* Finds materials by name, and reads those that objects use. A scene may use a material before it
 * defines it, so this happens when the whole scene is known. The file of a material that no object
 * uses is never opened. */
#include "data/scene/inside.h"

/* ---- definitions ---- */

static bool check_name(const struct scene_reader *reader, const struct word *word,
                       struct error *err)
{
    const int first = index_find(&reader->named, word->start, word->length);
    if (word_is(word, "{"))
        return error_at(err, word->place, "expected a name before the {");
    if (first < 0)
        return true;
    const struct material *material = &reader->scene->materials[first];
    return error_at(err, word->place, "there is a material '%.100s' already, in line %d of %.200s",
                    material->name, material->place.line, material->place.path);
}

/* Reads the words in braces behind the name, or a sample of a table; or notes the name of a file.
 */
static bool read_content(struct text *text, struct material *out, struct error *err)
{
    struct word word;
    if (!text_expect(text, &word, "a material file or {", err))
        return false;
    if (word_is(&word, "{"))
        return material_read_words(text, out, err) && text_end(text, "a material", err);
    if (!word.quoted && word.start[0] == '{')
        return error_at(err, word.place, "a { stands between blanks: material NAME { ... }");
    if (material_has_word(&word))
        return error_at(err, word.place, "'%.*s' stands between braces: material NAME { %.*s ... }",
                        word_shown(&word), word.start, word_shown(&word), word.start);
    out->place = word.place;
    if (!word_file(&word, FILE_MATERIAL, &out->path, err))
        return false;
    const bool is_sample = memchr(word.start, ':', word.length) && file_is_missing(out->path);
    return (!is_sample || spectrum_read(&word, 0, 1, &out->diffuse, err)) &&
           text_end(text, "a material", err);
}

bool material_keep(struct scene *scene, struct material *material, bool good, struct error *err)
{
    if (good && array_add(&scene->materials, &scene->n_materials, material, sizeof *material, err))
        return true;
    material_free(material);
    return false;
}

bool definition_read(struct scene_reader *reader, struct error *err)
{
    struct scene *scene = reader->scene;
    struct material material = {0};
    struct word word;
    const bool good = text_expect(reader->text, &word, "a name for the material", err) &&
                      check_name(reader, &word, err) &&
                      read_content(reader->text, &material, err) &&
                      (material.name = word_copy(&word, err)) &&
                      index_add(&reader->named, word.start, word.length, scene->n_materials, err);
    return material_keep(scene, &material, good, err);
}

/* ---- materials that are used ---- */

/* Proposes the materials that a statement defines by their names. A file in a list has no name yet;
 * an entry of an MTL file has a name, but no statement. */
static bool refuse_unknown(const struct scene *scene, const struct word *name, struct error *err)
{
    struct suggestion suggestion = {.distance = 0};
    for (int i = 0; i < scene->n_materials; i++) {
        const struct material *known = &scene->materials[i];
        if (known->name && !known->from_rgb)
            suggestion_add(&suggestion, name, known->name, strlen(known->name));
    }
    return error_at(err, name->place, "the scene defines no material '%.*s'; %s", word_shown(name),
                    name->start,
                    suggestion_end(&suggestion,
                                   suggestion.known[0] != '\0'
                                       ? "its materials are"
                                       : "a line such as 'material gold metals/gold' defines one"));
}

/* Reads a material file; name and place stay the scene's. Or reads the matrix of a material in
 * words. */
static bool load(struct material *material, struct error *err)
{
    struct material fresh;
    char *name = material->name;
    if (material->diffuse.kind != SPECTRUM_NONE)
        return !material->donaldson || material->matrix.share ||
               donaldson_read(material->donaldson, material->donaldson_place, material->densities,
                              &material->diffuse, &material->matrix, err);
    if (!material_read(material->path, material->place, &fresh, err))
        return false;
    if (name) {
        material->name = fresh.name;
        fresh.name = name;
    }
    fresh.place = material->place;
    material_free(material);
    *material = fresh;
    return true;
}

/* Finds a material and reads its file. */
static bool find_named(const struct scene_reader *reader, const struct word *name, int *out,
                       struct error *err)
{
    *out = index_find(&reader->named, name->start, name->length);
    return *out >= 0 ? load(&reader->scene->materials[*out], err)
                     : refuse_unknown(reader->scene, name, err);
}

/* Finds the partner that a material names, if it names one. */
static bool use_partner(const struct scene_reader *reader, int index, struct error *err)
{
    struct scene *scene = reader->scene;
    struct material *material = &scene->materials[index], *partner;
    struct word name = {.start = material->partner_name, .place = material->partner_place};
    if (!name.start)
        return true;
    name.length = strlen(name.start);
    if (!find_named(reader, &name, &material->partner_index, err))
        return false;
    partner = &scene->materials[material->partner_index];
    if (partner == material)
        return error_at(err, name.place, "'%.100s' is its own partner; it must be another material",
                        material->name);
    return (!partner->partner && !partner->partner_name) ||
           error_at(err, name.place, "'%.100s' has a partner itself; a partner must be without one",
                    partner->name);
}

static bool use_named(const struct scene_reader *reader, const struct word *name, int *out,
                      struct error *err)
{
    return find_named(reader, name, out, err) && use_partner(reader, *out, err);
}

const struct material *scene_partner(const struct scene *scene, const struct material *material)
{
    return material->partner_name ? &scene->materials[material->partner_index] : material->partner;
}

/* ---- material maps ---- */

/* Finds the MTL file that a word names, or opens it; -1 after an error. */
static int find_mtl(struct scene_reader *reader, const struct word *file, struct error *err)
{
    struct mtl mtl;
    char *path;
    int i = 0;
    if (!word_file(file, FILE_KINDS, &path, err))
        return -1;
    while (i < reader->n_mtl && strcmp(reader->mtl[i].text.path, path) != 0)
        i++;
    if (i == reader->n_mtl && !(mtl_open(path, file->place, &mtl, err) &&
                                array_add(&reader->mtl, &reader->n_mtl, &mtl, sizeof mtl, err))) {
        mtl_free(&mtl);
        i = -1;
    }
    free(path);
    return i;
}

/* Finds the material of an entry, or reads the entry; -1 after an error. */
static int entry_material(struct scene *scene, struct mtl_entry *entry, struct error *err)
{
    struct material material;
    if (entry->material == 0 &&
        material_keep(scene, &material, mtl_read(entry, &material, err), err))
        entry->material = scene->n_materials;
    return entry->material - 1;
}

/* Finds the material that an MTL file has by that name. */
static bool use_entry(struct scene_reader *reader, const struct word *name, const struct word *file,
                      int *out, struct error *err)
{
    if (word_is(name, "*"))
        return error_at(err, name->place, "* is no entry of an MTL file; give it a material");
    const int mtl = find_mtl(reader, file, err);
    struct mtl_entry *entry = mtl < 0 ? NULL : mtl_find(&reader->mtl[mtl], file->place, name, err);
    *out = entry ? entry_material(reader->scene, entry, err) : -1;
    return *out >= 0;
}

/* Reads "material MATERIAL" or "mtl FILE", and finds the material. */
static bool use_assigned(struct scene_reader *reader, struct text *text, const struct word *name,
                         int *out, struct error *err)
{
    static const char *const words[] = {"material", "mtl", NULL};
    const int kind = text_choose(text, "material or mtl", words, "word in a material map", err);
    struct word word;
    return kind >= 0 && text_expect(text, &word, kind == 0 ? "a material" : "an MTL file", err) &&
           text_end(text, "a line of a material map", err) &&
           (kind == 0 ? use_named(reader, &word, out, err)
                      : use_entry(reader, name, &word, out, err));
}

/* A material map, or a mesh with its own materials, that is being read. */
struct map {
    struct text text;
    struct object *object;
    struct index names; /* of its lines */
};

static bool add_assignment(struct map *map, const struct word *name,
                           struct material_assignment *assignment, struct error *err)
{
    struct object *object = map->object;
    assignment->name = word_copy(name, err);
    if (assignment->name &&
        index_add(&map->names, name->start, name->length, object->n_assignments, err) &&
        array_add(&object->assignments, &object->n_assignments, assignment, sizeof *assignment,
                  err))
        return true;
    free(assignment->name);
    return false;
}

/* Reads "NAME material MATERIAL" or "NAME mtl FILE". */
static bool read_assignment(struct scene_reader *reader, struct map *map, struct error *err)
{
    struct object *object = map->object;
    struct material_assignment assignment = {0};
    struct word name;
    if (!text_expect(&map->text, &name, "the name of a usemtl", err))
        return false;
    const int first = index_find(&map->names, name.start, name.length);
    if (first >= 0)
        return place_once(&object->assignments[first].place, name.place, "this name", err);
    assignment.place = name.place;
    return use_assigned(reader, &map->text, &name, &assignment.material, err) &&
           add_assignment(map, &name, &assignment, err);
}

static bool map_read(struct scene_reader *reader, struct object *object, struct error *err)
{
    struct map map = {.object = object};
    struct word word;
    bool done = scene_open(reader->scene, &object->named, FILE_MAP, &map.text, err);
    while (done && text_next_line(&map.text))
        done = !text_peek(map.text, &word) || read_assignment(reader, &map, err);
    index_free(&map.names);
    return done &&
           (object->n_assignments > 0 ||
            error_at(err, text_whole(&map.text), "no lines; a material map has at least one"));
}

/* ---- the materials that a mesh names itself ---- */

/* Gives a usemtl the entry that the first of n MTL files with that name has. */
static bool add_entry_of(struct scene_reader *reader, struct map *map, const struct word *name,
                         const int *libraries, int n, struct error *err)
{
    struct material_assignment assignment = {.place = map->object->place};
    if (index_find(&map->names, name->start, name->length) >= 0)
        return true;
    for (int i = 0; i < n; i++) {
        const struct mtl *mtl = &reader->mtl[libraries[i]];
        const int entry = index_find(&mtl->names, name->start, name->length);
        if (entry < 0)
            continue;
        assignment.material = entry_material(reader->scene, &mtl->entries[entry], err);
        return assignment.material >= 0 && add_assignment(map, name, &assignment, err);
    }
    return true; /* a face that uses it is refused later */
}

/* Reads the statements mtllib and usemtl of a mesh whose object has no material. The name behind
 * either of them is the rest of the line. */
static bool mesh_materials(struct scene_reader *reader, struct object *object, struct error *err)
{
    struct map map = {.object = object};
    struct word word, rest;
    int *libraries = NULL, n = 0;
    bool done = file_expected(object->shape.path, object->place, FILE_MODEL, err) &&
                text_open(&map.text, object->shape.path, object->place, TEXT_LARGE, err);
    while (done && text_next_line(&map.text)) {
        if (!text_word(&map.text, &word))
            continue;
        if (word_is(&word, "mtllib") && text_rest(&map.text, &rest)) {
            const int mtl = find_mtl(reader, &rest, err);
            done = mtl >= 0 && array_add(&libraries, &n, &mtl, sizeof mtl, err);
        } else if (word_is(&word, "usemtl") && text_rest(&map.text, &rest))
            done = add_entry_of(reader, &map, &rest, libraries, n, err);
    }
    done = done && (object->n_assignments > 0 ||
                    error_at(err, object->place,
                             "the object has no material, and %.300s no usemtl of a mtllib; "
                             "expected material and its name",
                             object->shape.path));
    free(libraries);
    index_free(&map.names);
    text_free(&map.text);
    return done;
}

/* ---- all of them ---- */

bool materials_resolve(struct scene_reader *reader, struct error *err)
{
    struct scene *scene = reader->scene;
    for (int i = 0; i < scene->n_objects; i++) {
        struct object *object = &scene->objects[i];
        if (object->named.start &&
            !(object->material_map ? map_read(reader, object, err)
                                   : use_named(reader, &object->named, &object->material, err)))
            return false;
        if (!object->named.start && object->material < 0 && !mesh_materials(reader, object, err))
            return false;
    }
    /* Listed materials come last: reading names them, and no object may find them by that name. */
    for (int i = 0; i < scene->n_objects; i++)
        if (scene->objects[i].material >= 0 &&
            !load(&scene->materials[scene->objects[i].material], err))
            return false;
    return true;
}
