/* SPDX-License-Identifier: MIT */
/* The room "gl": OpenGL without a window, by a library of OSMesa or of EGL that is opened at run
 * time, so that the program starts without both. (The static program has an OSMesa of its own, and
 * no EGL.) Draws the plan's picture, a tile and a pass at a time, and says which triangle OpenGL
 * shows at each pixel. It may not know what the reference shows: of lit scenes it reads only where
 * each surface lies in the window, so that it draws nothing that a tile cannot show. Renderers by
 * shaders share meshes, textures and numbers of triangles with it. */
#ifndef RASTER_GL_GL_H
#define RASTER_GL_GL_H

#include <GL/gl.h>
#include <GL/glext.h>

#include "raster/volumes/volumes.h"

/* ---- the functions of OpenGL ---- */

/* Each calls EACH(type of the result, name without "gl", parameters): the functions that every
 * OpenGL and OpenGL ES has; those of lighting without shaders; those of shaders. */
#define COMMON_FUNCTIONS(EACH)                                                                     \
    EACH(void, BindBuffer, (GLenum target, GLuint buffer))                                         \
    EACH(void, BindFramebuffer, (GLenum target, GLuint framebuffer))                               \
    EACH(void, BindRenderbuffer, (GLenum target, GLuint renderbuffer))                             \
    EACH(void, BindTexture, (GLenum target, GLuint texture))                                       \
    EACH(void, BufferData, (GLenum target, GLsizeiptr size, const void *data, GLenum usage))       \
    EACH(GLenum, CheckFramebufferStatus, (GLenum target))                                          \
    EACH(void, Clear, (GLbitfield mask))                                                           \
    EACH(void, ColorMask, (GLboolean red, GLboolean green, GLboolean blue, GLboolean alpha))       \
    EACH(void, DepthMask, (GLboolean on))                                                          \
    EACH(void, Disable, (GLenum capability))                                                       \
    EACH(void, DrawArrays, (GLenum mode, GLint first, GLsizei count))                              \
    EACH(void, DrawElements, (GLenum mode, GLsizei count, GLenum type, const void *indices))       \
    EACH(void, Enable, (GLenum capability))                                                        \
    EACH(void, Finish, (void))                                                                     \
    EACH(void, FramebufferRenderbuffer, (GLenum target, GLenum at, GLenum type, GLuint buffer))    \
    EACH(void, FrontFace, (GLenum mode))                                                           \
    EACH(void, GenBuffers, (GLsizei n, GLuint * buffers))                                          \
    EACH(void, GenFramebuffers, (GLsizei n, GLuint * framebuffers))                                \
    EACH(void, GenRenderbuffers, (GLsizei n, GLuint * renderbuffers))                              \
    EACH(void, GenTextures, (GLsizei n, GLuint * textures))                                        \
    EACH(GLenum, GetError, (void))                                                                 \
    EACH(void, GetIntegerv, (GLenum name, GLint * values))                                         \
    EACH(const GLubyte *, GetString, (GLenum name))                                                \
    EACH(void, ReadPixels,                                                                         \
         (GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type,             \
          void *pixels))                                                                           \
    EACH(void, RenderbufferStorage, (GLenum target, GLenum format, GLsizei width, GLsizei height)) \
    EACH(void, StencilOp, (GLenum fail, GLenum depth_fail, GLenum pass))                           \
    EACH(void, StencilOpSeparate, (GLenum face, GLenum fail, GLenum depth_fail, GLenum pass))      \
    EACH(void, TexImage2D,                                                                         \
         (GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height, GLint border, \
          GLenum format, GLenum type, const void *pixels))                                         \
    EACH(void, TexParameteri, (GLenum target, GLenum name, GLint value))                           \
    EACH(void, Viewport, (GLint x, GLint y, GLsizei width, GLsizei height))
