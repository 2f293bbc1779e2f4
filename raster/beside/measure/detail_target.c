/* SPDX-License-Identifier: MIT */
/* Measures how a driver finds the level of detail of a texture with mipmaps: each level holds its
 * own number, so that a pixel is its level of detail. Tilted triangles, across which w changes,
 * show by which corner of a quad, by which norm and by which logarithm. */
#include <math.h>
#include <stdlib.h>

#include "raster/beside/measure/inside.h"

enum { WIDTH = 64, HEIGHT = 16, LEVELS = 7 };

/* A triangle of the target: x, y in pixels from its top left corner. */
struct tilted {
    double x[3], y[3], w[3], s[3], t[3];
};
static const struct tilted triangles[] = {
    {{2, 120, 20}, {4, 12, 122}, {1, 2, 5}, {0, 6, -4}, {0, 8, 36}},
    {{125, 126, 5}, {3, 125, 100}, {4, 1, 2}, {12, -4, 2}, {-8, 32, 1}},
};
enum { TRIANGLES = sizeof triangles / sizeof *triangles };

static void upload_levels(const struct gl_functions *call)
{
    GLfloat texels[WIDTH * HEIGHT * 3];
    for (int k = 0; k < LEVELS; k++) {
        const int width = WIDTH >> k, height = HEIGHT >> k > 0 ? HEIGHT >> k : 1;
        for (int i = 0; i < 3 * width * height; i++)
            texels[i] = (GLfloat)k;
        call->TexImage2D(GL_TEXTURE_2D, k, GL_RGB32F_ARB, width, height, 0, GL_RGB, GL_FLOAT,
                         texels);
    }
}

/* Draws a triangle whose corners are given as x w, y w and w, so that w is its third coordinate. */
static void show_tilted(struct target *target, const struct tilted *of)
{
    static const double none[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double up = target->contexts->mirrored ? -1 : 1,
                 columns[16] = {1, 0, 0, 0, 0, -up, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0};
    struct target_corner corners[3];
    for (int i = 0; i < 3; i++)
        corners[i] = (struct target_corner){
            .position = {(float)((of->x[i] * 2 / TARGET - 1) * of->w[i]),
                         (float)((of->y[i] * 2 / TARGET - 1) * of->w[i]), (float)of->w[i]},
            .colour = {1, 1, 1},
            .s_t = {(float)of->s[i], (float)of->t[i]}};
    target_place(target, columns, none);
    target_shade(target, TARGET_TEXTURE, 0);
    target_show(target, corners, 1);
}

/* Raises what each rule leaves of the levels of detail that a triangle shows. */
static void compare_rules(const struct target *target, const struct tilted *of,
                          double residual[DETAIL_RULES])
{
    struct vertex vertices[3] = {{.s = 0}};
    for (int i = 0; i < 3; i++) {
        vertices[i].s = of->s[i];
        vertices[i].t = of->t[i];
    }
    const struct instance instance = {
        .vertices = vertices, .texels = {.width = WIDTH, .height = HEIGHT, .n_levels = LEVELS}};
    const struct surface surface = {.instance = &instance};
    struct screen_triangle screen = {
        .surface = &surface, .vertex = {0, 1, 2}, .share = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (int i = 0; i < 3; i++) {
        screen.x[i] = of->x[i];
        screen.y[i] = of->y[i];
        screen.inverse_w[i] = 1 / of->w[i];
    }
    screen.twice_area = 1; /* it has an area */
    for (int i = 0; i < TARGET * TARGET * DETAIL_RULES; i++) {
        const int x = i / DETAIL_RULES % TARGET, y = i / DETAIL_RULES / TARGET;
        const struct detail_rule rule = detail_rule(i % DETAIL_RULES);
        if (target_fragments(target, x, y) > 0)
            residual[i % DETAIL_RULES] =
                fmax(residual[i % DETAIL_RULES],
                     fabs((double)target->colours[y][x][0] - detail_find(&rule, &screen, x, y)));
    }
}

/* Returns how many pixels of the picture are not those of an earlier one, which it replaces. */
static long count_changes(const struct target *target, float *earlier)
{
    long n = 0;
    for (int i = 0; i < TARGET * TARGET; i++) {
        const float value = target->colours[i / TARGET][i % TARGET][0];
        n += value != earlier[i];
        earlier[i] = value;
    }
    return n;
}

/* An OpenGL ES that does not filter floats gets no linear textures. */
bool measure_detail(struct target *target, struct traits *out, struct error *err)
{
    const struct gl_functions *call = target->call;
    double residual[DETAIL_RULES] = {0};
    float *earlier;
    GLuint name;
    int best = 0;
    if (target->contexts->way == GL_ES &&
        !contexts_have(target->contexts, "GL_OES_texture_float_linear")) {
        out->detail_residual = HUGE_VAL;
        return true;
    }
    if (!MAKE_ARRAY(earlier, TARGET * TARGET, err, "a small picture"))
        return false;
    call->GenTextures(1, &name);
    call->BindTexture(GL_TEXTURE_2D, name);
    call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    upload_levels(call);
    for (int i = 0; i < TRIANGLES; i++) {
        show_tilted(target, &triangles[i]);
        count_changes(target, earlier);
        compare_rules(target, &triangles[i], residual);
        show_tilted(target, &triangles[i]);
        out->detail_changes += count_changes(target, earlier);
    }
    for (int i = 1; i < DETAIL_RULES; i++)
        best = residual[i] < residual[best] ? i : best;
    out->detail = detail_rule(best);
    out->detail_residual = residual[best];
    free(earlier);
    return true;
}
