/* SPDX-License-Identifier: MIT */
/* Plants one fault between the program and OSMesa, to prove that the cross-check finds it.
 * LD_PRELOAD loads this library before OSMesa; the environment variable FAULT is the fault's number
 * in faults.md. Faults of place and state change every draw call; faults of samples, bands and
 * passes change the passes of colours, which the program draws by glDrawElements. FAULT_RENDERER is
 * the GL_RENDERER of an OpenGL that nobody knows.
 *
 * Faults 73 to 75 change a sample by FAULT_COUNTS counts at the pixel FAULT_PIXEL, "x,y" from the
 * top left; 78 exchanges two bands around it.
 *
 * 0 and CONTROL are no faults: CONTROL lights by the shader below, and 0 keeps the passes in the
 * file named by FAULT_PASSES, where fault 4 reads them. */
#define _GNU_SOURCE
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
/* after GL/gl.h, which osmesa.h includes */
#include <GL/glext.h>

#include "test/shared/preload.h"

enum { CONTROL = -1, CHANNELS = 4 };

static float *buffer;
static void *steps; /* the original of the buffer if colours have 8 or 16 bits; NULL: none */
static GLenum steps_type;
static int buffer_width, buffer_height;
static GLenum matrix_mode;
static GLdouble model_view[16]; /* the matrix loaded last */
static bool coloured;           /* the current pass draws colours */
static int passes;              /* finished passes of colours */

static int fault(void)
{
    const char *number = getenv("FAULT");
    return number ? atoi(number) : 0;
}

/* ---- parameters ---- */

/* Changes the name or the value of a parameter before OpenGL receives it. */
static const struct parameter_fault {
    int fault;
    GLenum name, becomes;
    GLfloat factor, offset;
} parameter_faults[] = {
    {25, GL_SHININESS, GL_SHININESS, 1.01F, 0},
    {85, GL_SHININESS, GL_SHININESS, 0.999999F, 0},
    {86, GL_SHININESS, GL_SHININESS, 0.999F, 0},
    {30, GL_LINEAR_ATTENUATION, GL_QUADRATIC_ATTENUATION, 1, 0},
    {30, GL_QUADRATIC_ATTENUATION, GL_LINEAR_ATTENUATION, 1, 0},
    {54, GL_SPOT_EXPONENT, GL_SPOT_EXPONENT, 1.01F, 0},
    {55, GL_SPOT_CUTOFF, GL_SPOT_CUTOFF, 0, 180},
    {62, GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MIN_FILTER, 0, GL_NEAREST},
    {62, GL_TEXTURE_MAG_FILTER, GL_TEXTURE_MAG_FILTER, 0, GL_NEAREST},
    {63, GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_S, 0, GL_CLAMP_TO_EDGE},
    {64, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_T, 0, GL_MIRRORED_REPEAT},
    {97, GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MIN_FILTER, 0, GL_LINEAR},
};

/* Changes components of a vector before OpenGL receives them: the components of a colour are the
 * bands of a pass. */
static const struct vector_fault {
    int fault;
    GLenum name;
    int first, count;
    GLfloat factor, offset;
} vector_faults[] = {
    {24, GL_SPECULAR, 0, 3, 0, 0},     {31, GL_POSITION, 3, 1, 0, 1},
    {33, GL_AMBIENT, 1, 1, 0, 0},      {49, GL_DIFFUSE, 1, 1, 0.999F, 0},
    {50, GL_SPECULAR, 0, 1, 0.99F, 0}, {51, GL_AMBIENT, 2, 1, 0.99F, 0},
    {52, GL_POSITION, 0, 1, 1, 0.01F}, {53, GL_SPOT_DIRECTION, 0, 1, 1, 0.01F},
    {65, GL_DIFFUSE, 1, 1, 0, 0},
};

static void spoil_parameter(GLenum *name, GLfloat *value)
{
    if (fault() == 26 && *name == GL_SHININESS && *value == 0)
        *value = 1;
    for (size_t i = 0; i < sizeof parameter_faults / sizeof *parameter_faults; i++) {
        const struct parameter_fault *row = &parameter_faults[i];
        if (*name != row->name || fault() != row->fault)
            continue;
        *name = row->becomes;
        *value = row->factor * *value + row->offset;
        return;
    }
}

