/* SPDX-License-Identifier: MIT */
/* The words and sizes of shapes in the scene language. */
#include <float.h>

#include "data/mesh/mesh.h"

/* A length lies above 0 and has highest 0. Any other size is a count, which can be refined. A
 * length that is left out is `otherwise` times the first size, the first size itself and a count
 * are just so much. */
struct size {
    const char *name;
    int lowest, highest;
    double otherwise;
};
enum { MOST = MOST_DIVISIONS };

/* A shape's word, and its sizes up to a name that is NULL. */
static const struct form {
    const char *word;
    struct size sizes[5];
} forms[] = {
    [SHAPE_SPHERE] = {"sphere",
                      {{"radius", 0, 0, 1}, {"slices", 3, MOST, 48}, {"stacks", 2, MOST, 24}}},
    [SHAPE_TORUS] =
        {"torus",
         {{"tube", 0, 0, 0.25}, {"ring", 0, 0, 3}, {"sides", 3, MOST, 24}, {"rings", 3, MOST, 48}}},
    [SHAPE_BOX] =
        {"box",
         {{"width", 0, 0, 1}, {"height", 0, 0, 1}, {"depth", 0, 0, 1}, {"divisions", 1, MOST, 1}}},
    [SHAPE_PLANE] = {"plane", {{"width", 0, 0, 1}, {"height", 0, 0, 1}, {"divisions", 1, MOST, 1}}},
    [SHAPE_CYLINDER] = {"cylinder",
                        {{"radius", 0, 0, 1},
                         {"height", 0, 0, 2},
                         {"slices", 3, MOST, 48},
                         {"stacks", 1, MOST, 1}}},
    [SHAPE_CONE] = {"cone",
                    {{"radius", 0, 0, 1},
                     {"height", 0, 0, 2},
                     {"slices", 3, MOST, 48},
                     {"stacks", 1, MOST, 1}}},
    [SHAPE_DISK] = {"disk", {{"radius", 0, 0, 1}, {"slices", 3, MOST, 48}, {"rings", 1, MOST, 1}}},
    [SHAPE_TEAPOT] = {"teapot", {{"size", 0, 0, 1}, {"divisions", 1, MOST_TEAPOT_DIVISIONS, 10}}},
    [SHAPE_MESH] = {"mesh", {{NULL, 0, 0, 0}}},
};
enum { N_SHAPES = SHAPE_MESH + 1 };

const char *shape_name(enum shape_kind kind)
{
    return forms[kind].word;
}

void shape_print_signature(enum shape_kind kind, struct printed *to)
{
    const struct size *sizes = forms[kind].sizes;
    print_text(to, forms[kind].word);
    for (const struct size *size = sizes; size->name; size++)
        if (size == sizes || size->highest > 0)
            print(to, " [%s=%g]", size->name, size->otherwise);
        else if (size->otherwise == 1)
            print(to, " [%s=%s]", size->name, sizes->name);
        else
            print(to, " [%s=%g*%s]", size->name, size->otherwise, sizes->name);
}

struct shape shape_tessellated(const struct shape *shape, double factor)
{
    struct shape out = *shape;
    double *value = out.parameter;
    for (const struct size *size = forms[shape->kind].sizes; size->name; size++, value++)
        if (size->highest > 0)
            *value = fmax(size->lowest, fmin(floor(factor * *value + 0.5), size->highest));
    return out;
}

bool shape_is_solid(enum shape_kind kind)
{
    return kind == SHAPE_SPHERE || kind == SHAPE_TORUS || kind == SHAPE_BOX ||
           kind == SHAPE_CYLINDER || kind == SHAPE_CONE;
}

/* Appends the shape's signature to a message. */
static bool add_signature(enum shape_kind kind, struct error *err)
{
    struct printed signature = {.text = NULL};
    shape_print_signature(kind, &signature);
    char *text = printed_end(&signature);
    const size_t length = strlen(err->text);
    if (text)
        snprintf(err->text + length, sizeof err->text - length, "; expected %s", text);
    free(text);
    return false;
}

static bool read_size(const struct word *word, const struct size *size, double *out,
                      struct error *err)
{
    long count;
    if (size->highest == 0)
        return word_number(word, size->name, DBL_MIN, HUGE_VAL, out, err);
    if (!word_integer(word, size->name, size->lowest, size->highest, &count, err))
        return false;
    *out = (double)count;
    return true;
}

/* Reads the sizes that are given. The first word that begins no number ends them. */
static bool read_sizes(struct text *text, struct shape *out, struct error *err)
{
    const struct size *sizes = forms[out->kind].sizes;
    struct word word;
    bool given = true;
    for (int i = 0; sizes[i].name; i++) {
        given = given && text_peek(*text, &word) && word_begins_number(&word);
        out->parameter[i] =
            sizes[i].otherwise * (i > 0 && sizes[i].highest == 0 ? out->parameter[0] : 1);
        if (given &&
            !(text_word(text, &word) && read_size(&word, &sizes[i], &out->parameter[i], err)))
            return add_signature(out->kind, err);
    }
    if (!given || !text_peek(*text, &word) || !word_begins_number(&word))
        return true;
    error_at(err, word.place, "'%.*s' is one number too many", word_shown(&word), word.start);
    return add_signature(out->kind, err);
}

bool shape_read(struct text *text, struct shape *out, struct error *err)
{
    const char *words[N_SHAPES + 1] = {NULL};
    struct word word;
    *out = (struct shape){.crease_deg = 90, .repeat = {1, 1}, .place = text_next_place(*text)};
    for (int i = 0; i < N_SHAPES; i++)
        words[i] = forms[i].word;
    const int kind = text_choose(text, "a shape", words, "shape", err);
    if (kind < 0)
        return false;
    out->kind = (enum shape_kind)kind;
    if (out->kind != SHAPE_MESH)
        return read_sizes(text, out, err);
    out->place = text_next_place(*text);
    return text_expect(text, &word, "a mesh file", err) &&
           word_file(&word, FILE_MODEL, &out->path, err);
}

void shape_free(struct shape *shape)
{
    FREE_ALL(shape->path, shape->relief);
    *shape = (struct shape){.path = NULL};
}
