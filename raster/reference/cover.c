/* SPDX-License-Identifier: MIT */
/* Triangles in the window, and the pixel centres that they cover.
 *
 * With p the centre and a, b two corners minus p, the edge function a x b is twice the area of the
 * triangle (p, a, b). Swapping a and b changes exactly its sign in floating point too. Each edge is
 * decided from its two corners alone, and exactly: of two triangles that share an edge, one covers
 * a centre on it. */
#include <math.h>
#include <string.h>

#include "raster/reference/reference.h"

/* ---- triangles in the window ---- */

/* The corners of a triangle of the mesh, none of them cut. */
void whole_corners(const struct surface *surface, const int32_t vertex[3], struct corner out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = (struct corner){.inner = i, .outer = i};
        memcpy(out[i].clip, surface->vertices[vertex[i]].clip, sizeof out[i].clip);
        out[i].share[i] = 1;
    }
}

/* Makes a corner in front of the eye corner i of a screen triangle. */
void screen_corner(const struct view *view, const struct corner *from, int i,
                   struct screen_triangle *out)
{
    struct window_vertex vertex;
    memcpy(vertex.clip, from->clip, sizeof vertex.clip);
    window_place(view, &vertex);
    memcpy(out->share[i], from->share, sizeof from->share);
    out->x[i] = vertex.x;
    out->y[i] = vertex.y;
    out->z[i] = vertex.z;
    out->inverse_w[i] = vertex.inverse_w;
}

static void swap_corners(struct screen_triangle *triangle)
{
    const struct screen_triangle old = *triangle;
    for (int i = 0; i < 3; i++) {
        const int from = (3 - i) % 3; /* 0, 2, 1 */
        triangle->x[i] = old.x[from];
        triangle->y[i] = old.y[from];
        triangle->z[i] = old.z[from];
        triangle->inverse_w[i] = old.inverse_w[from];
        triangle->vertex[i] = old.vertex[from];
        for (int j = 0; j < 3; j++)
            triangle->share[i][j] = old.share[from][(3 - j) % 3];
    }
}

/* Turns the corners so that edge functions are positive inside. */
static void turn_corners(struct screen_triangle *triangle)
{
    const double *x = triangle->x, *y = triangle->y;
    double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    triangle->twice_area = fabs(area);
    triangle->clockwise = area >= 0;
    triangle->side = triangle->surface->n_sides == 2 &&
                     triangle->clockwise != triangle->surface->instance->mirrored;
    if (!triangle->clockwise)
        swap_corners(triangle);
}

/* Places a triangle in the window, cut by n planes, two at most. The polygon that they leave is
 * fanned from its first corner. Returns how many screen triangles that makes. */
int screen_triangles(const struct view *view, const struct surface *of, int triangle,
                     const struct clip_plane *planes, int n, struct screen_triangle out[])
{
    const int32_t *vertex = of->instance->triangles[triangle];
    struct corner corners[CLIP_CORNERS], from[CLIP_CORNERS];
    int left = 3;
    whole_corners(of, vertex, corners);
    for (int p = 0; p < n && left > 0; p++) {
        memcpy(from, corners, sizeof from);
        left = clip_polygon(&planes[p], from, left, corners);
    }
    for (int i = 2; i < left; i++) {
        struct screen_triangle *part = &out[i - 2];
        *part =
            (struct screen_triangle){.surface = of, .triangle = triangle, .provoking = vertex[2]};
        memcpy(part->vertex, vertex, sizeof part->vertex);
        screen_corner(view, &corners[0], 0, part);
        screen_corner(view, &corners[i - 1], 1, part);
        screen_corner(view, &corners[i], 2, part);
        turn_corners(part);
    }
    return left < 3 ? 0 : left - 2;
}

/* ---- edge functions ---- */

/* Finds the edge functions of a triangle at a point of the window. */
void edges_at(const double x[3], const double y[3], double px, double py, struct edge_functions *e)
{
    const double dx[3] = {x[0] - px, x[1] - px, x[2] - px},
                 dy[3] = {y[0] - py, y[1] - py, y[2] - py};
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        e->dx[i] = dx[i];
        e->dy[i] = dy[i];
        e->e[i] = dx[j] * dy[k] - dx[k] * dy[j];
    }
}

/* The sign of ax by - bx ay without error: where the rounded products are too near each other for
 * their rounded difference, that difference is exact, and the parts that rounding took from the
 * products decide (Dekker 1971). */
static double exact_turn(double ax, double ay, double bx, double by)
{
    double p = ax * by, q = bx * ay, difference = p - q;
    if (fabs(difference) > 16 * DOUBLE_ROUNDOFF * (fabs(p) + fabs(q))) /* above its rounding */
        return difference;
    return difference + (fma(ax, by, -p) - fma(bx, ay, -q));
}

/* A centre exactly on an edge belongs to the triangle whose edge runs this way, not to the one
 * whose edge runs back: to its left or lower one in the picture. sense: 1, or -1 if the corners
 * turn the other way. */
