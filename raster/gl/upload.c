/* SPDX-License-Identifier: MIT */
/* Meshes and textures as OpenGL keeps them. Geometry is uploaded once; a spectral texture's texels
 * are uploaded anew for each pass. Only this file says how a vertex lies in a buffer. */
#include <stdlib.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>

#include "data/mesh/mesh.h"
#include "raster/gl/gl.h"

enum { VERTICES, INDICES, COORDINATES, BUFFERS };

/* Floats of a vertex in its two buffers: position and normal; texture coordinates, which only
 * textured meshes have. */
enum { VERTEX_FLOATS = 6, COORDINATE_FLOATS = 2 };

/* ---- meshes ---- */

static void copy_vertex(const struct vertex *from, GLfloat *to)
{
    const struct vector p = from->position, n = from->normal;
    const double values[VERTEX_FLOATS] = {p.x, p.y, p.z, n.x, n.y, n.z};
    for (int i = 0; i < VERTEX_FLOATS; i++)
        to[i] = (GLfloat)values[i];
}

static void copy_coordinates(const struct vertex *from, GLfloat *to)
{
    to[0] = (GLfloat)from->s;
    to[1] = (GLfloat)from->t;
}

/* Fills the bound buffer with what `copy` takes from each vertex, n_floats of them. */
static bool upload_vertices(const struct mesh *mesh, size_t n_floats,
                            void (*copy)(const struct vertex *from, GLfloat *to), struct error *err)
{
    const size_t n = (size_t)mesh->n_vertices, size = n_floats * sizeof(GLfloat);
    GLfloat *floats = malloc(n * size);
    if (!floats)
        return error_memory(err);
    for (size_t i = 0; i < n; i++)
        copy(&mesh->vertices[i], floats + n_floats * i);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(n * size), floats, GL_STATIC_DRAW);
    free(floats);
    return true;
}

static bool upload_mesh(const struct gl *gl, int index, struct error *err)
{
    const struct mesh *mesh = &gl->plan->meshes[index].mesh;
    const GLuint *buffers = gl->buffers + BUFFERS * index;
    if (mesh->n_triangles == 0)
        return true;
    glBindBuffer(GL_ARRAY_BUFFER, buffers[VERTICES]);
    if (!upload_vertices(mesh, VERTEX_FLOATS, copy_vertex, err))
        return false;
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[INDICES]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER,
                 (GLsizeiptr)((size_t)mesh->n_triangles * sizeof *mesh->triangles), mesh->triangles,
                 GL_STATIC_DRAW);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[COORDINATES]);
    return !gl->plan->meshes[index].textured ||
           upload_vertices(mesh, COORDINATE_FLOATS, copy_coordinates, err);
}

static bool upload_meshes(struct gl *gl, struct error *err)
{
    int n_meshes = gl->plan->n_meshes;
    gl->buffers = calloc(BUFFERS * (size_t)n_meshes + 1, sizeof *gl->buffers);
    if (!gl->buffers)
        return error_memory(err);
    glGenBuffers(BUFFERS * n_meshes, gl->buffers);
    for (int i = 0; i < n_meshes; i++)
        if (!upload_mesh(gl, i, err))
            return false;
    return true;
}

void gl_bind_mesh(const struct gl *gl, int mesh, bool textured)
{
    const GLsizei step = VERTEX_FLOATS * sizeof(GLfloat);
    const GLuint *buffers = gl->buffers + BUFFERS * mesh;
    glBindBuffer(GL_ARRAY_BUFFER, buffers[VERTICES]);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[INDICES]);
    glVertexPointer(3, GL_FLOAT, step, NULL); /* offsets into the bound buffer */
    glNormalPointer(GL_FLOAT, step, (const void *)(3 * sizeof(GLfloat)));
    if (textured) {
        glBindBuffer(GL_ARRAY_BUFFER, buffers[COORDINATES]);
        glTexCoordPointer(2, GL_FLOAT, 0, NULL);
    }
}

/* ---- textures ---- */

/* Texels are of single precision: Mesa filters texels of 8 bits with weights of 8 bits. A spectral
 * texture has no texels yet. */
static bool upload_texture(const struct texture *texture, GLuint name, struct error *err)
{
    GLint filter = texture->linear ? GL_LINEAR : GL_NEAREST, largest = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    if (texture->image.width > largest || texture->image.height > largest)
        return error_system(err, "%.500s: this OpenGL has textures of at most %d texels a side",
                            texture->image.path, largest);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_REPEAT);
    if (!texture->spectral)
        glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE32F_ARB, texture->image.width,
                     texture->image.height, 0, GL_LUMINANCE, GL_FLOAT, texture->plane[0]);
    return true;
}

static bool upload_textures(struct gl *gl, struct error *err)
{
    int n_textures = gl->plan->n_textures;
    if (n_textures == 0)
        return true;
    gl->textures = calloc((size_t)n_textures, sizeof *gl->textures);
    if (!gl->textures)
        return error_memory(err);
    glGenTextures(n_textures, gl->textures);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, GL_MODULATE);
    for (int i = 0; i < n_textures; i++)
        if (!upload_texture(&gl->plan->textures[i], gl->textures[i], err))
            return false;
    return true;
}

/* Uploads the planes of a spectral texture that are loaded. */
static bool upload_planes(const struct texture *texture, GLuint name, struct error *err)
{
    size_t n = (size_t)texture->image.width * (size_t)texture->image.height;
    float *texels = malloc(n * BANDS_PER_PASS * sizeof *texels);
    if (!texels)
        return error_memory(err);
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < BANDS_PER_PASS; c++)
            texels[BANDS_PER_PASS * i + c] = texture->plane[c] ? texture->plane[c][i] : 0;
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F_ARB, texture->image.width, texture->image.height, 0,
                 GL_RGB, GL_FLOAT, texels);
    free(texels);
    return true;
}

void gl_bind_texture(const struct gl *gl, const struct texture *texture)
{
    if (!texture) {
        glDisable(GL_TEXTURE_2D);
        glDisableClientState(GL_TEXTURE_COORD_ARRAY);
        return;
    }
    glBindTexture(GL_TEXTURE_2D, gl->textures[texture - gl->plan->textures]);
    glEnable(GL_TEXTURE_2D);
    glEnableClientState(GL_TEXTURE_COORD_ARRAY);
}

bool gl_upload_bands(const struct gl *gl, struct error *err)
{
    const struct plan *plan = gl->plan;
    for (int i = 0; i < plan->n_textures; i++)
        if (plan->textures[i].spectral && !upload_planes(&plan->textures[i], gl->textures[i], err))
            return false;
    return true;
}

bool gl_upload(struct gl *gl, struct error *err)
{
    return upload_meshes(gl, err) && upload_textures(gl, err);
}
