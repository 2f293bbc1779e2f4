/* SPDX-License-Identifier: MIT */
/* Homogeneous clipping: a triangle is cut plane by plane in clip space, before any division. */
#include <math.h>

#include "coverage.h"

/* Cutting an edge in single precision: weight and sum round three times, relative to both ends. */
static const double cut_roundings = 3.0 / 16777216;

static double distance(const struct clip_plane *plane, const struct corner *corner)
{
    return plane->normal[0] * corner->clip[0] + plane->normal[1] * corner->clip[1] +
           plane->normal[2] * corner->clip[2] + plane->normal[3] * corner->clip[3] + plane->offset;
}

static double magnitude(const struct corner *corner)
{
    double x = fabs(corner->clip[0]), y = fabs(corner->clip[1]), z = fabs(corner->clip[2]);
    /* a tile's clip space is shifted against the picture's by at most w */
    return fmax(x, fmax(y, z)) + fabs(corner->clip[3]);
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
    out.cut_error = fmax(inner->cut_error, outer->cut_error) +
                    cut_roundings * (magnitude(inner) + magnitude(outer));
    return out;
}

static int clip_by(const struct clip_plane *plane, const struct corner *in, int n_in,
                   struct corner *out)
{
    int n_out = 0;
    for (int i = 0; i < n_in; i++) {
        const struct corner *here = &in[i], *next = &in[(i + 1) % n_in];
        double d_here = distance(plane, here), d_next = distance(plane, next);
        if (d_here >= 0)
            out[n_out++] = *here;
        if (d_here >= 0 && d_next < 0)
            out[n_out++] = cut(here, d_here, next, d_next);
        else if (d_here < 0 && d_next >= 0)
            out[n_out++] = cut(next, d_next, here, d_here);
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
