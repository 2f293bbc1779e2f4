/* SPDX-License-Identifier: MIT */
/* Passes: OpenGL 1.x lighting of the aimed tile. Three wavelengths ride in the red, green and blue
 * of a pass; each channel is lit by itself, so that a pass is three exact single-wavelength
 * renderings.
 *
 * A pass has eight lights. More lights take more passes, whose colours are added here; each pass
 * draws everything anew, so that all show the same surfaces. A pass changes colours only. */
#include <stdlib.h>
#include <string.h>

#include "raster/gl/inside.h"

struct gl {
    struct drawing base;    /* the first member */
    struct canvas *colours; /* numbers are drawn there, too, where `numbers` is NULL */
    struct canvas *numbers; /* of floats, where `colours` has steps */
    uint8_t *steps;         /* pixels of uint8_t or uint16_t, where `colours` has steps */
    bool is_stale[2]; /* of `colours` and `numbers`: the buffer holds colours of another tile */
    struct canvas *current;
    /* the state of `colours`, which is set only where it changes: */
    int group;               /* the group of lights that is placed; -1: none */
    struct pass_colours set; /* colours of lights and of a material */
    float gloss;             /* of the last material that shines; -1: none did */
    bool two_sided, mirrored;
    const struct texture *texture; /* NULL: textures are switched off */
};

static const GLfloat white[4] = {1, 1, 1, 1}, black[4] = {0, 0, 0, 1};

/* ---- the view ---- */

/* Replaces the current matrix of OpenGL. OpenGL keeps matrices by column. */
static void load_matrix(const struct gl_functions *call, const struct matrix *m)
{
    GLdouble columns[16];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            columns[4 * j + i] = m->row[i][j];
    call->LoadMatrixd(columns);
}

/* Loads projection and viewport of the aimed tile. */
static void load_view(const struct gl *gl)
{
    const struct gl_functions *call = gl->base.call;
    const struct matrix projection =
        pass_projection(gl->base.plan, &gl->base.tile, gl->base.contexts->mirrored);
    call->MatrixMode(GL_PROJECTION);
    load_matrix(call, &projection);
    call->MatrixMode(GL_MODELVIEW);
    drawing_set_viewport(&gl->base);
}

static void gl_aim(struct renderer *renderer, const struct rectangle *tile)
{
    struct gl *gl = (struct gl *)renderer;
    gl->base.tile = *tile;
    gl->is_stale[0] = gl->is_stale[1] = true;
    gl->base.has_shadows = false;
    load_view(gl);
}

/* ---- canvases: floats, or counts of 8, 10 or 16 bits ---- */

static bool check_canvas(const struct gl *gl, int needed_bits, struct error *err)
{
    GLint red_bits = 0, depth_bits = 0, stencil_bits = 0;
    gl->base.call->GetIntegerv(GL_RED_BITS, &red_bits);
    gl->base.call->GetIntegerv(GL_DEPTH_BITS, &depth_bits);
    gl->base.call->GetIntegerv(GL_STENCIL_BITS, &stencil_bits);
    return (red_bits == needed_bits && depth_bits >= 24 && stencil_bits >= 8) ||
           error_unsupported(err,
                             "%s gives %d bits of colour, %d of depth and %d of stencil; %d, 24 "
                             "and 8 are needed%s",
                             gl->base.contexts->name, red_bits, depth_bits, stencil_bits,
                             needed_bits, needed_bits == 10 ? "; --gl egl may have them" : "");
}

/* Makes OpenGL draw into these floats from now on; NULL: into steps. `numbers`: not colours. Each
 * type of buffer has a context of its own. One context for both would work, but OSMesa of
 * Mesa 22.3.6 would make new buffers at every change, and keep the old ones. */
static bool draw_into(struct gl *gl, float *floats, bool numbers, struct error *err)
{
    struct canvas *canvas = numbers && gl->numbers ? gl->numbers : gl->colours;
    if (!canvas_use(canvas, floats ? floats : (void *)gl->steps, err))
        return false;
    if (gl->current == canvas)
        return true;
    gl->current = canvas;
    if (gl->base.lit)
        load_view(gl);
    return check_canvas(gl, floats ? 32 : gl->base.plan->options.buffer_bits, err);
}

