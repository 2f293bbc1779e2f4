/* SPDX-License-Identifier: MIT */
/* Reads the statements of a Wavefront OBJ file: points, texture coordinates, normals and faces.
 * Everything is checked here, so that the rest of the mesh builder can rely on it. */
#include <float.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "mesh.h"

/* A statement's words, over all its continued lines. */
struct statement {
    struct word *words;
    size_t n, room;
    struct place end; /* where a further word would have stood */
};

/* Returns items with room for one more than n, or NULL; doubles, so that reading stays linear. */
static void *with_room(void *items, size_t n, size_t *room, size_t size, struct error *err)
{
    const size_t more = n < 64 ? 64 : 2 * n;

    if (n < *room)
        return items;
    void *grown = n > SIZE_MAX / 2 / size ? NULL : realloc(items, more * size);
    if (grown)
        *room = more;
    else
        error_memory(err);
    return grown;
}

/* ---- words ---- */

/* A backslash before the end of a line continues the statement on the next line. */
static bool take_continuation(const struct text *text, struct word *word)
{
    if (word->quoted || word->start[word->length - 1] != '\\' ||
        word->start + word->length != text->line_end)
        return false;
    word->length--;
    return true;
}

static bool read_words(struct text *text, struct statement *out, struct error *err)
{
    struct word word;
    bool more = true;

    out->n = 0;
    while (more) {
        more = false;
        while (text_word(text, &word)) {
            if (take_continuation(text, &word)) {
                more = true;
                if (word.length == 0)
                    break;
            }
            struct word *words = with_room(out->words, out->n, &out->room, sizeof *words, err);
            if (!words)
                return false;
            out->words = words;
            out->words[out->n++] = word;
        }
        out->end = text_place(text);
        more = more && text_next_line(text);
    }
    return true;
}

/* Reads up to `most` numbers after the keyword, at least `least`; *n tells how many. OpenGL takes
 * single-precision numbers, so larger ones could not be drawn. */
static bool read_numbers(const struct statement *statement, size_t least, size_t most,
                         double *numbers, size_t *n, struct error *err)
{
    const struct word *keyword = &statement->words[0];

    *n = statement->n - 1;
    if (*n < least)
        return error_at(err, statement->end, "expected a number: %.*s takes at least %d",
                        (int)keyword->length, keyword->start, (int)least);
    if (*n > most)
        return error_at(err, statement->words[most + 1].place,
                        "too many numbers: %.*s takes at most %d", (int)keyword->length,
                        keyword->start, (int)most);
    for (size_t i = 0; i < *n; i++)
        if (!word_number(&statement->words[i + 1], "coordinate", -(double)FLT_MAX,
                         (double)FLT_MAX, &numbers[i], err))
            return false;
    return true;
}

static bool full(size_t n, const struct statement *statement, struct error *err)
{
    if (n < INT32_MAX)
        return false;
    error_at(err, statement->words[0].place, "too many: a file has at most %ld of a kind",
             (long)INT32_MAX);
    return true;
}

/* ---- v, vt, vn ---- */

static bool read_point(const struct statement *statement, struct obj *obj, struct error *err)
{
    double number[7]; /* x y z, perhaps w, perhaps red green blue */
    size_t n;

    if (full(obj->n_points, statement, err) ||
        !read_numbers(statement, 3, 7, number, &n, err))
        return false;
    if (n == 5)
        return error_at(err, statement->end,
                        "expected a number: v takes x y z, perhaps w, perhaps red green blue");
    void *points = with_room(obj->points, obj->n_points, &obj->room_points, sizeof *obj->points,
                             err);
    if (!points)
        return false;
    obj->points = points;
    obj->points[obj->n_points++] = (struct vector){number[0], number[1], number[2]};
    return true;
}

static bool read_texture(const struct statement *statement, struct obj *obj, struct error *err)
{
    double number[3] = {0, 0, 0}; /* u, perhaps v, perhaps w */
    size_t n;

    if (full(obj->n_textures, statement, err) ||
        !read_numbers(statement, 1, 3, number, &n, err))
        return false;
    void *textures = with_room(obj->textures, obj->n_textures, &obj->room_textures,
                               sizeof *obj->textures, err);
    if (!textures)
        return false;
    obj->textures = textures;
    obj->textures[obj->n_textures][0] = number[0];
    obj->textures[obj->n_textures++][1] = number[1];
    return true;
}