bool owns_edge(const struct screen_triangle *triangle, int edge, int sense)
{
    int j = (edge + 1) % 3, k = (edge + 2) % 3;
    double dx = sense * (triangle->x[k] - triangle->x[j]),
           dy = sense * (triangle->y[k] - triangle->y[j]);
    return dy < 0 || (dy == 0 && dx < 0);
}

static bool covers_in_sense(const struct screen_triangle *triangle,
                            const struct edge_functions *edges, int sense)
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double turn = sense * exact_turn(edges->dx[j], edges->dy[j], edges->dx[k], edges->dy[k]);
        if (turn < 0 || (turn == 0 && !owns_edge(triangle, i, sense)))
            return false;
    }
    return true;
}

/* The rounded area of a needle may have the wrong sign: then all three edges agree on the other
 * sense. */
bool edges_cover(const struct screen_triangle *triangle, const struct edge_functions *edges)
{
    return covers_in_sense(triangle, edges, 1) || covers_in_sense(triangle, edges, -1);
}

/* Depth is linear in the window. Sums of edge functions, not the area, make shares add up to 1. */
double depth_at(const struct screen_triangle *triangle, const struct edge_functions *edges)
{
    const double *e = edges->e, *z = triangle->z;
    double sum = e[0] + e[1] + e[2];
    return sum > 0 ? (e[0] * z[0] + e[1] * z[1] + e[2] * z[2]) / sum : z[0];
}

/* The depth where the triangle covers the point; otherwise -1. */
double covered_depth(const struct screen_triangle *triangle, double px, double py)
{
    struct edge_functions edges;
    edges_at(triangle->x, triangle->y, px, py, &edges);
    return edges_cover(triangle, &edges) ? depth_at(triangle, &edges) : -1;
}

/* Barycentric coordinates of a point in the whole triangle; returns 1 / w there. Outside the part
 * that clipping left they extrapolate; where it has no area, or roundings leave none at the point,
 * they are those of its middle. */
double shares_at(const struct screen_triangle *triangle, double px, double py, double out[3])
{
    struct edge_functions edges;
    double share[3], sum = 0;
    edges_at(triangle->x, triangle->y, px, py, &edges);
    for (int i = 0; i < 3; i++)
        sum += share[i] = edges.e[i] * triangle->inverse_w[i];
    const bool has_area = triangle->twice_area > 0 && sum != 0;
    for (int i = 0; i < 3; i++)
        share[i] = has_area ? share[i] / sum : 1.0 / 3;
    for (int j = 0; j < 3; j++)
        out[j] = share[0] * triangle->share[0][j] + share[1] * triangle->share[1][j] +
                 share[2] * triangle->share[2][j];
    return has_area ? sum / triangle->twice_area : 1;
}

static int clamp_to(double value, int low, int high)
{
    return value < low ? low : value > high ? high : (int)value;
}

/* Narrows a row's pixels, *left to *right - 1, to those whose edge functions may all be at `least`
 * or above, and a few more. Edge functions are linear along a row. */
static void narrow_row(const struct screen_triangle *triangle, int y, double least, int *left,
                       int *right)
{
    double py = y + 0.5, px = *left + 0.5;
    int first = *left, last = *right;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double p = (triangle->x[j] - px) * (triangle->y[k] - py),
               q = (triangle->x[k] - px) * (triangle->y[j] - py),
               step = triangle->y[j] - triangle->y[k];
        double inside = p - q - least + 16 * DOUBLE_ROUNDOFF * (fabs(p) + fabs(q));
        if (step > 0 && inside < 0)
            *left = clamp_to(fmax(*left, first - inside / step), first, last);
        if (step < 0 && -inside / step < last - first)
            *right = clamp_to(fmin(*right, first - inside / step + 2), first, last);
    }
}

/* Visits every pixel of `at` whose centre the triangle may cover if its corners move by up to
 * `margin` pixels, and a few more. Stops where visit returns false, and returns false then.
 *
 * A corner that moves by up to `margin` in x and y changes an edge function by `margin` times the
 * distance from the centre to the edge's other end, and a second-order term. */
bool scan_triangle(const struct screen_triangle *triangle, const struct rectangle *at,
                   double margin, bool (*visit)(void *context, int x, int y), void *context)
{
    const double *x = triangle->x, *y = triangle->y;
    int left = clamp_to(floor(least_of(x) - margin - 0.5), at->x, at->x + at->width);
    int right = clamp_to(ceil(most_of(x) + margin + 0.5), at->x, at->x + at->width);
    int top = clamp_to(floor(least_of(y) - margin - 0.5), at->y, at->y + at->height);
    int bottom = clamp_to(ceil(most_of(y) + margin + 0.5), at->y, at->y + at->height);
    double reach = most_of(x) - least_of(x) + most_of(y) - least_of(y) + 2;
    for (int row = top; row < bottom; row++) {
        int first = left, last = right;
        narrow_row(triangle, row, -2 * margin * (reach + 3 * margin), &first, &last);
        for (int column = first; column < last; column++)
            if (!visit(context, column, row))
                return false;
    }
    return true;
}
