/* SPDX-License-Identifier: MIT */
/* Measures which pixels a triangle covers. */
#include <math.h>

#include "raster/beside/measure/inside.h"

/* The edge from corner i to corner i + 1, seen from a pixel's centre: a positive side is inside. */
struct edge {
    double side;      /* twice the area of the triangle that the edge and the centre make */
    double size;      /* by how much this changes if the edge's ends move by 1 in x and y */
    bool is_included; /* by the rule of rectangles: pixels whose centres lie on such an edge */
};

static double area_of(const struct target_corner corners[3])
{
    const float *a = corners[0].position, *b = corners[1].position, *c = corners[2].position;
    return ((double)b[0] - (double)a[0]) * ((double)c[1] - (double)a[1]) -
           ((double)c[0] - (double)a[0]) * ((double)b[1] - (double)a[1]);
}

/* turn: the sign of the area. y runs downwards: where the area is positive, the inside lies on the
 * right of an edge as one walks it. */
static struct edge edge_at(const struct target_corner corners[3], int i, double turn,
                           const int pixel[2], const bool draws[SIDES])
{
    const float *from = corners[i].position, *to = corners[(i + 1) % 3].position;
    const double x = pixel[0] + 0.5, y = pixel[1] + 0.5, ax = (double)from[0] - x,
                 ay = (double)from[1] - y, bx = (double)to[0] - x, by = (double)to[1] - y,
                 dx = turn * (bx - ax), dy = turn * (by - ay);
    const int side = dy != 0 ? (dy < 0 ? SIDE_LEFT : SIDE_RIGHT) : dx > 0 ? SIDE_TOP : SIDE_BOTTOM;
    return (struct edge){turn * (ax * by - ay * bx), fabs(ax) + fabs(ay) + fabs(bx) + fabs(by),
                         draws[side]};
}

/* Returns by how much corners must have moved, in x and in y, to explain that the pixel is drawn or
 * not; 0: they need not. Sets `on_edge` if the centre lies on an edge, and `by_rule` if the rule of
 * rectangles then draws it. */
static double shift_at(const struct target_corner corners[3], const int pixel[2],
                       const struct target *target, struct traits *of)
{
    const double area = area_of(corners);
    double outside = 0, inside = HUGE_VAL;
    bool on_edge = false, by_rule = true;
    for (int i = 0; i < 3; i++) {
        struct edge edge = edge_at(corners, i, area > 0 ? 1 : -1, pixel, of->draws);
        on_edge = on_edge || edge.side == 0;
        by_rule = by_rule && (edge.side != 0 || edge.is_included);
        outside = fmax(outside, -edge.side / edge.size);
        inside = fmin(inside, edge.side / edge.size);
    }
    const bool drawn = target_fragments(target, pixel[0], pixel[1]) > 0;
    if (outside == 0 && on_edge) {
        of->centres++;
        of->odd_centres += drawn != by_rule;
        return 0;
    }
    return drawn ? outside : fmax(inside, 0);
}

/* Returns whether a pixel lies beside the triangle's box by more than a pixel. */
static bool is_beside(const struct target_corner corners[3], const int pixel[2])
{
    bool beside = false;
    for (int j = 0; j < 2; j++) {
        const float a = corners[0].position[j], b = corners[1].position[j],
                    c = corners[2].position[j], at = (float)pixel[j] + 0.5F;
        beside = beside || at < fminf(a, fminf(b, c)) - 1 || at > fmaxf(a, fmaxf(b, c)) + 1;
    }
    return beside;
}

static void compare_pixels(struct target *target, const struct target_corner corners[3], bool exact,
                           struct traits *of)
{
    target_show(target, corners, 1);
    for (int y = 0; y < TARGET; y++)
        for (int x = 0; x < TARGET; x++) {
            const int pixel[2] = {x, y};
            if (target_fragments(target, x, y) == 0 && is_beside(corners, pixel))
                continue;
            const double shift = shift_at(corners, pixel, target, of);
            if (exact)
                of->odd_centres += shift > 0;
            else
                of->edge_px = fmax(of->edge_px, shift);
        }
}

/* ---- one triangle ---- */

static void measure_rectangle(struct target *target, struct traits *out)
{
    const struct target_corner like = {.position = {0, 0, 0.5F}};
    struct target_corner corners[6];
    rectangle_corners(2.5, 2.5, 6.5, 6.5, &like, corners);
    target_show(target, corners, 2);
    out->draws[SIDE_LEFT] = target_fragments(target, 2, 4);
    out->draws[SIDE_RIGHT] = target_fragments(target, 6, 4);
    out->draws[SIDE_TOP] = target_fragments(target, 4, 2);
    out->draws[SIDE_BOTTOM] = target_fragments(target, 4, 6);
}

/* Corners anywhere. Some triangles have an edge beside centres: there a grid shows at once. */
static void measure_edges(struct target *target, struct traits *out)
{
    for (int n = 0; n < 240; n++) {
        struct target_corner corners[3] = {{.position = {0, 0, 0.5F}}};
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 2; j++)
                corners[i].position[j] = (float)random_in(target, 2, TARGET - 2);
        if (n % 2) { /* an edge along a row or a column of centres, within 1/16 pixel */
            const int j = n / 2 % 2;
            const double beside = ldexp(random_in(target, -1, 1), -4 - random_below(target, 8));
            corners[1].position[j] = corners[0].position[j] =
                (float)(random_below(target, TARGET) + 0.5 + beside);
        }
        compare_pixels(target, corners, false, out);
    }
}

