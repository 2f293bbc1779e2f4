/* SPDX-License-Identifier: MIT */
/* All renderers through OpenGL do this: they aim at a tile, draw the numbers of its triangles and
 * its shadows once, and a batch of frames at a time, each of three bands, and each group of lights
 * by itself. */
#include "raster/gl/inside.h"

/* ---- a tile ---- */

struct matrix drawing_projection(const struct drawing *of)
{
    return pass_projection(of->plan, &of->tile, of->contexts->mirrored);
}

/* A smaller tile lies in the first rows of the buffer. */
static void load_view(const struct drawing *of)
{
    const int below = of->plan->tile_height - of->tile.height;
    if (of->kind->project)
        of->kind->project(of);
    of->call->Viewport(0, of->contexts->kind->flipped ? 0 : below, of->tile.width, of->tile.height);
}

static void frame_aim(struct renderer *renderer, const struct rectangle *tile)
{
    struct drawing *of = (struct drawing *)renderer;
    of->tile = *tile;
    of->colours->is_stale = true;
    if (of->numbers)
        of->numbers->is_stale = true;
    of->has_shadows = false;
    load_view(of);
}

/* Each type of buffer has a context of its own. One context for both would work, but OSMesa of
 * Mesa 22.3.6 would make new buffers at every change, and keep the old ones. */
bool frame_begin(struct drawing *of, float *floats, bool numbers, struct error *err)
{
    struct canvas *canvas = numbers && of->numbers ? of->numbers : of->colours;
    const bool is_current = of->contexts->current == canvas;
    if (!canvas_use(canvas, canvas->bits < 32 ? (void *)of->steps : floats, err))
        return false;
    if (of->lit && !is_current)
        load_view(of);
    return true;
}

