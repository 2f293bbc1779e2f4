/* SPDX-License-Identifier: MIT */
/* Measures whether the passes of a picture show the same triangles: one draws numbers as flat
 * colours from the program's memory, the others draw lit triangles from OpenGL's. */
#include <stdlib.h>
#include <string.h>

#include "raster/beside/measure/inside.h"

enum { CORNERS = 3 * BUFFERED_TRIANGLES };

/* A frustum of a right angle between 1 and 20; turned, and scaled differently along each axis. */
static void place_perspective(struct target *target)
{
    const double up = target->mirrors ? -1 : 1;
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

static void draw_flat(struct target *target, const struct target_corner corners[CORNERS])
{
    target_shade(target, TARGET_FLAT, 0);
    target_show(target, corners, BUFFERED_TRIANGLES);
}

static void draw_lit(struct target *target, const struct target_corner corners[CORNERS])
{
    target_shade(target, TARGET_DIFFUSE, 0);
    target_clear(target);
    target_draw_buffered(target, corners);
    target_read(target);
}

bool measure_passes(struct target *target, struct traits *out, struct error *err)
{
    struct target_corner *corners;
    uint32_t *flat = NULL;
    const bool done = MAKE_ARRAY(corners, CORNERS, err, "corners of triangles") &&
                      MAKE_ARRAY(flat, TARGET * TARGET, err, "depths of a small picture");
    place_perspective(target);
    target->call->DepthFunc(GL_LESS);
    for (int n = 0; done && n < 3; n++) {
        make_triangles(target, corners);
        draw_flat(target, corners);
        memcpy(flat, target->depths, sizeof target->depths);
        draw_lit(target, corners);
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
