/* SPDX-License-Identifier: MIT */
/* Homogeneous clipping (Sutherland and Hodgman 1974): a polygon is cut in clip space, before any
 * division. A cut edge gives the same corner, to the bit, in both triangles that share it. */
#include <float.h>
#include <math.h>

#include "raster/reference/reference.h"

const struct clip_plane depth_planes[2] = {{{0, 0, 1, 1}, 0}, {{0, 0, -1, 1}, 0}};

static double distance(const struct clip_plane *plane, const struct corner *corner)
{
    return plane->normal[0] * corner->clip[0] + plane->normal[1] * corner->clip[1] +
           plane->normal[2] * corner->clip[2] + plane->normal[3] * corner->clip[3] + plane->offset;
}

/* Cuts an edge at the plane, always computed from its inner end towards its outer one. */
static struct corner cut(const struct corner *in, const double *distances, int inner, int outer)
{
    const struct corner *from = &in[inner], *to = &in[outer];
    struct corner out = {.inner = inner, .outer = outer};
    double t = distances[inner] / (distances[inner] - distances[outer]);
    for (int i = 0; i < 4; i++)
        out.clip[i] = from->clip[i] + t * (to->clip[i] - from->clip[i]);
    for (int i = 0; i < 3; i++)
        out.share[i] = from->share[i] + t * (to->share[i] - from->share[i]);
    return out;
}

/* Rounding may place the corners of a polygon that lies in the plane, or nearly, inside and outside
 * by turns. Of several runs inside the longest is kept, so that a plane adds one corner at most. */
static void keep_longest_run(double distances[CLIP_CORNERS], int n)
{
    int longest = 0, first = 0;
    for (int i = 0; i < n; i++) {
        int run = 0;
        while (run < n && distances[(i + run) % n] >= 0)
            run++;
        if (run > longest) {
            longest = run;
            first = i;
        }
    }
    for (int i = longest; i < n; i++) /* not more than 0, so that a cut lands on the corner */
        distances[(first + i) % n] = fmin(distances[(first + i) % n], -DBL_MIN);
}

/* Keeps the part of a polygon of n corners that lies inside the plane; `out` has room for one more.
 * Returns how many corners are left, in the same sense of rotation; 0: nothing. */
int clip_polygon(const struct clip_plane *by, const struct corner *in, int n, struct corner *out)
{
    double distances[CLIP_CORNERS];
    int n_out = 0;
    for (int i = 0; i < n; i++)
        distances[i] = distance(by, &in[i]);
    keep_longest_run(distances, n);
    for (int i = 0; i < n; i++) {
        int next = (i + 1) % n;
        if (distances[i] >= 0) {
            out[n_out] = in[i];
            out[n_out].inner = out[n_out].outer = i;
            n_out++;
        }
        if (distances[i] >= 0 && distances[next] < 0)
            out[n_out++] = cut(in, distances, i, next);
        else if (distances[i] < 0 && distances[next] >= 0)
            out[n_out++] = cut(in, distances, next, i);
    }
    return n_out < 3 ? 0 : n_out;
}
