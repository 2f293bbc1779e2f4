/* SPDX-License-Identifier: MIT */
/* Batches of passes: four passes of three bands are drawn at once, in the order in which `draw`
 * will be asked for them. `draw` exchanges its buffer with the one that holds the pass. */
#include <stdlib.h>
#include <string.h>

#include "data/maths/maths.h"
#include "raster/beside/shader/inside.h"

enum { POSITION, NORMAL, COORDINATES, NUMBER = NORMAL }; /* the inputs of the vertex shaders */

/* ---- meshes and textures ---- */

/* Lets the next draw calls take their vertices from an instance's mesh. Returns their corners. */
static int bind_mesh(const struct shader *shader, int instance)
{
    const struct gl_functions *call = shader->base.call;
    const GLsizei step = VERTEX_NUMBERS * sizeof(GLfloat);
    const int n = mesh_bind(&shader->base, instance);
    call->VertexAttribPointer(POSITION, 3, GL_FLOAT, GL_FALSE, step, NULL);
    call->VertexAttribPointer(NORMAL, 3, GL_FLOAT, GL_FALSE, step,
                              (const void *)(3 * sizeof(GLfloat))); /* into the bound buffer */
    call->EnableVertexAttribArray(COORDINATES);
    call->VertexAttribPointer(COORDINATES, 2, GL_FLOAT, GL_FALSE, step,
                              (const void *)(6 * sizeof(GLfloat)));
    return n;
}

/* Lets them show a texture of the plan, which is drawn. */
static void bind_texture(const struct shader *shader, const struct texture *texture)
{
    for (int k = 0; k < (texture->spectral ? shader->base.n_units : 1); k++)
        texture_bind(&shader->base, (int)(texture - shader->base.plan->textures), k);
}

/* Uploads the spectral textures for some passes. */
static bool upload_bands(struct shader *shader, const int *first_bands, int n, struct error *err)
{
    const struct drawing *of = &shader->base;
    for (int i = 0; i < of->plan->n_textures; i++)
        for (int k = 0; k < n; k++) {
            if (!of->textures[i * of->n_units] || !of->plan->textures[i].spectral)
                continue;
            texture_bind(of, i, k);
            if (!texture_upload_bands(of, i, first_bands[k], err))
                return false;
        }
    return true;
}

/* ---- the view ---- */

static void shader_aim(struct renderer *renderer, const struct rectangle *tile)
{
    struct shader *shader = (struct shader *)renderer;
    shader->base.tile = *tile;
    shader->stale = true;
    shader->base.has_shadows = false;
    shader->batch = -1;
    drawing_set_viewport(&shader->base);
}

/* Sets a matrix of n x n: 4, or 3 for normals. OpenGL keeps matrices by column. */
static void set_matrix(const struct shader *shader, int at, const struct matrix *m, int n)
{
    GLfloat columns[16];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            columns[n * j + i] = (GLfloat)m->row[i][j];
    (n == 4 ? shader->base.call->UniformMatrix4fv
            : shader->base.call->UniformMatrix3fv)(at, 1, GL_FALSE, columns);
}

/* Sets the matrix that takes an instance to the tile's clip space. The product is made in double
 * and rounded once: all programs get the same numbers. */
static void place_instance(const struct shader *shader, const struct program *program, int instance)
{
    const struct instance *placed = &shader->base.plan->instances[instance].instance;
    const struct matrix projection =
        pass_projection(shader->base.plan, &shader->base.tile, shader->base.contexts->mirrored);
    const struct matrix to_clip = matrix_product(projection, placed->model_view);
    set_matrix(shader, program->to_clip, &to_clip, 4);
    if (program->to_eye >= 0)
        set_matrix(shader, program->to_eye, &placed->model_view, 4);
    if (program->normals >= 0)
        set_matrix(shader, program->normals, &placed->normal_matrix, 3);
}

/* ---- a material ---- */

/* Gives a program the colours of a material, of passes or of lights and passes, unless it has them.
 * Passes that a batch does not have are black. */
static void set_material(const struct shader *shader, struct program *program, int material,
                         int group)
{
    const struct shaded_material *shaded = &shader->base.plan->materials[material];
    const struct gl_functions *call = shader->base.call;
    const int n = shader->base.n_units;
    GLfloat constant[MOST_PASSES][4] = {{0}}, diffuse[LIGHTS_PER_PASS * MOST_PASSES][4] = {{0}},
            specular[LIGHTS_PER_PASS * MOST_PASSES][4] = {{0}};
    struct pass_colours colours = {.n_lights = 0};
    if (program->material == material && program->batch == shader->n_batches)
        return;
    program->material = material;
    program->batch = shader->n_batches;
    for (int k = 0; k < shader->n_batch; k++) {
        pass_colours(shader->base.plan, shaded, group, shader->order[shader->batch + k],
                     shader->full_scale, &colours);
        memcpy(constant[k], colours.constant, sizeof constant[k]);
        for (int i = 0; i < colours.n_lights; i++) {
            memcpy(diffuse[i * n + k], colours.diffuse[i], sizeof colours.diffuse[i]);
            memcpy(specular[i * n + k], colours.specular[i], sizeof colours.specular[i]);
        }
    }
    call->Uniform4fv(program->constant, n, constant[0]);
    call->Uniform4fv(program->diffuse, colours.n_lights * n, diffuse[0]);
    call->Uniform4fv(program->specular, colours.n_lights * n, specular[0]);
    call->Uniform1f(program->gloss, (GLfloat)shaded->material->gloss);
}

