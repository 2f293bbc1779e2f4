/* SPDX-License-Identifier: MIT */
/* Reads the statements of a Wavefront OBJ file: points, texture coordinates, normals and faces. It
 * checks them all, so that the rest of the mesh builder can rely on them. */
#include <float.h>
#include <limits.h>

#include "data/mesh/inside.h"

/* The statements that fill the lists, and the number of their numbers. */
static const struct list_form {
    const char *name, *item;
    int least, most;
} forms[3] = {[OBJ_POINT] = {"v", "vertex", 3, 7}, /* x y z, perhaps w, perhaps red green blue */
              [OBJ_TEXTURE] = {"vt", "texture coordinate", 1, 3},
              [OBJ_NORMAL] = {"vn", "normal", 3, 3}};

/* Reads the next word of the statement. A backslash at the end of a line continues the statement on
 * the next line. */
static bool next_word(struct text *text, struct word *out)
{
    while (text_word(text, out)) {
        const char *end = out->start + out->length;
        if (out->quoted || end[-1] != '\\' || end != text->line_end)
            return true;
        text_next_line(text);
        if (--out->length > 0)
            return true;
    }
    return false;
}

/* ---- v, vt, vn ---- */

/* Reads the numbers of v, vt or vn. Refuses those above the largest single-precision number, which
 * OpenGL could not draw. */
static bool read_item(struct text *text, const struct list_form *form, struct obj_list *list,
                      struct error *err)
{
    double number[7] = {0};
    struct word word;
    int n = 0;
    for (; next_word(text, &word); n++) {
        if (n == form->most)
            return error_at(err, word.place, "too many numbers: %s takes at most %d", form->name,
                            form->most);
        if (!word_number(&word, "coordinate", -(double)FLT_MAX, (double)FLT_MAX, &number[n], err))
            return false;
    }
    if (n < form->least)
        return error_at(err, text_place(text), "expected a number: %s takes at least %d",
                        form->name, form->least);
    if (n == 5)
        return error_at(err, text_place(text),
                        "expected a number: v takes x y z, perhaps w, perhaps red green blue");
    struct vector item = {number[0], number[1], number[2]};
    if (form == &forms[OBJ_NORMAL])
        item = vector_normalise(item);
    return array_add(&list->at, &list->n, &item, sizeof item, err);
}

/* ---- f ---- */

/* Reads an index, which counts from 1, or back from -1, the latest item. *out counts from 0. */
static bool read_index(const struct word *word, const char *item, int n, int32_t *out,
                       struct error *err)
{
    long index;
    if (!word_integer(word, item, LONG_MIN, LONG_MAX, &index, err))
        return false;
    if (index == 0)
        return error_at(err, word->place, "%s 0: the first is 1, and the latest -1", item);
    if (index > n || index < -n)
        return error_at(err, word->place, "%s %ld does not exist: there are %d before this line",
                        item, index, n);
    *out = (int32_t)(index > 0 ? index - 1 : n + index);
    return true;
}

/* Reads a corner: up to three indices between slashes. The middle one may be missing. */
static bool read_corner(const struct word *word, const struct obj *obj, struct obj_corner *out,
                        struct error *err)
{
    const char *at = word->start, *end = at + word->length;
    int slashes = 0;
    *out = (struct obj_corner){.index = {-1, -1, -1}, .face = obj->n_faces};
    for (const char *c = at; c < end; c++)
        slashes += *c == '/';
    if (word->quoted || slashes > 2 || at[0] == '/' || end[-1] == '/')
        return error_at(err, word->place,
                        "expected a corner, v, v/vt, v//vn or v/vt/vn; found %.*s",
                        word_shown(word), word->start);
    for (int i = OBJ_POINT; i <= slashes; i++) {
        const char *slash = memchr(at, '/', (size_t)(end - at));
        struct word part = *word;
        part.start = at;
        part.length = (size_t)((slash ? slash : end) - at);
        part.place.column += (int)(at - word->start);
        if (part.length > 0 &&
            !read_index(&part, forms[i].item, obj->list[i].n, &out->index[i], err))
            return false;
        at += part.length + 1;
    }
    return true;
}

struct vector obj_point(const struct obj *obj, int corner)
{
    return obj->list[OBJ_POINT].at[obj->corners[corner].index[OBJ_POINT]];
}

/* Appends the corner, unless it repeats the place of the face's last one. */
static bool add_corner(struct obj *obj, int first, struct obj_corner corner, struct error *err)
{
    const struct vector nothing = {0, 0, 0};
    int32_t *normal = &corner.index[OBJ_NORMAL];
    if (*normal >= 0 && same_place(obj->list[OBJ_NORMAL].at[*normal], nothing))
        *normal = -1; /* some programs write 0 0 0 for "none" */
    obj->lacks_normals = obj->lacks_normals || *normal < 0;
    if (!array_add(&obj->corners, &obj->n_corners, &corner, sizeof corner, err))
        return false;
    const int last = obj->n_corners - 1;
    if (last > first && same_place(obj_point(obj, last - 1), obj_point(obj, last)))
        obj->n_corners--;
    return true;
}