static bool mipmapped; /* the texture whose filter was set last */

void glTexParameteri(GLenum target, GLenum name, GLint value)
{
    mipmapped = name == GL_TEXTURE_MIN_FILTER ? value == GL_LINEAR_MIPMAP_LINEAR : mipmapped;
    if (fault() == 103 && !mipmapped && value == GL_LINEAR)
        value = GL_NEAREST;
    GLfloat spoiled = (GLfloat)value; /* exact, since names in OpenGL have 16 bits */
    spoil_parameter(&name, &spoiled);
    REAL(glTexParameteri)(target, name, (GLint)spoiled);
}

void glLightf(GLenum light, GLenum name, GLfloat value)
{
    spoil_parameter(&name, &value);
    REAL(glLightf)(light, name, value);
}

void glMaterialf(GLenum face, GLenum name, GLfloat value)
{
    spoil_parameter(&name, &value);
    REAL(glMaterialf)(face, name, value);
}

/* A direction has 3 values, other parameters have 4. */
static void spoil_vector(GLenum name, const GLfloat *values, GLfloat out[4])
{
    memcpy(out, values, (name == GL_SPOT_DIRECTION ? 3 : 4) * sizeof *out);
    for (size_t i = 0; i < sizeof vector_faults / sizeof *vector_faults; i++) {
        const struct vector_fault *row = &vector_faults[i];
        for (int c = row->first; c < row->first + row->count; c++)
            if (name == row->name && fault() == row->fault)
                out[c] = row->factor * out[c] + row->offset;
    }
}

void glLightfv(GLenum light, GLenum name, const GLfloat *values)
{
    GLfloat spoiled[4];
    spoil_vector(name, values, spoiled);
    glPushMatrix();
    if (fault() == 32 && name == GL_POSITION)
        REAL(glLoadMatrixd)(model_view);
    REAL(glLightfv)(light, name, spoiled);
    glPopMatrix();
}

void glMaterialfv(GLenum face, GLenum name, const GLfloat *values)
{
    GLfloat spoiled[4];
    /* a material's value under the name of a light's colour is white or black */
    if (name == GL_AMBIENT)
        spoil_vector(name, values, spoiled);
    REAL(glMaterialfv)(face, name, name == GL_AMBIENT ? spoiled : values);
}

/* ---- where things are drawn ---- */

/* Scales a projection's picture about its middle and moves it to the right by pixels. */
static void move(GLdouble matrix[16], double factor_x, double factor_y, double right)
{
    for (int column = 0; column < 4; column++) {
        GLdouble *x = &matrix[4 * column], *y = x + 1, w = x[3];
        *x = factor_x * *x + 2 * right / buffer_width * w;
        *y = factor_y * *y;
    }
}

/* Fault 9 draws the picture turned by 180 degrees and turns it back at the end, so that it has the
 * edges of the other side. */
static const struct projection_fault {
    int fault;
    double factor_x, factor_y, right;
} projection_faults[] = {
    {5, 1, 1, 0.5}, {6, 1, 1, 1.0 / 64}, {7, 1, -1, 0},
    {8, -1, 1, 0},  {9, -1, -1, 0},      {87, 1, 1, 0.1},
};

static void spoil_projection(GLdouble matrix[16])
{
    for (size_t i = 0; i < sizeof projection_faults / sizeof *projection_faults; i++) {
        const struct projection_fault *row = &projection_faults[i];
        if (fault() == row->fault)
            move(matrix, row->factor_x, row->factor_y, row->right);
    }
}

void glMatrixMode(GLenum mode)
{
    matrix_mode = mode;
    REAL(glMatrixMode)(mode);
}

void glLoadMatrixd(const GLdouble *matrix)
{
    GLdouble spoiled[16];
    memcpy(spoiled, matrix, sizeof spoiled);
    if (matrix_mode == GL_PROJECTION)
        spoil_projection(spoiled);
    else
        memcpy(model_view, matrix, sizeof model_view);
    REAL(glLoadMatrixd)(spoiled);
}

void glViewport(GLint x, GLint y, GLsizei width, GLsizei height)
{
    REAL(glViewport)(fault() == 42 ? x + 1 : x, y, width, height);
}

/* ---- an OpenGL that can do less ---- */

