/* SPDX-License-Identifier: MIT */
/* The objects of a scene: shapes with their transforms, and the thesis's grid of one object for
 * each material. */
#include <float.h>

#include "data/scene/inside.h"

/* ---- transforms ---- */

/* Reads one factor or three. Two numbers are a mistake. */
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
    OBJECT_TWO_SIDED,
    OBJECT_CASTS,
    OBJECT_PLANAR,
    OBJECT_REPEAT,
    OBJECT_DISPLACE,
    OBJECT_UNITIZE,
    OBJECT_CREASE,
    OBJECT_OPTIONS
};
static const char *const option_words[] = {
    "material", "materials", "scale",    "rotate",  "translate", "two-sided", "casts",
    "planar",   "repeat",    "displace", "unitize", "crease",    NULL};

/* ---- objects ---- */

/* An object as its statement describes it. */
struct description {
    struct object object;
    struct place given[OBJECT_OPTIONS]; /* of options that may be given once; of a doubted rotate */
    bool listed;                        /* a list gives the materials */
};

/* X Y Z ANGLE, as other programs order them, is a turn by 1 degree at most about a long axis. */
static bool read_transform(struct text *text, int option, struct description *out,
                           struct error *err)
{
    struct matrix *transform = &out->object.transform;
    const struct place first = text_next_place(*text);
    struct matrix next;
    struct vector by;
    double angle;
    if (option == OBJECT_SCALE) {
        if (!read_scale(text, &by, err))
            return false;
        next = matrix_scaling(by);
    } else if (option == OBJECT_ROTATE) {
        if (!text_number(text, "angle", -HUGE_VAL, HUGE_VAL, &angle, err) ||
            !text_direction(text, "axis (ANGLE X Y Z)", &by, err))
            return false;
        if (fabs(angle) <= 1 && fabs(by.x) <= 1 && fabs(by.z) > 1)
            out->given[OBJECT_ROTATE] = first;
        next = matrix_rotation(angle, by);
    } else {
        if (!text_vector(text, "translation", &by, err))
            return false;
        next = matrix_translation(by);
    }
    *transform = matrix_product(next, *transform);
    return true;
}

static bool read_material(struct text *text, struct place place, bool map, struct description *out,
                          struct error *err)
{
    if (out->listed)
        return error_at(err, place, "the materials of a checker come from its list");
    if (map && out->object.shape.kind != SHAPE_MESH)
        return error_at(err, place, "only a mesh has several materials");
    return place_once(&out->given[OBJECT_MATERIAL], place, "material", err) &&
           text_expect(text, &out->object.named, map ? "a material map" : "a material", err) &&
           (!map || word_file(&out->object.named, FILE_MAP, &out->object.material_map, err));
}

/* Reads a relief and its height. Height 0 is none. */
static bool read_relief(struct text *text, struct shape *out, struct error *err)
{
    const double most = 1e30;
    struct word word;
    out->relief_place = text_next_place(*text);
    if (!text_expect(text, &word, "a relief", err) ||
        !word_file(&word, FILE_RELIEF, &out->relief, err) ||
        !text_number(text, "height", -most, most, &out->relief_height, err))
        return false;
    if (out->relief_height == 0) {
        free(out->relief);
        out->relief = NULL;
    }
    return true;
}

