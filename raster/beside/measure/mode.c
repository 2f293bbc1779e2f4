/* SPDX-License-Identifier: MIT */
/* How the corners of a target's triangles become colours: by OpenGL's own lighting and textures, or
 * by shaders that do what those of raster/shader do. */
#include "raster/beside/measure/inside.h"

enum { POSITION, COLOUR, NORMAL, COORDINATES, INPUTS };

/* ---- by OpenGL's own lighting ---- */

static const GLfloat white[4] = {1, 1, 1, 1}, black[4] = {0, 0, 0, 1};

/* Clamps are off; the light shines along z. */
static void prepare_lighting(const struct target *target)
{
    static const GLfloat towards[4] = {0, 0, 1, 0};
    const struct gl_functions *call = target->call;
    call->ClampColorARB(GL_CLAMP_VERTEX_COLOR_ARB, GL_FALSE);
    call->ClampColorARB(GL_CLAMP_FRAGMENT_COLOR_ARB, GL_FALSE);
    call->ClampColorARB(GL_CLAMP_READ_COLOR_ARB, GL_FALSE);
    call->LightModelfv(GL_LIGHT_MODEL_AMBIENT, black);
    call->MatrixMode(GL_MODELVIEW);
    call->LoadIdentity();
    call->Lightfv(GL_LIGHT0, GL_POSITION, towards);
    call->Enable(GL_LIGHT0);
    call->EnableClientState(GL_VERTEX_ARRAY);
    call->EnableClientState(GL_COLOR_ARRAY);
    call->EnableClientState(GL_NORMAL_ARRAY);
    call->EnableClientState(GL_TEXTURE_COORD_ARRAY);
}

static void set_lighting(const struct target *target, enum target_mode mode, double gloss)
{
    const struct gl_functions *call = target->call;
    const bool lit = mode == TARGET_HIGHLIGHT || mode == TARGET_DIFFUSE;
    (lit ? call->Enable : call->Disable)(GL_LIGHTING);
    (mode == TARGET_DIFFUSE ? call->Enable : call->Disable)(GL_NORMALIZE);
    (mode == TARGET_TEXTURE ? call->Enable : call->Disable)(GL_TEXTURE_2D);
    call->ShadeModel(mode == TARGET_FLAT ? GL_FLAT : GL_SMOOTH);
    call->Materialfv(GL_FRONT_AND_BACK, GL_DIFFUSE, mode == TARGET_DIFFUSE ? white : black);
    call->Materialfv(GL_FRONT_AND_BACK, GL_SPECULAR, mode == TARGET_HIGHLIGHT ? white : black);
    call->Materialf(GL_FRONT_AND_BACK, GL_SHININESS, (GLfloat)gloss);
}

static void point_arrays(const struct target *target, const struct target_corner *corners)
{
    const struct gl_functions *call = target->call;
    const char *at = (const char *)corners;
    call->VertexPointer(3, GL_FLOAT, sizeof *corners, at);
    call->ColorPointer(3, GL_FLOAT, sizeof *corners, at + offsetof(struct target_corner, colour));
    call->NormalPointer(GL_FLOAT, sizeof *corners, at + offsetof(struct target_corner, normal));
    call->TexCoordPointer(2, GL_FLOAT, sizeof *corners, at + offsetof(struct target_corner, s_t));
}

/* ---- by shaders ---- */