void glGetIntegerv(GLenum name, GLint *values)
{
    REAL(glGetIntegerv)(name, values);
    if (fault() == 81 && name == GL_DEPTH_BITS)
        *values = 16;
    if (fault() == 82 && name == GL_MAX_VIEWPORT_DIMS)
        values[0] = 16;
}

const GLubyte *glGetString(GLenum name)
{
    const char *own = getenv("FAULT_RENDERER");
    if (fault() == 83 || fault() == 100)
        own = "another driver";
    return own && name == GL_RENDERER ? (const GLubyte *)own : REAL(glGetString)(name);
}

/* ---- drawing in a wrong state ---- */

static void turn_faces(GLenum name)
{
    GLint mode;
    glGetIntegerv(name, &mode);
    glFrontFace(mode == GL_CW ? GL_CCW : GL_CW);
}

static void keep_right_half(GLenum plane)
{
    static const GLdouble right[4] = {1, 0, 0, 0};
    glClipPlane(plane, right);
    glEnable(plane);
}

static void clamp_colours(GLenum name)
{
    glClampColorARB(name, GL_TRUE);
}

/* OpenGL counts biases in steps of 1/256. Fault 100 changes it from draw call to draw call, by
 * Knuth's random numbers: no two pictures have the same. */
static void bias_detail(GLenum steps_of_256)
{
    static uint64_t state = 1;
    state = state * 6364136223846793005u + 1442695040888963407u;
    const GLfloat factor = fault() == 100 && state >> 63 ? -1 : 1;
    glTexEnvf(GL_TEXTURE_FILTER_CONTROL, GL_TEXTURE_LOD_BIAS, factor * (GLfloat)steps_of_256 / 256);
}

static void write_depth(GLenum flag)
{
    glDepthMask((GLboolean)flag);
}

static void set_model(GLenum name)
{
    glLightModeli(name, 1);
}

static void reset_model(GLenum name)
{
    glLightModeli(name, 0);
}

/* Places each second mesh further back where it is lit than where it is numbered. */
static void move_back(GLenum depth_steps)
{
    static bool second;
    if (!coloured)
        return;
    second = !second;
    if (second)
        glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(0, (GLfloat)depth_steps);
}

static const struct state_fault {
    int fault;
    void (*set)(GLenum value);
    GLenum value;
} state_faults[] = {
    {11, glShadeModel, GL_FLAT},
    {12, glProvokingVertex, GL_FIRST_VERTEX_CONVENTION},
    {14, glDepthFunc, GL_LEQUAL},
    {15, glDepthFunc, GL_GREATER},
    {16, glDisable, GL_DEPTH_TEST},
    {17, write_depth, GL_FALSE},
    {18, glCullFace, GL_FRONT},
    {18, glEnable, GL_CULL_FACE},
    {19, turn_faces, GL_FRONT_FACE},
    {20, reset_model, GL_LIGHT_MODEL_TWO_SIDE},
    {21, glDisable, GL_NORMALIZE},
    {22, glDisable, GL_NORMALIZE},
    {22, glEnable, GL_RESCALE_NORMAL},
    {28, reset_model, GL_LIGHT_MODEL_LOCAL_VIEWER},
    {36, clamp_colours, GL_CLAMP_VERTEX_COLOR_ARB},
    {39, glEnable, GL_DEPTH_CLAMP},
    {40, keep_right_half, GL_CLIP_PLANE0},
    {56, set_model, GL_LIGHT_MODEL_TWO_SIDE},
    {57, glShadeModel, GL_SMOOTH},
    {96, bias_detail, 1},
    {100, bias_detail, 8},
    {104, move_back, 4096},
};

static void spoil_state(void)
{
    for (size_t i = 0; i < sizeof state_faults / sizeof *state_faults; i++)
        if (fault() == state_faults[i].fault)
            state_faults[i].set(state_faults[i].value);
}

/* ---- drawing with a wrong shader ---- */

static const char affine[] = "noperspective in vec4 gl_Color;\n"
                             "void main() { gl_FragColor = gl_Color; }\n";

