/* SPDX-License-Identifier: MIT */
/* Geometry is uploaded once; and drawn once more in numbers. Only this file says how a vertex lies
 * in a buffer. */
#include <stdlib.h>
#include <string.h>

#include "data/mesh/mesh.h"
#include "raster/gl/inside.h"

enum { VERTICES, COORDINATES, BUFFERS };

/* Fills a buffer that has no name yet with n_floats numbers of each vertex, from number `first` on.
 */
static bool upload_vertices(const struct drawing *of, GLuint *name, const struct mesh *mesh,
                            size_t first, size_t n_floats, struct error *err)
{
    const size_t n = (size_t)mesh->n_vertices;
    float *floats, numbers[VERTEX_NUMBERS];
    if (*name || !MAKE_ARRAY(floats, n * n_floats, err, "%zu vertices of a mesh", n))
        return *name;
    for (size_t i = 0; i < n; i++) {
        vertex_numbers(&mesh->vertices[i], numbers);
        memcpy(floats + n_floats * i, numbers + first, n_floats * sizeof *floats);
    }
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
    const int index = of->plan->instances[instance].mesh;
    const struct mesh *mesh = &of->plan->meshes[index].mesh;
    GLuint *buffers = of->objects + BUFFERS * index, *indices = index_buffer(of, instance);
    if (!of->plan->instances[instance].in_view)
        return true;
    if (!upload_vertices(of, &buffers[VERTICES], mesh, 0, VERTEX_FLOATS, err) ||
        (shows_texture(of, instance) &&
         !upload_vertices(of, &buffers[COORDINATES], mesh, VERTEX_FLOATS, COORDINATE_FLOATS, err)))
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

/* ---- triangles with their numbers as colours ---- */

/* Triangles given to OpenGL at once: few enough to stay in the second-level cache. */
enum { BATCH = 4096 };

static void number_triangle(const struct mesh *mesh, int triangle, int placed,
                            struct numbered_vertex out[3])
{
    for (int i = 0; i < 3; i++) {
        struct vector p = mesh->vertices[mesh->triangles[triangle][i]].position;
        out[i] = (struct numbered_vertex){
            {(float)p.x, (float)p.y, (float)p.z},
            {(float)(triangle & 0xffff), (float)(triangle >> 16), (float)(placed + 1)}};
    }
}

static void draw_instance(struct drawing *of, int instance, const struct numbered_draw *by,
                          struct numbered_vertex batch[3 * BATCH])
{
    const struct mesh *mesh = &of->plan->meshes[of->plan->instances[instance].mesh].mesh;
    const bool *hidden = of->lit->bounds[instance].hidden;
    int n = 0;
    by->place(of, instance);
    for (int i = 0; i < mesh->n_triangles; i++) {
        if (hidden && hidden[i])
            continue;
        number_triangle(mesh, i, instance, batch + 3 * (size_t)n++);
        if (n == BATCH) {
            by->draw(of, batch, 3 * n);
            n = 0;
        }
    }
    if (n > 0)
        by->draw(of, batch, 3 * n);
}

bool numbers_draw(struct drawing *of, const struct numbered_draw *by, struct error *err)
{
    struct numbered_vertex *batch;
    if (!MAKE_ARRAY(batch, 3 * BATCH, err, "%d triangles", BATCH))
        return false;
    for (int i = 0; i < of->plan->n_instances; i++)
        if (surface_reaches(&of->lit->bounds[i], &of->tile))
            draw_instance(of, i, by, batch);
    free(batch);
    return true;
}
