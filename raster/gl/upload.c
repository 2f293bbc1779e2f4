/* SPDX-License-Identifier: MIT */
/* Meshes and textures as OpenGL keeps them. Geometry is uploaded once; a spectral texture's texels
 * are uploaded anew for each pass. Only this file says how a vertex lies in a buffer. */
#include <stdlib.h>
#include <string.h>

#include "data/mesh/mesh.h"
#include "raster/context/context.h"
#include "raster/gl/gl.h"

enum { VERTICES, COORDINATES, BUFFERS };

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

/* Fills a buffer that has no name yet with what `copy` takes from each vertex, n_floats of them. */
static bool upload_vertices(const struct gl *gl, GLuint *name, const struct mesh *mesh,
                            size_t n_floats, void (*copy)(const struct vertex *from, GLfloat *to),
                            struct error *err)
{
    const size_t n = (size_t)mesh->n_vertices, size = n_floats * sizeof(GLfloat);
    GLfloat *floats = *name ? NULL : malloc(n * size);
    if (!floats)
        return *name || error_memory(err);
    for (size_t i = 0; i < n; i++)
        copy(&mesh->vertices[i], floats + n_floats * i);
    gl->call->GenBuffers(1, name);
    gl->call->BindBuffer(GL_ARRAY_BUFFER, *name);
    gl->call->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(n * size), floats, GL_STATIC_DRAW);
    free(floats);
    return true;
}

static bool shows_texture(const struct gl *gl, int instance)
{
    const int shaded = gl->plan->instances[instance].shaded;
    return texture_is_drawn(gl->plan, gl->plan->materials[shaded].texture);
}

static bool upload_mesh(const struct gl *gl, int instance, struct error *err)
{
    const int index = gl->plan->instances[instance].mesh;
    const struct mesh *mesh = &gl->plan->meshes[index].mesh;
    GLuint *buffers = gl->objects + BUFFERS * index;
    return upload_vertices(gl, &buffers[VERTICES], mesh, VERTEX_FLOATS, copy_vertex, err) &&
           (!shows_texture(gl, instance) ||
            upload_vertices(gl, &buffers[COORDINATES], mesh, COORDINATE_FLOATS, copy_coordinates,
                            err));
}

/* Returns the name of the buffer of an instance's triangles: its mesh's, or its own if it hides
 * some of them. 0: there is none yet. */
static GLuint *index_buffer(const struct gl *gl, int instance)
{
    return &gl->indices[gl->lit->bounds[instance].hidden ? gl->plan->n_meshes + instance
                                                         : gl->plan->instances[instance].mesh];
}

/* Fills the bound buffer with the triangles of an instance that are not hidden. */
static bool upload_triangles(const struct gl *gl, int instance, struct error *err)
{
    const struct mesh *mesh = &gl->plan->meshes[gl->plan->instances[instance].mesh].mesh;
    const bool *hidden = gl->lit->bounds[instance].hidden;
    const size_t size = sizeof *mesh->triangles;
    size_t n = 0;
    char *indices = malloc((size_t)mesh->n_triangles * size + 1);
    if (!indices)
        return error_memory(err);
    for (int i = 0; i < mesh->n_triangles; i++)
        if (!hidden || !hidden[i])
            memcpy(indices + size * n++, mesh->triangles[i], size);
    gl->call->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(n * size), indices, GL_STATIC_DRAW);
    free(indices);
    return true;
}

int gl_bind_mesh(const struct gl *gl, int instance)
{
    const GLsizei step = VERTEX_FLOATS * sizeof(GLfloat);
    const struct placed_instance *placed = &gl->plan->instances[instance];
    const GLuint *buffers = gl->objects + BUFFERS * placed->mesh;
    gl->call->BindBuffer(GL_ARRAY_BUFFER, buffers[VERTICES]);
    gl->call->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, *index_buffer(gl, instance));
    gl->call->VertexPointer(3, GL_FLOAT, step, NULL); /* offsets into the bound buffer */
    gl->call->NormalPointer(GL_FLOAT, step, (const void *)(3 * sizeof(GLfloat)));
    if (shows_texture(gl, instance)) {
        gl->call->BindBuffer(GL_ARRAY_BUFFER, buffers[COORDINATES]);
        gl->call->TexCoordPointer(2, GL_FLOAT, 0, NULL);
    }
    return 3 * (placed->instance.n_triangles - gl->lit->bounds[instance].n_hidden);
}

/* ---- textures ---- */

