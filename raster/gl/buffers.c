/* SPDX-License-Identifier: MIT */
/* Geometry is uploaded once. Only this file says how a vertex lies in a buffer. */
#include <stdlib.h>
#include <string.h>

#include "data/mesh/mesh.h"
#include "raster/gl/inside.h"

enum { VERTICES, COORDINATES, BUFFERS };

static void copy_vertex(const struct vertex *from, float *to)
{
    const struct vector p = from->position, n = from->normal;
    const double values[VERTEX_FLOATS] = {p.x, p.y, p.z, n.x, n.y, n.z};
    for (int i = 0; i < VERTEX_FLOATS; i++)
        to[i] = (float)values[i];
}

static void copy_coordinates(const struct vertex *from, float *to)
{
    to[0] = (float)from->s;
    to[1] = (float)from->t;
}

/* Fills a buffer that has no name yet with what `copy` takes from each vertex, n_floats of them. */
static bool upload_vertices(const struct drawing *of, GLuint *name, const struct mesh *mesh,
                            size_t n_floats, void (*copy)(const struct vertex *from, float *to),
                            struct error *err)
{
    const size_t n = (size_t)mesh->n_vertices;
    float *floats;
    if (*name || !MAKE_ARRAY(floats, n * n_floats, err, "%zu vertices of a mesh", n))
        return *name;
    for (size_t i = 0; i < n; i++)
        copy(&mesh->vertices[i], floats + n_floats * i);
    of->call->GenBuffers(1, name);
    of->call->BindBuffer(GL_ARRAY_BUFFER, *name);
    of->call->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(n * n_floats * sizeof *floats), floats,
                         GL_STATIC_DRAW);
    free(floats);
    return true;
}

static bool shows_texture(const struct drawing *of, int instance)
{
    const int shaded = of->plan->instances[instance].shaded;
    return texture_is_drawn(of->plan, of->plan->materials[shaded].texture);
}

static bool upload_mesh(const struct drawing *of, int instance, struct error *err)
{
    const int index = of->plan->instances[instance].mesh;
    const struct mesh *mesh = &of->plan->meshes[index].mesh;
    GLuint *buffers = of->objects + BUFFERS * index;
    return upload_vertices(of, &buffers[VERTICES], mesh, VERTEX_FLOATS, copy_vertex, err) &&
           (!shows_texture(of, instance) ||
            upload_vertices(of, &buffers[COORDINATES], mesh, COORDINATE_FLOATS, copy_coordinates,
                            err));
}

/* Returns the name of the buffer of an instance's triangles: its mesh's, or its own if it hides
 * some of them. 0: there is none yet. */
static GLuint *index_buffer(const struct drawing *of, int instance)
{
    return &of->indices[of->lit->bounds[instance].hidden ? of->plan->n_meshes + instance
                                                         : of->plan->instances[instance].mesh];
}

/* Fills the bound buffer with the triangles of an instance that are not hidden. */
static bool upload_triangles(const struct drawing *of, int instance, struct error *err)
{
    const struct mesh *mesh = &of->plan->meshes[of->plan->instances[instance].mesh].mesh;
    const bool *hidden = of->lit->bounds[instance].hidden;
    const size_t size = sizeof *mesh->triangles;
    size_t n = 0;
    char *indices;
    if (!MAKE_ARRAY(indices, (size_t)mesh->n_triangles * size, err, "the triangles of %s",
                    object_name(of->plan, instance)))
        return false;
    for (int i = 0; i < mesh->n_triangles; i++)
        if (!hidden || !hidden[i])
            memcpy(indices + size * n++, mesh->triangles[i], size);
    of->call->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(n * size), indices, GL_STATIC_DRAW);
    free(indices);
    return true;
}

static bool upload_instance(const struct drawing *of, int instance, struct error *err)
{
    GLuint *indices = index_buffer(of, instance);
    if (!of->plan->instances[instance].in_view)
        return true;
    if (!upload_mesh(of, instance, err))
        return false;
    if (*indices)
        return true;
    of->call->GenBuffers(1, indices);
    of->call->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, *indices);
    return upload_triangles(of, instance, err);
}

bool meshes_upload(struct drawing *of, struct error *err)
{
    const int n = of->plan->n_instances, n_meshes = of->plan->n_meshes;
    if (!MAKE_ARRAY(of->objects, BUFFERS * n_meshes, err, "%d meshes", n_meshes) ||
        !MAKE_ARRAY(of->indices, n_meshes + n, err, "%d objects", n))
        return false;
    for (int i = 0; i < n; i++)
        if (!upload_instance(of, i, err))
            return false;
    return true;
}

static unsigned buffer_of(const struct drawing *of, int instance, int which)
{
    return of->objects[BUFFERS * of->plan->instances[instance].mesh + which];
}

int mesh_bind_triangles(const struct drawing *of, int instance)
{
    of->call->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, *index_buffer(of, instance));
    return 3 * (of->plan->instances[instance].instance.n_triangles -
                of->lit->bounds[instance].n_hidden);
}

void mesh_bind_vertices(const struct drawing *of, int instance)
{
    of->call->BindBuffer(GL_ARRAY_BUFFER, buffer_of(of, instance, VERTICES));
}

bool mesh_bind_coordinates(const struct drawing *of, int instance)
{
    if (!shows_texture(of, instance))
        return false;
    of->call->BindBuffer(GL_ARRAY_BUFFER, buffer_of(of, instance, COORDINATES));
    return true;
}
