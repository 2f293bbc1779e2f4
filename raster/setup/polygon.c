/* SPDX-License-Identifier: MIT */
/* What clipping makes of a triangle, and bounds on OpenGL's errors in the corners. */
#include <math.h>

#include "raster/setup/setup.h"

/* ---- corners of the triangle ---- */

const struct vertex_bounds *vertex_bounds(const struct lit_scene *lit,
                                          const struct screen_triangle *screen, int corner)
{
    return &bounds_of(lit, screen)->vertices[screen->vertex[corner]];
}

struct slack whole_slack(const struct lit_scene *lit, const struct screen_triangle *screen,
                         int corner)
{
    const struct vertex_bounds *vertex = vertex_bounds(lit, screen, corner);
    return (struct slack){(double)vertex->slack_px, (double)vertex->slack_depth,
                          (double)vertex->slack_w};
}

/* The largest error of a clip coordinate (CLIP_XY, CLIP_Z, CLIP_W) of any corner. */
static double largest_e_clip(const struct lit_scene *lit, const struct screen_triangle *screen,
                             int coordinate)
{
    double e[3];
    for (int i = 0; i < 3; i++)
        e[i] = (double)vertex_bounds(lit, screen, i)->e_clip[coordinate];
    return most_of(e);
}

/* ---- cuts ---- */

static double plane_distance(const struct clip_plane *plane, const double clip[4])
{
    return plane->normal[0] * clip[0] + plane->normal[1] * clip[1] + plane->normal[2] * clip[2] +
           plane->normal[3] * clip[3] + plane->offset;
}

/* Bounds the error that OpenGL makes in a corner's distance from a plane, a sum of four products,
 * and that of the corner's place in it. The offset is only ours. */
static struct bounded corner_distance(const struct clip_plane *plane, const double clip[4],
                                      const struct cut_corner *cut, double *rounding)
{
    static const int coordinate[4] = {CLIP_XY, CLIP_XY, CLIP_Z, CLIP_W};
    struct bounded out = {plane_distance(plane, clip), fabs(plane->offset)};
    *rounding = 0;
    for (int i = 0; i < 4; i++) {
        *rounding += roundings(4) * fabs(plane->normal[i] * clip[i]);
        out.error += fabs(plane->normal[i]) * (cut->e[coordinate[i]] + cut->slide[coordinate[i]]);
    }
    out.error += *rounding;
    return out;
}

/* Finds the errors of a corner that a cut makes between corners a and b. OpenGL starts at the end
 * that is nearer to the plane, and adds a part of the edge: it rounds the edge, the product and the
 * sum. */
static struct cut_corner cut_edge(const struct clip_plane *plane, const struct polygon *from, int a,
                                  int b, const double clip[4])
{
    const double *p = from->corner[a].clip, *q = from->corner[b].clip;
    const struct cut_corner *of_p = &from->cut[a], *of_q = &from->cut[b];
    double rounding_p, rounding_q;
    const struct bounded at_p = corner_distance(plane, p, of_p, &rounding_p),
                         at_q = corner_distance(plane, q, of_q, &rounding_q);
    const double apart = fabs(at_p.value) + fabs(at_q.value),
                 t = apart > 0 ? fabs(at_p.value) / apart : 0, *near = t < 0.5 ? p : q,
                 error = (1 - t) * at_p.error + t * at_q.error,
                 e_t = apart > 2 * error ? error / (apart - error) + roundings(2) : 1;
    struct cut_corner out = {.off = (1 - t) * rounding_p + t * rounding_q,
                             .cuts = 1 + (of_p->cuts > of_q->cuts ? of_p->cuts : of_q->cuts),
                             .planes = of_p->planes & of_q->planes,
                             .whole = -1};
    double rounded = 0;
    for (int i = 0; i < 4; i++) {
        const int k = i < 2 ? CLIP_XY : i == 2 ? CLIP_Z : CLIP_W;
        double rounding = roundings(1) * (2 * fabs(clip[i] - near[i]) + fabs(clip[i])),
               e = (1 - t) * of_p->e[k] + t * of_q->e[k] + rounding,
               slide = (1 - t) * of_p->slide[k] + t * of_q->slide[k] + e_t * fabs(q[i] - p[i]);
        out.e[k] = fmax(out.e[k], e);
        out.slide[k] = fmax(out.slide[k], slide);
        rounded += rounding;
    }
    out.off = fmax(out.off, (1 - t) * of_p->off + t * of_q->off) + rounded;
    return out;
}

