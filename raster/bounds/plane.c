/* SPDX-License-Identifier: MIT */
/* Bounds OpenGL's errors inside a triangle whose corners are right to within known bounds.
 *
 * Mesa interpolates a value a through planes: N = a / w and D = 1 / w are set up from the corners
 * in single precision with their origin at the corner of the framebuffer, evaluated at the pixel
 * centre, and divided. With N' and D' for OpenGL's values, and r for the true quotient,
 *     N' / D' - r = ((N' - N) - r (D' - D)) / D'.
 * Corners that are off by e_i change a plane by the sum of l_i g . e_i, where g is its gradient and
 * l_i are the barycentric coordinates in the triangle that OpenGL has: position errors count once,
 * times the gradient of N - r D, and a shift of the triangle as a whole cancels out of everything
 * else. Roundings of the set-up are magnified by the triangle's thinness, those of the evaluation
 * grow with the distance to the origin. */
#include <math.h>

#include "raster/bounds/bounds.h"

/* Edge vectors and what follows from them. Edge i runs from corner i to corner i + 1. */
struct edges {
    double dx[3], dy[3];
    double twice_area;    /* not negative */
    double width, height; /* of the bounding box, a pixel added for extrapolation */
    double e_area;        /* relative rounding error of the area in single precision */
    double thinness;      /* relative change of the area when each corner is off by its slack */
    double spread;        /* sum of |l_i| at a pixel that OpenGL may cover: 1 inside */
    /* slack_px of corner i is at most slack + slack_per_d / w_i: errors of cutting near the eye do
     * not matter far from it */
    double slack, slack_per_d;
};

static double largest(const double q[3])
{
    return fmax(fabs(q[0]), fmax(fabs(q[1]), fabs(q[2])));
}

static struct edges edges_of(const struct clipped_triangle *triangle)
{
    struct edges edges = {.slack_per_d = 0};
    for (int i = 0; i < 3; i++) {
        int next = (i + 1) % 3;
        edges.dx[i] = triangle->x[next] - triangle->x[i];
        edges.dy[i] = triangle->y[next] - triangle->y[i];
    }
    double e = edges.dx[0] * edges.dy[1], f = edges.dx[1] * edges.dy[0];
    edges.twice_area = fabs(e - f);
    edges.width = most_of(triangle->x) - least_of(triangle->x) + 1;
    edges.height = most_of(triangle->y) - least_of(triangle->y) + 1;
    edges.e_area = roundings(3 * (fabs(e) + fabs(f)) / edges.twice_area + 2);
    double worst = most_of(triangle->slack_px), change = 8 * worst * worst, perimeter = 0;
    for (int i = 0; i < 3; i++) { /* a corner moves the area by the length of the edge opposite */
        double length = fabs(edges.dx[i]) + fabs(edges.dy[i]);
        change += triangle->slack_px[(i + 2) % 3] * length;
        perimeter += length;
    }
    edges.thinness = change / edges.twice_area;
    edges.spread = 1 + 2 * triangle->grid_px * perimeter / edges.twice_area;
    edges.slack = least_of(triangle->slack_px);
    for (int i = 0; i < 3; i++)
        edges.slack_per_d =
            fmax(edges.slack_per_d, (triangle->slack_px[i] - edges.slack) / triangle->inverse_w[i]);
    return edges;
}

struct gradient {
    double x, y;
};

static struct gradient gradient_of(const struct edges *edges, const double q[3])
{
    double d1 = q[1] - q[0], d2 = q[2] - q[0];
    double dx2 = -edges->dx[2], dy2 = -edges->dy[2]; /* corner 0 to corner 2 */
    double area = edges->dx[0] * dy2 - dx2 * edges->dy[0];
    return (struct gradient){(d1 * dy2 - d2 * edges->dy[0]) / area,
                             (d2 * edges->dx[0] - d1 * dx2) / area};
}

