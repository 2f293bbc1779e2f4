/* SPDX-License-Identifier: MIT */
/* Passes: OpenGL 1.x lighting of the aimed tile. Three wavelengths ride in the red, green and blue
 * of a pass; each channel is lit by itself, so that a pass is three exact single-wavelength
 * renderings.
 *
 * A pass has eight lights. More lights take more passes, whose colours are added here; each pass
 * draws everything anew, so that all show the same surfaces. A pass changes colours only. */
#include <string.h>

#include "data/scene/scene.h"
#include "raster/gl/inside.h"

static const GLfloat white[4] = {1, 1, 1, 1}, black[4] = {0, 0, 0, 1};

/* ---- the view ---- */

/* OpenGL keeps matrices by column. */
void gl_load_matrix(const struct gl_functions *call, const struct matrix *m)
{
    GLdouble columns[16];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            columns[4 * j + i] = m->row[i][j];
    call->LoadMatrixd(columns);
}

void gl_load_view(const struct gl *gl)
{
    const struct gl_functions *call = gl->base.call;
    const struct matrix projection =
        pass_projection(gl->base.plan, &gl->base.tile, gl->base.contexts->mirrored);
    call->MatrixMode(GL_PROJECTION);
    gl_load_matrix(call, &projection);
    call->MatrixMode(GL_MODELVIEW);
    drawing_set_viewport(&gl->base);
}

void gl_aim(struct renderer *renderer, const struct rectangle *tile)
{
    struct gl *gl = (struct gl *)renderer;
    gl->base.tile = *tile;
    gl->is_stale[0] = gl->is_stale[1] = true;
    gl_load_view(gl);
}

/* ---- state ---- */

/* Clamps are off: colours may exceed 1 on their way through a triangle (Mesa clamps vertex colours
 * by default, even for float buffers). */
void gl_set_state(const struct gl *gl)
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
    for (int i = 0; i < LIGHTS_PER_PASS; i++) {
        int light = group * LIGHTS_PER_PASS + i;
        if (light < gl->base.plan->n_lights && !gl->base.plan->is_idle[light])
            place_light(gl, GL_LIGHT0 + (GLenum)i, &gl->base.plan->lights[light],
                        gl->base.plan->sources[light]);
        else if (gl->base.plan->n_light_groups > 1)
            gl->base.call->Disable(GL_LIGHT0 + (GLenum)i);
    }
}

/* ---- drawing ---- */

/* One pass draws up to BANDS_PER_PASS bands, lit by one group of lights. */
struct pass {
    int first_band, group;
    double full_scale;
};

/* Returns whether a colour is not the one that OpenGL has, which it becomes. */
static bool is_new(const float colour[4], float set[4])
{
    const bool differs = memcmp(colour, set, 4 * sizeof *set) != 0;
    memcpy(set, colour, 4 * sizeof *set);
    return differs;
}

static void set_material(struct gl *gl, const struct shaded_material *shaded,
                         const struct pass *pass)
{
    const struct gl_functions *call = gl->base.call;
    struct pass_colours colours, *set = &gl->set;
    pass_colours(gl->base.plan, shaded, pass->group, pass->first_band, pass->full_scale, &colours);
    const float gloss = colours.shines ? (float)shaded->material->gloss : gl->gloss;
    for (int i = 0; i < colours.n_lights; i++) {
        const bool idle = gl->base.plan->is_idle[pass->group * LIGHTS_PER_PASS + i];
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
    gl_bind_texture(gl, shaded->texture);
}

static void draw_instance(struct gl *gl, int instance)
{
    const struct gl_functions *call = gl->base.call;
    const struct placed_instance *placed = &gl->base.plan->instances[instance];
    const int n = gl_bind_mesh(gl, instance);
    if (gl->two_sided != placed->object->two_sided)
        call->LightModeli(GL_LIGHT_MODEL_TWO_SIDE, placed->object->two_sided);
    if (gl->mirrored != placed->instance.mirrored)
        call->FrontFace(placed->instance.mirrored != gl->base.contexts->mirrored ? GL_CW : GL_CCW);
    gl->two_sided = placed->object->two_sided;
    gl->mirrored = placed->instance.mirrored;
    gl_load_matrix(gl->base.call, &placed->instance.model_view);
    call->DrawElements(GL_TRIANGLES, n, GL_UNSIGNED_INT, NULL);
}

/* Clears the colour by drawing over it: Mesa fills 16-byte pixels one by one, at ten times the
 * price of a rectangle. */
void gl_blacken(struct gl *gl)
{
    const struct gl_functions *call = gl->base.call;
    if (gl->current == gl->colours) /* the other one never has a texture */
        gl_bind_texture(gl, NULL);
    call->Disable(GL_LIGHTING);
    call->Disable(GL_DEPTH_TEST); /* which also leaves the cleared depth alone */
    call->MatrixMode(GL_PROJECTION);
    call->PushMatrix();
    call->LoadIdentity();
    call->MatrixMode(GL_MODELVIEW);
    call->LoadIdentity();
    call->Color4f(0, 0, 0, 0);
    call->Rectf(-1, -1, 1, 1);
    call->MatrixMode(GL_PROJECTION);
    call->PopMatrix();
    call->MatrixMode(GL_MODELVIEW);
    call->Enable(GL_DEPTH_TEST);
    call->Enable(GL_LIGHTING);
}

static void draw_pass(struct gl *gl, const struct pass *pass)
{
    const struct plan *plan = gl->base.plan;
    int shaded = -1;
    gl_clear_stale(gl);
    gl->base.call->Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    place_lights(gl, pass->group);
    for (int i = 0; i < plan->n_instances; i++) {
        const struct placed_instance *placed = &plan->instances[i];
        if (!surface_reaches(&gl->base.lit->bounds[i], &gl->base.tile))
            continue;
        if (placed->shaded != shaded)
            set_material(gl, &plan->materials[placed->shaded], pass);
        shaded = placed->shaded;
        draw_instance(gl, i);
        gl->base.renderer.work.draw_calls++;
    }
    canvas_fill(gl->current);
    gl->base.renderer.work.passes++;
}

bool gl_draw(struct renderer *renderer, int buffer, int first_band, double full_scale,
             struct error *err)
{
    struct gl *gl = (struct gl *)renderer;
    float *sum = gl->base.renderer.buffers[buffer];
    for (int group = 0; group < gl->base.plan->n_light_groups; group++) {
        float *pixels = group == 0 ? sum : gl->base.part;
        if (!group_is_drawn(gl->base.plan, group))
            continue;
        if (!gl_draw_into(gl, gl->steps ? NULL : pixels, false, err) ||
            (group == 0 && !gl_upload_bands(gl, first_band, err)))
            return false;
        draw_pass(gl, &(struct pass){first_band, group, full_scale});
        if (gl->steps)
            pass_convert(gl->base.plan, gl->steps, pixels);
        if (group > 0)
            pass_add(gl->base.plan, gl->base.part, sum);
    }
    return functions_succeeded(gl->base.call, err);
}