/* Cuts by plane number p. */
static void clip(struct polygon *polygon, const struct clip_plane *plane, int p)
{
    const struct polygon from = *polygon;
    polygon->n = clip_polygon(plane, from.corner, from.n, polygon->corner);
    for (int i = 0; i < polygon->n; i++) {
        int inner = polygon->corner[i].inner, outer = polygon->corner[i].outer;
        polygon->cut[i] = from.cut[inner];
        if (inner == outer)
            continue;
        polygon->cut[i] = cut_edge(plane, &from, inner, outer, polygon->corner[i].clip);
        polygon->cut[i].planes |= 1 << p;
    }
}

void clip_planes(const struct lit_scene *lit, const struct screen_triangle *screen,
                 const struct rectangle *tile, struct clip_plane planes[CLIP_PLANES])
{
    const struct plan *plan = lit->plan;
    double width = plan->scene->width, height = plan->scene->height;
    double near_w = plan->scene->camera.perspective ? plan->near : 1;
    double error = largest_e_clip(lit, screen, CLIP_Z);
    double left = 2 * tile->x / width - 1, right = 2 * (tile->x + tile->width) / width - 1;
    double top = 1 - 2 * tile->y / height, bottom = 1 - 2 * (tile->y + tile->height) / height;
    planes[0] = (struct clip_plane){{-1, 0, 0, right}, 0};
    planes[1] = (struct clip_plane){{1, 0, 0, -left}, 0};
    planes[2] = (struct clip_plane){{0, -1, 0, top}, 0};
    planes[3] = (struct clip_plane){{0, 1, 0, -bottom}, 0};
    planes[4] = (struct clip_plane){{0, 0, 1, 1}, fmin(2 * error, 0.25 * near_w)};
    planes[5] = (struct clip_plane){{0, 0, -1, 1}, 2 * error};
}

struct polygon polygon_of(const struct lit_scene *lit, const struct screen_triangle *screen,
                          const struct rectangle *tile)
{
    struct clip_plane planes[CLIP_PLANES];
    struct corner whole[3];
    struct polygon out = {.n = 3};
    whole_corners(screen->surface, screen->vertex, whole);
    for (int i = 0; i < 3; i++) {
        int corner = screen->clockwise ? i : (3 - i) % 3;
        const float *e_clip = vertex_bounds(lit, screen, corner)->e_clip;
        out.corner[i] = whole[corner];
        out.cut[i] = (struct cut_corner){.whole = corner};
        for (int k = 0; k < 3; k++)
            out.cut[i].e[k] = (double)e_clip[k];
    }
    clip_planes(lit, screen, tile, planes);
    for (int p = 0; p < CLIP_PLANES && out.n > 0; p++)
        clip(&out, &planes[p], p);
    return out;
}

/* ---- bounds of corners ---- */

/* The slack of a corner whose clip coordinates have these errors. A tile's clip space is shifted
 * against the picture's by at most w. */
static struct slack corner_slack(const struct lit_scene *lit, const double clip[4],
                                 const double e[3])
{
    const double half = 0.5 * fmax(lit->plan->scene->width, lit->plan->scene->height), w = clip[3];
    const struct bounded xy = {fmax(fabs(clip[0]), fabs(clip[1])),
                               e[CLIP_XY] + lit->plan->tiled * e[CLIP_W]};
    const struct bounded bounded[4] = {xy, xy, {w, e[CLIP_Z]}, {w, e[CLIP_W]}}; /* |z| <= w */
    return window_slack(bounded, half, half);
}

struct slack polygon_slack(const struct lit_scene *lit, const struct screen_triangle *screen,
                           const struct polygon *polygon, int i)
{
    const struct cut_corner *cut = &polygon->cut[i];
    return cut->whole >= 0 ? whole_slack(lit, screen, cut->whole)
                           : corner_slack(lit, polygon->corner[i].clip, cut->e);
}

/* How far a corner may be from its place in the window. A corner of the tile, made by a side and by
 * the top or the bottom, is fixed by both, however far the triangle's corners are off. */
double moved_px(const struct lit_scene *lit, const struct screen_triangle *screen,
                const struct polygon *polygon, int i)
{
    const struct cut_corner *cut = &polygon->cut[i];
    double e[3], slack_px = polygon_slack(lit, screen, polygon, i).px;
    if (cut->whole >= 0)
        return slack_px;
    const bool fixed = (cut->planes & 3) != 0 && (cut->planes & 12) != 0;
    for (int k = 0; k < 3; k++)
        e[k] = fixed ? (k == CLIP_XY) * cut->off : cut->e[k] + cut->slide[k];
    return fmax(slack_px * !fixed, corner_slack(lit, polygon->corner[i].clip, e).px);
}
