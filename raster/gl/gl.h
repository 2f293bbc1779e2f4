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

/* ---- library.c: the functions of OpenGL ---- */

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
    EACH(void, ClearColor, (GLclampf red, GLclampf green, GLclampf blue, GLclampf alpha))          \
    EACH(void, DepthFunc, (GLenum function))                                                       \
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
    EACH(void, Uniform1i, (GLint at, GLint value))                                                 \
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

/* Returns false after any error of OpenGL since the last call. */
bool functions_succeeded(const struct gl_functions *call, struct error *err);

/* ---- context.c: a library in use, and what it draws on ---- */

/* The choice of --gl: see driver_accepts_library. "auto" (NULL too) takes the first of osmesa and
 * egl that is there. driver: Mesa's; NULL: any. threads: of llvmpipe. */
struct context_wish {
    const char *library, *driver;
    int threads;
    enum gl_way way; /* by shaders: EGL only */
};
/* A library in use. */
struct contexts {
    const char *name; /* "OSMesa" or "EGL" */
    enum gl_way way;
    struct gl_functions call;
    bool flipped;  /* the first row that OpenGL draws is the top of the picture */
    bool mirrored; /* the projection must turn y around for this, so that fronts go round with the
                      clock; known when a canvas is open */
    struct canvas *current;
    const struct context_kind *kind; /* NULL: no library was found */
    void *own;                       /* of osmesa.c or egl.c; owned */
};

/* A context with a buffer of colours, RGBA, 24 bits of depth and 8 of stencil. It has state of its
 * own, and shares no objects. */
struct canvas;
struct canvas_size {
    int bits, width, height; /* bits: of a channel, 8, 10 (EGL), 16, or 32 of floats */
    int n_colours;           /* buffers of colours, where shaders draw; otherwise 1 */
};
void canvas_close(struct canvas *canvas); /* NULL is fine */
/* Makes OpenGL draw on the canvas, whose pixels go to the caller's memory: rows from the top. */
bool canvas_use(struct canvas *canvas, void *pixels, struct error *err);
/* Waits, and reads one of the buffers of colours of a canvas of EGL. */
void canvas_read(const struct canvas *canvas, int colour, void *pixels);
/* Returns whether OpenGL has an extension; a canvas is open. */
bool contexts_have(const struct contexts *contexts, const char *extension);

/* ---- opened.c: what can be used ---- */

/* Opens a library and closes it. For a process of its own, which opens no other one. */
bool contexts_describe(const struct context_wish *wish, struct context_description *out,
                       struct error *err);

/* Finds how many devices EGL lists; 0 without EGL. For a process of its own. */
bool contexts_devices(int *out, struct error *err);

struct canvas {
    struct contexts *contexts;
    struct canvas_size size;
    void *context; /* the library's; NULL: none */
    void *pixels;
};

/* ---- opened.c: what renderers through OpenGL share ---- */

/* A room embeds it as the first member of a struct of its own. */
struct drawing {
    struct renderer renderer; /* the first member */
    const struct plan *plan;
    const struct lit_scene *lit; /* NULL: not taken yet */
    struct contexts *contexts;
    const struct gl_functions *call;
    struct driver_threads before; /* the first context */
    /* names of the buffer objects of meshes, 0: not in view; of triangles: each mesh's, then those
     * of instances that hide some; of the objects of each texture, 0: not drawn; owned */
    unsigned *objects, *indices, *textures;
    int n_units; /* objects of each texture: one for each pass that is drawn at once */
    /* 4 floats a pixel: of some lights, NULL: one pass has all; numbers, NULL: no check; owned */
    float *part, *shown;
    uint32_t *depths; /* 24 bits of depth, 8 of stencil; NULL: no check, or not to be read; owned */
    uint8_t *
        reached; /* [light with shadows][pixel]: it reaches the pixel; NULL: there is none; owned */
    uint32_t *counts; /* as depths, but of shadow volumes; owned */
    bool has_shadows; /* `reached` is of this tile; a renderer that aims resets it */
    struct rectangle tile;
};
/* Makes buffers, and opens the library that the plan asks for. drawing_close frees all with the
 * struct that begins with *of, also after a failure; its canvases are closed before. */
bool drawing_open(struct drawing *of, int n_buffers, struct error *err);
void drawing_close(struct drawing *of);
/* Opens a canvas of the size of a tile: see canvas_open. */
bool drawing_canvas(const struct drawing *of, int bits, int n_colours, struct canvas **out,
                    struct error *err);
/* Takes the names of what draws the plan, and the driver of that name. A canvas is in use. Refuses
 * a tile that is too large for OpenGL, another driver than the wanted one, which was chosen before
 * the first canvas, and what driver_has_threads refuses. The bounds of raster/bounds hold for the
 * shaders of a known driver as for its own lighting: the shaders do the same operations, and both
 * measure the same (traits.py). */
bool drawing_accept(struct drawing *of, struct error *err);
/* As struct renderer_kind says. The first uploads all but the texels of spectral textures into the
 * current context. */
bool drawing_take_scene(struct renderer *renderer, const struct lit_scene *lit, struct error *err);
struct shown drawing_shown(const struct renderer *renderer, int x, int y);
void drawing_set_viewport(const struct drawing *of); /* of the tile */
void drawing_read_depths(const struct drawing *of);  /* if they are wanted */
/* Empties all depths, and stale colours: those of another tile. They are stale no more. */
void drawing_clear(const struct drawing *of, bool *is_stale);

/* Binds the vertices of an instance, VERTEX_NUMBERS floats each, and its triangles. Returns how
 * many corners these have. */
int mesh_bind(const struct drawing *of, int instance);

/* Binds an object of a texture of the plan to its unit. */
void texture_bind(const struct drawing *of, int index, int unit);
/* Uploads the texels of a spectral texture for the bands of a pass into the bound texture. */
bool texture_upload_bands(const struct drawing *of, int index, int first_band, struct error *err);

/* A corner of a triangle that is drawn in its number: see shown_of. */
struct numbered_vertex {
    float position[3], number[3];
};
/* Draws all instances that reach the tile: places each, and gives its triangles that are not hidden
 * to `draw`, some at a time. */
struct numbered_draw {
    void (*place)(struct drawing *of, int instance);
    void (*draw)(struct drawing *of, const struct numbered_vertex *corners, int n);
};
bool numbers_draw(struct drawing *of, const struct numbered_draw *by, struct error *err);

/* ---- shadows.c ---- */

/* Finds the pixels of the tile that each light with shadows reaches. Colours stay what they are. */
bool shadows_draw(struct drawing *of, const struct numbered_draw *by, struct error *err);
/* Returns whether the light of a group reaches each pixel of the tile; NULL: the group has no
 * shadows. */
const uint8_t *shadows_of(const struct drawing *of, int group);

/* Writes name, version and driver of the library that is used by default. */
void gl_library(char *out, size_t capacity);
/* Opens OpenGL for a plan: see struct drawing_ways. */
bool gl_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err);

#endif