/* ---- drawing ---- */

static struct program_effects effects_of(const struct shader *shader, int instance, int group)
{
    const struct plan *plan = shader->base.plan;
    const struct placed_instance *placed = &plan->instances[instance];
    const struct shaded_material *shaded = &plan->materials[placed->shaded];
    const bool textured = texture_is_drawn(plan, shaded->texture);
    struct program_effects out = {.group = group,
                                  .shines = has_term(shaded, TERM_SPECULAR),
                                  .two_sided = placed->object->two_sided};
    out.texture = !textured                   ? UNTEXTURED
                  : shaded->texture->spectral ? SPECTRAL_TEXTURE
                                              : GREY_TEXTURE;
    return out;
}

static bool draw_instance(struct shader *shader, int instance, int group, struct error *err)
{
    const struct placed_instance *placed = &shader->base.plan->instances[instance];
    const struct program_effects effects = effects_of(shader, instance, group);
    struct program *program = program_use(shader, &effects, err);
    if (!program)
        return false;
    set_material(shader, program, placed->shaded, group);
    place_instance(shader, program, instance);
    if (effects.texture != UNTEXTURED)
        bind_texture(shader, shader->base.plan->materials[placed->shaded].texture);
    shader->base.call->FrontFace(
        placed->instance.mirrored != shader->base.contexts->mirrored ? GL_CW : GL_CCW);
    const int n = bind_mesh(shader, instance);
    shader->base.call->DrawElements(GL_TRIANGLES, n, GL_UNSIGNED_INT, NULL);
    shader->base.renderer.work.draw_calls++;
    return true;
}

/* ---- identifying ---- */

static void draw_corners(struct drawing *of, const struct numbered_vertex *corners, int n)
{
    const struct gl_functions *call = of->call;
    const GLsizei step = sizeof *corners;
    call->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)n * step, corners, GL_STREAM_DRAW);
    call->VertexAttribPointer(POSITION, 3, GL_FLOAT, GL_FALSE, step, NULL);
    call->VertexAttribPointer(NUMBER, 3, GL_FLOAT, GL_FALSE, step,
                              (const void *)sizeof corners->position); /* into the bound buffer */
    call->DrawArrays(GL_TRIANGLES, 0, n);
}

static void place(struct drawing *of, int instance)
{
    const struct shader *shader = (const struct shader *)of;
    place_instance(shader, &shader->numbers, instance);
}

static const struct numbered_draw by_numbers = {place, draw_corners};

/* Finds the shadows of the tile. */
static bool draw_shadows(struct shader *shader, struct error *err)
{
    if (!program_use(shader, NULL, err))
        return false;
    shader->base.call->DisableVertexAttribArray(COORDINATES);
    shader->base.call->BindBuffer(GL_ARRAY_BUFFER, shader->stream);
    return shadows_draw(&shader->base, &by_numbers, err);
}

/* Lets the first n buffers of colours be drawn. */
static void choose_colours(const struct shader *shader, int n)
{
    GLenum colours[MOST_PASSES];
    for (int i = 0; i < n; i++)
        colours[i] = GL_COLOR_ATTACHMENT0 + (GLenum)i;
    shader->base.call->DrawBuffers(n, colours);
}

/* Finds which triangle OpenGL shows at each pixel, as raster/gl does. All programs compute
 * positions by the same expression of the same numbers, which is declared invariant. */
static bool shader_identify(struct renderer *renderer, struct error *err)
{
    struct shader *shader = (struct shader *)renderer;
    if (!program_use(shader, NULL, err))
        return false;
    drawing_clear(&shader->base, &shader->stale);
    choose_colours(shader, 1);
    shader->base.call->Enable(GL_STENCIL_TEST);
    shader->base.call->DisableVertexAttribArray(COORDINATES);
    shader->base.call->BindBuffer(GL_ARRAY_BUFFER, shader->stream);
    const bool done = numbers_draw(&shader->base, &by_numbers, err);
    shader->base.call->Disable(GL_STENCIL_TEST);
    choose_colours(shader, shader->base.n_units);
    canvas_read(shader->canvas, 0, shader->base.shown);
    drawing_read_depths(&shader->base);
    return done && functions_succeeded(shader->base.call, err);
}

/* ---- colours ---- */

