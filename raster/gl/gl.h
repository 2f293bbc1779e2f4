/* SPDX-License-Identifier: MIT */
/* The room "gl": OpenGL without a window, by a library of OSMesa or of EGL that is opened at run
 * time, so that the program starts without both. (The static program has an OSMesa of its own, and
 * no EGL.) Draws the plan's picture, a tile and a pass at a time, and says which triangle OpenGL
 * shows at each pixel. It may not know what the reference shows: of lit scenes it reads only where
 * each surface lies in the window, so that it draws nothing that a tile cannot show. Renderers by
 * shaders share meshes, textures and numbers of triangles with it. */
#ifndef RASTER_GL_GL_H
#define RASTER_GL_GL_H

#define GL_GLEXT_PROTOTYPES /* for the types of all functions */
#include <GL/gl.h>
#include <GL/glext.h>

#include "raster/bounds/bounds.h"

/* ---- library.c: the functions of OpenGL ---- */

/* Each calls EACH(name without "gl"): the functions that every OpenGL and OpenGL ES has; those of
 * lighting without shaders; those of shaders. The headers of OpenGL give their types. */
/* clang-format off */
#define COMMON_FUNCTIONS(EACH)                                                                     \
    EACH(BindBuffer) EACH(BindFramebuffer) EACH(BindRenderbuffer) EACH(BindTexture)                \
    EACH(BufferData) EACH(CheckFramebufferStatus) EACH(Clear) EACH(ClearColor) EACH(DepthFunc)     \
    EACH(Disable) EACH(DrawArrays) EACH(DrawElements) EACH(Enable) EACH(Finish)                    \
    EACH(FramebufferRenderbuffer) EACH(FrontFace) EACH(GenBuffers) EACH(GenFramebuffers)           \
    EACH(GenRenderbuffers) EACH(GenTextures) EACH(GetError) EACH(GetIntegerv) EACH(GetString)      \
    EACH(ReadPixels) EACH(RenderbufferStorage) EACH(StencilOp) EACH(TexImage2D)                    \
    EACH(TexParameteri) EACH(Viewport)
#define FIXED_FUNCTIONS(EACH)                                                                      \
    EACH(ClampColorARB) EACH(Color4f) EACH(ColorPointer) EACH(DisableClientState)                  \
    EACH(EnableClientState) EACH(LightModelfv) EACH(LightModeli) EACH(Lightf) EACH(Lightfv)        \
    EACH(LoadIdentity) EACH(LoadMatrixd) EACH(Materialf) EACH(Materialfv) EACH(MatrixMode)         \
    EACH(NormalPointer) EACH(PopMatrix) EACH(PushMatrix) EACH(Rectf) EACH(ShadeModel)              \
    EACH(TexCoordPointer) EACH(VertexPointer)
#define SHADER_FUNCTIONS(EACH)                                                                     \
    EACH(ActiveTexture) EACH(AttachShader) EACH(BindVertexArray) EACH(CompileShader)               \
    EACH(CreateProgram) EACH(CreateShader) EACH(DisableVertexAttribArray) EACH(DrawBuffers)        \
    EACH(EnableVertexAttribArray) EACH(GenVertexArrays) EACH(GetProgramiv) EACH(GetShaderInfoLog)  \
    EACH(GetShaderiv) EACH(GetStringi) EACH(GetUniformLocation) EACH(LinkProgram)                  \
    EACH(ReadBuffer) EACH(ShaderSource) EACH(Uniform1f) EACH(Uniform1fv) EACH(Uniform1i)           \
    EACH(Uniform3fv) EACH(Uniform4fv) EACH(UniformMatrix3fv) EACH(UniformMatrix4fv)                \
    EACH(UseProgram) EACH(VertexAttribPointer)
/* clang-format on */
#define GL_FUNCTION(name) __typeof__(gl##name) *name;
struct gl_functions {
    COMMON_FUNCTIONS(GL_FUNCTION)
    FIXED_FUNCTIONS(GL_FUNCTION)
    SHADER_FUNCTIONS(GL_FUNCTION)
};

/* Returns false after any error of OpenGL since the last call. */
bool functions_succeeded(const struct gl_functions *call, struct error *err);

/* ---- gl_program.c: programs of shaders ---- */

/* Prints the first lines of a shader. */
void program_begin(enum gl_way way, struct printed *to);
/* Compiles two complete shaders, links and uses them; *out is the program's name. Frees both texts,
 * also after a failure. */