bool obj_add_normal(struct obj *obj, struct vector normal, struct error *err)
{
    void *normals = with_room(obj->normals, obj->n_normals, &obj->room_normals,
                              sizeof *obj->normals, err);

    if (!normals)
        return false;
    obj->normals = normals;
    obj->normals[obj->n_normals++] = normal;
    return true;
}

static bool read_normal(const struct statement *statement, struct obj *obj, struct error *err)
{
    double number[3];
    size_t n;

    if (full(obj->n_normals, statement, err) ||
        !read_numbers(statement, 3, 3, number, &n, err))
        return false;
    return obj_add_normal(
        obj, vector_normalise((struct vector){number[0], number[1], number[2]}), err);
}

/* ---- f ---- */

/* An index counts from 1, or back from -1, the latest; *out from 0. */
static bool read_index(const struct word *word, const char *what, size_t n, int32_t *out,
                       struct error *err)
{
    long index;

    if (!word_integer(word, what, LONG_MIN, LONG_MAX, &index, err))
        return false;
    if (index == 0)
        return error_at(err, word->place, "%s 0: the first is 1, and the latest -1", what);
    if (index > (long)n || index < -(long)n)
        return error_at(err, word->place, "%s %ld does not exist: there are %ld before this line",
                        what, index, (long)n);
    *out = (int32_t)(index > 0 ? index - 1 : (long)n + index);
    return true;
}

/* Splits a corner at its slashes; returns the number of parts, or 4 when there are more than 3. */
static int split(const struct word *word, struct word part[3])
{
    size_t at = 0;

    for (int n = 0; n < 3; n++) {
        const char *slash = memchr(word->start + at, '/', word->length - at);
        const size_t end = slash ? (size_t)(slash - word->start) : word->length;
        part[n] = *word;
        part[n].start += at;
        part[n].length = end - at;
        part[n].place.column += (int)at;
        if (!slash)
            return n + 1;
        at = end + 1;
    }
    return 4;
}

static bool read_corner(const struct word *word, const struct obj *obj, struct obj_corner *out,
                        struct error *err)
{
    struct word part[3];
    const int n = word->quoted ? 4 : split(word, part);

    *out = (struct obj_corner){-1, -1, -1};
    if (n > 3 || part[0].length == 0 || part[n - 1].length == 0)
        return error_at(err, word->place,
                        "%.*s is no corner; a corner is written v, v/vt, v//vn or v/vt/vn",
                        word->length < 40 ? (int)word->length : 40, word->start);
    if (!read_index(&part[0], "vertex", obj->n_points, &out->point, err))
        return false;
    if (n > 1 && part[1].length > 0 &&
        !read_index(&part[1], "texture coordinate", obj->n_textures, &out->texture, err))
        return false;
    return n < 3 || read_index(&part[2], "normal", obj->n_normals, &out->normal, err);
}

static bool same_place(const struct obj *obj, const struct obj_corner *a,
                       const struct obj_corner *b)
{
    const struct vector *p = &obj->points[a->point], *q = &obj->points[b->point];

    return a->point == b->point || (p->x == q->x && p->y == q->y && p->z == q->z);
}

/* Appends the corner, unless it repeats the place of the face's last one. */
static bool add_corner(struct obj *obj, size_t first, struct obj_corner corner, struct error *err)
{
    void *corners = with_room(obj->corners, obj->n_corners, &obj->room_corners,
                              sizeof *obj->corners, err);

    if (!corners)
        return false;
    obj->corners = corners;
    if (obj->n_corners > first && same_place(obj, &obj->corners[obj->n_corners - 1], &corner))
        return true;
    if (corner.normal >= 0) {
        const struct vector *normal = &obj->normals[corner.normal];
        if (normal->x == 0 && normal->y == 0 && normal->z == 0) /* some writers' "none" */
            corner.normal = -1;
    }
    obj->corners[obj->n_corners++] = corner;
    return true;
}

