/* SPDX-License-Identifier: MIT */
/* Takes the place of all other files of this room in a program without OpenGL. gl_open always
 * fails, so the functions that need an open struct gl are here only to be linked. */
#include <errno.h>

#include "raster/gl/gl.h"

bool gl_is_built(void)
{
    return false;
}

void gl_library(char *out, size_t capacity)
{
    snprintf(out, capacity, "without OpenGL");
}

bool gl_open(const struct plan *plan, int n_buffers, struct gl **out, struct error *err)
{
    (void)plan, (void)n_buffers;
    *out = NULL;
    errno = 0;
    return error_system(err, "this program was built without OpenGL");
}

void gl_close(struct gl *gl)
{
    (void)gl;
}

/* ---- for an open struct gl ---- */

struct gl_names gl_names(const struct gl *gl)
{
    (void)gl;
    return (struct gl_names){"", ""};
}

bool gl_take_scene(struct gl *gl, const struct lit_scene *lit, struct error *err)
{
    (void)gl, (void)lit;
    return error_system(err, "there is no OpenGL");
}

void gl_aim(struct gl *gl, const struct rectangle *tile)
{
    (void)gl, (void)tile;
}

bool gl_draw(struct gl *gl, int buffer, int first_band, double full_scale, struct error *err)
{
    (void)gl, (void)buffer, (void)first_band, (void)full_scale;
    return error_system(err, "there is no OpenGL");
}

const float *gl_pixels(const struct gl *gl, int buffer)
{
    (void)gl, (void)buffer;
    return NULL;
}

bool gl_identify(struct gl *gl, struct error *err)
{
    (void)gl;
    return error_system(err, "there is no OpenGL");
}

struct shown gl_shown(const struct gl *gl, int x, int y)
{
    (void)gl, (void)x, (void)y;
    return (struct shown){-1, -1, 0, 0};
}

struct gl_work gl_work(const struct gl *gl)
{
    (void)gl;
    return (struct gl_work){0, 0};
}
