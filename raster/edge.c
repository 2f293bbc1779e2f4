/* SPDX-License-Identifier: MIT */
/* Edge functions: on which side of a triangle's edges a pixel centre lies.
 *
 * With p the centre and a, b two corners minus p, the edge function a x b is twice the area of the
 * triangle (p, a, b). Swapping a and b changes exactly its sign in floating point too, so that two
 * triangles with a common edge never both own, nor both miss, a pixel. Moving a by up to e and b by
 * up to f in x and y changes a x b by at most e |b|_1 + f |a|_1 + 2 e f: the slack. */
#include <math.h>

#include "coverage.h"

double least_of(const double v[3])
{
    return fmin(v[0], fmin(v[1], v[2]));
}

double most_of(const double v[3])
{
    return fmax(v[0], fmax(v[1], v[2]));
}

void edges_at(const double x[3], const double y[3], double px, double py, const double errors[3],
              struct edge_values *out)
{
    double reach[3];
    for (int i = 0; i < 3; i++) {
        out->dx[i] = x[i] - px;
        out->dy[i] = y[i] - py;
        reach[i] = fabs(out->dx[i]) + fabs(out->dy[i]);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out->e[i] = out->dx[j] * out->dy[k] - out->dx[k] * out->dy[j];
        out->slack[i] = errors[j] * reach[k] + errors[k] * reach[j] + 2 * errors[j] * errors[k];
    }
}

/* The sign of ax by - bx ay without error: of two products that are too near each other for their
 * rounded difference, the difference is exact and what rounding took from each decides
 * (Dekker 1971). */
static double exact_turn(double ax, double ay, double bx, double by)
{
    double p = ax * by, q = bx * ay, difference = p - q;
    if (fabs(difference) > 1e-15 * (fabs(p) + fabs(q))) /* above four roundings */
        return difference;
    return difference + (fma(ax, by, -p) - fma(bx, ay, -q));
}

/* A centre exactly on an edge belongs to the triangle whose edge runs this way, not to the one
 * whose edge runs back: to its left or lower one in the picture, as in llvmpipe. sense: 1, or -1 if
 * the corners turn the other way. */
static bool owns_edge(const struct facet *facet, int edge, int sense)
{
    int j = (edge + 1) % 3, k = (edge + 2) % 3;
    double dx = sense * (facet->x[k] - facet->x[j]), dy = sense * (facet->y[k] - facet->y[j]);
    return dy < 0 || (dy == 0 && dx < 0);
}

static bool covers_in_sense(const struct facet *facet, const struct edge_values *edges, int sense)
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double turn = sense * exact_turn(edges->dx[j], edges->dy[j], edges->dx[k], edges->dy[k]);
        if (turn < 0 || (turn == 0 && !owns_edge(facet, i, sense)))
            return false;
    }
    return true;
}

/* Each edge is decided from its two corners alone, so that triangles that meet neither both own,
 * nor both miss, a centre. Of a needle the rounded area may have the wrong sign: then all three
 * edges agree on the other sense. */
bool edges_cover(const struct facet *facet, const struct edge_values *edges)
{
    return covers_in_sense(facet, edges, 1) || covers_in_sense(facet, edges, -1);
}

enum presence edges_presence(const struct facet *facet, const struct edge_values *edges)
{
    enum presence presence = DEFINITE;
    for (int i = 0; i < 3; i++) {
        bool exact = facet->edge_px[(i + 1) % 3] <= 0 && facet->edge_px[(i + 2) % 3] <= 0,
             on_edge = exact && edges->e[i] == 0;
        if (edges->e[i] < -edges->slack[i] || (on_edge && !owns_edge(facet, i, 1)))
            return IMPOSSIBLE;
        if (!(edges->e[i] > edges->slack[i]) && !on_edge)
            presence = POSSIBLE;
    }
    return facet->twice_area > 0 ? presence : POSSIBLE;
}

/* A triangle without area touches its longest edge only. */
enum presence outline_presence(const struct outline *outline, double px, double py)
{
    const double *x = outline->x, *y = outline->y, error = most_of(outline->edge_px);
    struct edge_values edges;
    if (least_of(x) - error > px || px > most_of(x) + error || least_of(y) - error > py ||
        py > most_of(y) + error)
        return IMPOSSIBLE;
    edges_at(x, y, px, py, outline->edge_px, &edges);
    double turn = edges.e[0] + edges.e[1] + edges.e[2] < 0 ? -1 : 1;
    enum presence presence = DEFINITE;
    for (int i = 0; i < 3; i++) {
        if (turn * edges.e[i] < -edges.slack[i])
            return IMPOSSIBLE;
        if (!(turn * edges.e[i] > edges.slack[i]))
            presence = POSSIBLE;
    }
    return presence;
}
