/* SPDX-License-Identifier: MIT */
/* Draws a picture with the reference alone, for test/raster/reference/alone.sh: a torus in the
 * light of a spot, and in its shadow, over a textured square that the near and the far plane cut.
 */
#include <stdio.h>

#include "data/maths/maths.h"
#include "raster/visibility/visibility.h"

enum { WIDTH = 120, HEIGHT = 80, SIDES = 24, RINGS = 48, TERMS = 3 };

uint64_t
digest(void); /* digest of every bit of the picture; WebAssembly exports it; 0: no memory */

static const struct term terms[TERMS] = {{CONSTANT, -1}, {DIFFUSE, 0}, {SPECULAR, 0}};
static const double spectrum[TERMS] = {0.1, 0.7, 0.8};
static const struct eye_light spot = {
    false, true, true, {-1, 2, -1}, {0.28, -0.576, -0.768}, {1, 0.02, 0.01}, 0.7, 2.5, 0, 1};
static const struct vertex corners[] = {{{-4, -1, 1}, {0, 1, 0}, 0, 0},
                                        {{4, -1, 1}, {0, 1, 0}, 4, 0},
                                        {{4, -1, -12}, {0, 1, 0}, 4, 6},
                                        {{-4, -1, -12}, {0, 1, 0}, 0, 6}};
static const int32_t halves[][3] = {{0, 1, 2}, {0, 2, 3}};
static const float texels[] = {0.2F, 1, 1, 0.2F};
static struct vertex vertices[SIDES * RINGS];
static int32_t triangles[2 * SIDES * RINGS][3];
static double radiance[WIDTH * HEIGHT];

static void make_torus(void)
{
    for (int i = 0; i < SIDES * RINGS; i++) {
        int ring = i / SIDES, side = i % SIDES, after = ring * SIDES + (side + 1) % SIDES,
            next = (i + SIDES) % (SIDES * RINGS), last = (after + SIDES) % (SIDES * RINGS);
        double x, y, in, up;
        sine_cosine_of_turn(ring, RINGS, &y, &x);
        sine_cosine_of_turn(side, SIDES, &up, &in);
        vertices[i] = (struct vertex){.normal = {in * x, in * y, up}};
        vertices[i].position =
            (struct vector){(0.8 + 0.3 * in) * x, (0.8 + 0.3 * in) * y, 0.3 * up};
        for (int k = 0; k < 6; k++)
            triangles[2 * i + k / 3][k % 3] = (const int[]){i, next, after, after, next, last}[k];
    }
}

static bool draw(const struct view *view, const struct instance instances[2])
{
    const struct rectangle all = {0, 0, WIDTH, HEIGHT};
    struct surface surfaces[2];
    struct light_work work = {0};
    static const bool casts[2] = {true, true};
    static uint32_t dark[WIDTH * HEIGHT];
    struct occluders occluders;
    struct picture picture = {.surface = NULL};
    bool done = surface_open(&instances[0], &surfaces[0]);
    done = surface_open(&instances[1], &surfaces[1]) && done;
    for (int s = 0; s < 2 && done; s++)
        for (int i = 0; i < instances[s].n_vertices; i++)
            surface_light(view, &surfaces[s], i, &work);
    done = done && picture_draw(view, surfaces, 2, &all, TERMS, &picture);
    done = occluders_make(surfaces, 2, casts, 8, &occluders) && done;
    if (done)
        picture_shadow(view, &occluders, &picture, dark);
    for (int i = 0; i < WIDTH * HEIGHT && done; i++)
        for (int t = 0; t < TERMS && picture.surface[i] >= 0; t++) {
            const double *row = picture.rows + t * WIDTH * HEIGHT + i;
            add_term(row, spectrum[t], 1, &radiance[i]);
        }
    occluders_free(&occluders);
    picture_free(&picture);
    surface_close(&surfaces[0]);
    surface_close(&surfaces[1]);
    return done;
}

uint64_t digest(void)
{
    const struct matrix turn = matrix_rotation(35, (struct vector){1, 1, 0}),
                        place = matrix_translation((struct vector){0, 0, -3});
    struct instance instances[2] = {
        {.vertices = vertices,
         .triangles = (const int32_t(*)[3])triangles,
         .n_vertices = SIDES * RINGS,
         .n_triangles = 2 * SIDES * RINGS,
         .model_view = matrix_product(place, turn),
         .normal_matrix = turn},
        {.vertices = corners,
         .triangles = halves,
         .n_vertices = 4,
         .n_triangles = 2,
         .model_view = matrix_identity(),
         .normal_matrix = matrix_identity(),
         .textured = true,
         .texels = {.values = texels, .width = 2, .height = 2, .linear = true, .n_levels = 1}}};
    struct view view = {.width = WIDTH,
                        .height = HEIGHT,
                        .projection = {{{1.2}, {0, 1.8}, {0, 0, -1.25, -1.125}, {0, 0, -1}}},
                        .local_viewer = true,
                        .shading = GOURAUD,
                        .lights = &spot,
                        .n_lights = 1,
                        .n_shadowed = 1};
    uint64_t hash = 0xcbf29ce484222325; /* FNV-1a: G. Fowler, L. Noll, P. Vo, public domain */
    for (int i = 0; i < 2; i++) {
        instances[i].terms = terms;
        instances[i].n_terms = TERMS;
        instances[i].gloss = 20;
    }
    make_torus();
    for (; view.shading <= PHONG && draw(&view, instances); view.shading++)
        for (size_t i = 0; i < sizeof radiance; i++)
            hash = (hash ^ ((const unsigned char *)radiance)[i]) * 0x100000001b3;
    return view.shading > PHONG ? hash : 0;
}

#ifndef __wasm__ /* stdio would need an operating system here */
int main(void)
{
    return printf("%llu\n", (unsigned long long)digest()) < 0;
}
#endif
