/* SPDX-License-Identifier: MIT */
/* A small picture to draw known triangles on. */
#include <stdlib.h>

#include "raster/beside/measure/inside.h"

/* ---- how corners become colours ---- */

/* How the corners of a target's triangles become colours: by OpenGL's own lighting and textures, or
 * by shaders that do what those of raster/beside/shader do. */

enum { INPUTS = 4 }; /* of a shader */

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
    const uintptr_t at = (uintptr_t)corners; /* or 0: OpenGL takes offsets into the bound buffer */
    const GLsizei step = sizeof *corners;
    call->VertexPointer(3, GL_FLOAT, step, (const void *)at);
    call->ColorPointer(3, GL_FLOAT, step,
                       (const void *)(at + offsetof(struct target_corner, colour)));
    call->NormalPointer(GL_FLOAT, step,
                        (const void *)(at + offsetof(struct target_corner, normal)));
    call->TexCoordPointer(2, GL_FLOAT, step,
                          (const void *)(at + offsetof(struct target_corner, s_t)));
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
    program_begin(target->contexts->way, &vertex);
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
    program_begin(target->contexts->way, &fragment);
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

/* The inputs are the members of a corner, in their order. */
static void point_inputs(const struct target *target)
{
    static const GLint numbers[INPUTS] = {3, 3, 3, 2};
    size_t at = 0;
    for (GLuint i = 0; i < INPUTS; i++) {
        target->call->VertexAttribPointer(i, numbers[i], GL_FLOAT, GL_FALSE,
                                          sizeof(struct target_corner),
                                          (const void *)at); /* into the bound buffer */
        at += (size_t)numbers[i] * sizeof(float);
    }
}

/* ---- either ---- */

void target_shade(const struct target *target, enum target_mode mode, double gloss)
{
    (target->contexts->way == GL_WITHOUT_SHADERS ? set_lighting : set_program)(target, mode, gloss);
}

/* Lets OpenGL take corners from memory; NULL: from the bound buffer. */
static void target_point(const struct target *target, const struct target_corner *corners)
{
    if (target->contexts->way == GL_WITHOUT_SHADERS)
        point_arrays(target, corners);
    else
        point_inputs(target);
}

/* Shaders get the product, rounded once, as those of raster/beside/shader do. */
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
    if (target->contexts->way != GL_WITHOUT_SHADERS)
        return;
    call->MatrixMode(GL_PROJECTION);
    call->LoadMatrixd(projection);
    call->MatrixMode(GL_MODELVIEW);
    call->LoadMatrixd(model);
}

/* ---- the picture ---- */

/* Window coordinates become clip coordinates by products and sums that single precision does not
 * round for corners on a grid of 1/65536 pixel. */
static void place_window(struct target *target)
{
    static const double none[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double up = target->contexts->mirrored ? -1 : 1, side = 2.0 / TARGET;
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
    target->random = 1;
    if (target->contexts->way == GL_ES && !contexts_have(contexts, "GL_NV_read_depth_stencil"))
        return error_unsupported(err, "this OpenGL ES cannot read depths, which measurements need");
    if (contexts->way == GL_WITHOUT_SHADERS)
        prepare_lighting(target);
    else if (!prepare_shaders(target, err))
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
    const bool buffered = target->contexts->way != GL_WITHOUT_SHADERS;
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
    return target->depths[target->contexts->flipped ? y : TARGET - 1 - y][x];
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