/* ---- meshes and textures; a spectral texture gets its texels anew for each pass ---- */

/* The next draw call takes its vertices from an instance's mesh. Returns how many. */
static int bind_mesh(const struct gl *gl, int instance)
{
    const GLsizei step = VERTEX_NUMBERS * sizeof(GLfloat);
    const int n = mesh_bind(&gl->base, instance);
    gl->base.call->VertexPointer(3, GL_FLOAT, step, NULL); /* offsets into the bound buffer */
    gl->base.call->NormalPointer(GL_FLOAT, step, (const void *)(3 * sizeof(GLfloat)));
    if (gl->texture)
        gl->base.call->TexCoordPointer(2, GL_FLOAT, step, (const void *)(6 * sizeof(GLfloat)));
    return n;
}

static void switch_textures(const struct gl *gl, bool on)
{
    (on ? gl->base.call->Enable : gl->base.call->Disable)(GL_TEXTURE_2D);
    (on ? gl->base.call->EnableClientState
        : gl->base.call->DisableClientState)(GL_TEXTURE_COORD_ARRAY);
}

/* The next draw calls show a texture of the plan; NULL: none. */
static void bind_texture(struct gl *gl, const struct texture *texture)
{
    const struct texture *drawn = texture_is_drawn(gl->base.plan, texture) ? texture : NULL;
    if (!drawn != !gl->texture)
        switch_textures(gl, drawn != NULL);
    if (drawn && drawn != gl->texture)
        texture_bind(&gl->base, (int)(texture - gl->base.plan->textures), 0);
    gl->texture = drawn;
}

/* Loads and uploads all spectral textures for the bands of a pass. */
static bool upload_bands(struct gl *gl, int first_band, struct error *err)
{
    for (int i = 0; i < gl->base.plan->n_textures; i++) {
        const struct texture *texture = &gl->base.plan->textures[i];
        if (!gl->base.textures[i] || !texture->spectral)
            continue;
        bind_texture(gl, texture);
        if (!texture_upload_bands(&gl->base, i, first_band, err))
            return false;
    }
    return true;
}

/* ---- state ---- */

/* Sets the state of a new context that no pass changes. Clamps are off: colours may exceed 1 on
 * their way through a triangle (Mesa clamps vertex colours by default, even for float buffers). */
static void set_state(const struct gl *gl)
{
    const struct gl_functions *call = gl->base.call;
    call->ClampColorARB(GL_CLAMP_VERTEX_COLOR_ARB, GL_FALSE);
    call->ClampColorARB(GL_CLAMP_FRAGMENT_COLOR_ARB, GL_FALSE);
    call->ClampColorARB(GL_CLAMP_READ_COLOR_ARB, GL_FALSE);
    call->Disable(GL_DITHER);
    call->Enable(GL_DEPTH_TEST);
    call->DepthFunc(GL_LESS);
    call->ShadeModel(gl->base.plan->scene->shading == SHADING_FLAT ? GL_FLAT : GL_SMOOTH);
    call->Enable(GL_NORMALIZE);
    call->Enable(GL_LIGHTING);
    call->LightModelfv(GL_LIGHT_MODEL_AMBIENT, white);
    call->LightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, gl->base.plan->scene->local_viewer);
    call->Materialfv(GL_FRONT_AND_BACK, GL_DIFFUSE, white);
    call->Materialfv(GL_FRONT_AND_BACK, GL_EMISSION, black);
    call->ClearColor(0, 0, 0, 0);
    if (gl->base.plan->options.check)
        call->StencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP); /* for gl_identify */
    if (gl->base.contexts->mirrored)
        call->FrontFace(GL_CW);
    call->MatrixMode(GL_MODELVIEW);
    call->EnableClientState(GL_VERTEX_ARRAY);
    call->EnableClientState(GL_NORMAL_ARRAY);
}