#define FIXED_FUNCTIONS(EACH)                                                                      \
    EACH(void, ClampColorARB, (GLenum target, GLenum clamp))                                       \
    EACH(void, ColorPointer, (GLint size, GLenum type, GLsizei stride, const void *pointer))       \
    EACH(void, DisableClientState, (GLenum array))                                                 \
    EACH(void, EnableClientState, (GLenum array))                                                  \
    EACH(void, LightModelfv, (GLenum name, const GLfloat *values))                                 \
    EACH(void, LightModeli, (GLenum name, GLint value))                                            \
    EACH(void, Lightf, (GLenum light, GLenum name, GLfloat value))                                 \
    EACH(void, Lightfv, (GLenum light, GLenum name, const GLfloat *values))                        \
    EACH(void, LoadIdentity, (void))                                                               \
    EACH(void, LoadMatrixd, (const GLdouble *columns))                                             \
    EACH(void, Materialf, (GLenum face, GLenum name, GLfloat value))                               \
    EACH(void, Materialfv, (GLenum face, GLenum name, const GLfloat *values))                      \
    EACH(void, MatrixMode, (GLenum mode))                                                          \
    EACH(void, NormalPointer, (GLenum type, GLsizei stride, const void *pointer))                  \
    EACH(void, ShadeModel, (GLenum mode))                                                          \
    EACH(void, TexCoordPointer, (GLint size, GLenum type, GLsizei stride, const void *pointer))    \
    EACH(void, VertexPointer, (GLint size, GLenum type, GLsizei stride, const void *pointer))
#define SHADER_FUNCTIONS(EACH)                                                                     \
    EACH(void, ActiveTexture, (GLenum unit))                                                       \
    EACH(void, AttachShader, (GLuint program, GLuint shader))                                      \
    EACH(void, BindVertexArray, (GLuint array))                                                    \
    EACH(void, CompileShader, (GLuint shader))                                                     \
    EACH(GLuint, CreateProgram, (void))                                                            \
    EACH(GLuint, CreateShader, (GLenum type))                                                      \
    EACH(void, DisableVertexAttribArray, (GLuint index))                                           \
    EACH(void, DrawBuffers, (GLsizei n, const GLenum *buffers))                                    \
    EACH(void, EnableVertexAttribArray, (GLuint index))                                            \
    EACH(void, GenVertexArrays, (GLsizei n, GLuint * arrays))                                      \
    EACH(void, GetProgramiv, (GLuint program, GLenum name, GLint * value))                         \
    EACH(void, GetShaderInfoLog, (GLuint shader, GLsizei size, GLsizei * length, char *log))       \
    EACH(void, GetShaderiv, (GLuint shader, GLenum name, GLint * value))                           \
    EACH(const GLubyte *, GetStringi, (GLenum name, GLuint index))                                 \
    EACH(GLint, GetUniformLocation, (GLuint program, const char *name))                            \
    EACH(void, LinkProgram, (GLuint program))                                                      \
    EACH(void, ReadBuffer, (GLenum buffer))                                                        \
    EACH(void, ShaderSource,                                                                       \
         (GLuint shader, GLsizei n, const char *const *texts, const GLint *lengths))               \
    EACH(void, Uniform1f, (GLint at, GLfloat value))                                               \
    EACH(void, Uniform1fv, (GLint at, GLsizei n, const GLfloat *values))                           \
    EACH(void, Uniform1iv, (GLint at, GLsizei n, const GLint *values))                             \
    EACH(void, Uniform3fv, (GLint at, GLsizei n, const GLfloat *values))                           \
    EACH(void, Uniform4fv, (GLint at, GLsizei n, const GLfloat *values))                           \
    EACH(void, UniformMatrix3fv,                                                                   \
         (GLint at, GLsizei n, GLboolean transposed, const GLfloat *values))                       \
    EACH(void, UniformMatrix4fv,                                                                   \
         (GLint at, GLsizei n, GLboolean transposed, const GLfloat *values))                       \
    EACH(void, UseProgram, (GLuint program))                                                       \
    EACH(void, VertexAttribPointer,                                                                \
         (GLuint index, GLint size, GLenum type, GLboolean normalized, GLsizei stride,             \
          const void *pointer))
#define GL_FUNCTION(type, name, parameters) type(*name) parameters;
struct gl_functions {
    COMMON_FUNCTIONS(GL_FUNCTION)
    FIXED_FUNCTIONS(GL_FUNCTION)
    SHADER_FUNCTIONS(GL_FUNCTION)
};

/* ---- opened.c: what can be used ---- */

/* Opens the library that the options choose and closes it. For a process of its own, which opens no
 * other one. */