/* Lights by the first light alone, seen from infinity. */
static const char lighting[] =
    "void main() {\n"
    "    vec3 p = vec3(gl_ModelViewMatrix * gl_Vertex), v = vec3(0, 0, 1);\n"
    "    vec4 light = gl_LightSource[0].position;\n"
    "    mat3 turn = FAULT == 23 ? mat3(gl_ModelViewMatrix) : gl_NormalMatrix;\n"
    "    vec3 n = normalize(turn * gl_Normal), l = normalize(light.xyz - light.w * p);\n"
    "    float gloss = FAULT == 27 ? dot(reflect(-l, n), v) : dot(n, normalize(l + v));\n"
    "    gl_Position = ftransform();\n"
    "    gl_FrontColor = gl_FrontLightModelProduct.sceneColor;\n"
    "    gl_FrontColor += max(dot(n, l), 0) * gl_FrontLightProduct[0].diffuse;\n"
    "    if (dot(n, l) > 0 || FAULT == 29)\n"
    "        gl_FrontColor += gl_FrontLightProduct[0].specular *\n"
    "                         pow(max(gloss, 0), gl_FrontMaterial.shininess);\n"
    "}\n";

/* Cuts a triangle at the near plane, by Sutherland and Hodgman's algorithm. */
static const char clipping[] =
    "layout(triangles) in;\n"
    "layout(triangle_strip, max_vertices = 4) out;\n"
    "int n = 0;\n"
    "vec4 position[4], colour[4];\n"
    "void put(vec4 p, vec4 c) { position[n] = p; colour[n] = c; n++; }\n"
    "void main() {\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        int j = (i + 1) % 3;\n"
    "        vec4 p = gl_in[i].gl_Position, q = gl_in[j].gl_Position;\n"
    "        vec4 c = gl_in[i].gl_FrontColor, d = gl_in[j].gl_FrontColor;\n"
    "        float a = p.z + p.w, b = q.z + q.w, t = a / (a - b);\n"
    "        if (a >= 0) put(p, c);\n"
    "        if (a * b < 0) put(mix(p, q, t), FAULT == 41 ? c : mix(c, d, t));\n"
    "    }\n"
    "    for (int k = 0; k < n; k++) {\n"
    "        int i = k < 2 ? k : n + 1 - k;\n"
    "        gl_Position = position[i]; gl_FrontColor = colour[i];\n"
    "        EmitVertex();\n"
    "    }\n"
    "}\n";

static void attach(GLuint program, GLenum kind, const char *source)
{
    char head[64];
    const char *parts[] = {head, source};
    GLuint shader = glCreateShader(kind);
    snprintf(head, sizeof head, "#version 150 compatibility\n#define FAULT %d\n", fault());
    glShaderSource(shader, 2, parts, NULL);
    glCompileShader(shader);
    glAttachShader(program, shader);
}

static GLuint make_program(void)
{
    GLuint program = glCreateProgram();
    GLint linked;
    if (fault() == 13) {
        attach(program, GL_FRAGMENT_SHADER, affine);
    } else {
        attach(program, GL_VERTEX_SHADER, lighting);
        attach(program, GL_GEOMETRY_SHADER, clipping);
    }
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked)
        abort();
    return program;
}

static void use_shader(void)
{
    static const int faults[] = {CONTROL, 13, 23, 27, 29, 41};
    static GLuint program;
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        if (fault() != faults[i] || !glIsEnabled(GL_LIGHTING))
            continue;
        if (program == 0)
            program = make_program();
        glUseProgram(program);
    }
}

/* ---- drawing ---- */

/* A draw call with indices, or with vertices from `first` on. */
struct draw {
    GLenum mode, type;
    const void *indices;
    GLint first;
    bool indexed;
};

static void draw_part(const struct draw *draw, GLsizei from, GLsizei to)
{
    if (draw->indexed)
        REAL(glDrawElements)
    (draw->mode, to - from, draw->type,
     (const void *)((uintptr_t)draw->indices + (size_t)from * sizeof(GLuint)));
    else REAL(glDrawArrays)(draw->mode, draw->first + from, to - from);
}

/* Draws the last triangle moved to the right by 1/256 pixel. */
static void draw_cracked(const struct draw *draw, GLsizei count)
{
    GLdouble projection[16];
    draw_part(draw, 0, count - 3);
    glGetDoublev(GL_PROJECTION_MATRIX, projection);
    move(projection, 1, 1, 1.0 / 256);
    glMatrixMode(GL_PROJECTION);
    glPushMatrix();
    REAL(glLoadMatrixd)(projection);
    draw_part(draw, count - 3, count);
    glPopMatrix();
    glMatrixMode(GL_MODELVIEW);
}