/* Ends the face that began at `first`; one that is only a point or an edge is forgotten. */
static bool end_face(struct obj *obj, size_t first, struct error *err)
{
    void *ends = with_room(obj->face_ends, obj->n_faces, &obj->room_faces, sizeof *obj->face_ends,
                           err);

    if (!ends)
        return false;
    obj->face_ends = ends;
    while (obj->n_corners > first + 1 &&
           same_place(obj, &obj->corners[first], &obj->corners[obj->n_corners - 1]))
        obj->n_corners--;
    if (obj->n_corners < first + 3)
        obj->n_corners = first;
    else
        obj->face_ends[obj->n_faces++] = (int32_t)obj->n_corners;
    return true;
}

static bool read_face(const struct statement *statement, struct obj *obj, struct error *err)
{
    const size_t first = obj->n_corners;
    struct obj_corner corner, form = {0, 0, 0};

    if (statement->n < 4)
        return error_at(err, statement->end, "expected a corner: a face has at least 3");
    if (full(obj->n_corners + statement->n, statement, err))
        return false;
    for (size_t i = 1; i < statement->n; i++) {
        if (!read_corner(&statement->words[i], obj, &corner, err))
            return false;
        if (i == 1)
            form = corner;
        if ((corner.texture < 0) != (form.texture < 0) || (corner.normal < 0) != (form.normal < 0))
            return error_at(err, statement->words[i].place,
                            "%.*s is not written as the face's first corner, %.*s",
                            (int)statement->words[i].length, statement->words[i].start,
                            (int)statement->words[1].length, statement->words[1].start);
        if (!add_corner(obj, first, corner, err))
            return false;
    }
    return end_face(obj, first, err);
}

/* ---- the file ---- */

/* Known statements that say nothing about polygons. */
static bool is_skipped(const struct word *keyword)
{
    static const char *const skipped[] = {
        "g",      "o",    "s",     "usemtl",     "mtllib",    "usemap", "maplib",   "mg",
        "p",      "l",    "vp",    "cstype",     "deg",       "bmat",   "step",     "curv",
        "curv2",  "surf", "parm",  "trim",       "hole",      "scrv",   "sp",       "end",
        "con",    "lod",  "bevel", "c_interp",   "d_interp",  "ctech",  "stech",    "bsp",
        "bzp",    "cdc",  "cdp",   "shadow_obj", "trace_obj", "res"};

    for (size_t i = 0; i < sizeof skipped / sizeof *skipped; i++)
        if (word_is(keyword, skipped[i]))
            return true;
    return false;
}

static bool read_statement(const struct statement *statement, struct obj *obj, struct error *err)
{
    const struct word *keyword = &statement->words[0];

    if (word_is(keyword, "f"))
        return read_face(statement, obj, err);
    if (word_is(keyword, "v"))
        return read_point(statement, obj, err);
    if (word_is(keyword, "vn"))
        return read_normal(statement, obj, err);
    if (word_is(keyword, "vt"))
        return read_texture(statement, obj, err);
    if (is_skipped(keyword))
        return true;
    return error_at(err, keyword->place,
                    "unknown statement %.*s; OBJ has v, vt, vn, f, g, o, s, usemtl, mtllib, ...",
                    keyword->length < 40 ? (int)keyword->length : 40, keyword->start);
}

bool obj_read(const char *path, struct place from, struct obj *out, struct error *err)
{
    struct statement statement = {.n = 0};
    struct text text;
    bool good = true;

    *out = (struct obj){.n_points = 0};
    if (!text_open(&text, path, from, err))
        return false;
    while (good && text_next_line(&text))
        good = read_words(&text, &statement, err) &&
               (statement.n == 0 || read_statement(&statement, out, err));
    if (good && out->n_faces == 0)
        good = error_at(err, text_whole(&text),
                        "has nothing to draw: no f with three different corners");
    free(statement.words);
    text_free(&text);
    return good;
}

void obj_free(struct obj *obj)
{
    free(obj->points);
    free(obj->normals);
    free(obj->textures);
    free(obj->corners);
    free(obj->face_ends);
    *obj = (struct obj){.n_points = 0};
}