static bool draw_batch(struct shader *shader, int first, struct error *err)
{
    struct drawing *of = &shader->base;
    const struct plan *plan = of->plan;
    const int left = shader->n_order - first;
    shader->batch = first;
    shader->n_batch = left < of->n_units ? left : of->n_units;
    if ((plan->view.n_shadowed > 0 && !of->has_shadows && !draw_shadows(shader, err)) ||
        !upload_bands(shader, shader->order + first, shader->n_batch, err))
        return false;
    for (int group = 0; group < plan->n_light_groups; group++) {
        if (!group_is_drawn(plan, group))
            continue;
        shader->n_batches++;
        drawing_clear(&shader->base, &shader->stale);
        for (int i = 0; i < plan->n_instances; i++)
            if (surface_reaches(&of->lit->bounds[i], &of->tile) &&
                !draw_instance(shader, i, group, err))
                return false;
        of->renderer.work.passes++;
        for (int k = 0; k < shader->n_batch; k++) {
            canvas_read(shader->canvas, k, group == 0 ? shader->ready[k] : of->part);
            if (group > 0)
                pass_add(plan, of->part, shadows_of(of, group), shader->ready[k]);
        }
    }
    return functions_succeeded(of->call, err);
}

static bool shader_expect(struct renderer *renderer, const int *first_bands, int n,
                          struct error *err)
{
    struct shader *shader = (struct shader *)renderer;
    if (!MAKE_ARRAY(shader->order, n, err, "%d passes", n))
        return false;
    memcpy(shader->order, first_bands, (size_t)n * sizeof *first_bands);
    shader->n_order = n;
    return true;
}

static bool shader_draw(struct renderer *renderer, int buffer, int first_band, double full_scale,
                        struct error *err)
{
    struct shader *shader = (struct shader *)renderer;
    int place = 0;
    while (place < shader->n_order && shader->order[place] != first_band)
        place++;
    shader->full_scale = full_scale;
    if ((shader->batch < 0 || place < shader->batch || place >= shader->batch + shader->n_batch) &&
        !draw_batch(shader, place, err))
        return false;
    float **ready = &shader->ready[place - shader->batch], *pixels = *ready;
    *ready = shader->base.renderer.buffers[buffer];
    shader->base.renderer.buffers[buffer] = pixels;
    return true;
}

/* ---- opening ---- */

/* Sets the state that no pass changes. */
static void set_state(struct shader *shader)
{
    const struct gl_functions *call = shader->base.call;
    GLuint array;
    call->GenVertexArrays(1, &array);
    call->BindVertexArray(array);
    call->EnableVertexAttribArray(0);
    call->EnableVertexAttribArray(1);
    call->GenBuffers(1, &shader->stream);
    call->Disable(GL_DITHER);
    call->Enable(GL_DEPTH_TEST);
    call->DepthFunc(GL_LESS);
    call->ClearColor(0, 0, 0, 0);
    call->StencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP);
}

static bool open_all(struct shader *shader, int n_buffers, struct error *err)
{
    struct drawing *of = &shader->base;
    const size_t n = 4 * (size_t)of->plan->tile_width * (size_t)of->plan->tile_height;
    for (int i = 0; i < of->n_units; i++)
        if (!MAKE_ARRAY(shader->ready[i], n, err, "the pixels of a tile"))
            return false;
    if (!MAKE_ARRAY(shader->programs, VARIANTS * of->plan->n_light_groups, err, "the shaders") ||
        !drawing_open(of, n_buffers, err) ||
        !drawing_canvas(of, 32, of->n_units, &shader->canvas, err) ||
        !canvas_use(shader->canvas, shader->ready[0], err))
        return false;
    /* depths can be read by OpenGL, and by OpenGL ES with an extension */
    of->renderer.lacks.depths = of->plan->options.check && of->plan->options.gl_way == GL_ES &&
                                !contexts_have(of->contexts, "GL_NV_read_depth_stencil");
    if (of->renderer.lacks.depths) {
        free(of->depths);
        of->depths = NULL;
    }
    set_state(shader);
    return drawing_accept(of, err) && functions_succeeded(of->call, err);
}

static void shader_close(struct renderer *renderer)
{
    struct shader *shader = (struct shader *)renderer;
    canvas_close(shader->canvas);
    for (int i = 0; i < MOST_PASSES; i++)
        free(shader->ready[i]);
    FREE_ALL(shader->programs, shader->order);
    drawing_close(&shader->base);
}

bool shader_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    static const struct renderer_kind kind = {.take_scene = drawing_take_scene,
                                              .aim = shader_aim,
                                              .expect = shader_expect,
                                              .draw = shader_draw,
                                              .identify = shader_identify,
                                              .shown = drawing_shown,
                                              .close = shader_close};
    struct shader *shader;
    *out = NULL;
    if (!MAKE_ARRAY(shader, 1, err, "a renderer"))
        return false;
    *out = &shader->base.renderer;
    shader->base.renderer.kind = &kind;
    shader->base.plan = plan;
    shader->base.n_units = plan->n_passes < MOST_PASSES ? plan->n_passes : MOST_PASSES;
    shader->batch = -1;
    return open_all(shader, n_buffers, err);
}
