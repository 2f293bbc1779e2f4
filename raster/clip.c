/* SPDX-License-Identifier: MIT */
/* Homogeneous clipping: a triangle is cut plane by plane in clip space, before any division. */
#include <float.h>
#include <math.h>

#include "coverage.h"

/* Cutting an edge in single precision: weight and sum round three times, relative to both ends. */
static const double cut_roundings = 3.0 / 16777216;

static double distance(const struct clip_plane *plane, const struct corner *corner)
{
    return plane->normal[0] * corner->clip[0] + plane->normal[1] * corner->clip[1] +
           plane->normal[2] * corner->clip[2] + plane->normal[3] * corner->clip[3] + plane->offset;
}

/* Where the edge crosses the plane, always computed from the inner end towards the outer one. */
static struct corner cut(const struct corner *inner, double d_inner, const struct corner *outer,
                         double d_outer)
{
    struct corner out = {.whole = -1};
    double t = d_inner / (d_inner - d_outer);
    for (int i = 0; i < 4; i++)
        out.clip[i] = inner->clip[i] + t * (outer->clip[i] - inner->clip[i]);
    for (int i = 0; i < 3; i++)
        out.share[i] = inner->share[i] + t * (outer->share[i] - inner->share[i]);
    double sums[4];
    for (int i = 0; i < 4; i++)
        sums[i] = cut_roundings * (fabs(inner->clip[i]) + fabs(outer->clip[i]));
    const double errors[3] = {
        [CLIP_XY] = fmax(sums[0], sums[1]), [CLIP_Z] = sums[2], [CLIP_W] = sums[3]};
    for (int k = 0; k < 3; k++)
        out.cut_error[k] = fmax(inner->cut_error[k], outer->cut_error[k]) + errors[k];
    return out;
}

/* Rounding may tell the corners of a polygon that lies in the plane, or nearly, in and out by
 * turns. Of several runs inside the longest is kept, so that a plane adds one corner at most. */
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

static int clip_by(const struct clip_plane *plane, const struct corner *in, int n_in,
                   struct corner *out)
{
    double distances[CLIP_CORNERS];
    int n_out = 0;
    for (int i = 0; i < n_in; i++)
        distances[i] = distance(plane, &in[i]);
    keep_longest_run(distances, n_in);
    for (int i = 0; i < n_in; i++) {
        int next = (i + 1) % n_in;
        double d_here = distances[i], d_next = distances[next];
        if (d_here >= 0)
            out[n_out++] = in[i];
        if (d_here >= 0 && d_next < 0)
            out[n_out++] = cut(&in[i], d_here, &in[next], d_next);
        else if (d_here < 0 && d_next >= 0)
            out[n_out++] = cut(&in[next], d_next, &in[i], d_here);
    }
    return n_out;
}

int clip_triangle(const struct corner whole[3], const struct clip_plane *planes, int n_planes,
                  struct corner out[CLIP_CORNERS])
{
    struct corner from[CLIP_CORNERS];
    int n = 3;
    for (int i = 0; i < 3; i++)
        out[i] = whole[i];
    for (int p = 0; p < n_planes && n > 0; p++) {
        for (int i = 0; i < n; i++)
            from[i] = out[i];
        n = clip_by(&planes[p], from, n, out);
    }
    return n < 3 ? 0 : n;
}