static void place_light(const struct gl *gl, GLenum name, const struct eye_light *light,
                        const struct light *source)
{
    const struct gl_functions *call = gl->base.call;
    struct vector at = light->position, axis = light->axis;
    GLfloat position[4] = {(GLfloat)at.x, (GLfloat)at.y, (GLfloat)at.z,
                           source->directional ? 0.0F : 1.0F};
    GLfloat direction[3] = {(GLfloat)axis.x, (GLfloat)axis.y, (GLfloat)axis.z};
    static const GLenum attenuations[] = {GL_CONSTANT_ATTENUATION, GL_LINEAR_ATTENUATION,
                                          GL_QUADRATIC_ATTENUATION};
    call->Enable(name);
    call->Lightfv(name, GL_AMBIENT, black);
    call->Lightfv(name, GL_POSITION, position);
    for (int i = 0; i < 3; i++)
        call->Lightf(name, attenuations[i], (GLfloat)light->attenuation[i]);
    call->Lightf(name, GL_SPOT_CUTOFF, light->spot ? (GLfloat)source->spot_cutoff_deg : 180.0F);
    call->Lightf(name, GL_SPOT_EXPONENT, light->spot ? (GLfloat)source->spot_exponent : 0.0F);
    if (light->spot)
        call->Lightfv(name, GL_SPOT_DIRECTION, direction);
}

/* Places the lights of a group, in eye coordinates, unless they are placed already. */
static void place_lights(struct gl *gl, int group)
{
    if (gl->group == group)
        return;
    gl->group = group;
    gl->base.call->LoadIdentity();
    const struct light_group lights = light_group(gl->base.plan, group);
    for (int i = 0; i < LIGHTS_PER_PASS; i++) {
        const int light = lights.first + i;
        if (i < lights.n && !gl->base.plan->is_idle[light])
            place_light(gl, GL_LIGHT0 + (GLenum)i, &gl->base.plan->lights[light],
                        gl->base.plan->sources[light]);
        else if (gl->base.plan->n_light_groups > 1)
            gl->base.call->Disable(GL_LIGHT0 + (GLenum)i);
    }
}

/* ---- drawing ---- */

/* Returns whether a colour is not the one that OpenGL has, which it becomes. */
static bool is_new(const float colour[4], float set[4])
{
    const bool differs = memcmp(colour, set, 4 * sizeof *set) != 0;
    memcpy(set, colour, 4 * sizeof *set);
    return differs;
}

static void set_material(struct gl *gl, const struct shaded_material *shaded, int group,
                         int first_band, double full_scale)
{
    const struct gl_functions *call = gl->base.call;
    struct pass_colours colours, *set = &gl->set;
    const int first = light_group(gl->base.plan, group).first;
    pass_colours(gl->base.plan, shaded, group, first_band, full_scale, &colours);
    const float gloss = colours.shines ? (float)shaded->material->gloss : gl->gloss;
    for (int i = 0; i < colours.n_lights; i++) {
        const bool idle = gl->base.plan->is_idle[first + i];
        if (!idle && is_new(colours.diffuse[i], set->diffuse[i]))
            call->Lightfv(GL_LIGHT0 + (GLenum)i, GL_DIFFUSE, colours.diffuse[i]);
        if (!idle && colours.shines && is_new(colours.specular[i], set->specular[i]))
            call->Lightfv(GL_LIGHT0 + (GLenum)i, GL_SPECULAR, colours.specular[i]);
    }
    if (is_new(colours.constant, set->constant))
        call->Materialfv(GL_FRONT_AND_BACK, GL_AMBIENT, colours.constant);
    if (colours.shines != set->shines)
        call->Materialfv(GL_FRONT_AND_BACK, GL_SPECULAR, colours.shines ? white : black);
    if (gloss != gl->gloss)
        call->Materialf(GL_FRONT_AND_BACK, GL_SHININESS, gloss);
    set->shines = colours.shines;
    gl->gloss = gloss;
    bind_texture(gl, shaded->texture);
}

