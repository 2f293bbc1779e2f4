/* SPDX-License-Identifier: MIT */
/* Decides whether OpenGL has a fragment at a point for sure, perhaps, or not. With p the point and
 * a, b two corners minus p, moving a by up to e and b by up to f in x and y changes the edge
 * function a x b by at most e |b|_1 + f |a|_1 + 2 e f: the slack. */
#include <math.h>

#include "data/maths/maths.h"
#include "raster/candidates/inside.h"

void edge_slack(const struct edge_functions *edges, const double errors[3], double slack[3])
{
    double reach[3];
    for (int i = 0; i < 3; i++)
        reach[i] = fabs(edges->dx[i]) + fabs(edges->dy[i]);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        slack[i] = errors[j] * reach[k] + errors[k] * reach[j] + 2 * errors[j] * errors[k];
    }
}

/* scan_triangle visits centres up to the error and 1.5 pixels outside of the bounding box. */
double most_slack(const struct bounded_triangle *triangle)
{
    const double *x = triangle->screen.x, *y = triangle->screen.y,
                 error = most_of(triangle->edge_px),
                 size = most_of(x) - least_of(x) + most_of(y) - least_of(y);
    return 2 * error * (size + 3 + 3 * error);
}

static enum presence near_edges(const struct bounded_triangle *triangle,
                                const struct edge_functions *edges)
{
    const double *errors = triangle->edge_px;
    enum presence presence = DEFINITE;
    double slack[3];
    edge_slack(edges, errors, slack);
    for (int i = 0; i < 3; i++) {
        bool exact = errors[(i + 1) % 3] <= 0 && errors[(i + 2) % 3] <= 0,
             on_edge = exact && edges->e[i] == 0;
        if (edges->e[i] < -slack[i] || (on_edge && !owns_edge(&triangle->screen, i, 1)))
            return IMPOSSIBLE;
        if (!(edges->e[i] > slack[i]) && !on_edge)
            presence = POSSIBLE;
    }
    return presence;
}

enum presence triangle_presence(const struct bounded_triangle *triangle,
                                const struct edge_functions *edges, double most)
{
    const double *e = edges->e;
    enum presence presence = DEFINITE;
    if (e[0] < -most || e[1] < -most || e[2] < -most)
        return IMPOSSIBLE;
    if (!(e[0] > most && e[1] > most && e[2] > most))
        presence = near_edges(triangle, edges);
    return presence == DEFINITE && !(triangle->screen.twice_area > 0) ? POSSIBLE : presence;
}

/* A triangle without area touches its longest edge only. */
enum presence clipped_presence(const struct clipped_triangle *triangle, double px, double py)
{
    const double *x = triangle->x, *y = triangle->y;
    struct edge_functions edges;
    double slack[3], errors[3];
    for (int i = 0; i < 3; i++)
        errors[i] = triangle->moved_px[i] + triangle->grid_px;
    const double error = most_of(errors);
    if (least_of(x) - error > px || px > most_of(x) + error || least_of(y) - error > py ||
        py > most_of(y) + error)
        return IMPOSSIBLE;
    edges_at(x, y, px, py, &edges);
    edge_slack(&edges, errors, slack);
    double turn = edges.e[0] + edges.e[1] + edges.e[2] < 0 ? -1 : 1;
    enum presence presence = DEFINITE;
    for (int i = 0; i < 3; i++) {
        if (turn * edges.e[i] < -slack[i])
            return IMPOSSIBLE;
        if (!(turn * edges.e[i] > slack[i]))
            presence = POSSIBLE;
    }
    return presence;
}
