/* SPDX-License-Identifier: MIT */
/* Measures depths, colours and textures inside of triangles, the light at a vertex, and whether the
 * passes of a picture show the same triangles. All measurements, one after the other. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/beside/measure/inside.h"
#include "raster/bounds/bounds.h"

static const double depth_steps = 16777215;

/* ---- depth ---- */

enum { SIDE = 4, MANY = TARGET / SIDE, POINTS = MANY * MANY };

/* Draws a small rectangle like each of these corners, and reads the target. */
static void draw_grid(struct target *target, const struct target_corner like[POINTS])
{
    target_clear(target);
    for (int i = 0; i < POINTS; i++) {
        struct target_corner corners[6];
        const int x = SIDE * (i % MANY), y = SIDE * (i / MANY);
        rectangle_corners(x, y, x + SIDE, y + SIDE, &like[i], corners);
        target_draw(target, corners, 2);
    }
    target_read(target);
}

/* Depths lie on a grid of 1/65536, which single precision holds. */
static void measure_depth(struct target *target, struct traits *out)
{
    struct target_corner like[POINTS];
    for (int i = 0; i < POINTS; i++)
        like[i] = (struct target_corner){
            .position = {0, 0, (float)random_below(target, 65537) / 65536}, .normal = {0, 0, 1}};
    draw_grid(target, like);
    for (int i = 0; i < POINTS; i++) {
        const double off = target_depth(target, SIDE * (i % MANY) + 1, SIDE * (i / MANY) + 1) -
                           (double)like[i].position[2] * depth_steps;
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
    if (target->contexts->way == GL_ES &&
        !contexts_have(target->contexts, "GL_OES_texture_float_linear"))
        return;
    call->GenTextures(1, &name);
    call->BindTexture(GL_TEXTURE_2D, name);
    call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    target_shade(target, TARGET_TEXTURE, 0);
    out->filter_texels = fmax(filter_error(target, true), filter_error(target, false));
    target_shade(target, TARGET_COLOURS, 0);
}

/* ---- the light at a vertex ---- */

/* Returns the red of rectangle i of a grid. */
static double red_of(const struct target *target, int i)
{
    return (double)target->colours[SIDE * (i / MANY) + 1][SIDE * (i % MANY) + 1][0];
}

/* Without GL_NORMALIZE a normal (0, 0, h) gives the highlight h^gloss. Values below `least` may be
 * flushed. */
static void measure_power(struct target *target, double gloss, struct traits *out)
{
    static const double least = 1e-30;
    struct target_corner like[POINTS];
    for (int i = 0; i < POINTS; i++)
        like[i] = (struct target_corner){.position = {0, 0, 0.5F},
                                         .normal = {0, 0, (float)random_in(target, 0.52, 1)}};
    target_shade(target, TARGET_HIGHLIGHT, gloss);
    draw_grid(target, like);
    for (int i = 0; i < POINTS; i++) {
        const double base = (double)like[i].normal[2], expected = power(base, gloss),
                     off = fabs(red_of(target, i) / expected - 1);
        if (expected < least)
            continue;
        out->power_error = fmax(out->power_error, off);
        out->power_ratio = fmax(out->power_ratio, off / pow_error(base, gloss));
    }
}

/* Normals of lengths from 1/1024 to 1024. */
static void measure_normals(struct target *target, struct traits *out)
{
    struct target_corner like[POINTS];
    for (int i = 0; i < POINTS; i++) {
        const double length = ldexp(1, random_below(target, 21) - 10);
        like[i] = (struct target_corner){.position = {0, 0, 0.5F}};
        for (int j = 0; j < 3; j++)
            like[i].normal[j] = (float)(length * random_in(target, j < 2 ? -1 : 0.1, 1));
    }
    target_shade(target, TARGET_DIFFUSE, 0);
    draw_grid(target, like);
    for (int i = 0; i < POINTS; i++) {
        const float *n = like[i].normal;
        const struct vector normal = {(double)n[0], (double)n[1], (double)n[2]};
        const double off = fabs(red_of(target, i) - normal.z / vector_length(normal));
        out->normal_roundings = fmax(out->normal_roundings, off / roundings(1));
    }
}

/* ---- passes ---- */

/* Measures whether the passes of a picture show the same triangles: one draws numbers as flat
 * colours from the program's memory, the others draw lit triangles from OpenGL's. */

enum { CORNERS = 3 * BUFFERED_TRIANGLES };

/* A frustum of a right angle between 1 and 20; turned, and scaled differently along each axis. */
static void place_perspective(struct target *target)
{
    const double up = target->contexts->mirrored ? -1 : 1;
    const double projection[16] = {1, 0, 0,          0,  0, up, 0,          0,
                                   0, 0, -21.0 / 19, -1, 0, 0,  -40.0 / 19, 0},
                 model[16] = {0.96, 0.28, 0.1, 0, -0.25, 0.85, 0.3, 0,
                              0.02, -0.3, 1,   0, 0,     0,    0,   1};
    target_place(target, projection, model);
}

/* Triangles of several sizes; some cross the near plane. */
static void make_triangles(struct target *target, struct target_corner out[CORNERS])
{
    for (int t = 0; t < BUFFERED_TRIANGLES; t++) {
        double middle[3];
        const double size = t % 10 == 0 ? 4 : 0.4;
        for (int j = 0; j < 3; j++)
            middle[j] = random_in(target, j < 2 ? -4 : -12, j < 2 ? 4 : 1);
        for (int i = 3 * t; i < 3 * t + 3; i++)
            for (int j = 0; j < 3; j++) {
                out[i].position[j] = (float)(middle[j] + random_in(target, -size, size));
                out[i].normal[j] = (float)random_in(target, -1, 1);
                out[i].colour[j] = (float)random_in(target, 0, 1);
            }
    }
}

static bool measure_passes(struct target *target, struct traits *out, struct error *err)
{
    struct target_corner *corners;
    uint32_t *flat = NULL;
    const bool done = MAKE_ARRAY(corners, CORNERS, err, "corners of triangles") &&
                      MAKE_ARRAY(flat, TARGET * TARGET, err, "depths of a small picture");
    place_perspective(target);
    target->call->DepthFunc(GL_LESS);
    for (int n = 0; done && n < 3; n++) {
        make_triangles(target, corners);
        target_shade(target, TARGET_FLAT, 0);
        target_show(target, corners, BUFFERED_TRIANGLES);
        memcpy(flat, target->depths, sizeof target->depths);
        target_shade(target, TARGET_DIFFUSE, 0);
        target_clear(target);
        target_draw_buffered(target, corners);
        target_read(target);
        for (int i = 0; i < TARGET * TARGET; i++) {
            const uint32_t lit = target->depths[i / TARGET][i % TARGET];
            out->seen_pixels += (flat[i] & 0xff) > 0;
            out->varying_pixels += lit != flat[i];
        }
    }
    free(corners);
    free(flat);
    return done;
}

/* ---- all of it ---- */

bool traits_measure(struct contexts *contexts, struct traits *out, struct error *err)
{
    static const double gloss[] = {0.3, 1, 2, 10.5, 40, 128};
    struct target *target;
    *out = (struct traits){.subpixel_bits = 0};
    bool done = target_open(contexts, &target, err);
    if (done) {
        target->call->GetIntegerv(GL_SUBPIXEL_BITS, &out->subpixel_bits);
        out->depth_bits = 24; /* those of the buffer that canvas_open makes */
        if (target->contexts->way == GL_WITHOUT_SHADERS)
            target->call->GetIntegerv(GL_DEPTH_BITS, &out->depth_bits);
        measure_coverage(target, out);
        measure_depth(target, out);
        measure_provoking(target, out);
        measure_clamp(target, out);
        measure_interpolation(target, out);
        measure_filter(target, out);
        for (size_t i = 0; i < sizeof gloss / sizeof *gloss; i++)
            measure_power(target, gloss[i], out);
        measure_normals(target, out);
        done = measure_detail(target, out, err);
        target_shade(target, TARGET_COLOURS, 0);
        done = done && measure_passes(target, out, err);
        const GLenum code = target->call->GetError();
        if (done && code != GL_NO_ERROR)
            done = error_failed(err, "OpenGL reports error 0x%04x on small targets", code);
    }
    target_close(target);
    return done;
}

bool driver_measure(struct contexts *contexts, const char *gl_renderer, struct driver *out,
                    struct error *err)
{
    struct canvas *in_use = contexts->current;
    struct traits traits;
    struct error refused = {.status = EXIT_AGREED};
    return traits_measure(contexts, &traits, err) && canvas_use(in_use, in_use->pixels, err) &&
           (traits_profile(&traits, out, &refused) ||
            error_unsupported(err,
                              "%s cannot be checked: %s; spectral drivers --measure prints more",
                              gl_renderer, error_words(&refused)));
}
