/* SPDX-License-Identifier: MIT */
/* The Utah teapot: bicubic Bézier patches. Positions along a seam are computed from the same
 * numbers by the same steps, so that neighbours agree in every bit. */
#include <stdlib.h>

#include "data/mesh/inside.h"

enum { TEAPOT_POINTS = 290 };

/* Cubic Bernstein weights at index/count, and a third of their derivatives. Mirrored indices give
 * mirrored weights in every bit. */
struct bernstein {
    double value[4], slope[4];
};

static struct bernstein bernstein_at(double index, double count)
{
    const double u = index / count, v = (count - index) / count;
    return (struct bernstein){{v * v * v, 3 * (v * v * u), 3 * (u * u * v), u * u * u},
                              {-(v * v), v * v - 2 * (u * v), 2 * (u * v) - u * u, u * u}};
}

/* Returns the sum of the weighted points, in an order that gives the same bits for the reversed
 * curve: patches that share an edge may run along it in opposite directions. */
static struct vector weigh(const struct vector point[4], const double weight[4])
{
    return vector_add(
        vector_add(vector_scale(point[0], weight[0]), vector_scale(point[3], weight[3])),
        vector_add(vector_scale(point[1], weight[1]), vector_scale(point[2], weight[2])));
}

/* Returns the outward normal of a patch whose first row is one point. The tangents there, along the
 * two sides of the patch, span the tangent plane. */
static struct vector pole_normal(const struct vector point[16])
{
    return vector_cross(vector_subtract(point[7], point[0]), vector_subtract(point[4], point[0]));
}

/* Turns the teapot from z up to y up, as in glutSolidTeapot. Adding 0 makes -0 into 0, so that
 * seams agree in that bit, too. */
static struct vector upright(struct vector a)
{
    return (struct vector){a.x + 0.0, a.z + 0.0, 0.0 - a.y};
}

struct vertex teapot_vertex(const struct teapot_patch *patch, double size, double column,
                            double row, double count)
{
    const struct vector *point = patch->point;
    const struct bernstein rows = bernstein_at(row, count), columns = bernstein_at(column, count);
    const bool pole = patch->pole && row == 0;
    struct vector across[4], along[4];
    for (int i = 0; i < 4; i++) {
        across[i] = weigh(&point[4 * i], columns.value);
        along[i] = weigh(&point[4 * i], columns.slope);
    }
    /* Weights add up to 1 within rounding only, but a pole is one exact point. */
    struct vector position = pole ? point[0] : weigh(across, rows.value);
    const struct vector normal =
        pole ? pole_normal(point)
             : vector_cross(weigh(along, rows.value), weigh(across, rows.slope));
    position.z -= 1.5;
    return (struct vertex){vector_scale(upright(position), size / 2),
                           vector_normalise(upright(normal)), 1 - column / count, 1 - row / count};
}

static bool read_patch(struct text *text, const struct vector *points, int n_points,
                       struct teapot_patch *out, struct error *err)
{
    long index, last = -1;
    for (int i = 0; i < 16; i++, last = index) {
        if (!text_integer(text, "point of a patch", 0, n_points - 1, &index, err))
            return false;
        out->point[i] = points[index];
        if (i == 1)
            out->pole = index == last;
    }
    return text_end(text, "a patch", err);
}

static bool read_lines(struct text *text, struct teapot_patch *out, struct error *err)
{
    struct vector points[TEAPOT_POINTS];
    struct word word;
    int n_points = 0, n_patches = 0;
    bool good = true;
    while (good && text_next_line(text)) {
        if (!text_word(text, &word))
            continue;
        if (word_is(&word, "point") && n_points < TEAPOT_POINTS)
            good = text_vector(text, "point", &points[n_points++], err) &&
                   text_end(text, "a point", err);
        else if (n_patches++ < TEAPOT_PATCHES)
            good = read_patch(text, points, n_points, &out[n_patches - 1], err);
    }
    return good && (n_patches == TEAPOT_PATCHES ||
                    error_at(err, text_whole(text), "expected %d patches, found %d", TEAPOT_PATCHES,
                             n_patches));
}

struct teapot_patch *teapot_read(struct place from, struct error *err)
{
    struct teapot_patch *out;
    struct text text;
    if (!MAKE_ARRAY(out, TEAPOT_PATCHES, err, "the teapot"))
        return NULL;
    bool good = text_open(&text, "builtin:models/teapot.txt", from, err);
    if (good) {
        good = read_lines(&text, out, err);
        text_free(&text);
    }
    if (good)
        return out;
    free(out);
    return NULL;
}