/* Empties all depths, and colours of another tile: each pass of a tile draws the same pixels. */
static void clear(const struct drawing *of)
{
    struct canvas *canvas = of->contexts->current;
    const GLbitfield colours = canvas->is_stale ? GL_COLOR_BUFFER_BIT : 0;
    of->call->Clear(colours | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    canvas->is_stale = false;
}

void turn_fronts(struct drawing *of, bool mirrored)
{
    const GLenum front = mirrored != of->contexts->mirrored ? GL_CW : GL_CCW;
    if (of->front != front)
        of->call->FrontFace(front);
    of->front = front;
}

/* ---- numbers ---- */

/* Draws all instances in their numbers; or instead finds the shadows that they throw, with the
 * depths of the canvas of colours. */
static bool draw_numbers(struct drawing *of, bool shadows, struct error *err)
{
    if (!frame_begin(of, shadows ? of->part : of->shown, !shadows, err) ||
        !of->kind->begin_numbers(of, err))
        return false;
    if (!shadows) {
        clear(of);
        of->call->Enable(GL_STENCIL_TEST);
    }
    const bool done = shadows ? shadows_draw(of, err) : numbers_draw(of, err);
    of->call->Disable(GL_STENCIL_TEST);
    if (of->kind->end_numbers)
        of->kind->end_numbers(of);
    return done;
}

/* Finds which triangle OpenGL shows at each pixel, its depth, and how many fragments OpenGL has
 * drawn there: draws all instances once more, with their numbers as flat colours, while the stencil
 * counts fragments, hidden ones too. Corners, order and matrices are the same, so OpenGL must show
 * the same triangles as in colour (section 2.22 of the OpenGL 2.1 specification, invariance). */
static bool frame_identify(struct renderer *renderer, struct error *err)
{
    struct drawing *of = (struct drawing *)renderer;
    if (!draw_numbers(of, false, err))
        return false;
    of->contexts->kind->fill(of->contexts->current, 0, of->shown);
    if (!of->renderer.lacks.depths)
        of->call->ReadPixels(0, 0, of->plan->tile_width, of->plan->tile_height, GL_DEPTH_STENCIL,
                             GL_UNSIGNED_INT_24_8, of->depths);
    if (!functions_succeeded(of->call, err))
        return false;
    /* OSMesa fills the buffer once more when another context becomes current */
    return !of->numbers || frame_begin(of, NULL, false, err);
}

static struct shown frame_shown(const struct renderer *renderer, int x, int y)
{
    const struct drawing *of = (const struct drawing *)renderer;
    const size_t width = (size_t)of->plan->tile_width,
                 row = (size_t)(of->contexts->kind->flipped ? y : of->plan->tile_height - 1 - y);
    return shown_of(of->plan->n_instances, of->shown + 4 * ((size_t)y * width + (size_t)x),
                    of->depths[row * width + (size_t)x]);
}

/* ---- colours ---- */

static bool draw_group(struct drawing *of, int group, const struct frame_batch *batch,
                       struct error *err)
{
    clear(of);
    for (int i = 0; i < of->plan->n_instances; i++) {
        if (!surface_reaches(&of->lit->bounds[i], &of->tile))
            continue;
        if (!of->kind->draw_instance(of, i, group, batch, err))
            return false;
        of->renderer.work.draw_calls++;
    }
    of->renderer.work.passes++;
    return true;
}

/* Converts steps of a colour buffer to parts of full scale, which is `whole` of them. 10 bits are
 * read as 16. */
static void convert_steps(const void *steps, uint32_t whole, size_t n, float *pixels)
{
    const uint16_t *words = steps;
    const uint8_t *bytes = steps;
    const bool wide = whole > UINT8_MAX;
    for (size_t i = 0; i < n; i++)
        pixels[i] = (float)(wide ? (words[i] * whole + UINT16_MAX / 2) / UINT16_MAX : bytes[i]) /
                    (float)whole;
}

/* Puts the colours of a group of lights into a buffer, or adds them there, where the group reaches
 * the pixel. */
static void add_group(const struct drawing *of, int group, int colours, float *sum)
{
    const size_t n = 4 * (size_t)of->plan->tile_width * (size_t)of->plan->tile_height;
    const uint8_t *reached = shadows_of(of, group);
    float *pixels = group == 0 ? sum : of->part;
    of->contexts->kind->fill(of->contexts->current, colours,
                             of->steps ? (void *)of->steps : pixels);
    if (of->steps)
        convert_steps(of->steps, (uint32_t)buffer_steps(of->plan), n, pixels);
    for (size_t i = 0; i < n && group > 0; i++)
        if (!reached || reached[i / 4])
            sum[i] += pixels[i];
}

static bool frame_draw(struct renderer *renderer, const struct frame_batch *batch,
                       struct error *err)
{
    struct drawing *of = (struct drawing *)renderer;
    float *const *buffers = of->renderer.buffers;
    if (of->plan->view.n_shadowed > 0 && !of->has_shadows && !draw_numbers(of, true, err))
        return false;
    for (int group = 0; group < of->plan->n_light_groups; group++) {
        if (!group_is_drawn(of->plan, group))
            continue;
        if (!frame_begin(of, group == 0 ? buffers[batch->buffers[0]] : of->part, false, err) ||
            (group == 0 && !textures_upload_bands(of, batch, err)) ||
            !draw_group(of, group, batch, err))
            return false;
        for (int i = 0; i < batch->n; i++)
            add_group(of, group, i, buffers[batch->buffers[i]]);
    }
    return functions_succeeded(of->call, err);
}

/* ---- the renderer ---- */

static void frame_close(struct renderer *renderer)
{
    struct drawing *of = (struct drawing *)renderer;
    if (of->kind->close)
        of->kind->close(of);
    contexts_close(of->contexts);
    FREE_ALL(of->objects, of->indices, of->textures, of->part, of->shown, of->steps, of->depths,
             of->reached, of->counts);
    renderer_free(renderer);
}

const struct renderer_kind drawing_renderer = {.take_scene = drawing_take_scene,
                                               .aim = frame_aim,
                                               .draw = frame_draw,
                                               .identify = frame_identify,
                                               .shown = frame_shown,
                                               .close = frame_close};
