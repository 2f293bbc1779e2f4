/* SPDX-License-Identifier: MIT */
/* A small picture to draw known triangles on. */
#include <math.h>
#include <stdlib.h>

#include "raster/traits/traits.h"

/* Window coordinates become clip coordinates by products and sums that single precision does not
 * round for corners on a grid of 1/65536 pixel. */
static void load_window(const struct target *target)
{
    const double up = target->mirrors ? -1 : 1;
    const GLdouble columns[16] = {2.0 / TARGET,
                                  0,
                                  0,
                                  0,
                                  0,
                                  -up * 2 / TARGET,
                                  0,
                                  0, /* x, y */
                                  0,
                                  0,
                                  2,
                                  0,
                                  -1,
                                  up,
                                  -1,
                                  1};
    target->call->MatrixMode(GL_PROJECTION);
    target->call->LoadMatrixd(columns);
    target->call->MatrixMode(GL_MODELVIEW);
    target->call->LoadIdentity();
    target->call->Viewport(0, 0, TARGET, TARGET);
}

static void set_state(const struct target *target)
{
    const struct gl_functions *call = target->call;
    call->ClampColorARB(GL_CLAMP_VERTEX_COLOR_ARB, GL_FALSE);
    call->ClampColorARB(GL_CLAMP_FRAGMENT_COLOR_ARB, GL_FALSE);
    call->ClampColorARB(GL_CLAMP_READ_COLOR_ARB, GL_FALSE);
    call->Disable(GL_DITHER);
    call->Enable(GL_DEPTH_TEST);
    call->DepthFunc(GL_ALWAYS);
    call->Enable(GL_STENCIL_TEST);
    call->StencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP);
    call->ShadeModel(GL_SMOOTH);
    call->ClearColor(0, 0, 0, 0);
    call->EnableClientState(GL_VERTEX_ARRAY);
    call->EnableClientState(GL_COLOR_ARRAY);
    load_window(target);
}

bool target_open(struct contexts *contexts, struct target **out, struct error *err)
{
    const struct canvas_size size = {32, TARGET, TARGET, 1};
    struct target *target = calloc(1, sizeof *target);
    *out = target;
    if (!target)
        return error_memory(err);
    if (!canvas_open(contexts, &size, &target->canvas, err) ||
        !canvas_use(target->canvas, target->colours, err))
        return false;
    target->call = contexts_functions(contexts);
    target->flipped = contexts_flipped(contexts);
    target->mirrors = contexts_mirrored(contexts);
    target->random = 1;
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

void target_draw(const struct target *target, const struct target_corner *corners, int n_triangles)
{
    const struct gl_functions *call = target->call;
    call->VertexPointer(3, GL_FLOAT, sizeof *corners, corners->position);
    call->ColorPointer(3, GL_FLOAT, sizeof *corners, corners->colour);
    call->NormalPointer(GL_FLOAT, sizeof *corners, corners->normal);
    call->TexCoordPointer(2, GL_FLOAT, sizeof *corners, corners->s_t);
    call->DrawArrays(GL_TRIANGLES, 0, 3 * n_triangles);
}

void target_read(struct target *target)
{
    canvas_fill(target->canvas);
    target->call->ReadPixels(0, 0, TARGET, TARGET, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8,
                             target->depths);
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
