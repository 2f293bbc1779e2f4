/* SPDX-License-Identifier: MIT */
/* The room "library": a library of OpenGL that is opened at run time, and the functions of OpenGL
 * that the program calls. */
#ifndef LIBRARY_H
#define LIBRARY_H

#include <GL/gl.h>
/* after GL/gl.h */
#include <GL/glext.h>

#include "data/base/base.h"
#include "raster/driver/driver.h"
#include "spectral.h"

/* ---- library.c: files of libraries ---- */

typedef void any_function(void);
/* Opens the first of the files that is there; NULL ends the list. *out is NULL if none is. The
 * library stays open as long as the program runs: Mesa's may not be closed. */
bool library_open(const char *const *files, void **out, struct error *err);
/* Finds a function of an open library, or one of that name that was loaded before it; NULL: there
 * is none. `out` points to a pointer to the function. */
void library_find(void *library, const char *name, void *out);

/* ---- functions.c: the functions of OpenGL ---- */

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
    EACH(void, ClearColor, (GLclampf red, GLclampf green, GLclampf blue, GLclampf alpha))          \
    EACH(void, DepthFunc, (GLenum function))                                                       \
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
    EACH(void, TexImage2D,                                                                         \
         (GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height, GLint border, \
          GLenum format, GLenum type, const void *pixels))                                         \
    EACH(void, TexParameteri, (GLenum target, GLenum name, GLint value))                           \
    EACH(void, Viewport, (GLint x, GLint y, GLsizei width, GLsizei height))
#define FIXED_FUNCTIONS(EACH)                                                                      \
    EACH(void, ClampColorARB, (GLenum target, GLenum clamp))                                       \
    EACH(void, Color4f, (GLfloat red, GLfloat green, GLfloat blue, GLfloat alpha))                 \
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
    EACH(void, PopMatrix, (void))                                                                  \
    EACH(void, PushMatrix, (void))                                                                 \
    EACH(void, Rectf, (GLfloat left, GLfloat bottom, GLfloat right, GLfloat top))                  \
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
/* Finds the functions of a way, in the library (NULL: none), or by what its own function finds; all
 * others are NULL. Fails with EXIT_SYSTEM if one is missing. `name`: the library's. */
struct gl_source {
    void *library;
    any_function *(*get)(const char *name);
    const char *name;
};
bool functions_find(const struct gl_source *in, enum gl_way way, struct gl_functions *out,
                    struct error *err);
/* Returns false after any error of OpenGL since the last call. */
bool functions_succeeded(const struct gl_functions *call, struct error *err);

/* ---- program.c: programs of shaders ---- */

/* Prints the first lines of a shader. */
void program_begin(enum gl_way way, struct printed *to);
/* Compiles two complete shaders, links and uses them; *out is the program's name. Frees both texts,
 * also after a failure. */
bool program_end(const struct gl_functions *call, struct printed *vertex, struct printed *fragment,
                 unsigned *out, struct error *err);

#endif