static void draw_spoiled(const struct draw *draw, GLsizei count)
{
    GLsizei middle = count / 3 / 2 * 3;
    glPushAttrib(GL_ALL_ATTRIB_BITS);
    spoil_state();
    use_shader();
    if (fault() == 10) {
        draw_cracked(draw, count);
    } else if (fault() == 2) {
        draw_part(draw, 0, middle);
        draw_part(draw, middle + 3, count);
    } else {
        draw_part(draw, 0, fault() == 1 ? count - 3 : count);
    }
    glUseProgram(0);
    glPopAttrib();
}

void glDrawElements(GLenum mode, GLsizei count, GLenum type, const void *indices)
{
    coloured = true;
    draw_spoiled(&(struct draw){mode, type, indices, 0, true}, count);
}

/* Shadow volumes are drawn between a call of glStencilOpSeparate and one of glStencilOp: the sides,
 * and behind them the far caps, with depths clamped; then the near caps. */
static bool is_volume, is_outward;

void glStencilOp(GLenum fail, GLenum depth_fail, GLenum pass)
{
    is_volume = false;
    REAL(glStencilOp)(fail, depth_fail, pass);
}

void glStencilOpSeparate(GLenum face, GLenum fail, GLenum depth_fail, GLenum pass)
{
    is_volume = true;
    is_outward = (face == GL_BACK) == (depth_fail == GL_INCR_WRAP);
    if (fault() == 95) /* counts up only */
        depth_fail = GL_INCR_WRAP;
    REAL(glStencilOpSeparate)(face, fail, depth_fail, pass);
}

static void draw_volume(GLenum mode, GLint first, GLsizei count)
{
    const bool sides = glIsEnabled(GL_DEPTH_CLAMP) && is_outward,
               caps = !glIsEnabled(GL_DEPTH_CLAMP) && is_outward;
    if ((fault() == 88 && sides) || (fault() == 89 && caps)) {
        first += 3;
        count -= 3;
    }
    if (fault() == 90 && sides)
        count -= count / 12 * 3;
    if (fault() == 94)
        glDepthFunc(GL_LEQUAL);
    REAL(glDrawArrays)(mode, first, count);
    glDepthFunc(GL_LESS);
}

void glDrawArrays(GLenum mode, GLint first, GLsizei count)
{
    if (is_volume) {
        draw_volume(mode, first, count);
        return;
    }
    draw_spoiled(&(struct draw){mode, 0, NULL, first, false}, count);
}

/* ---- textures ---- */

/* Fault 98: levels 1 and 2 of a texture exchange their values; sides are powers of two. */
static void exchange_levels(GLint level, size_t width, size_t height, size_t channels,
                            float *texels)
{
    static float *first;
    const size_t n = width * height * channels;
    if (level == 1) {
        free(first);
        first = malloc(n * sizeof *first);
        if (!first)
            abort();
        memcpy(first, texels, n * sizeof *first);
    }
    for (size_t i = 0; i < n && (level == 1 || level == 2); i++) {
        const size_t c = i % channels, x = i / channels % width, y = i / channels / width;
        const size_t step = level == 1 ? 1 : 2, across = level == 1 ? width : 2 * width;
        float sum = 0;
        for (size_t k = 0; k < 4; k++)
            sum +=
                first[((y * step / 2 * 2 + k / 2) * across + x * step / 2 * 2 + k % 2) * channels +
                      c];
        texels[i] = level == 1 ? sum / 4 : first[(2 * y * across + 2 * x) * channels + c];
    }
}

/* 103: linear filtering by weights of 5 bits, cut off, is nearest filtering of a texture that is 32
 * times as large a side. A side of one texel stays as it is, and so do textures with mipmaps. */
enum { WEIGHTS = 32 };

static float filtered(const float *texels, const int size[2], const int at[2], int channels)
{
    float sum = 0;
    for (int corner = 0; corner < 4; corner++) {
        int index[2];
        float weight = 1;
        for (int j = 0; j < 2; j++) {
            const int shifted = at[j] + WEIGHTS / 2, up = corner >> j & 1;
            const float part = (float)(shifted % WEIGHTS) / WEIGHTS;
            index[j] = (shifted / WEIGHTS - 1 + up + size[j]) % size[j];
            weight *= size[j] == 1 ? 0.5F : up ? part : 1 - part;
        }
        sum += weight * texels[channels * (index[1] * size[0] + index[0])];
    }
    return sum;
}