static bool read_option(struct text *text, const struct word *word, struct description *out,
                        struct error *err)
{
    static const char *const casts[] = {"no", NULL};
    struct shape *shape = &out->object.shape;
    int option = word_choose(word, option_words, "word for an object", err);
    if (option < 0)
        return false;
    if (option <= OBJECT_MATERIALS)
        return read_material(text, word->place, option == OBJECT_MATERIALS, out, err);
    if (option <= OBJECT_TRANSLATE)
        return read_transform(text, option, out, err);
    if (option >= OBJECT_UNITIZE && shape->kind != SHAPE_MESH)
        return error_at(err, word->place, "%s is for a mesh, not for a %s", option_words[option],
                        shape_name(shape->kind));
    if (!place_once(&out->given[option], word->place, option_words[option], err))
        return false;
    out->object.casts_none = out->object.casts_none || option == OBJECT_CASTS;
    if (option == OBJECT_CASTS)
        return text_choose(text, "'no' behind casts", casts, "word behind casts", err) == 0;
    if (option == OBJECT_REPEAT)
        return text_number(text, "repeat along s", DBL_MIN, HUGE_VAL, &shape->repeat[0], err) &&
               text_number(text, "repeat along t", DBL_MIN, HUGE_VAL, &shape->repeat[1], err);
    if (option == OBJECT_DISPLACE)
        return read_relief(text, shape, err);
    if (option == OBJECT_CREASE)
        return text_number(text, "crease", 0, 180, &shape->crease_deg, err);
    out->object.two_sided = out->object.two_sided || option == OBJECT_TWO_SIDED;
    shape->planar = shape->planar || option == OBJECT_PLANAR;
    shape->unitize = shape->unitize || option == OBJECT_UNITIZE;
    return true;
}

/* Reads the shape and all words after it. */
static bool read_description(struct scene_reader *reader, struct description *out,
                             struct error *err)
{
    struct word word;
    out->object.place = reader->place;
    out->object.material = -1;
    out->object.transform = matrix_identity();
    if (!shape_read(reader->text, &out->object.shape, err))
        return false;
    while (text_word(reader->text, &word))
        if (!read_option(reader->text, &word, out, err))
            return false;
    if (out->given[OBJECT_ROTATE].line > 0)
        reader->scene->doubted_turn = out->given[OBJECT_ROTATE];
    return out->listed || out->given[OBJECT_MATERIAL].line > 0 ||
           out->object.shape.kind == SHAPE_MESH ||
           error_at(err, reader->place,
                    "the object has no material; expected material and its name");
}

void object_free(struct object *object)
{
    shape_free(&object->shape);
    free(object->material_map);
    for (int i = 0; i < object->n_assignments; i++)
        free(object->assignments[i].name);
    free(object->assignments);
    *object = (struct object){.n_assignments = 0};
}

/* Adds a copy of an object, which keeps what it owns. */
static bool add_object(struct scene *scene, const struct object *from, struct error *err)
{
    struct object object = *from;
    object.shape.path = object.shape.relief = object.material_map = NULL;
    if (string_copy(from->shape.path, &object.shape.path, err) &&
        string_copy(from->shape.relief, &object.shape.relief, err) &&
        string_copy(from->material_map, &object.material_map, err) &&
        array_add(&scene->objects, &scene->n_objects, &object, sizeof object, err))
        return true;
    object_free(&object);
    return false;
}

bool object_read(struct scene_reader *reader, struct error *err)
{
    struct description description = {.listed = false};
    bool done = read_description(reader, &description, err) &&
                add_object(reader->scene, &description.object, err);
    object_free(&description.object);
    return done;
}

bool background_read(struct scene_reader *reader, struct error *err)
{
    struct scene *scene = reader->scene;
    const struct object object = {.shape = {.kind = SHAPE_PLANE,
                                            .parameter = {1, 1, 1},
                                            .repeat = {1, 1},
                                            .place = reader->place},
                                  .material = scene->n_materials,
                                  .background = true,
                                  .transform = matrix_identity(),
                                  .place = reader->place};
    struct material material;
    const bool good = material_read_emission(reader->text, &material, err) &&
                      text_end(reader->text, "background SPECTRUM INTENSITY", err);
    return material_keep(scene, &material, good, err) && add_object(scene, &object, err);
}

/* ---- the thesis's grid ---- */

/* Returns the transform of object i of n. The number of objects decides how many rows there are.
 * They are filled from the top left; objects stand 6 units apart before scaling. The thesis's
 * scales are 1, 0.66, 0.5 and 0.333; a smaller one brings all of them into its view, 12 wide and 8
 * high. */
