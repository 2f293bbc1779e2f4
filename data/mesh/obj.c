/* SPDX-License-Identifier: MIT */
/* Reads the statements of a Wavefront OBJ file: points, texture coordinates, normals and faces. It
 * checks them all, so that the rest of the mesh builder can rely on them. */
#include <float.h>
#include <limits.h>
#include <strings.h>

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

/* Returns whether a word stands for no number, as C libraries write it: nan, -nan(ind), inf,
 * 1.#QNAN, -1.#IND. */
static bool is_no_number(const struct word *word)
{
    const char *at = word->start + strspn(word->start, "+-1.#");
    return word->length >= 3 && (strncasecmp(at, "nan", 3) == 0 || strncasecmp(at, "inf", 3) == 0 ||
                                 strncasecmp(at, "ind", 3) == 0 || strncasecmp(at, "qnan", 4) == 0);
}

/* Reads the numbers of v, vt or vn. Refuses one above the largest single-precision number, which
 * OpenGL could not draw. A word for no number becomes NaN, but not in a position. */
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
        number[n] = (double)NAN;
        if (((form == &forms[OBJ_POINT] && n < 3) || !is_no_number(&word)) &&
            !word_number(&word, "coordinate", -(double)FLT_MAX, (double)FLT_MAX, &number[n], err))
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
        item = isnan(item.x + item.y + item.z) ? (struct vector){0, 0, 0} : vector_normalise(item);
    return array_add(&list->at, &list->n, &item, sizeof item, err);
}

/* ---- f ---- */

/* Reads an index, which counts from 1, or back from -1, the latest item. *out counts from 0. It may
 * be that of an item in a later line. */
static bool read_index(const struct word *word, struct obj *obj, int list, int32_t *out,
                       struct error *err)
{
    const char *item = forms[list].item;
    const int n = obj->list[list].n;
    struct obj_latest *latest = &obj->latest[list];
    long index;
    if (!word_integer(word, item, LONG_MIN, INT32_MAX, &index, err))
        return false;
    if (index == 0)
        return error_at(err, word->place, "%s 0: the first is 1, and the latest -1", item);
    if (index < -n)
        return error_at(err, word->place, "%s %ld does not exist: there are %d before this line",
                        item, index, n);
    *out = (int32_t)(index > 0 ? index - 1 : n + index);
    if (*out >= latest->end)
        *latest = (struct obj_latest){*out + 1, word->place};
    return true;
}

/* Reads a corner: up to three indices between slashes. The later ones may be missing. */
static bool read_corner(const struct word *word, struct obj *obj, struct obj_corner *out,
                        struct error *err)
{
    const char *at = word->start, *end = at + word->length;
    int slashes = 0;
    *out = (struct obj_corner){.index = {-1, -1, -1}, .face = obj->n_faces};
    for (const char *c = at; c < end; c++)
        slashes += *c == '/';
    if (word->quoted || slashes > 2 || at[0] == '/')
        return error_at(err, word->place,
                        "expected a corner, v, v/vt, v//vn or v/vt/vn; found %.*s",
                        word_shown(word), word->start);
    for (int i = OBJ_POINT; i <= slashes; i++) {
        const char *slash = memchr(at, '/', (size_t)(end - at));
        struct word part = *word;
        part.start = at;
        part.length = (size_t)((slash ? slash : end) - at);
        part.place.column += (int)(at - word->start);
        if (part.length > 0 && !read_index(&part, obj, i, &out->index[i], err))
            return false;
        at += part.length + 1;
    }
    return true;
}

/* Reads a face. One of one or two corners is a point or an edge. */
static bool read_face(struct text *text, struct obj *obj, struct error *err)
{
    const int first = obj->n_corners;
    struct obj_corner corner;
    struct word word, opening = {0};
    int n = 0;
    for (; next_word(text, &word); n++) {
        if (!read_corner(&word, obj, &corner, err) ||
            !array_add(&obj->corners, &obj->n_corners, &corner, sizeof corner, err))
            return false;
        if (n == 0)
            opening = word;
        for (int i = OBJ_TEXTURE; i <= OBJ_NORMAL; i++)
            if ((corner.index[i] < 0) != (obj->corners[first].index[i] < 0))
                return error_at(
                    err, word.place,
                    "expected a corner with the same indices as the first one, %.*s; found %.*s",
                    (int)opening.length, opening.start, (int)word.length, word.start);
    }
    if (n == 0)
        return error_at(err, text_place(text), "expected a corner: a face has at least 3");
    if (n > LONGEST_FACE)
        return error_at(err, opening.place,
                        "a face of %d corners; expected at most %d: cut it into several faces", n,
                        LONGEST_FACE);
    const struct obj_face face = {first, n, obj->n_uses - 1};
    return array_add(&obj->faces, &obj->n_faces, &face, sizeof face, err);
}

/* ---- faces, when all items are known ---- */

struct vector obj_point(const struct obj *obj, int corner)
{
    return obj->list[OBJ_POINT].at[obj->corners[corner].index[OBJ_POINT]];
}