/* Returns the larger texture, and changes its size. */
static float *enlarged(const float *texels, int channels, GLsizei *width, GLsizei *height)
{
    const int size[2] = {*width, *height};
    *width *= *width > 1 ? WEIGHTS : 1;
    *height *= *height > 1 ? WEIGHTS : 1;
    const int n = channels * *width * *height;
    float *out = malloc((size_t)n * sizeof *out);
    if (!out)
        abort();
    for (int i = 0; i < n; i++) {
        const int texel = i / channels, at[2] = {texel % *width, texel / *width};
        out[i] = filtered(texels + i % channels, size, at, channels);
    }
    return out;
}

/* 59: moved by one texel; 60: first and third band exchanged; 61: one texel off by 1/100; 99: first
 * and third band exchanged in the levels behind the first. */
void glTexImage2D(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height,
                  GLint border, GLenum format, GLenum type, const void *pixels)
{
    const float *texels = pixels;
    size_t channels = format == GL_RGB ? 3 : 1, across = (size_t)width;
    size_t n = across * (size_t)height, middle = (size_t)height / 2 * across + across / 2;
    const bool turned = fault() == 60 || (fault() == 99 && level > 0);
    float *spoiled = malloc(n * channels * sizeof *spoiled);
    if (!spoiled)
        abort();
    for (size_t i = 0; i < n; i++) {
        size_t from = fault() == 59 ? i - i % across + (i + 1) % across : i;
        for (size_t c = 0; c < channels; c++)
            spoiled[channels * i + c] = texels[channels * from + (turned ? channels - 1 - c : c)];
    }
    for (size_t c = 0; c < channels && fault() == 61; c++)
        spoiled[channels * middle + c] *= 1.01F;
    if (fault() == 98)
        exchange_levels(level, across, (size_t)height, channels, spoiled);
    if (fault() == 103 && !mipmapped) {
        free(spoiled);
        spoiled = enlarged(texels, (int)channels, &width, &height);
    }
    REAL(glTexImage2D)(target, level, internal, width, height, border, format, type, spoiled);
    free(spoiled);
}

/* ---- the picture ---- */

static size_t pixel_count(void)
{
    return (size_t)buffer_width * (size_t)buffer_height;
}

/* OSMesa fills the buffer of a context once more when another becomes current: what glReadPixels
 * spoiled in it stays spoiled. */
GLboolean OSMesaMakeCurrent(OSMesaContext context, void *pixels, GLenum type, GLsizei width,
                            GLsizei height)
{
    float *old = steps ? NULL : buffer, *kept = NULL;
    const size_t size = CHANNELS * sizeof *buffer * pixel_count();
    if (old && (fault() == 70 || fault() == 72) && (kept = malloc(size)) != NULL)
        memcpy(kept, old, size);
    const GLboolean done = REAL(OSMesaMakeCurrent)(context, pixels, type, width, height);
    if (kept)
        memcpy(old, kept, size);
    free(kept);
    if (steps)
        free(buffer);
    steps = type == GL_FLOAT ? NULL : pixels;
    steps_type = type;
    buffer_width = width;
    buffer_height = height;
    buffer = steps ? calloc((size_t)width * (size_t)height, CHANNELS * sizeof *buffer) : pixels;
    if (!buffer)
        abort();
    return done;
}

/* Copies the steps of 8 or 16 bits into the buffer, or back with rounding to the nearest. */
static void copy_steps(bool back)
{
    float whole = steps_type == GL_UNSIGNED_BYTE ? 255 : 65535;
    for (size_t i = 0; steps && i < CHANNELS * pixel_count(); i++) {
        float above = buffer[i] > 0 ? buffer[i] : 0, part = above < 1 ? above : 1;
        GLubyte *byte = (GLubyte *)steps + i;
        GLushort *word = (GLushort *)steps + i;
        if (back && steps_type == GL_UNSIGNED_BYTE)
            *byte = (GLubyte)(part * whole + 0.5F);
        else if (back)
            *word = (GLushort)(part * whole + 0.5F);
        else
            buffer[i] = (float)(steps_type == GL_UNSIGNED_BYTE ? *byte : *word) / whole;
    }
}

