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

#include "raster/candidates/inside.h"

/* Edge vectors and what follows from them. Edge i runs from corner i to corner i + 1. */
struct edges {
    double dx[3], dy[3];
    double twice_area;    /* not negative; the least that OpenGL may have */
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

/* Bounds the change of twice the area when each corner moves as far as it may, and in x and in y by
 * `more`. A corner moves the area by the length of the edge opposite. */
static double area_change(const struct clipped_triangle *triangle, const struct edges *edges,
                          double more)
{
    double change = 0;
    for (int i = 0; i < 3; i++) {
        const double *moved = triangle->moved_px[(i + 2) % 3], *other = triangle->moved_px[i],
                     x = moved[0] + more, y = moved[1] + more;
        change += x * fabs(edges->dy[i]) + y * fabs(edges->dx[i]) + x * (other[1] + more) +
                  y * (other[0] + more);
    }
    return change;
}

static struct edges edges_of(const struct clipped_triangle *triangle)
{
    struct edges edges = {.slack_per_d = 0};
    for (int i = 0; i < 3; i++) {
        int next = (i + 1) % 3;
        edges.dx[i] = triangle->screen.x[next] - triangle->screen.x[i];
        edges.dy[i] = triangle->screen.y[next] - triangle->screen.y[i];
    }
    double e = edges.dx[0] * edges.dy[1], f = edges.dx[1] * edges.dy[0];
    edges.twice_area = fabs(e - f) * triangle->least_part;
    edges.width = most_of(triangle->screen.x) - least_of(triangle->screen.x) + 1;
    edges.height = most_of(triangle->screen.y) - least_of(triangle->screen.y) + 1;
    edges.e_area = roundings(3 * (fabs(e) + fabs(f)) / edges.twice_area + 2);
    double perimeter = 0;
    for (int i = 0; i < 3; i++)
        perimeter += fabs(edges.dx[i]) + fabs(edges.dy[i]);
    edges.thinness = area_change(triangle, &edges, 0) / edges.twice_area;
    edges.spread = 1 + 2 * triangle->grid_px * perimeter / edges.twice_area;
    edges.slack = least_of(triangle->slack_px);
    for (int i = 0; i < 3; i++)
        edges.slack_per_d = fmax(edges.slack_per_d, (triangle->slack_px[i] - edges.slack) /
                                                        triangle->screen.inverse_w[i]);
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

/* Bounds on the roundings of a plane: those that all attributes share, and those of this one. */
struct plane_rounding {
    double common, own;
};

/* The step of q along one edge times the other edge over the area, over the triangle's extent. */
static double product_size(const struct edges *edges, const double q[3], int step, int other)
{
    return fabs(q[(step + 1) % 3] - q[step]) *
           (fabs(edges->dy[other]) * edges->width + fabs(edges->dx[other]) * edges->height) /
           edges->twice_area;
}

/* Roundings of a plane through q, but for those relative to its value at the pixel.
 * A gradient is a difference of two products, each of a step of q along one edge and another edge
 * over the area. Edges and area are computed once for all attributes: 2 roundings of each product,
 * and the area's own. An attribute rounds its steps and products (2 of each product), the
 * difference and its scaling (2). Gradients act over the extent of the triangle. With X and Y for
 * the parts of the plane's value that grow with x and y from the framebuffer's origin, the value at
 * the origin rounds X, Y, X + Y and itself; the evaluation rounds X, Y and the sum of two of the
 * three parts: 2 X + 3 Y + 2 (X + Y). A corner's coordinates round once, for all attributes. y may
 * run either way. */
static struct plane_rounding plane_rounding(const struct clipped_triangle *triangle,
                                            const struct edges *edges, const double q[3])
{
    struct gradient g = gradient_of(edges, q);
    double terms = 0, across = fabs(g.x) * triangle->reach_x, up = fabs(g.y) * triangle->reach_y;
    for (int i = 0; i < 3; i++) /* from any corner */
        terms = fmax(terms, product_size(edges, q, i, (i + 2) % 3) +
                                product_size(edges, q, (i + 2) % 3, i));
    double extent = fabs(g.x) * edges->width + fabs(g.y) * edges->height;
    return (struct plane_rounding){
        .common = roundings(2) * terms + edges->e_area * extent + roundings(1) * (across + up),
        .own = roundings(2) * (terms + extent) + roundings(4) * across + roundings(5) * up};
}

/* Bounds the error of a plane through q, but for its part relative to the value at the pixel. */
static double plane_error(const struct clipped_triangle *triangle, const struct edges *edges,
                          const double q[3])
{
    const struct plane_rounding rounding = plane_rounding(triangle, edges, q);
    return rounding.common + rounding.own;
}

/* True in a parallel view: w is 1, and neither products nor divisions by it round. */
static bool is_parallel(const struct clipped_triangle *triangle)
{
    const double *d = triangle->screen.inverse_w;
    return d[0] == 1 && d[1] == 1 && d[2] == 1;
}

/* Roundings of D's plane relative to its value at the pixel. */
static double inverse_w_roundings(const struct clipped_triangle *triangle)
{
    return is_parallel(triangle) ? 0 : roundings(triangle->value_roundings);
}

double bound_linear(const struct clipped_triangle *triangle, const double values[3],
                    double e_values)
{
    struct edges edges = edges_of(triangle);
    return most_of(triangle->slack_px) * edges.spread * norm(gradient_of(&edges, values)) +
           e_values * edges.spread + plane_error(triangle, &edges, values) +
           roundings(triangle->value_roundings) * largest(values) * edges.spread;
}

/* The sum of |l_i| slack_px of corner i, without the part that grows with D: the sum of l_i / w_i
 * is D itself, to which a pixel outside of the triangle adds. */
static double fixed_slack(const struct clipped_triangle *triangle, const struct edges *edges)
{
    return edges->slack * edges->spread +
           edges->slack_per_d * (edges->spread - 1) * largest(triangle->screen.inverse_w);
}

void bound_inverse_w(struct clipped_triangle *triangle)
{
    struct edges edges = edges_of(triangle);
    const double *d = triangle->screen.inverse_w;
    double slope = norm(gradient_of(&edges, d)),
           fixed = slope * fixed_slack(triangle, &edges) + plane_error(triangle, &edges, d),
           per_d = slope * edges.slack_per_d + inverse_w_roundings(triangle),
           magnification = HUGE_VAL;
    /* beyond, second-order terms would no longer be small */
    if (edges.thinness <= 0.75 && edges.e_area <= 0.25)
        magnification = 1.001 / ((1 - edges.thinness) * (1 - edges.e_area));
    triangle->magnification = magnification;
    triangle->folds = area_change(triangle, &edges, triangle->grid_px) >= edges.twice_area;
    triangle->inverse_w_bound =
        (struct colour_bound){.fixed = fixed * magnification, .per_d = per_d * magnification};
}

/* The corners' products a / w round once each. Inside the triangle their errors, interpolated, are
 * relative to a value between theirs. So are the roundings of a plane that are relative to its own
 * value, of N and of D. The division rounds twice. */
struct colour_bound bound_colour(const struct clipped_triangle *triangle, const double values[3])
{
    struct edges edges = edges_of(triangle);
    const double *d = triangle->screen.inverse_w, products = is_parallel(triangle) ? 0 : 3;
    double n[3], slope = 0, range = 0, value = largest(values), beyond = edges.spread - 1;
    for (int i = 0; i < 3; i++) {
        n[i] = values[i] * d[i];
        range = fmax(range, fabs(values[i] - values[(i + 1) % 3]));
    }
    struct gradient g_n = gradient_of(&edges, n), g_d = gradient_of(&edges, d);
    for (int i = 0; i < 3; i++) /* linear in r, so largest at a corner's value */
        slope = fmax(slope,
                     norm((struct gradient){g_n.x - values[i] * g_d.x, g_n.y - values[i] * g_d.y}));
    struct plane_rounding of_n = plane_rounding(triangle, &edges, n);
    return (struct colour_bound){
        .slope = slope,
        .constant = triangle->slack.w * range + inverse_w_roundings(triangle) * value,
        .per_d = slope * edges.slack_per_d,
        .fixed = slope * fixed_slack(triangle, &edges) +
                 triangle->slack.w * range * beyond * largest(d) + of_n.common +
                 value * plane_error(triangle, &edges, d),
        .own_constant = roundings(products + triangle->value_roundings) * value,
        .own_fixed = of_n.own + roundings(1 + triangle->value_roundings) * beyond * largest(n)};
}

/* ---- from pixel to pixel ---- */

/* A value at a pixel, and what follows from it. */
struct at_pixel {
    double share[3], inverse_w, value; /* share: barycentric coordinates in the window */
    struct gradient gradient;          /* of the value */
};
/* The change of a value between two pixels. */
struct value_step {
    const struct clipped_triangle *triangle;
    const double *values;
    double n[3]; /* values / w */
    struct edges edges;
    double by[2]; /* pixels, in x and in y */
    struct at_pixel from, to;
};

static struct at_pixel at_pixel(const struct value_step *of, const double px[2])
{
    const double *d = of->triangle->screen.inverse_w;
    struct edge_functions functions;
    struct at_pixel out = {.inverse_w = 0};
    double n = 0;
    edges_at(of->triangle->screen.x, of->triangle->screen.y, px[0], px[1], &functions);
    const double *e = functions.e, twice_area = e[0] + e[1] + e[2];
    for (int i = 0; i < 3; i++) {
        out.share[i] = e[i] / twice_area;
        out.inverse_w += out.share[i] * d[i];
        n += out.share[i] * of->n[i];
    }
    out.value = n / out.inverse_w;
    const struct gradient g_n = gradient_of(&of->edges, of->n), g_d = gradient_of(&of->edges, d);
    out.gradient = (struct gradient){(g_n.x - out.value * g_d.x) / out.inverse_w,
                                     (g_n.y - out.value * g_d.y) / out.inverse_w};
    return out;
}

/* Positions: corners that are off by e_i change a value by the sum of share_i gradient . e_i. From
 * one pixel to the other both the shares and the gradient change. */
static double step_of_positions(const struct value_step *of)
{
    const struct gradient before = of->from.gradient, after = of->to.gradient,
                          turn = {after.x - before.x, after.y - before.y};
    double spread = 0, moved = 0;
    for (int i = 0; i < 3; i++) {
        spread += fabs(of->to.share[i]);
        moved += fabs(of->to.share[i] - of->from.share[i]);
    }
    return most_of(of->triangle->slack_px) * (spread * norm(turn) + moved * norm(before));
}

/* Corners: values that are off by e_values, and w by slack.w relative to it, with the weights by
 * which corners count at the pixels. */
static double step_of_corners(const struct value_step *of, double e_values)
{
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        const double d = of->triangle->screen.inverse_w[i], value = of->values[i],
                     before = of->from.share[i] * d / of->from.inverse_w,
                     after = of->to.share[i] * d / of->to.inverse_w;
        sum += e_values * fabs(after - before) +
               of->triangle->slack.w *
                   fabs(after * (value - of->to.value) - before * (value - of->from.value));
    }
    return sum;
}

/* Planes: with e for the errors of N and D that both pixels share, and c for those of their changes
 * from pixel to pixel, the change of N / D is off by
 *     (c_N - r c_D) / D + e_N (1 / D - 1 / D_0) - e_D (r / D - r_0 / D_0).
 * For c a gradient acts over the step alone; the evaluation rounds at both pixels. */
static double step_of_planes(const struct value_step *of)
{
    const double *d = of->triangle->screen.inverse_w, d0 = of->from.inverse_w,
                 d1 = of->to.inverse_w, r0 = of->from.value, r1 = of->to.value;
    struct edges beside = of->edges;
    beside.width = fabs(of->by[0]);
    beside.height = fabs(of->by[1]);
    return (plane_error(of->triangle, &beside, of->n) +
            fabs(r1) * plane_error(of->triangle, &beside, d)) /
               fabs(d1) +
           plane_error(of->triangle, &of->edges, of->n) * fabs(1 / d1 - 1 / d0) +
           plane_error(of->triangle, &of->edges, d) * fabs(r1 / d1 - r0 / d0);
}

/* The values at both pixels round by themselves: the sums of either plane, the division twice, and
 * that by q = 1 of fixed-function texturing three times. Corners round by 3 of their values. */
double bound_step(const struct clipped_triangle *triangle, const double values[3], double e_values,
                  const double from[2], const double to[2])
{
    const struct colour_bound *of_d = &triangle->inverse_w_bound;
    struct value_step step = {.triangle = triangle,
                              .values = values,
                              .edges = edges_of(triangle),
                              .by = {to[0] - from[0], to[1] - from[1]}};
    for (int i = 0; i < 3; i++)
        step.n[i] = values[i] * triangle->screen.inverse_w[i];
    step.from = at_pixel(&step, from);
    step.to = at_pixel(&step, to);
    const double d0 = fabs(step.from.inverse_w), d1 = fabs(step.to.inverse_w),
                 e0 = of_d->fixed + of_d->per_d * d0, e1 = of_d->fixed + of_d->per_d * d1,
                 at_pixels = roundings(2 * triangle->value_roundings + 5) *
                             (fabs(step.from.value) + fabs(step.to.value));
    if (!(triangle->magnification < HUGE_VAL && d0 > 2 * e0 && d1 > 2 * e1))
        return HUGE_VAL;
    return triangle->magnification * (1 + 2 * e0 / d0 + 2 * e1 / d1) *
           (step_of_positions(&step) +
            step_of_corners(&step, e_values + roundings(3) * largest(values)) +
            step_of_planes(&step) + at_pixels);
}
