/* SPDX-License-Identifier: MIT */
/* Programs of shaders, written for the effects of a scene. Lighting is that of OpenGL 1.x: section
 * 2.14.1 of the OpenGL 2.1 specification. Each light has the statements of its own kind only. */
#include "raster/beside/shader/inside.h"

/* Prints the first lines of a shader. */
static void program_begin(const struct shader *of, struct printed *to)
{
    print_text(to, of->base.plan->options.gl_way == GL_ES
                       ? "#version 300 es\nprecision highp float;\nprecision highp sampler2D;\n"
                       : "#version 330 core\n");
}

/* How a program declares colours; flat shading does not interpolate them. */
static const char *flat_word(const struct shader *of)
{
    return of->base.plan->view.shading == FLAT ? "flat " : "";
}

/* ---- lighting at a vertex ---- */

/* Prints the direction towards a light, and the part `left` of it that distance and spot leave. */
static void print_incidence(const struct eye_light *light, int i, struct printed *to)
{
    if (light->directional)
        print(to, "        vec3 towards = place[%d];\n", i);
    else
        print(to,
              "        vec3 path = place[%d] - eye;\n"
              "        vec3 towards = normalize(path);\n",
              i);
    print_text(to, "        float left = 1.0;\n");
    if (light->attenuated)
        print(to,
              "        float far = length(path);\n"
              "        left /= attenuation[%d].x + attenuation[%d].y * far + "
              "attenuation[%d].z * far * far;\n",
              i, i, i);
    if (light->spot)
        print(to,
              "        float aside = dot(-towards, axis[%d].xyz);\n"
              "        left *= aside >= axis[%d].w ? power(aside, exponent[%d]) : 0.0;\n",
              i, i, i);
}

static void print_light(const struct eye_light *light, bool shines, int i, struct printed *to)
{
    print_text(to, "    {\n");
    print_incidence(light, i, to);
    print(to,
          "        float facing = dot(normal_there, towards);\n"
          "        float weight = max(facing, 0.0) * left;\n"
          "        sum += weight * diffuse[%d];\n",
          i);
    if (shines)
        print(to,
              "        float near = dot(normal_there, normalize(towards + viewer));\n"
              "        float highlight = facing > 0.0 ? power(near, gloss) * left : 0.0;\n"
              "        sum += highlight * specular[%d];\n",
              i);
    print_text(to, "    }\n");
}

/* Prints the function that lights a side of a vertex. */
static void print_lighting(const struct shader *of, const struct program_effects *effects,
                           struct printed *to)
{
    const struct plan *plan = of->base.plan;
    const struct light_group lights = light_group(plan, effects->group);
    print_text(to, "float power(float base, float exponent)\n"
                   "{\n"
                   "    return exponent == 0.0 ? 1.0 : base > 0.0 ? pow(base, exponent) : 0.0;\n"
                   "}\n"
                   "void light(vec3 normal_there, vec3 eye, vec3 viewer, out mat4 sum)\n{\n"
                   "    sum = constant;\n");
    for (int i = 0; i < lights.n; i++)
        if (!plan->is_idle[lights.first + i])
            print_light(&plan->lights[lights.first + i], effects->shines, i, to);
    print_text(to, "}\n");
}

static void print_vertex_variables(const struct shader *of, const struct program_effects *effects,
                                   struct printed *to)
{
    const int n = light_group(of->base.plan, effects->group).n;
    const char *flat = flat_word(of);
    const int lights = n > 0 ? n : 1;
    print(to,
          "layout(location = 0) in vec3 position;\n"
          "layout(location = 1) in vec3 normal;\n"
          "layout(location = 2) in vec2 coordinates;\n"
          "uniform mat4 to_clip, to_eye;\n"
          "uniform mat3 normals;\n"
          "uniform float gloss;\n"
          "uniform mat4 constant, diffuse[%d], specular[%d];\n"
          "uniform vec3 place[%d], attenuation[%d];\n"
          "uniform vec4 axis[%d];\n"
          "uniform float exponent[%d];\n"
          "invariant gl_Position;\n"
          "out vec2 at;\n"
          "%sout mat4 front;\n",
          lights, lights, lights, lights, lights, lights, flat);
    if (effects->two_sided)
        print(to, "%sout mat4 back;\n", flat);
}

static void print_vertex_shader(const struct shader *of, const struct program_effects *effects,
                                struct printed *to)
{
    print_vertex_variables(of, effects, to);
    print_lighting(of, effects, to);
    print(to,
          "void main()\n{\n"
          "    vec3 eye = (to_eye * vec4(position, 1.0)).xyz;\n"
          "    vec3 viewer = %s;\n"
          "    vec3 normal_there = normalize(normals * normal);\n"
          "    gl_Position = to_clip * vec4(position, 1.0);\n"
          "    at = coordinates;\n"
          "    light(normal_there, eye, viewer, front);\n",
          of->base.plan->view.local_viewer ? "normalize(-eye)" : "vec3(0.0, 0.0, 1.0)");
    if (effects->two_sided)
        print_text(to, "    light(-normal_there, eye, viewer, back);\n");
    print_text(to, "}\n");
}

/* ---- colours at a pixel ---- */