bool program_end(const struct gl_functions *call, struct printed *vertex, struct printed *fragment,
                 unsigned *out, struct error *err);

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
    /* what the library does for a canvas; by osmesa.c or egl.c */
    const struct context_kind {
        bool (*open)(struct canvas *canvas, struct error *err);
        bool (*use)(struct canvas *canvas, struct error *err);
        void (*fill)(const struct canvas *canvas);
        void (*close)(struct canvas *canvas);
        void (*end)(struct contexts *contexts);
    } * kind;
    void *own; /* of osmesa.c or egl.c; owned */
};
/* Opens a library. Fails with EXIT_SYSTEM, and names the packages, where it is missing. One process
 * opens one of them. contexts_close frees *out, also after a failure. */
bool contexts_open(const struct context_wish *wish, struct contexts **out, struct error *err);
void contexts_close(struct contexts *contexts); /* NULL is fine; after all of its canvases */

/* A context with a buffer of colours, RGBA, 24 bits of depth and 8 of stencil. It has state of its
 * own, and shares no objects. */
struct canvas;
struct canvas_size {
    int bits, width, height; /* bits: of a channel, 8, 16, or 32 of floats */
    int n_colours;           /* buffers of colours, where shaders draw; otherwise 1 */
};
/* The caller closes *out, also after a failure. */
bool canvas_open(struct contexts *contexts, const struct canvas_size *size, struct canvas **out,
                 struct error *err);
void canvas_close(struct canvas *canvas); /* NULL is fine */
/* Makes OpenGL draw on the canvas, whose pixels go to the caller's memory: rows from the top. */
bool canvas_use(struct canvas *canvas, void *pixels, struct error *err);
/* Waits until all is drawn, and has filled the caller's pixels. */
void canvas_fill(const struct canvas *canvas);
/* Waits, and reads one of the buffers of colours of a canvas of EGL. */
void canvas_read(const struct canvas *canvas, int colour, void *pixels);
/* Returns whether OpenGL has an extension; a canvas is open. */
bool contexts_have(const struct contexts *contexts, const char *extension);

/* ---- opened.c: what can be used ---- */

struct context_description {
    struct renderer_names names;
    char vendor[128];
    int largest_viewport[2], largest_texture; /* pixels, texels, a side */
};
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
    struct rectangle tile;
};
/* Makes buffers, and opens the library that the plan asks for. drawing_close frees all with the
 * struct that begins with *of, also after a failure; its canvases are closed before. */
bool drawing_open(struct drawing *of, int n_buffers, struct error *err);
void drawing_close(struct drawing *of);
/* Opens a canvas of the size of a tile: see canvas_open. */
bool drawing_canvas(const struct drawing *of, int bits, int n_colours, struct canvas **out,
                    struct error *err);
/* Takes the names of what draws the plan, and the bounds by which it is judged: an unknown driver
 * is measured first. A canvas is in use. Refuses a tile that is too large for OpenGL, another
 * driver than the wanted one, which was chosen before the first canvas, and what driver_has_threads
 * refuses. The bounds of raster/bounds hold for the shaders of a known driver as for its own
 * lighting: the shaders do the same operations, and both measure the same (traits.py). */
bool drawing_accept(struct drawing *of, struct error *err);
/* As struct renderer_kind says. The first uploads all but the texels of spectral textures into the
 * current context. */
bool drawing_take_scene(struct renderer *renderer, const struct lit_scene *lit, struct error *err);
struct shown drawing_shown(const struct renderer *renderer, int x, int y);
void drawing_set_viewport(const struct drawing *of); /* of the tile */
void drawing_read_depths(const struct drawing *of);  /* if they are wanted */

/* Floats of a vertex in its two buffers: position and normal; texture coordinates, which only
 * textured meshes have. */
enum { VERTEX_FLOATS = 6, COORDINATE_FLOATS = 2 };
/* Binds the triangles of an instance. Returns how many corners they have. */
int mesh_bind_triangles(const struct drawing *of, int instance);
/* Bind the buffer of positions and normals, and that of texture coordinates; the latter returns
 * false where the instance shows no texture. */
void mesh_bind_vertices(const struct drawing *of, int instance);
bool mesh_bind_coordinates(const struct drawing *of, int instance);

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

/* Writes name, version and driver of the library that is used by default. */
void gl_library(char *out, size_t capacity);
/* Opens OpenGL for a plan: see struct drawing_ways. */
bool gl_open(const struct plan *plan, int n_buffers, struct renderer **out, struct error *err);

#endif
