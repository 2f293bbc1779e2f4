/* SPDX-License-Identifier: MIT */
/* Draws a small picture with the reference alone, for test/alone.sh. Three instances: a textured
 * floor that the near and the far plane cut, a tetrahedron with highlights, and its mirrored copy.
 * The digest covers every bit of three pictures, one a shading model. */
#include <stdio.h>
#include <string.h>

#include "raster/reference/reference.h"

enum { WIDTH = 96, HEIGHT = 64, INSTANCES = 3, TERMS = 4 };

uint64_t digest(void); /* what WebAssembly exports; 0: something was not drawn */

static const struct term terms[TERMS] = {
    {TERM_CONSTANT, -1}, {TERM_DIFFUSE, 0}, {TERM_DIFFUSE, 1}, {TERM_SPECULAR, 1}};
static const struct eye_light lights[] = {
    {.directional = true, .position = {0.6, 0.64, 0.48}, .first = 0, .share = 1},
    {.spot = true,
     .attenuated = true,
     .position = {-1, 2, -1},
     .attenuation = {1, 0.1, 0.01},
     .axis = {0.28, -0.576, -0.768},
     .cutoff_cosine = 0.7,
     .spot_exponent = 2.5,
     .first = 1,
     .share = 1}};
static const struct vertex floor_vertices[] = {{{-4, -1, 1}, {0, 1, 0}, 0, 0},
                                               {{4, -1, 1}, {0, 1, 0}, 3, 0},
                                               {{4, -1, -9}, {0, 1, 0}, 3, 4},
                                               {{-4, -1, -9}, {0, 1, 0}, 0, 4}};
static const struct vertex solid_vertices[] = {{{1, 1, 1}, {0.6, 0.64, 0.48}, 0, 0},
                                               {{-1, -1, 1}, {-0.6, -0.64, 0.48}, 0, 0},
                                               {{-1, 1, -1}, {-0.6, 0.64, -0.48}, 0, 0},
                                               {{1, -1, -1}, {0.6, -0.64, -0.48}, 0, 0}};
static const int32_t floor_triangles[][3] = {{0, 1, 2}, {0, 2, 3}};
static const int32_t solid_triangles[][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
static const float texels[] = {0.25F, 0.5F, 1, 0.125F, 0.75F, 0.375F};

static void place(struct instance *instance, const struct vector by, double turn_deg, double mirror)
{
    const struct matrix turn = matrix_rotation(turn_deg, (struct vector){1, 2, 3});
    const struct matrix size = matrix_scaling((struct vector){0.7 * mirror, 0.7, 0.7});
    instance->mirrored = mirror < 0;
    instance->model_view = matrix_product(matrix_translation(by), matrix_product(turn, size));
    matrix_normal(&instance->model_view, &instance->normal_matrix);
}

/* FNV-1a (G. Fowler, L. Noll, P. Vo, public domain) */
static uint64_t add(uint64_t hash, const void *bytes, size_t length)
{
    for (size_t i = 0; i < length; i++)
        hash = (hash ^ ((const unsigned char *)bytes)[i]) * 0x100000001b3;
    return hash;
}

static uint64_t draw(const struct view *view, struct surface *surfaces, uint64_t hash)
{
    const struct rectangle all = {0, 0, WIDTH, HEIGHT};
    const size_t n = WIDTH * HEIGHT;
    struct picture picture;
    struct light_work work = {0};
    bool seen[INSTANCES + 1] = {false};
    for (int s = 0; s < INSTANCES; s++)
        for (int vertex = 0; vertex < surfaces[s].instance->n_vertices; vertex++)
            surface_light(view, &surfaces[s], vertex, &work);
    if (picture_draw(view, surfaces, INSTANCES, &all, TERMS, &picture)) {
        for (size_t i = 0; i < n; i++) {
            seen[picture.surface[i] + 1] = true;
            for (size_t row = 0; row < TERMS && picture.surface[i] >= 0; row++)
                hash = add(hash, &picture.rows[row * n + i], sizeof *picture.rows);
        }
        hash = add(hash, picture.surface, n * sizeof *picture.surface);
        hash = add(hash, picture.triangle, n * sizeof *picture.triangle);
        hash = add(hash, picture.depth, n * sizeof *picture.depth);
    }
    picture_free(&picture);
    return memchr(seen, false, sizeof seen) ? 0 : hash;
}

uint64_t digest(void)
{
    struct instance instances[INSTANCES] = {{.vertices = floor_vertices,
                                             .triangles = floor_triangles,
                                             .n_vertices = 4,
                                             .n_triangles = 2,
                                             .textured = true,
                                             .texels = {texels, 3, 2, true}},
                                            {.vertices = solid_vertices,
                                             .triangles = solid_triangles,
                                             .n_vertices = 4,
                                             .n_triangles = 4}};
    struct surface surfaces[INSTANCES] = {{.instance = NULL}};
    struct view view = {
        WIDTH, HEIGHT,  {{{1.2, 0, 0, 0}, {0, 1.8, 0, 0}, {0, 0, -1.25, -1.125}, {0, 0, -1, 0}}},
        true,  GOURAUD, lights,
        2};
    uint64_t hash = 0xcbf29ce484222325;
    bool opened = true;
    instances[2] = instances[1];
    place(&instances[0], (struct vector){0, 0, 0}, 0, 1);
    place(&instances[1], (struct vector){-0.7, 0.1, -3}, 40, 1);
    place(&instances[2], (struct vector){0.8, 0.2, -4}, 75, -1);
    for (int i = 0; i < INSTANCES; i++) {
        instances[i].terms = terms;
        instances[i].n_terms = TERMS;
        instances[i].gloss = 20;
        opened = surface_open(&instances[i], &surfaces[i]) && opened;
    }
    for (int shading = GOURAUD; shading <= PHONG && opened && hash; shading++) {
        view.shading = (enum shading_model)shading;
        hash = draw(&view, surfaces, hash);
    }
    for (int i = 0; i < INSTANCES; i++)
        surface_close(&surfaces[i]);
    return opened ? hash : 0;
}

#ifndef __wasm__ /* where stdio would ask for a system */
int main(void)
{
    printf("%llu\n", (unsigned long long)digest());
    return 0;
}
#endif
