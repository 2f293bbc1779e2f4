/* SPDX-License-Identifier: MIT */
/* How sure it is that OpenGL has a fragment at a point. With p the point and a, b two corners minus
 * p, moving a by up to e and b by up to f in x and y changes the edge function a x b by at most
 * e |b|_1 + f |a|_1 + 2 e f: the slack. */
#include <math.h>

#include "data/maths/maths.h"
#include "raster/bounds/bounds.h"
#include "raster/candidates/candidates.h"
#include "raster/reference/reference.h"

static void edge_slack(const struct edge_functions *edges, const double errors[3], double slack[3])
{
    double reach[3];
    for (int i = 0; i < 3; i++)
        reach[i] = fabs(edges->dx[i]) + fabs(edges->dy[i]);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        slack[i] = errors[j] * reach[k] + errors[k] * reach[j] + 2 * errors[j] * errors[k];
    }
}

enum presence triangle_presence(const struct bounded_triangle *triangle, double px, double py,
                                struct edge_functions *edges, double slack[3])
{
    const double *errors = triangle->edge_px;
    enum presence presence = DEFINITE;
    edges_at(triangle->screen.x, triangle->screen.y, px, py, edges);
    edge_slack(edges, errors, slack);
    for (int i = 0; i < 3; i++) {
        bool exact = errors[(i + 1) % 3] <= 0 && errors[(i + 2) % 3] <= 0,
             on_edge = exact && edges->e[i] == 0;
        if (edges->e[i] < -slack[i] || (on_edge && !owns_edge(&triangle->screen, i, 1)))
            return IMPOSSIBLE;
        if (!(edges->e[i] > slack[i]) && !on_edge)
            presence = POSSIBLE;
    }
    return triangle->screen.twice_area > 0 ? presence : POSSIBLE;
}

/* A triangle without area touches its longest edge only. */
enum presence clipped_presence(const struct clipped_triangle *triangle, double px, double py)
{
    const double *x = triangle->x, *y = triangle->y, error = most_of(triangle->edge_px);
    struct edge_functions edges;
    double slack[3];
    if (least_of(x) - error > px || px > most_of(x) + error || least_of(y) - error > py ||
        py > most_of(y) + error)
        return IMPOSSIBLE;
    edges_at(x, y, px, py, &edges);
    edge_slack(&edges, triangle->edge_px, slack);
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