static void draw_instance(struct gl *gl, int instance)
{
    const struct gl_functions *call = gl->base.call;
    const struct placed_instance *placed = &gl->base.plan->instances[instance];
    const int n = bind_mesh(gl, instance);
    if (gl->two_sided != placed->object->two_sided)
        call->LightModeli(GL_LIGHT_MODEL_TWO_SIDE, placed->object->two_sided);
    if (gl->mirrored != placed->instance.mirrored)
        call->FrontFace(placed->instance.mirrored != gl->base.contexts->mirrored ? GL_CW : GL_CCW);
    gl->two_sided = placed->object->two_sided;
    gl->mirrored = placed->instance.mirrored;
    load_matrix(gl->base.call, &placed->instance.model_view);
    call->DrawElements(GL_TRIANGLES, n, GL_UNSIGNED_INT, NULL);
}

/* Draws up to BANDS_PER_PASS bands, lit by one group of lights. */
static void draw_pass(struct gl *gl, int group, int first_band, double full_scale)
{
    const struct plan *plan = gl->base.plan;
    int shaded = -1;
    drawing_clear(&gl->base, &gl->is_stale[gl->current != gl->colours]);
    place_lights(gl, group);
    for (int i = 0; i < plan->n_instances; i++) {
        const struct placed_instance *placed = &plan->instances[i];
        if (!surface_reaches(&gl->base.lit->bounds[i], &gl->base.tile))
            continue;
        if (placed->shaded != shaded)
            set_material(gl, &plan->materials[placed->shaded], group, first_band, full_scale);
        shaded = placed->shaded;
        draw_instance(gl, i);
        gl->base.renderer.work.draw_calls++;
    }
    canvas_fill(gl->current);
    gl->base.renderer.work.passes++;
}

/* ---- identifying ---- */

static void draw_batch(struct drawing *of, const struct numbered_vertex *corners, int n)
{
    of->call->VertexPointer(3, GL_FLOAT, sizeof *corners, corners->position);
    of->call->ColorPointer(3, GL_FLOAT, sizeof *corners, corners->number);
    of->call->DrawArrays(GL_TRIANGLES, 0, n);
}

static void place(struct drawing *of, int instance)
{
    load_matrix(of->call, &of->plan->instances[instance].instance.model_view);
}

/* Draws all instances in their numbers; or instead finds the shadows that they throw. */
static bool draw_instances(struct gl *gl, bool shadows, struct error *err)
{
    static const struct numbered_draw by = {place, draw_batch};
    const struct gl_functions *call = gl->base.call;
    const bool is_smooth = gl->base.plan->scene->shading != SHADING_FLAT;
    if (gl->current == gl->colours) /* `numbers` never has a texture */
        bind_texture(gl, NULL);
    call->Disable(GL_LIGHTING);
    if (is_smooth)
        call->ShadeModel(GL_FLAT);
    if (!shadows) {
        drawing_clear(&gl->base, &gl->is_stale[gl->current != gl->colours]);
        call->Enable(GL_STENCIL_TEST);
    }
    call->BindBuffer(GL_ARRAY_BUFFER, 0);
    call->DisableClientState(GL_NORMAL_ARRAY);
    call->EnableClientState(GL_COLOR_ARRAY);
    const bool done =
        shadows ? shadows_draw(&gl->base, &by, err) : numbers_draw(&gl->base, &by, err);
    call->DisableClientState(GL_COLOR_ARRAY);
    call->EnableClientState(GL_NORMAL_ARRAY);
    call->Disable(GL_STENCIL_TEST);
    call->Enable(GL_LIGHTING);
    if (is_smooth)
        call->ShadeModel(GL_SMOOTH);
    return done;
}

/* Finds which triangle OpenGL shows at each pixel, its depth, and how many fragments OpenGL has
 * drawn there: draws all instances once more, with their numbers as flat colours, while the stencil
 * counts fragments, hidden ones too. Corners, order and matrices are the same, so OpenGL must show
 * the same triangles as in colour (section 2.22 of the OpenGL 2.1 specification, invariance). */
