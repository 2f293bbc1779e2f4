/* SPDX-License-Identifier: MIT */
/* A small picture to draw known triangles on. */
#include <stdlib.h>

#include "raster/beside/measure/inside.h"

/* Window coordinates become clip coordinates by products and sums that single precision does not
 * round for corners on a grid of 1/65536 pixel. */
static void place_window(struct target *target)
{
    static const double none[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double up = target->mirrors ? -1 : 1, side = 2.0 / TARGET;
    const double columns[16] = {side, 0, 0, 0, 0, -up * side, 0, 0, 0, 0, 2, 0, -1, up, -1, 1};
    target_place(target, columns, none);
}

static void set_state(struct target *target)
{
    const struct gl_functions *call = target->call;
    call->Disable(GL_DITHER);
    call->Enable(GL_DEPTH_TEST);
    call->DepthFunc(GL_ALWAYS);
    call->Enable(GL_STENCIL_TEST);
    call->StencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP);
    call->ClearColor(0, 0, 0, 0);
    call->GenBuffers(2, target->buffers);
    call->Viewport(0, 0, TARGET, TARGET);
    place_window(target);
    target_shade(target, TARGET_COLOURS, 0);
}

bool target_open(struct contexts *contexts, struct target **out, struct error *err)
{
    const struct canvas_size size = {32, TARGET, TARGET, 1};
    struct target *target;
    *out = NULL;
    if (!MAKE_ARRAY(target, 1, err, "a small picture"))
        return false;
    *out = target;
    if (!canvas_open(contexts, &size, &target->canvas, err) ||
        !canvas_use(target->canvas, target->colours, err))
        return false;
    target->call = &contexts->call;
    target->contexts = contexts;
    target->way = contexts->way;
    target->flipped = contexts->flipped;
    target->mirrors = contexts->mirrored;
    target->random = 1;
    if (target->way == GL_ES && !contexts_have(contexts, "GL_NV_read_depth_stencil"))
        return error_unsupported(err, "this OpenGL ES cannot read depths, which measurements need");
    if (!target_prepare(target, err))
        return false;
    set_state(target);
    return true;
}

void target_close(struct target *target)
{
    if (target)
        canvas_close(target->canvas);
    free(target);
}

void target_clear(struct target *target)
{
    target->call->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
}

/* OpenGL without lighting of its own takes corners from buffers only. */
void target_draw(const struct target *target, const struct target_corner *corners, int n_triangles)
{
    const struct gl_functions *call = target->call;
    const bool buffered = target->way != GL_WITHOUT_SHADERS;
    const GLsizeiptr size = 3 * (GLsizeiptr)n_triangles * (GLsizeiptr)sizeof *corners;
    if (buffered) {
        call->BindBuffer(GL_ARRAY_BUFFER, target->buffers[0]);
        call->BufferData(GL_ARRAY_BUFFER, size, corners, GL_STREAM_DRAW);
    }
    target_point(target, buffered ? NULL : corners);
    call->DrawArrays(GL_TRIANGLES, 0, 3 * n_triangles);
}

void target_draw_buffered(const struct target *target, const struct target_corner *corners)
{
    enum { CORNERS = 3 * BUFFERED_TRIANGLES };
    const struct gl_functions *call = target->call;
    GLuint indices[CORNERS];
    for (int i = 0; i < CORNERS; i++)
        indices[i] = (GLuint)i;
    call->BindBuffer(GL_ARRAY_BUFFER, target->buffers[0]);
    call->BufferData(GL_ARRAY_BUFFER, CORNERS * (GLsizeiptr)sizeof *corners, corners,
                     GL_STATIC_DRAW);
    call->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, target->buffers[1]);
    call->BufferData(GL_ELEMENT_ARRAY_BUFFER, CORNERS * (GLsizeiptr)sizeof *indices, indices,
                     GL_STATIC_DRAW);
    target_point(target, NULL);
    call->DrawElements(GL_TRIANGLES, CORNERS, GL_UNSIGNED_INT, NULL);
    call->BindBuffer(GL_ARRAY_BUFFER, 0);
    call->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);
}

void target_read(struct target *target)
{
    canvas_fill(target->canvas);
    target->call->ReadPixels(0, 0, TARGET, TARGET, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8,
                             target->depths);
}

void target_show(struct target *target, const struct target_corner *corners, int n_triangles)
{
    target_clear(target);
    target_draw(target, corners, n_triangles);
    target_read(target);
}

static uint32_t depth_stencil(const struct target *target, int x, int y)
{
    return target->depths[target->flipped ? y : TARGET - 1 - y][x];
}

uint32_t target_depth(const struct target *target, int x, int y)
{
    return depth_stencil(target, x, y) >> 8;
}

int target_fragments(const struct target *target, int x, int y)
{
    return (int)(depth_stencil(target, x, y) & 0xff);
}

/* Knuth's constants of MMIX. */
static uint32_t random_bits(struct target *target)
{
    target->random = target->random * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(target->random >> 33);
}

double random_in(struct target *target, double low, double high)
{
    return low + (high - low) * random_bits(target) / 2147483648.0;
}

int random_below(struct target *target, int n)
{
    return (int)(random_bits(target) % (uint32_t)n);
}

void rectangle_corners(double left, double top, double right, double bottom,
                       const struct target_corner *like, struct target_corner out[6])
{
    static const int order[6] = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i < 6; i++) {
        out[i] = *like;
        out[i].position[0] = (float)(order[i] == 0 || order[i] == 3 ? left : right);
        out[i].position[1] = (float)(order[i] < 2 ? bottom : top);
    }
}