bool contexts_describe(const struct plan_options *wish, struct context_description *out,
                       struct error *err);
/* Finds how many devices EGL lists; 0 without EGL. For a process of its own. */
bool contexts_devices(int *out, struct error *err);
/* Writes name, version and driver of the library that is used by default. */
bool gl_library(char *out, size_t capacity);

/* ---- opened.c: what renderers through OpenGL share ---- */

/* A corner of a triangle that is drawn in its number: see shown_of. */
struct numbered_vertex {
    float position[3], number[3];
};
struct drawing;
/* All in which lighting of OpenGL's own and shaders differ. */
struct drawing_kind {
    size_t size; /* of the struct that begins with struct drawing, in bytes; it begins zeroed */
    int most_at_once; /* frames that it draws at once: see struct renderer */
    /* Sets the state of a new context that no pass changes. The context is in use. */
    bool (*set_state)(struct drawing *of, struct error *err);
    void (*project)(const struct drawing *of); /* loads drawing_projection; NULL: not here */
    /* Draws an instance in the bands of a batch, under one group of lights. */
    bool (*draw_instance)(struct drawing *of, int instance, int group,
                          const struct frame_batch *batch, struct error *err);
    /* Between these two calls triangles are drawn in their numbers: those of an instance that is
     * placed, some corners at a time. `end` NULL: there is nothing to do. */
    bool (*begin_numbers)(struct drawing *of, struct error *err);
    void (*place)(const struct drawing *of, int instance);
    void (*draw_corners)(const struct drawing *of, const struct numbered_vertex *corners, int n);
    void (*end_numbers)(struct drawing *of);
    void (*close)(struct drawing *of); /* frees what the room has added; NULL: nothing */
};
/* A room embeds it as the first member of a struct of its own. */
struct drawing {
    struct renderer renderer; /* the first member */
    const struct drawing_kind *kind;
    const struct plan *plan;
    const struct lit_scene *lit; /* NULL: not taken yet */
    struct contexts *contexts;
    struct canvas *colours; /* numbers are drawn there, too, where `numbers` is NULL */
    struct canvas *numbers; /* of floats, where `colours` has steps */
    const struct gl_functions *call;
    /* names of the buffer objects of meshes, 0: not in view; of triangles: each mesh's, then those
     * of instances that hide some; of textures, n_at_once for each, 0: not drawn; owned */
    unsigned *objects, *indices, *textures;
    /* 4 floats a pixel: of some lights, NULL: one pass has all; numbers, NULL: no check; owned */
    float *part, *shown;
    uint8_t *steps;   /* pixels of uint8_t or uint16_t; NULL: the canvas has floats; owned */
    uint32_t *depths; /* 24 bits of depth, 8 of stencil; NULL: no check; owned */
    uint8_t *
        reached; /* [light with shadows][pixel]: it reaches the pixel; NULL: there is none; owned */
    uint32_t *counts; /* as depths, but of shadow volumes; owned */
    bool has_shadows; /* `reached` is of this tile */
    struct rectangle tile;
    /* the state of `colours`: */
    const struct texture *texture; /* that is bound; NULL: none */
    unsigned front;                /* how fronts turn: GL_CCW or GL_CW */
};
/* Opens a renderer of a plan: see struct drawing_ways. The bounds of raster/bounds hold for the
 * shaders of a known driver as for its own lighting: the shaders do the same operations, and both
 * measure the same (traits.py). */
bool drawing_open(const struct drawing_kind *kind, const struct plan *plan, int n_buffers,
                  struct renderer **out, struct error *err);
/* Binds the vertices of an instance, VERTEX_NUMBERS floats each, and its triangles, and says how
 * its fronts turn. Returns how many corners these have. */
int mesh_bind(struct drawing *of, int instance);
/* Binds a texture of the plan, which is drawn: a spectral one for each frame of a batch to the unit
 * of its number, another one to unit 0. */
void texture_bind(struct drawing *of, const struct texture *texture);
/* Returns what makes the aimed tile fill clip space. */
struct matrix drawing_projection(const struct drawing *of);

/* Opens OpenGL for a plan: see struct drawing_ways. */
bool gl_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err);

#endif
