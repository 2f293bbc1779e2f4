/* SPDX-License-Identifier: MIT */
/* Meshes and textures as OpenGL keeps them. Geometry is uploaded once; a spectral texture's texels
 * are uploaded anew for each pass. Only this file says how a vertex lies in a buffer. */
#include <stdlib.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>

#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "data/tiff/tiff.h"
#include "raster/gl/gl.h"
#include "raster/plan/plan.h"
#include "spectral.h"

enum { VERTICES, INDICES, COORDINATES, BUFFERS };

/* A vertex as OpenGL reads it. Texture coordinates have a buffer of their own, which only textured
 * meshes fill. */
struct gl_vertex {
    GLfloat position[3], normal[3];
};
struct gl_coordinates {
    GLfloat s, t;
};

/* ---- meshes ---- */

static bool upload_vertices(const struct mesh *mesh, struct error *err)
{
    struct gl_vertex *copy = malloc((size_t)mesh->n_vertices * sizeof *copy);
    if (!copy)
        return error_memory(err);
    for (int i = 0; i < mesh->n_vertices; i++) {
        struct vector p = mesh->vertices[i].position, n = mesh->vertices[i].normal;
        copy[i] = (struct gl_vertex){{(GLfloat)p.x, (GLfloat)p.y, (GLfloat)p.z},
                                     {(GLfloat)n.x, (GLfloat)n.y, (GLfloat)n.z}};
    }
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)((size_t)mesh->n_vertices * sizeof *copy), copy,
                 GL_STATIC_DRAW);
    free(copy);
    return true;
}

static bool upload_coordinates(const struct mesh *mesh, struct error *err)
{
    struct gl_coordinates *copy = malloc((size_t)mesh->n_vertices * sizeof *copy);
    if (!copy)
        return error_memory(err);
    for (int i = 0; i < mesh->n_vertices; i++)
        copy[i] =
            (struct gl_coordinates){(GLfloat)mesh->vertices[i].s, (GLfloat)mesh->vertices[i].t};
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)((size_t)mesh->n_vertices * sizeof *copy), copy,
                 GL_STATIC_DRAW);
    free(copy);
    return true;
}

static bool upload_mesh(const struct gl *gl, int index, struct error *err)
{
    const struct mesh *mesh = &gl->plan->meshes[index].mesh;
    const GLuint *buffers = gl->buffers + BUFFERS * index;
    if (mesh->n_triangles == 0)
        return true;
    glBindBuffer(GL_ARRAY_BUFFER, buffers[VERTICES]);
    if (!upload_vertices(mesh, err))
        return false;
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[INDICES]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER,
                 (GLsizeiptr)((size_t)mesh->n_triangles * sizeof *mesh->triangles), mesh->triangles,
                 GL_STATIC_DRAW);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[COORDINATES]);
    return !gl->plan->meshes[index].textured || upload_coordinates(mesh, err);
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
    const struct gl_vertex *first = NULL; /* offsets into the bound buffer */
    const GLuint *buffers = gl->buffers + BUFFERS * mesh;
    glBindBuffer(GL_ARRAY_BUFFER, buffers[VERTICES]);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[INDICES]);
    glVertexPointer(3, GL_FLOAT, sizeof *first, (const void *)offsetof(struct gl_vertex, position));
    glNormalPointer(GL_FLOAT, sizeof *first, (const void *)offsetof(struct gl_vertex, normal));
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