static void print_fragment_shader(const struct shader *of, const struct program_effects *effects,
                                  struct printed *to)
{
    const int n = of->base.renderer.n_at_once;
    const char *flat = flat_word(of);
    print(to, "in vec2 at;\n%sin mat4 front;\n", flat);
    if (effects->two_sided)
        print(to, "%sin mat4 back;\n", flat);
    print(to,
          "layout(location = 0) out vec4 colours[%d];\n"
          "uniform sampler2D texels[%d];\n"
          "void main()\n{\n"
          "    mat4 lit = %s;\n",
          n, n, effects->two_sided ? "gl_FrontFacing ? front : back" : "front");
    for (int k = 0; k < n; k++) {
        print(to, "    colours[%d] = lit[%d]", k, k);
        if (effects->texture == GREY_TEXTURE)
            print_text(to, " * vec4(texture(texels[0], at).rrr, 1.0)");
        if (effects->texture == SPECTRAL_TEXTURE)
            print(to, " * vec4(texture(texels[%d], at).rgb, 1.0)", k);
        print_text(to, ";\n");
    }
    print_text(to, "}\n");
}

/* ---- making a program ---- */

/* Compiles a shader and attaches it. Frees the text. */
static bool attach(const struct gl_functions *call, GLuint program, GLenum type,
                   struct printed *text, struct error *err)
{
    const GLuint shader = call->CreateShader(type);
    char *source = printed_take(text, err), log[256] = "";
    const char *const sources[] = {source};
    GLint done = 0;
    if (!source)
        return false;
    call->ShaderSource(shader, 1, sources, NULL);
    call->CompileShader(shader);
    call->GetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (!done) {
        call->GetShaderInfoLog(shader, sizeof log, NULL, log);
        hide_unprintable(log, "");
    }
    call->AttachShader(program, shader);
    free(source);
    return done || error_unsupported(err, "OpenGL does not compile a shader: %s", log);
}

/* Compiles two complete shaders, links and uses them; *out is the program's name. Frees both texts,
 * also after a failure. */
static bool program_end(const struct gl_functions *call, struct printed *vertex,
                        struct printed *fragment, unsigned *out, struct error *err)
{
    const GLuint name = call->CreateProgram();
    GLint done = 0;
    const bool attached = attach(call, name, GL_VERTEX_SHADER, vertex, err) &&
                          attach(call, name, GL_FRAGMENT_SHADER, fragment, err);
    free(printed_end(fragment));
    if (!attached)
        return false;
    call->LinkProgram(name);
    call->GetProgramiv(name, GL_LINK_STATUS, &done);
    if (!done)
        return error_unsupported(err, "OpenGL does not link the shaders of a program");
    call->UseProgram(name);
    *out = name;
    return true;
}

/* Sets what no pass changes: the lights of the group, and the units of textures. */
static void set_lights(const struct shader *of, int group, GLuint program)
{
    static const GLint units[MOST_AT_ONCE] = {0, 1, 2, 3};
    const struct gl_functions *call = of->base.call;
    GLfloat place[LIGHTS_PER_PASS][3] = {{0}}, attenuation[LIGHTS_PER_PASS][3] = {{0}},
            axis[LIGHTS_PER_PASS][4] = {{0}}, exponent[LIGHTS_PER_PASS] = {0};
    const struct light_group lights = light_group(of->base.plan, group);
    const int n = lights.n;
    for (int i = 0; i < n; i++) {
        const struct eye_light *light = &of->base.plan->lights[lights.first + i];
        const double from[] = {light->position.x, light->position.y, light->position.z};
        const double along[] = {light->axis.x, light->axis.y, light->axis.z, light->cutoff_cosine};
        for (int k = 0; k < 4; k++)
            axis[i][k] = (GLfloat)along[k];
        for (int k = 0; k < 3; k++) {
            place[i][k] = (GLfloat)from[k];
            attenuation[i][k] = (GLfloat)light->attenuation[k];
        }
        exponent[i] = (GLfloat)light->spot_exponent;
    }
    call->Uniform3fv(call->GetUniformLocation(program, "place"), n, place[0]);
    call->Uniform3fv(call->GetUniformLocation(program, "attenuation"), n, attenuation[0]);
    call->Uniform4fv(call->GetUniformLocation(program, "axis"), n, axis[0]);
    call->Uniform1fv(call->GetUniformLocation(program, "exponent"), n, exponent);
    call->Uniform1iv(call->GetUniformLocation(program, "texels"), of->base.renderer.n_at_once,
                     units);
}

/* ---- the programs ---- */

/* Prints the shaders that draw the numbers of triangles into the first buffer of colours. Other
 * buffers get undefined colours there, and then those of frames, which show the same pixels. */
static void print_numbers(struct printed *vertex, struct printed *fragment)
{
    print_text(vertex, "layout(location = 0) in vec3 position;\n"
                       "layout(location = 1) in vec3 number;\n"
                       "uniform mat4 to_clip;\n"
                       "invariant gl_Position;\n"
                       "flat out vec3 shown;\n"
                       "void main()\n{\n"
                       "    gl_Position = to_clip * vec4(position, 1.0);\n"
                       "    shown = number;\n}\n");
    print_text(fragment, "flat in vec3 shown;\n"
                         "layout(location = 0) out vec4 colour0;\n"
                         "void main()\n{\n"
                         "    colour0 = vec4(shown, 0.0);\n}\n");
}

unsigned program_use(struct shader *shader, const struct program_effects *effects,
                     struct error *err)
{
    const struct gl_functions *call = shader->base.call;
    unsigned *program = shader->programs;
    struct printed vertex = {.text = NULL}, fragment = {.text = NULL};
    if (effects)
        program += 1 + VARIANTS * effects->group + 6 * effects->shines + 3 * effects->two_sided +
                   (int)effects->texture;
    if (*program) {
        call->UseProgram(*program);
        return *program;
    }
    program_begin(shader, &vertex);
    program_begin(shader, &fragment);
    if (effects) {
        print_vertex_shader(shader, effects, &vertex);
        print_fragment_shader(shader, effects, &fragment);
    } else
        print_numbers(&vertex, &fragment);
    if (program_end(call, &vertex, &fragment, program, err) && effects)
        set_lights(shader, effects->group, *program);
    return *program;
}
