/* SPDX-License-Identifier: MIT */
/* Objects by shaders: each gets the program of its effects, and the colours of its material. */
#include "raster/beside/shader/inside.h"

enum { POSITION, NORMAL, COORDINATES, NUMBER = NORMAL }; /* the inputs of the vertex shaders */

/* ---- meshes ---- */

/* Lets the next draw calls take their vertices from an instance's mesh. Returns their corners. */
static int bind_mesh(struct shader *shader, int instance)
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

/* ---- where an object lies ---- */

/* Sets a matrix of n x n: 4, or 3 for normals. OpenGL keeps matrices by column, and ignores what a
 * program does not have. */
static void set_matrix(const struct gl_functions *call, int at, const struct matrix *m, int n)
{
    GLfloat columns[16];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            columns[n * j + i] = (GLfloat)m->row[i][j];
    (n == 4 ? call->UniformMatrix4fv : call->UniformMatrix3fv)(at, 1, GL_FALSE, columns);
}

/* Sets the matrix that takes an instance to the tile's clip space. The product is made in double
 * and rounded once: all programs get the same numbers. */
static void place_instance(const struct shader *shader, unsigned program, int instance)
{
    const struct gl_functions *call = shader->base.call;
    const struct instance *placed = &shader->base.plan->instances[instance].instance;
    const struct matrix to_clip =
        matrix_product(drawing_projection(&shader->base), placed->model_view);
    set_matrix(call, call->GetUniformLocation(program, "to_clip"), &to_clip, 4);
    set_matrix(call, call->GetUniformLocation(program, "to_eye"), &placed->model_view, 4);
    set_matrix(call, call->GetUniformLocation(program, "normals"), &placed->normal_matrix, 3);
}

/* ---- drawing ---- */

/* The colours of the frames of a batch: a column of a matrix has those of one frame. Frames that a
 * batch does not have are black. */
typedef GLfloat batch_colours[MOST_AT_ONCE][4];

/* Gives a program the colours of a material. */
static void set_material(const struct shader *shader, unsigned program,
                         const struct shaded_material *shaded, int group,
                         const struct frame_batch *batch)
{
    const struct gl_functions *call = shader->base.call;
    batch_colours constant = {{0}}, diffuse[LIGHTS_PER_PASS] = {{{0}}},
                  specular[LIGHTS_PER_PASS] = {{{0}}};
    struct pass_colours colours = {.n_lights = 0};
    for (int k = 0; k < batch->n; k++) {
        pass_colours(shader->base.plan, shaded, group, batch->first_bands[k],
                     shader->base.lit->full_scale, &colours);
        memcpy(constant[k], colours.constant, sizeof constant[k]);
        for (int i = 0; i < colours.n_lights; i++) {
            memcpy(diffuse[i][k], colours.diffuse[i], sizeof diffuse[i][k]);
            memcpy(specular[i][k], colours.specular[i], sizeof specular[i][k]);
        }
    }
    call->UniformMatrix4fv(call->GetUniformLocation(program, "constant"), 1, GL_FALSE, constant[0]);
    call->UniformMatrix4fv(call->GetUniformLocation(program, "diffuse"), colours.n_lights, GL_FALSE,
                           diffuse[0][0]);
    call->UniformMatrix4fv(call->GetUniformLocation(program, "specular"), colours.n_lights,
                           GL_FALSE, specular[0][0]);
    call->Uniform1f(call->GetUniformLocation(program, "gloss"), (GLfloat)shaded->material->gloss);
}

static bool draw_instance(struct drawing *of, int instance, int group,
                          const struct frame_batch *batch, struct error *err)
{
    struct shader *shader = (struct shader *)of;
    const struct placed_instance *placed = &of->plan->instances[instance];
    const struct shaded_material *shaded = &of->plan->materials[placed->shaded];
    struct program_effects effects = {.group = group,
                                      .shines = has_term(shaded, TERM_SPECULAR),
                                      .two_sided = placed->object->two_sided};
    if (shaded->texture)
        effects.texture = shaded->texture->spectral ? SPECTRAL_TEXTURE : GREY_TEXTURE;
    const unsigned program = program_use(shader, &effects, err);
    if (program == 0)
        return false;
    set_material(shader, program, shaded, group, batch);
    place_instance(shader, program, instance);
    if (shaded->texture)
        texture_bind(of, shaded->texture);
    const int n = bind_mesh(shader, instance);
    of->call->DrawElements(GL_TRIANGLES, n, GL_UNSIGNED_INT, NULL);
    return true;
}

/* ---- numbers ---- */

/* All programs compute positions by the same expression of the same numbers, which is declared
 * invariant. */
static bool begin_numbers(struct drawing *of, struct error *err)
{
    struct shader *shader = (struct shader *)of;
    if (!program_use(shader, NULL, err))
        return false;
    of->call->DisableVertexAttribArray(COORDINATES);
    of->call->BindBuffer(GL_ARRAY_BUFFER, shader->stream);
    return true;
}

static void draw_corners(const struct drawing *of, const struct numbered_vertex *corners, int n)
{
    const struct gl_functions *call = of->call;
    const GLsizei step = sizeof *corners;
    call->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)n * step, corners, GL_STREAM_DRAW);
    call->VertexAttribPointer(POSITION, 3, GL_FLOAT, GL_FALSE, step, NULL);
    call->VertexAttribPointer(NUMBER, 3, GL_FLOAT, GL_FALSE, step,
                              (const void *)sizeof corners->position); /* into the bound buffer */
    call->DrawArrays(GL_TRIANGLES, 0, n);
}

static void place(const struct drawing *of, int instance)
{
    const struct shader *shader = (const struct shader *)of;
    place_instance(shader, shader->programs[0], instance);
}

/* ---- opening ---- */

static bool set_state(struct drawing *of, struct error *err)
{
    struct shader *shader = (struct shader *)of;
    const int n_programs = 1 + VARIANTS * of->plan->n_light_groups;
    GLuint array;
    of->call->GenVertexArrays(1, &array);
    of->call->BindVertexArray(array);
    of->call->EnableVertexAttribArray(POSITION);
    of->call->EnableVertexAttribArray(NORMAL);
    of->call->GenBuffers(1, &shader->stream);
    of->call->Disable(GL_DITHER);
    of->call->Enable(GL_DEPTH_TEST);
    of->call->StencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP);
    return MAKE_ARRAY(shader->programs, n_programs, err, "the shaders");
}

static void close_shader(struct drawing *of)
{
    free(((struct shader *)of)->programs);
}

bool shader_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    static const struct drawing_kind kind = {.size = sizeof(struct shader),
                                             .most_at_once = MOST_AT_ONCE,
                                             .set_state = set_state,
                                             .draw_instance = draw_instance,
                                             .begin_numbers = begin_numbers,
                                             .place = place,
                                             .draw_corners = draw_corners,
                                             .close = close_shader};
    return drawing_open(&kind, plan, n_buffers, out, err);
}