static bool make_program(struct target *target, enum target_mode mode, struct error *err)
{
    static const char *const colours[] = {
        [TARGET_COLOURS] = "colour",
        [TARGET_FLAT] = "colour",
        [TARGET_TEXTURE] = "colour",
        [TARGET_HIGHLIGHT] = "vec3(pow(dot(normal, normalize(vec3(0.0, 0.0, 2.0))), gloss))",
        [TARGET_DIFFUSE] = "vec3(max(dot(normalize(normal), vec3(0.0, 0.0, 1.0)), 0.0))"};
    const char *flat = mode == TARGET_FLAT ? "flat " : "";
    struct printed vertex = {.text = NULL}, fragment = {.text = NULL};
    program_begin(target->way, &vertex);
    print(&vertex,
          "layout(location = 0) in vec3 position;\n"
          "layout(location = 1) in vec3 colour;\n"
          "layout(location = 2) in vec3 normal;\n"
          "layout(location = 3) in vec2 coordinates;\n"
          "uniform mat4 to_clip;\n"
          "uniform float gloss;\n"
          "invariant gl_Position;\n"
          "out vec2 at;\n"
          "%sout vec3 shown;\n"
          "void main()\n{\n"
          "    gl_Position = to_clip * vec4(position, 1.0);\n"
          "    at = coordinates;\n"
          "    shown = %s;\n}\n",
          flat, colours[mode]);
    program_begin(target->way, &fragment);
    print(&fragment,
          "in vec2 at;\n%sin vec3 shown;\n"
          "uniform sampler2D texels;\n"
          "layout(location = 0) out vec4 colour0;\n"
          "void main()\n{\n"
          "    colour0 = vec4(shown%s, 1.0);\n}\n",
          flat, mode == TARGET_TEXTURE ? " * texture(texels, at).rgb" : "");
    return program_end(target->call, &vertex, &fragment, &target->programs[mode], err);
}

static bool prepare_shaders(struct target *target, struct error *err)
{
    const struct gl_functions *call = target->call;
    GLuint array;
    for (int mode = 0; mode < TARGET_MODES; mode++)
        if (!make_program(target, (enum target_mode)mode, err))
            return false;
    call->GenVertexArrays(1, &array);
    call->BindVertexArray(array);
    for (GLuint i = 0; i < INPUTS; i++)
        call->EnableVertexAttribArray(i);
    return true;
}

static void set_program(const struct target *target, enum target_mode mode, double gloss)
{
    const struct gl_functions *call = target->call;
    const GLuint name = target->programs[mode];
    call->UseProgram(name);
    call->UniformMatrix4fv(call->GetUniformLocation(name, "to_clip"), 1, GL_FALSE, target->to_clip);
    call->Uniform1f(call->GetUniformLocation(name, "gloss"), (GLfloat)gloss);
}

static void point_inputs(const struct target *target)
{
    static const struct {
        GLuint input;
        GLint n;
        size_t at;
    } inputs[] = {{POSITION, 3, offsetof(struct target_corner, position)},
                  {COLOUR, 3, offsetof(struct target_corner, colour)},
                  {NORMAL, 3, offsetof(struct target_corner, normal)},
                  {COORDINATES, 2, offsetof(struct target_corner, s_t)}};
    for (int i = 0; i < INPUTS; i++)
        target->call->VertexAttribPointer(inputs[i].input, inputs[i].n, GL_FLOAT, GL_FALSE,
                                          sizeof(struct target_corner),
                                          (const void *)inputs[i].at); /* into the bound buffer */
}

/* ---- either ---- */

bool target_prepare(struct target *target, struct error *err)
{
    if (target->way != GL_WITHOUT_SHADERS)
        return prepare_shaders(target, err);
    prepare_lighting(target);
    return true;
}

void target_shade(const struct target *target, enum target_mode mode, double gloss)
{
    (target->way == GL_WITHOUT_SHADERS ? set_lighting : set_program)(target, mode, gloss);
}

void target_point(const struct target *target, const struct target_corner *corners)
{
    if (target->way == GL_WITHOUT_SHADERS)
        point_arrays(target, corners);
    else
        point_inputs(target);
}

/* Shaders get the product, rounded once, as those of raster/shader do. */
void target_place(struct target *target, const double projection[16], const double model[16])
{
    const struct gl_functions *call = target->call;
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            double sum = 0;
            for (int k = 0; k < 4; k++)
                sum += projection[4 * k + row] * model[4 * column + k];
            target->to_clip[4 * column + row] = (float)sum;
        }
    if (target->way != GL_WITHOUT_SHADERS)
        return;
    call->MatrixMode(GL_PROJECTION);
    call->LoadMatrixd(projection);
    call->MatrixMode(GL_MODELVIEW);
    call->LoadMatrixd(model);
}
