/* SPDX-License-Identifier: MIT */
/* Passes: OpenGL 1.x lighting of the aimed tile. Three wavelengths ride in the red, green and blue
 * of a pass; each channel is lit by itself, so that a pass is three exact single-wavelength
 * renderings.
 *
 * A pass has eight lights. More lights take more passes, whose colours frame.c adds; each pass
 * draws everything anew, so that all show the same surfaces. A pass changes colours only. */
#include "raster/gl/inside.h"

struct gl {
    struct drawing base; /* the first member */
    /* the state of the canvas of colours, which is set only where it changes: */
    int group;               /* the group of lights that is placed; -1: none */
    struct pass_colours set; /* colours of lights and of a material */
    float gloss;             /* of the last material that shines; -1: none did */
    bool two_sided, textured;
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

static void project(const struct drawing *of)
{
    const struct matrix projection = drawing_projection(of);
    of->call->MatrixMode(GL_PROJECTION);
    load_matrix(of->call, &projection);
    of->call->MatrixMode(GL_MODELVIEW);
}

static void place(const struct drawing *of, int instance)
{
    load_matrix(of->call, &of->plan->instances[instance].instance.model_view);
}

/* ---- textures ---- */

static void switch_textures(struct gl *gl, bool on)
{
    const struct gl_functions *call = gl->base.call;
    if (on != gl->textured) {
        (on ? call->Enable : call->Disable)(GL_TEXTURE_2D);
        (on ? call->EnableClientState : call->DisableClientState)(GL_TEXTURE_COORD_ARRAY);
    }
    gl->textured = on;
}

/* ---- state ---- */

static bool check_canvas(const struct drawing *of, struct error *err)
{
    const int needed_bits = of->contexts->current->bits;
    GLint red_bits = 0, depth_bits = 0, stencil_bits = 0;
    of->call->GetIntegerv(GL_RED_BITS, &red_bits);
    of->call->GetIntegerv(GL_DEPTH_BITS, &depth_bits);
    of->call->GetIntegerv(GL_STENCIL_BITS, &stencil_bits);
    return (red_bits == needed_bits && depth_bits >= 24 && stencil_bits >= 8) ||
           error_unsupported(err,
                             "%s gives %d bits of colour, %d of depth and %d of stencil; %d, 24 "
                             "and 8 are needed%s",
                             of->contexts->kind->name, red_bits, depth_bits, stencil_bits,
                             needed_bits, needed_bits == 10 ? "; --gl egl may have them" : "");
}

/* Clamps are off: colours may exceed 1 on their way through a triangle (Mesa clamps vertex colours
 * by default, even for float buffers). */
static bool set_state(struct drawing *of, struct error *err)
{
    const struct gl_functions *call = of->call;
    struct gl *gl = (struct gl *)of;
    gl->group = -1;
    gl->gloss = -1;
    if (!check_canvas(of, err))
        return false;
    call->ClampColorARB(GL_CLAMP_VERTEX_COLOR_ARB, GL_FALSE);
    call->ClampColorARB(GL_CLAMP_FRAGMENT_COLOR_ARB, GL_FALSE);
    call->ClampColorARB(GL_CLAMP_READ_COLOR_ARB, GL_FALSE);
    call->Disable(GL_DITHER);
    call->Enable(GL_DEPTH_TEST);
    call->ShadeModel(of->plan->scene->shading == SHADING_FLAT ? GL_FLAT : GL_SMOOTH);
    call->Enable(GL_NORMALIZE);
    call->Enable(GL_LIGHTING);
    call->LightModelfv(GL_LIGHT_MODEL_AMBIENT, white);
    call->LightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, of->plan->scene->local_viewer);
    call->Materialfv(GL_FRONT_AND_BACK, GL_DIFFUSE, white);
    call->Materialfv(GL_FRONT_AND_BACK, GL_EMISSION, black);
    if (of->plan->options.check)
        call->StencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP); /* counts fragments */
    call->MatrixMode(GL_MODELVIEW);
    call->EnableClientState(GL_VERTEX_ARRAY);
    call->EnableClientState(GL_NORMAL_ARRAY);
    return true;
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
                         int first_band)
{
    const struct plan *plan = gl->base.plan;
    const struct gl_functions *call = gl->base.call;
    struct pass_colours colours, *set = &gl->set;
    const int first = light_group(plan, group).first;
    pass_colours(plan, shaded, group, first_band, gl->base.lit->full_scale, &colours);
    const float gloss = colours.shines ? (float)shaded->material->gloss : gl->gloss;
    for (int i = 0; i < colours.n_lights; i++) {
        const bool idle = plan->is_idle[first + i];
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
    switch_textures(gl, shaded->texture);
    if (gl->textured)
        texture_bind(&gl->base, shaded->texture);
}

static bool draw_instance(struct drawing *of, int instance, int group,
                          const struct frame_batch *batch, struct error *err)
{
    struct gl *gl = (struct gl *)of;
    const struct placed_instance *placed = &of->plan->instances[instance];
    const GLsizei step = VERTEX_NUMBERS * sizeof(GLfloat);
    (void)err; /* see functions_succeeded */
    place_lights(gl, group);
    set_material(gl, &of->plan->materials[placed->shaded], group, batch->first_bands[0]);
    if (gl->two_sided != placed->object->two_sided)
        of->call->LightModeli(GL_LIGHT_MODEL_TWO_SIDE, placed->object->two_sided);
    gl->two_sided = placed->object->two_sided;
    place(of, instance);
    const int n = mesh_bind(of, instance);
    of->call->VertexPointer(3, GL_FLOAT, step, NULL); /* offsets into the bound buffer */
    of->call->NormalPointer(GL_FLOAT, step, (const void *)(3 * sizeof(GLfloat)));
    if (gl->textured)
        of->call->TexCoordPointer(2, GL_FLOAT, step, (const void *)(6 * sizeof(GLfloat)));
    of->call->DrawElements(GL_TRIANGLES, n, GL_UNSIGNED_INT, NULL);
    return true;
}

/* ---- numbers ---- */

static void draw_corners(const struct drawing *of, const struct numbered_vertex *corners, int n)
{
    of->call->VertexPointer(3, GL_FLOAT, sizeof *corners, corners->position);
    of->call->ColorPointer(3, GL_FLOAT, sizeof *corners, corners->number);
    of->call->DrawArrays(GL_TRIANGLES, 0, n);
}

static bool begin_numbers(struct drawing *of, struct error *err)
{
    const struct gl_functions *call = of->call;
    (void)err;                                /* see functions_succeeded */
    if (of->contexts->current == of->colours) /* the other canvas never has a texture */
        switch_textures((struct gl *)of, false);
    call->Disable(GL_LIGHTING);
    if (of->plan->scene->shading != SHADING_FLAT)
        call->ShadeModel(GL_FLAT);
    call->BindBuffer(GL_ARRAY_BUFFER, 0);
    call->DisableClientState(GL_NORMAL_ARRAY);
    call->EnableClientState(GL_COLOR_ARRAY);
    return true;
}

static void end_numbers(struct drawing *of)
{
    of->call->DisableClientState(GL_COLOR_ARRAY);
    of->call->EnableClientState(GL_NORMAL_ARRAY);
    of->call->Enable(GL_LIGHTING);
    if (of->plan->scene->shading != SHADING_FLAT)
        of->call->ShadeModel(GL_SMOOTH);
}

/* ---- opening ---- */

bool gl_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err)
{
    static const struct drawing_kind kind = {.size = sizeof(struct gl),
                                             .most_at_once = 1,
                                             .set_state = set_state,
                                             .project = project,
                                             .draw_instance = draw_instance,
                                             .begin_numbers = begin_numbers,
                                             .place = place,
                                             .draw_corners = draw_corners,
                                             .end_numbers = end_numbers};
    return drawing_open(&kind, plan, n_buffers, out, err);
}