/* Finds the current usemtl among the names, or adds it. */
static bool find_name(struct obj *obj, struct error *err)
{
    const struct word *material = &obj->material;
    obj->name = index_find(&obj->places, material->start, material->length);
    if (obj->name >= 0)
        return true;
    obj->name = obj->n_names;
    char *name = word_copy(material, err);
    if (name && index_add(&obj->places, material->start, material->length, obj->n_names, err) &&
        array_add(&obj->names, &obj->n_names, &name, sizeof name, err))
        return true;
    free(name);
    return false;
}

/* Ends the face that began at `first`. Drops it if it is only a point or an edge. */
static bool end_face(struct obj *obj, int first, struct error *err)
{
    while (obj->n_corners > first + 1 &&
           same_place(obj_point(obj, first), obj_point(obj, obj->n_corners - 1)))
        obj->n_corners--;
    if (obj->n_corners < first + 3) {
        obj->n_corners = first;
        return true;
    }
    if (obj->name < 0 && !find_name(obj, err))
        return false;
    const struct obj_face face = {first, obj->n_corners - first, obj->name};
    return array_add(&obj->faces, &obj->n_faces, &face, sizeof face, err);
}

static bool read_face(struct text *text, struct obj *obj, struct error *err)
{
    const int first = obj->n_corners;
    struct obj_corner corner, form = {.face = 0};
    struct word word, opening = {0};
    int n = 0;
    for (; next_word(text, &word); n++) {
        if (!read_corner(&word, obj, &corner, err))
            return false;
        if (n == 0) {
            form = corner;
            opening = word;
        }
        for (int i = OBJ_TEXTURE; i <= OBJ_NORMAL; i++)
            if ((corner.index[i] < 0) != (form.index[i] < 0))
                return error_at(
                    err, word.place,
                    "expected a corner with the same indices as the first one, %.*s; found %.*s",
                    (int)opening.length, opening.start, (int)word.length, word.start);
        if (!add_corner(obj, first, corner, err))
            return false;
    }
    if (n < 3)
        return error_at(err, text_place(text), "expected a corner: a face has at least 3");
    if (n > LONGEST_FACE)
        return error_at(err, opening.place,
                        "a face of %d corners; expected at most %d: cut it into several faces", n,
                        LONGEST_FACE);
    return end_face(obj, first, err);
}

/* ---- the file ---- */

/* Returns whether the statement is a known one that has no effect on polygons. */
static bool is_skipped(const struct word *name)
{
    static const char *const skipped[] = {
        "g",    "o",     "s",          "mtllib",    "usemap", "maplib", "mg",   "p",
        "l",    "vp",    "cstype",     "deg",       "bmat",   "step",   "curv", "curv2",
        "surf", "parm",  "trim",       "hole",      "scrv",   "sp",     "end",  "con",
        "lod",  "bevel", "c_interp",   "d_interp",  "ctech",  "stech",  "bsp",  "bzp",
        "cdc",  "cdp",   "shadow_obj", "trace_obj", "res"};
    for (size_t i = 0; i < sizeof skipped / sizeof *skipped; i++)
        if (word_is(name, skipped[i]))
            return true;
    return false;
}

static bool read_statement(struct text *text, const struct word *name, struct obj *obj,
                           struct error *err)
{
    struct word word;
    if (word_is(name, "f"))
        return read_face(text, obj, err);
    for (int i = OBJ_POINT; i <= OBJ_NORMAL; i++)
        if (word_is(name, forms[i].name))
            return read_item(text, &forms[i], &obj->list[i], err);
    if (word_is(name, "usemtl")) {
        obj->material.length = 0;
        obj->name = -1;
        next_word(text, &obj->material);
    } else if (!is_skipped(name)) {
        return error_at(err, name->place,
                        "unknown statement %.*s; OBJ has v, vt, vn, f, g, o, s, usemtl, mtllib, "
                        "...",
                        word_shown(name), name->start);
    }
    while (next_word(text, &word))
        continue;
    return true;
}

bool obj_read(const char *path, struct place from, struct obj *out, struct error *err)
{
    struct text text;
    struct word name;
    bool good = true;
    *out = (struct obj){.material = {.start = ""}, .name = -1};
    if (!file_expected(path, from, FILE_MODEL, err) || !text_open(&text, path, from, true, err))
        return false;
    while (good && text_next_line(&text))
        good = !next_word(&text, &name) || read_statement(&text, &name, out, err);
    if (good && out->n_faces == 0)
        good = error_at(err, text_whole(&text),
                        "the file has nothing to draw; expected an f with three different corners");
    text_free(&text);
    return good;
}

void obj_free(struct obj *obj)
{
    for (int i = OBJ_POINT; i <= OBJ_NORMAL; i++)
        free(obj->list[i].at);
    for (int i = 0; i < obj->n_names; i++)
        free(obj->names[i]);
    free(obj->names);
    index_free(&obj->places);
    FREE_ALL(obj->corners, obj->faces);
    *obj = (struct obj){.n_faces = 0};
}