static struct matrix grid_place(int i, int n)
{
    int rows = n <= 3 ? 1 : n <= 8 ? 2 : n <= 15 ? 3 : 4;
    double scale = rows == 1 ? 1 : rows == 2 ? 0.66 : rows == 3 ? 0.5 : 0.333;
    int columns = n / rows + (n % rows != 0);
    scale = fmin(scale, fmin(12 / (6.0 * columns), 8 / (6.0 * rows)));
    struct vector size = {scale, scale, scale};
    struct vector at = {6.0 * (i % columns) - 3.0 * (columns - 1),
                        3.0 * (rows - 1) - 6.0 * (i / columns), 0};
    return matrix_product(matrix_scaling(size), matrix_translation(at));
}

/* Adds the material of a file that a list names; *out is its index. It has no name until it is
 * read. A file that is listed twice is one material. */
static bool add_file(struct scene_reader *reader, const struct word *word, int *out,
                     struct error *err)
{
    struct material material = {.place = word->place};
    struct scene *scene = reader->scene;
    if (!word_file_or_here(word, FILE_MATERIAL, &material.path, err))
        return false;
    const size_t length = strlen(material.path);
    *out = index_find(&reader->listed, material.path, length);
    if (*out >= 0) {
        material_free(&material);
        return true;
    }
    *out = scene->n_materials;
    return material_keep(scene, &material,
                         index_add(&reader->listed, material.path, length, *out, err), err);
}

/* Reads one material file a line, and adds a copy of the pattern with each material. */
static bool add_listed(struct scene_reader *reader, struct text *list, struct object *pattern,
                       struct error *err)
{
    struct word word;
    while (text_next_line(list))
        if (text_peek(*list, &word) && (!text_expect(list, &word, "a material file", err) ||
                                        !text_end(list, "a line of a list", err) ||
                                        !add_file(reader, &word, &pattern->material, err) ||
                                        !add_object(reader->scene, pattern, err)))
            return false;
    return true;
}

/* Adds a copy of the pattern with each sample of a table as its material. */
static bool add_samples(struct scene *scene, const struct text *set, struct object *pattern,
                        struct error *err)
{
    struct spectrum *samples;
    int n;
    bool done = set_read(*set, 1, &samples, &n, err);
    for (int i = 0; done && i < n; i++) {
        struct material material = {.place = text_whole(set), .diffuse = samples[i]};
        samples[i] = (struct spectrum){.kind = SPECTRUM_NONE}; /* taken over */
        done = string_copy(material.diffuse.name, &material.name, err);
        pattern->material = scene->n_materials;
        done = material_keep(scene, &material, done, err) && add_object(scene, pattern, err);
    }
    set_free(samples, n);
    return done;
}

static bool add_grid(struct scene_reader *reader, struct text *list, struct object *pattern,
                     struct error *err)
{
    struct scene *scene = reader->scene;
    int first = scene->n_objects, n;
    if (!(set_is(*list) ? add_samples(scene, list, pattern, err)
                        : add_listed(reader, list, pattern, err)))
        return false;
    n = scene->n_objects - first;
    for (int i = 0; i < n; i++) {
        struct matrix *transform = &scene->objects[first + i].transform;
        *transform = matrix_product(grid_place(i, n), *transform);
        scene->objects[first + i].fit = 2.8;
    }
    return n > 0 || error_at(err, text_whole(list), "no materials; a list names at least one");
}

bool checker_read(struct scene_reader *reader, struct error *err)
{
    struct description description = {.listed = true};
    struct text list = reader->list;
    struct word word;
    bool done = text_expect(reader->text, &word, "a list of material files", err) &&
                (list.path || scene_open(reader->scene, &word, FILE_LIST, &list, err)) &&
                read_description(reader, &description, err) &&
                add_grid(reader, &list, &description.object, err);
    object_free(&description.object);
    return done;
}