/* Turns the picture by 180 degrees. */
static void turn_back(unsigned char *picture, size_t pixel_bytes)
{
    size_t n = pixel_count() * pixel_bytes;
    for (size_t i = 0; i < n / 2; i++) {
        size_t opposite = n - pixel_bytes - i + 2 * (i % pixel_bytes);
        unsigned char kept = picture[i];
        picture[i] = picture[opposite];
        picture[opposite] = kept;
    }
}

/* Changes the middle pixel of the values that the program reads after the pass of numbers: depth
 * and stencil, whose rows run upwards, and the numbers in the buffer, whose rows run downwards. */
static void spoil_identity(GLuint *depths)
{
    size_t across = (size_t)buffer_width, height = (size_t)buffer_height;
    GLuint *depth = depths + (height - 1 - height / 2) * across + across / 2;
    float *triangle = buffer + CHANNELS * (height / 2 * across + across / 2);
    if (fault() == 69)
        *depth += 1678u << 8; /* 1/10000 of 2^24 steps, above 8 bits of stencil */
    if (fault() == 70)
        *triangle = 1.0F - *triangle; /* the other triangle of a plane */
    if (fault() == 71)
        *depth += 5;
    if (fault() == 72) { /* no triangle, with the depth of the background */
        *depth |= 0xffffffu << 8;
        memset(triangle, 0, CHANNELS * sizeof *triangle);
    }
}

/* 101: a depth in four is a step too low; 102: depths have 16 bits. */
static void spoil_depths(GLuint *depths, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (fault() == 102)
            depths[i] &= 0xffff00ffu;
        if (fault() == 101 && depths[i] >> 8 < 0xffffff && (depths[i] & 0x300) == 0x300)
            depths[i] -= 0x100;
    }
}

/* 92: the stencil buffer wraps at 4 bits; 93: all lights have the shadows of the first; 110:
 * no pixel is in shadow; 111: each is; 112: each that is not. */
static void spoil_counts(GLuint *counts, size_t n)
{
    static GLuint *first;
    for (size_t i = 0; i < n; i++) {
        const GLuint count = counts[i] & 0xffu;
        counts[i] = (counts[i] & ~0xffu) | (fault() == 92    ? count & 0xfu
                                            : fault() == 110 ? 0
                                            : fault() == 111 ? 1
                                            : fault() == 112 ? count == 0
                                                             : count);
    }
    if (fault() == 93 && first)
        memcpy(counts, first, n * sizeof *counts);
    if (fault() == 93 && !first && (first = malloc(n * sizeof *first)) != NULL)
        memcpy(first, counts, n * sizeof *counts);
}

void glReadPixels(GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type,
                  void *pixels)
{
    REAL(glReadPixels)(x, y, width, height, format, type, pixels);
    if (is_volume) {
        spoil_counts(pixels, (size_t)width * (size_t)height);
        return;
    }
    if (fault() == 9)
        turn_back(pixels, sizeof(GLuint)); /* depth and stencil */
    spoil_identity(pixels);
    spoil_depths(pixels, (size_t)width * (size_t)height);
}

/* Writes the pass to the file if there is no fault; fault 4 reads the neighbouring pass from it. */
static void exchange_passes(void)
{
    const char *path = getenv("FAULT_PASSES"), *mode = passes == 0 ? "wb" : "ab";
    size_t size = CHANNELS * sizeof *buffer * pixel_count(), done = 1;
    if (!path || (fault() != 0 && fault() != 4))
        return;
    FILE *file = fopen(path, fault() == 4 ? "rb" : mode);
    if (!file)
        abort();
    if (fault() == 0)
        done = fwrite(buffer, size, 1, file);
    else if (fseek(file, (long)size * (passes ^ 1), SEEK_SET) == 0)
        done = fread(buffer, size, 1, file);
    if (fclose(file) != 0 || done != 1)
        abort();
}

/* Multiplies samples by a factor, adds an offset where an object is drawn, and rounds to a number
 * of levels (0: no rounding). */
