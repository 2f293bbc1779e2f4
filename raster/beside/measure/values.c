/* SPDX-License-Identifier: MIT */
/* Measures depths, colours and textures inside of triangles. */
#include <math.h>

#include "raster/beside/measure/inside.h"

static const double depth_steps = 16777215;

/* ---- depth ---- */

/* A grid of rectangles with depths on a grid of 1/65536, which single precision holds. */
static void measure_depth(struct target *target, struct traits *out)
{
    enum { SIDE = 4, MANY = TARGET / SIDE };
    double depth[MANY][MANY];
    target_clear(target);
    for (int y = 0; y < MANY; y++)
        for (int x = 0; x < MANY; x++) {
            struct target_corner corners[6], like = {.normal = {0, 0, 1}};
            depth[y][x] = random_below(target, 65537) / 65536.0;
            like.position[2] = (float)depth[y][x];
            rectangle_corners(SIDE * x, SIDE * y, SIDE * (x + 1), SIDE * (y + 1), &like, corners);
            target_draw(target, corners, 2);
        }
    target_read(target);
    for (int y = 0; y < MANY; y++)
        for (int x = 0; x < MANY; x++) {
            const double off =
                target_depth(target, SIDE * x + 1, SIDE * y + 1) - depth[y][x] * depth_steps;
            out->depth_low = fmin(out->depth_low, off);
            out->depth_high = fmax(out->depth_high, off);
        }
}

/* ---- colours ---- */

static void measure_provoking(struct target *target, struct traits *out)
{
    struct target_corner corners[3] = {{{8, 8, 0.5F}, {1, 0, 0}, {0, 0, 1}, {0, 0}},
                                       {{8, 80, 0.5F}, {0, 1, 0}, {0, 0, 1}, {0, 0}},
                                       {{80, 80, 0.5F}, {0, 0, 1}, {0, 0, 1}, {0, 0}}};
    target_shade(target, TARGET_FLAT, 0);
    target_show(target, corners, 1);
    target_shade(target, TARGET_COLOURS, 0);
    const float *seen = target->colours[60][20];
    out->provoking = seen[0] == 1 ? 0 : seen[1] == 1 ? 1 : 2;
}

static void measure_clamp(struct target *target, struct traits *out)
{
    const struct target_corner like = {.position = {0, 0, 0.5F}, .colour = {2, -1, 3.5F}};
    struct target_corner corners[6];
    rectangle_corners(0, 0, TARGET, TARGET, &like, corners);
    target_show(target, corners, 2);
    const float *seen = target->colours[TARGET / 2][TARGET / 2];
    out->clamps =
        seen[0] != like.colour[0] || seen[1] != like.colour[1] || seen[2] != like.colour[2];
}

/* A value that is straight across a triangle. */
struct plane {
    double x, y, at_origin;
    double area; /* twice that of the triangle; positive where it is drawn clockwise */
};

static struct plane plane_of(const struct target_corner c[3], int channel)
{
    const double x0 = (double)c[0].position[0], y0 = (double)c[0].position[1],
                 dx1 = (double)c[1].position[0] - x0, dy1 = (double)c[1].position[1] - y0,
                 dx2 = (double)c[2].position[0] - x0, dy2 = (double)c[2].position[1] - y0,
                 q = (double)c[0].colour[channel], q1 = (double)c[1].colour[channel] - q,
                 q2 = (double)c[2].colour[channel] - q, area = dx1 * dy2 - dx2 * dy1;
    struct plane out = {(q1 * dy2 - q2 * dy1) / area, (q2 * dx1 - q1 * dx2) / area, 0, area};
    out.at_origin = q - out.x * x0 - out.y * y0;
    return out;
}

static void compare_plane(const struct target *target, const struct target_corner corners[3],
                          int channel, struct traits *out)
{
    const struct plane plane = plane_of(corners, channel);
    const double slope = fabs(plane.x) + fabs(plane.y);
    if (slope < 1.0 / TARGET)
        return;
    for (int y = 0; y < TARGET; y++)
        for (int x = 0; x < TARGET; x++)
            if (target_fragments(target, x, y) > 0) {
                const double expected = plane.x * (x + 0.5) + plane.y * (y + 0.5) + plane.at_origin;
                const double off = fabs((double)target->colours[y][x][channel] - expected);
                out->value_px = fmax(out->value_px, off / slope);
            }
}

/* Triangles with some area, and values with some slope, so that roundings of the set-up stay small
 * beside a pixel. */
static void measure_interpolation(struct target *target, struct traits *out)
{
    for (int n = 0; n < 60;) {
        struct target_corner corners[3] = {{.position = {0, 0, 0}}};
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                corners[i].position[j] = j < 2 ? (float)random_in(target, 0, TARGET) : 0.5F;
                corners[i].colour[j] = (float)random_in(target, 0, 1);
            }
        if (fabs(plane_of(corners, 0).area) < 0.2 * TARGET * TARGET)
            continue;
        target_show(target, corners, 1);
        for (int channel = 0; channel < 3; channel++)
            compare_plane(target, corners, channel, out);
        n++;
    }
}

/* ---- textures ---- */

/* Draws from the centre of a texel of 0 nine tenths of the way to the centre of one of 1: linear
 * filtering gives the part of the way, which lies on no grid of a power of two. */
static double filter_error(struct target *target, bool across)
{
    static const GLfloat texels[6] = {0, 0, 0, 1, 1, 1};
    struct target_corner corners[6], like = {.position = {0, 0, 0.5F}, .colour = {1, 1, 1}};
    double largest = 0;
    target->call->TexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F_ARB, across ? 2 : 1, across ? 1 : 2, 0,
                             GL_RGB, GL_FLOAT, texels);
    rectangle_corners(0, 0, TARGET, TARGET, &like, corners);
    for (int i = 0; i < 6; i++)
        corners[i].s_t[!across] = corners[i].position[!across] > 0 ? 0.7F : 0.25F;
    target_show(target, corners, 2);
    for (int y = 0; y < TARGET; y++)
        for (int x = 0; x < TARGET; x++) {
            const double expected = 0.9 * ((across ? x : y) + 0.5) / TARGET;
            largest = fmax(largest, fabs((double)target->colours[y][x][0] - expected));
        }
    return largest;
}

/* An OpenGL ES that does not filter floats gets no linear textures. */
static void measure_filter(struct target *target, struct traits *out)
{
    const struct gl_functions *call = target->call;
    GLuint name;
    if (target->way == GL_ES && !contexts_have(target->contexts, "GL_OES_texture_float_linear"))
        return;
    call->GenTextures(1, &name);
    call->BindTexture(GL_TEXTURE_2D, name);
    call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    target_shade(target, TARGET_TEXTURE, 0);
    out->filter_texels = fmax(filter_error(target, true), filter_error(target, false));
    target_shade(target, TARGET_COLOURS, 0);
}

void measure_values(struct target *target, struct traits *out)
{
    measure_depth(target, out);
    measure_provoking(target, out);
    measure_clamp(target, out);
    measure_interpolation(target, out);
    measure_filter(target, out);
}