static bool gl_identify(struct renderer *renderer, struct error *err)
{
    struct gl *gl = (struct gl *)renderer;
    if (!draw_into(gl, gl->base.shown, true, err) || !draw_instances(gl, false, err))
        return false;
    canvas_fill(gl->current);
    drawing_read_depths(&gl->base);
    if (!functions_succeeded(gl->base.call, err))
        return false;
    /* OSMesa fills the buffer once more when another context becomes current */
    return !gl->numbers || draw_into(gl, NULL, false, err);
}

/* ---- colours ---- */

/* Finds the shadows of the tile, with the depths of the canvas of colours. */
static bool draw_shadows(struct gl *gl, struct error *err)
{
    const bool done = draw_into(gl, gl->steps ? NULL : gl->base.part, false, err) &&
                      draw_instances(gl, true, err);
    gl->mirrored = false; /* shadows_draw leaves it so */
    return done;
}

static bool gl_draw(struct renderer *renderer, int buffer, int first_band, double full_scale,
                    struct error *err)
{
    struct gl *gl = (struct gl *)renderer;
    float *sum = gl->base.renderer.buffers[buffer];
    if (gl->base.plan->view.n_shadowed > 0 && !gl->base.has_shadows && !draw_shadows(gl, err))
        return false;
    for (int group = 0; group < gl->base.plan->n_light_groups; group++) {
        float *pixels = group == 0 ? sum : gl->base.part;
        if (!group_is_drawn(gl->base.plan, group))
            continue;
        if (!draw_into(gl, gl->steps ? NULL : pixels, false, err) ||
            (group == 0 && !upload_bands(gl, first_band, err)))
            return false;
        draw_pass(gl, group, first_band, full_scale);
        if (gl->steps)
            pass_convert(gl->base.plan, gl->steps, pixels);
        if (group > 0)
            pass_add(gl->base.plan, gl->base.part, shadows_of(&gl->base, group), sum);
    }
    return functions_succeeded(gl->base.call, err);
}

/* ---- opening ---- */

static bool open_canvases(struct gl *gl, int n_buffers, struct error *err)
{
    const struct plan *plan = gl->base.plan;
    const bool steps = buffer_steps(plan) > 0;
    const size_t n = (size_t)plan->tile_width * (size_t)plan->tile_height;
    return (!steps || MAKE_ARRAY(gl->steps, n * (plan->options.buffer_bits > 8 ? 8 : 4), err,
                                 "the pixels of a tile")) &&
           drawing_open(&gl->base, n_buffers, err) &&
           drawing_canvas(&gl->base, steps ? plan->options.buffer_bits : 32, 1, &gl->colours,
                          err) &&
           (!steps || !plan->options.check ||
            drawing_canvas(&gl->base, 32, 1, &gl->numbers, err)) &&
           draw_into(gl, steps ? NULL : gl->base.renderer.buffers[0], false, err) &&
           drawing_accept(&gl->base, err);
}

static void gl_close(struct renderer *renderer)
{
    struct gl *gl = (struct gl *)renderer;
    canvas_close(gl->numbers);
    canvas_close(gl->colours);
    free(gl->steps);
    drawing_close(&gl->base);
}

bool gl_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    static const struct renderer_kind kind = {.take_scene = drawing_take_scene,
                                              .aim = gl_aim,
                                              .draw = gl_draw,
                                              .identify = gl_identify,
                                              .shown = drawing_shown,
                                              .close = gl_close};
    struct gl *gl;
    *out = NULL;
    if (!MAKE_ARRAY(gl, 1, err, "a renderer"))
        return false;
    *out = &gl->base.renderer;
    gl->base.renderer.kind = &kind;
    gl->base.plan = plan;
    gl->base.n_units = 1;
    gl->group = -1;
    gl->gloss = -1;
    if (!open_canvases(gl, n_buffers, err))
        return false;
    set_state(gl);
    if (!gl->numbers)
        return functions_succeeded(gl->base.call, err);
    if (!functions_succeeded(gl->base.call, err) || !draw_into(gl, gl->base.shown, true, err))
        return false;
    set_state(gl);
    return functions_succeeded(gl->base.call, err) &&
           draw_into(gl, NULL, false, err); /* for uploads */
}