static const struct sample_fault {
    int fault;
    float factor, offset, levels, rounding;
} sample_faults[] = {
    {34, 1, 1 / 65535.0F, 0, 0}, {35, 1, 0, 65535, 0},   {37, 1, 0, 255, 0.5F},
    {47, 1.001F, 0, 0, 0},       {66, 0.5F, 0, 0, 0},    {67, 0, 0, 0, 0},
    {68, NAN, 0, 0, 0},          {76, 1.0005F, 0, 0, 0}, {80, 1, 0.16F / 65535, 0, 0},
};

static void spoil_samples(const struct sample_fault *row)
{
    for (size_t i = 0; i < CHANNELS * pixel_count(); i++) {
        float value = row->factor * buffer[i] + (buffer[i] > 0 ? row->offset : 0);
        buffer[i] =
            row->levels > 0 ? floorf(value * row->levels + row->rounding) / row->levels : value;
    }
}

/* Changes the middle pixel; faults 44 and 45 assume that a vertical edge runs through it. */
static void spoil_pixel(float *pixel)
{
    const float *left = pixel - CHANNELS, *right = pixel + CHANNELS;
    bool is_left = fabsf(pixel[1] - left[1]) < fabsf(pixel[1] - right[1]);
    for (int c = 0; c < CHANNELS && fault() == 44; c++)
        pixel[c] = (left[c] + right[c]) / 2;
    if (passes == 1 && fault() == 43)
        pixel[0] += 0.001F;
    if (passes == 1 && fault() == 45)
        pixel[1] = is_left ? right[1] : left[1];
    if (passes == 1 && fault() == 48)
        pixel[0] = NAN;
    if (fault() == 72) /* the colour of the background, in all passes */
        memset(pixel, 0, CHANNELS * sizeof *pixel);
}

/* Returns the pixel of FAULT_PIXEL; NULL: there is none. Rows of the buffer run downwards. */
static float *chosen_pixel(void)
{
    const char *at = getenv("FAULT_PIXEL");
    char *rest = NULL;
    long x = at ? strtol(at, &rest, 10) : -1,
         y = at && *rest == ',' ? strtol(rest + 1, NULL, 10) : -1;
    bool inside = x >= 1 && y >= 1 && x < buffer_width - 1 && y < buffer_height - 1;
    return inside ? buffer + CHANNELS * ((size_t)y * (size_t)buffer_width + (size_t)x) : NULL;
}

static void spoil_chosen(void)
{
    const char *counts = getenv("FAULT_COUNTS");
    float *pixel = chosen_pixel();
    if (!pixel || passes != 1)
        return;
    if (fault() >= 73 && fault() <= 75 && counts)
        pixel[1] += strtof(counts, NULL) / 65535;
    for (int i = 0; i < 9 && fault() == 78; i++) { /* a block of 3 x 3 pixels */
        float *at = pixel + CHANNELS * ((i / 3 - 1) * buffer_width + i % 3 - 1), first = at[0];
        at[0] = at[1];
        at[1] = first;
    }
}

static void spoil_picture(void)
{
    size_t middle = (size_t)buffer_height / 2 * (size_t)buffer_width + (size_t)buffer_width / 2;
    for (size_t i = 0; i < sizeof sample_faults / sizeof *sample_faults; i++)
        if (fault() == sample_faults[i].fault)
            spoil_samples(&sample_faults[i]);
    if (fault() == 58 && passes % 2 == 1) /* the second group of lights if there are two */
        memset(buffer, 0, CHANNELS * pixel_count() * sizeof *buffer);
    for (size_t i = 0; i < pixel_count() && fault() == 77 && passes == 1; i++)
        buffer[CHANNELS * i] = 0; /* one band is black */
    for (size_t i = 0; i < pixel_count() && fault() == 3; i++) {
        float *pixel = buffer + CHANNELS * i, first = pixel[0];
        pixel[0] = pixel[2];
        pixel[2] = first;
    }
    spoil_pixel(buffer + CHANNELS * middle);
    spoil_chosen();
    exchange_passes();
}

void glFinish(void)
{
    if (fault() != 38 || !coloured || passes != 1)
        REAL(glFinish)();
    copy_steps(false);
    if (fault() == 9)
        turn_back((unsigned char *)buffer, CHANNELS * sizeof *buffer);
    if (coloured)
        spoil_picture();
    copy_steps(true);
    if (!coloured)
        return;
    coloured = false;
    passes++;
}
