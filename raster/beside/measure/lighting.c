/* SPDX-License-Identifier: MIT */
/* Measures the light at a vertex. */
#include <math.h>

#include "data/maths/maths.h"
#include "raster/beside/measure/inside.h"
#include "raster/bounds/bounds.h"

enum { SIDE = 4, MANY = TARGET / SIDE, POINTS = MANY * MANY };

/* Draws a small rectangle for each normal; `seen` gets their red. */
static void light_points(struct target *target, float normals[POINTS][3], double seen[POINTS])
{
    target_clear(target);
    for (int i = 0; i < POINTS; i++) {
        struct target_corner corners[6], like = {.position = {0, 0, 0.5F}};
        const int x = SIDE * (i % MANY), y = SIDE * (i / MANY);
        for (int j = 0; j < 3; j++)
            like.normal[j] = normals[i][j];
        rectangle_corners(x, y, x + SIDE, y + SIDE, &like, corners);
        target_draw(target, corners, 2);
    }
    target_read(target);
    for (int i = 0; i < POINTS; i++)
        seen[i] = (double)target->colours[SIDE * (i / MANY) + 1][SIDE * (i % MANY) + 1][0];
}

/* Without GL_NORMALIZE a normal (0, 0, h) gives the highlight h^gloss. Values below `least` may be
 * flushed. */
static void measure_power(struct target *target, double gloss, struct traits *out)
{
    static const double least = 1e-30;
    float normals[POINTS][3] = {{0}};
    double seen[POINTS];
    for (int i = 0; i < POINTS; i++)
        normals[i][2] = (float)random_in(target, 0.52, 1);
    target_shade(target, TARGET_HIGHLIGHT, gloss);
    light_points(target, normals, seen);
    for (int i = 0; i < POINTS; i++) {
        const double base = (double)normals[i][2], expected = power(base, gloss),
                     off = fabs(seen[i] / expected - 1);
        if (expected < least)
            continue;
        out->power_error = fmax(out->power_error, off);
        out->power_ratio = fmax(out->power_ratio, off / pow_error(base, gloss));
    }
}

/* Normals of lengths from 1/1024 to 1024. */
static void measure_normals(struct target *target, struct traits *out)
{
    float normals[POINTS][3];
    double seen[POINTS];
    for (int i = 0; i < POINTS; i++) {
        const double length = ldexp(1, random_below(target, 21) - 10);
        for (int j = 0; j < 3; j++)
            normals[i][j] = (float)(length * random_in(target, j < 2 ? -1 : 0.1, 1));
    }
    target_shade(target, TARGET_DIFFUSE, 0);
    light_points(target, normals, seen);
    for (int i = 0; i < POINTS; i++) {
        const struct vector normal = {(double)normals[i][0], (double)normals[i][1],
                                      (double)normals[i][2]};
        const double off = fabs(seen[i] - normal.z / vector_length(normal));
        out->normal_roundings = fmax(out->normal_roundings, off / roundings(1));
    }
}

void measure_lighting(struct target *target, struct traits *out)
{
    static const double gloss[] = {0.3, 1, 2, 10.5, 40, 128};
    for (size_t i = 0; i < sizeof gloss / sizeof *gloss; i++)
        measure_power(target, gloss[i], out);
    measure_normals(target, out);
    target_shade(target, TARGET_COLOURS, 0);
}