/* Texels are of single precision: Mesa filters texels of 8 bits with weights of 8 bits. A spectral
 * texture has no texels yet. */
static bool upload_texture(const struct gl *gl, const struct texture *texture, GLuint *name,
                           struct error *err)
{
    GLint filter = texture->linear ? GL_LINEAR : GL_NEAREST, largest = 0;
    gl->call->GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    if (texture->image.width > largest || texture->image.height > largest)
        return error_system(err, "%.500s: this OpenGL has textures of at most %d texels a side",
                            texture->image.path, largest);
    gl->call->GenTextures(1, name);
    gl->call->BindTexture(GL_TEXTURE_2D, *name);
    gl->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    gl->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    gl->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    gl->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_REPEAT);
    if (!texture->spectral)
        gl->call->TexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE32F_ARB, texture->image.width,
                             texture->image.height, 0, GL_LUMINANCE, GL_FLOAT, texture->plane[0]);
    return true;
}

static bool upload_textures(struct gl *gl, struct error *err)
{
    const size_t n = (size_t)gl->plan->n_textures;
    gl->textures = calloc(n + 1, sizeof *gl->textures);
    if (!gl->textures)
        return error_memory(err);
    for (size_t i = 0; i < n; i++)
        if (texture_is_drawn(gl->plan, &gl->plan->textures[i]) &&
            !upload_texture(gl, &gl->plan->textures[i], &gl->textures[i], err))
            return false;
    return true;
}

static void switch_textures(const struct gl *gl, bool on)
{
    (on ? gl->call->Enable : gl->call->Disable)(GL_TEXTURE_2D);
    (on ? gl->call->EnableClientState : gl->call->DisableClientState)(GL_TEXTURE_COORD_ARRAY);
}

void gl_bind_texture(struct gl *gl, const struct texture *texture)
{
    const struct texture *drawn = texture_is_drawn(gl->plan, texture) ? texture : NULL;
    if (!drawn != !gl->texture)
        switch_textures(gl, drawn != NULL);
    if (drawn && drawn != gl->texture)
        gl->call->BindTexture(GL_TEXTURE_2D, gl->textures[texture - gl->plan->textures]);
    gl->texture = drawn;
}

static bool upload_texture_bands(struct gl *gl, int index, int first_band, struct error *err)
{
    struct texture *texture = &gl->plan->textures[index];
    const int width = texture->image.width, height = texture->image.height;
    float *texels = calloc((size_t)width * (size_t)height, BANDS_PER_PASS * sizeof *texels);
    const bool done =
        texels ? pass_texels(gl->plan, texture, first_band, texels, err) : error_memory(err);
    gl_bind_texture(gl, texture);
    if (done)
        gl->call->TexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F_ARB, width, height, 0, GL_RGB, GL_FLOAT,
                             texels);
    free(texels);
    return done;
}

bool gl_upload_bands(struct gl *gl, int first_band, struct error *err)
{
    for (int i = 0; i < gl->plan->n_textures; i++)
        if (gl->textures[i] && gl->plan->textures[i].spectral &&
            !upload_texture_bands(gl, i, first_band, err))
            return false;
    return true;
}

/* ---- the scene ---- */

/* Nothing is uploaded twice, and nothing of an instance out of view. */
static bool upload_instance(const struct gl *gl, int instance, struct error *err)
{
    GLuint *indices = index_buffer(gl, instance);
    if (!gl->plan->instances[instance].in_view)
        return true;
    if (!upload_mesh(gl, instance, err))
        return false;
    if (*indices)
        return true;
    gl->call->GenBuffers(1, indices);
    gl->call->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, *indices);
    return upload_triangles(gl, instance, err);
}

bool gl_take_scene(struct renderer *renderer, const struct lit_scene *lit, struct error *err)
{
    struct gl *gl = (struct gl *)renderer;
    const size_t n_instances = (size_t)gl->plan->n_instances, n_meshes = (size_t)gl->plan->n_meshes;
    gl->lit = lit;
    gl->objects = calloc(BUFFERS * n_meshes + 1, sizeof *gl->objects);
    gl->indices = calloc(n_meshes + n_instances + 1, sizeof *gl->indices);
    if (!gl->objects || !gl->indices)
        return error_memory(err);
    for (int i = 0; i < gl->plan->n_instances; i++)
        if (!upload_instance(gl, i, err))
            return false;
    return upload_textures(gl, err) && gl_succeeded(gl, err);
}