static double norm(struct gradient g)
{
    return fabs(g.x) + fabs(g.y);
}

/* Roundings of a plane through q: each gradient is a difference of two products over the area (5
 * roundings of its terms, and the area's own), used over the extent of the triangle; the plane's
 * value at the framebuffer's origin and its evaluation round 6 times relative to the distance from
 * there and 4 times relative to the value itself. */
static double plane_rounding(const struct clipped_triangle *triangle, const struct edges *edges,
                             const double q[3])
{
    struct gradient g = gradient_of(edges, q);
    double terms_x = 0, terms_y = 0;
    for (int i = 0; i < 3; i++) {
        double step = fabs(q[(i + 1) % 3] - q[i]);
        terms_x += step * fabs(edges->dy[i]) / edges->twice_area;
        terms_y += step * fabs(edges->dx[i]) / edges->twice_area;
    }
    return roundings(5) * (terms_x * edges->width + terms_y * edges->height) +
           edges->e_area * (fabs(g.x) * edges->width + fabs(g.y) * edges->height) +
           roundings(6) * (fabs(g.x) * triangle->reach_x + fabs(g.y) * triangle->reach_y) +
           roundings(4) * largest(q);
}

double bound_linear(const struct clipped_triangle *triangle, const double values[3],
                    double e_values)
{
    struct edges edges = edges_of(triangle);
    return most_of(triangle->slack_px) * edges.spread * norm(gradient_of(&edges, values)) +
           e_values * edges.spread + plane_rounding(triangle, &edges, values);
}

/* The sum of |l_i| slack_px of corner i, without the part that grows with D: the sum of l_i / w_i
 * is D itself, to which a pixel outside of the triangle adds. */
static double fixed_slack(const struct clipped_triangle *triangle, const struct edges *edges)
{
    return edges->slack * edges->spread +
           edges->slack_per_d * (edges->spread - 1) * largest(triangle->inverse_w);
}

void bound_inverse_w(struct clipped_triangle *triangle)
{
    struct edges edges = edges_of(triangle);
    double slope = norm(gradient_of(&edges, triangle->inverse_w)),
           fixed = slope * fixed_slack(triangle, &edges) +
                   plane_rounding(triangle, &edges, triangle->inverse_w),
           magnification = HUGE_VAL;
    /* beyond, second-order terms would no longer be small */
    if (edges.thinness <= 0.75 && edges.e_area <= 0.25)
        magnification = 1.001 / ((1 - edges.thinness) * (1 - edges.e_area));
    triangle->magnification = magnification;
    triangle->inverse_w_bound = (struct colour_bound){
        .fixed = fixed * magnification, .per_d = slope * edges.slack_per_d * magnification};
}

struct colour_bound bound_colour(const struct clipped_triangle *triangle, const double values[3])
{
    struct edges edges = edges_of(triangle);
    const double *d = triangle->inverse_w;
    double n[3], slope = 0, range = 0, value = largest(values);
    for (int i = 0; i < 3; i++) {
        n[i] = values[i] * d[i];
        range = fmax(range, fabs(values[i] - values[(i + 1) % 3]));
    }
    struct gradient g_n = gradient_of(&edges, n), g_d = gradient_of(&edges, d);
    for (int i = 0; i < 3; i++) /* linear in r, so largest at a corner's value */
        slope = fmax(slope,
                     norm((struct gradient){g_n.x - values[i] * g_d.x, g_n.y - values[i] * g_d.y}));
    return (struct colour_bound){
        .slope = slope,
        .constant = triangle->slack.w * range + roundings(2) * value,
        .per_d = slope * edges.slack_per_d,
        .fixed = slope * fixed_slack(triangle, &edges) + roundings(1) * largest(n) +
                 triangle->slack.w * range * (edges.spread - 1) * largest(d) +
                 plane_rounding(triangle, &edges, n) + value * plane_rounding(triangle, &edges, d)};
}