/* Corners lie on a grid of 1/256 pixel. The first edge runs through a pixel centre in a direction
 * of small integers, and so through many centres. */
static void measure_rule(struct target *target, struct traits *out)
{
    enum { GRID = 256 };
    for (int n = 0; n < 160; n++) {
        struct target_corner corners[3] = {{.position = {0, 0, 0.5F}}};
        const int back = random_below(target, 700) + 1, ahead = random_below(target, 700);
        for (int j = 0; j < 2; j++) {
            const double centre = TARGET / 4 + random_below(target, TARGET / 2) + 0.5,
                         step = (random_below(target, 17) - 8) / (double)GRID;
            corners[0].position[j] = (float)(centre - back * step);
            corners[1].position[j] = (float)(centre + ahead * step);
            corners[2].position[j] = (float)(random_below(target, TARGET * GRID) / (double)GRID);
        }
        if (area_of(corners) != 0)
            compare_pixels(target, corners, true, out);
    }
}

/* ---- triangles that meet ---- */

enum { CELLS = 8, NET_TRIANGLES = 2 * CELLS * CELLS };

/* Makes a net of triangles around the middle of the target. All corners lie at pixel centres; the
 * inner ones are moved at random. */
static void make_net(struct target *target, double cell,
                     struct target_corner out[3 * NET_TRIANGLES])
{
    static const int order[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    float net[CELLS + 1][CELLS + 1][2];
    for (int i = 0; i <= CELLS; i++)
        for (int j = 0; j <= CELLS; j++)
            for (int k = 0; k < 2; k++) {
                const int at = k ? j : i;
                const double shake = at > 0 && at < CELLS ? random_in(target, -0.2, 0.2) : 0;
                net[i][j][k] = (float)(floor(TARGET / 2 + (at - CELLS / 2 + shake) * cell) + 0.5);
            }
    for (int n = 0; n < CELLS * CELLS; n++)
        for (int k = 0; k < 6; k++) {
            const float *at = net[n / CELLS + order[k][0]][n % CELLS + order[k][1]];
            out[6 * n + k] = (struct target_corner){.position = {at[0], at[1], 0.5F}};
        }
}

/* Every pixel inside of the net is to be drawn once. A larger net is clipped at the target. */
static void measure_shared_edges(struct target *target, struct traits *out)
{
    static const int cell[2] = {14, 24}, border[2] = {8, 0};
    struct target_corner corners[3 * NET_TRIANGLES];
    for (int n = 0; n < 100; n++) {
        const int kind = n % 2;
        make_net(target, cell[kind], corners);
        target_show(target, corners, NET_TRIANGLES);
        for (int y = border[kind] + 1; y < TARGET - border[kind] - 1; y++)
            for (int x = border[kind] + 1; x < TARGET - border[kind] - 1; x++) {
                out->shared_pixels++;
                out->holes += target_fragments(target, x, y) == 0;
                out->doubles += target_fragments(target, x, y) > 1;
            }
    }
}

/* ---- triangles without area ---- */

/* Three corners on one line on a grid of 1/1024 pixel, the middle one beside a pixel's centre. */
static void make_sliver(struct target *target, struct target_corner out[3])
{
    const int back = random_below(target, 4) + 1, ahead = random_below(target, 4) + 1;
    for (int i = 0; i < 3; i++)
        out[i] = (struct target_corner){.position = {0, 0, 0.25F * (float)(i + 1)},
                                        .colour = {i == 0, i == 1, i == 2}};
    for (int j = 0; j < 2; j++) {
        const double aside = (random_below(target, 5) - 2.0) / 1024,
                     middle = 40 + random_below(target, 48) + 0.5 + aside,
                     step = (random_below(target, 16385) - 8192) / 1024.0;
        out[0].position[j] = (float)(middle - back * step);
        out[1].position[j] = (float)middle;
        out[2].position[j] = (float)(middle + ahead * step);
    }
}

static void measure_slivers(struct target *target, struct traits *out)
{
    enum { SLIVERS = 10 };
    struct target_corner corners[3 * SLIVERS];
    target->call->DepthFunc(GL_LEQUAL);
    for (int n = 0; n < 30; n++) {
        for (int i = 0; i < SLIVERS; i++)
            make_sliver(target, corners + 3 * i);
        target_show(target, corners, SLIVERS);
        for (int y = 0; y < TARGET; y++)
            for (int x = 0; x < TARGET; x++) {
                const float *c = target->colours[y][x];
                const int drawn = target_fragments(target, x, y);
                out->sliver_pixels += drawn > 0;
                out->undefined_pixels += drawn > 0 && !isfinite(c[0] + c[1] + c[2]);
                out->shown_pixels += target_depth(target, x, y) < 0xffffff;
            }
    }
    target->call->DepthFunc(GL_ALWAYS);
}

void measure_coverage(struct target *target, struct traits *out)
{
    measure_rectangle(target, out);
    measure_edges(target, out);
    measure_rule(target, out);
    measure_shared_edges(target, out);
    measure_slivers(target, out);
}