/* Finds a usemtl among the names, or adds it. */
static bool find_name(struct obj *obj, const struct word *material, int32_t *out, struct error *err)
{
    *out = index_find(&obj->places, material->start, material->length);
    if (*out >= 0)
        return true;
    *out = obj->n_names;
    char *name = word_copy(material, err);
    if (name && index_add(&obj->places, material->start, material->length, obj->n_names, err) &&
        array_add(&obj->names, &obj->n_names, &name, sizeof name, err))
        return true;
    free(name);
    return false;
}

/* Copies a face's corners to the end of those that are kept, without those that repeat the place of
 * the one before. Returns how many are left. */
static int keep_corners(struct obj *obj, const struct obj_face *face)
{
    const int first = obj->n_corners;
    for (int i = face->first; i < face->first + face->n; i++) {
        struct obj_corner *to = &obj->corners[obj->n_corners];
        *to = obj->corners[i];
        if (obj->n_corners == first ||
            !same_place(obj_point(obj, obj->n_corners - 1), obj_point(obj, obj->n_corners)))
            obj->n_corners++;
    }
    while (obj->n_corners > first + 1 &&
           same_place(obj_point(obj, first), obj_point(obj, obj->n_corners - 1)))
        obj->n_corners--;
    return obj->n_corners - first;
}

/* Some programs write normals of 0 0 0, and coordinates that are no numbers, for "none". */
static void drop_items(struct obj *obj, struct obj_corner *corner)
{
    const struct vector nothing = {0, 0, 0};
    int32_t *normal = &corner->index[OBJ_NORMAL], *at = &corner->index[OBJ_TEXTURE];
    if (*normal >= 0 && same_place(obj->list[OBJ_NORMAL].at[*normal], nothing))
        *normal = -1;
    if (*at >= 0 && isnan(obj->list[OBJ_TEXTURE].at[*at].x + obj->list[OBJ_TEXTURE].at[*at].y))
        *at = -1;
    obj->lacks_normals = obj->lacks_normals || *normal < 0;
}

/* Checks the corners, drops faces that are only a point or an edge, and names the others. */
static bool settle_faces(struct obj *obj, struct error *err)
{
    const int n_faces = obj->n_faces;
    int32_t use = -1, name = -1;
    for (int i = OBJ_POINT; i <= OBJ_NORMAL; i++)
        if (obj->latest[i].end > obj->list[i].n)
            return error_at(err, obj->latest[i].place, "%s %d does not exist: the file has %d",
                            forms[i].item, (int)obj->latest[i].end, obj->list[i].n);
    obj->n_corners = obj->n_faces = 0;
    for (int k = 0; k < n_faces; k++) {
        const struct obj_face face = obj->faces[k];
        const int first = obj->n_corners, n = keep_corners(obj, &face);
        if (n < 3) {
            obj->n_corners = first;
            continue;
        }
        if ((name < 0 || face.name != use) &&
            !find_name(obj, &obj->uses[use = face.name], &name, err))
            return false;
        for (int i = first; i < obj->n_corners; i++) {
            obj->corners[i].face = obj->n_faces;
            drop_items(obj, &obj->corners[i]);
        }
        obj->faces[obj->n_faces++] = (struct obj_face){first, n, name};
    }
    return true;
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
        "cdc",  "cdp",   "shadow_obj", "trace_obj", "res",    "vw",     "t",    NULL};
    return word_find(name, skipped) >= 0;
}

static bool read_statement(struct text *text, const struct word *name, struct obj *obj,
                           struct error *err)
{
    struct word word;
    if (word_is(name, "f") || word_is(name, "fo")) /* its name in the format's first version */
        return read_face(text, obj, err);
    for (int i = OBJ_POINT; i <= OBJ_NORMAL; i++)
        if (word_is(name, forms[i].name))
            return read_item(text, &forms[i], &obj->list[i], err);
    if (word_is(name, "usemtl")) {
        word = (struct word){.start = ""};
        text_rest(text, &word);
        return array_add(&obj->uses, &obj->n_uses, &word, sizeof word, err);
    }
    if (!is_skipped(name))
        return error_at(err, name->place,
                        "unknown statement %.*s; OBJ has v, vt, vn, f, g, o, s, usemtl, mtllib, "
                        "...; put # before it if it draws nothing",
                        word_shown(name), name->start);
    while (next_word(text, &word))
        continue;
    return true;
}

bool obj_read(const char *path, struct place from, struct obj *out, struct error *err)
{
    struct text text;
    struct word name;
    const struct word nameless = {.start = ""};
    *out = (struct obj){.n_faces = 0};
    if (!file_expected(path, from, FILE_MODEL, err) ||
        !text_open(&text, path, from, TEXT_LARGE, err))
        return false;
    bool good = array_add(&out->uses, &out->n_uses, &nameless, sizeof nameless, err);
    while (good && text_next_line(&text))
        good = !next_word(&text, &name) || read_statement(&text, &name, out, err);
    good = good && settle_faces(out, err);
    free(out->uses);
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
