/* SPDX-License-Identifier: MIT */
/* Clips triangles, and bounds OpenGL's errors in the corners. */
#include <math.h>

#include "data/maths/maths.h"
#include "raster/candidates/inside.h"
#include "raster/plan/plan.h"

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

/* Returns a corner's distance from a plane, with a bound on OpenGL's error in it: of the corner's
 * place, and of the sum of four products. A tile's clip space is shifted by at most w, which comes
 * into the sum. The offset is only ours. */
static struct bounded corner_distance(const struct clip_plane *plane, const double clip[4],
                                      const struct cut_corner *cut, double *rounding)
{
    struct bounded out = {fabs(plane_distance(plane, clip)), fabs(plane->offset)};
    *rounding = roundings(4) * fabs(clip[CLIP_W]);
    for (int i = 0; i < 4; i++) {
        *rounding += roundings(4) * fabs(plane->normal[i] * clip[i]);
        out.error += fabs(plane->normal[i]) * cut->e[i];
    }
    for (int v = 0; v < cut->n_slides && v < SLIDES; v++) {
        const double *slide = cut->slides[v], *n = plane->normal;
        out.error += fabs(n[0] * slide[0] + n[1] * slide[1] + n[2] * slide[2] + n[3] * slide[3]);
    }
    out.error += *rounding;
    return out;
}

/* Adds the slides of a corner, times a factor. */
static void add_slides(struct cut_corner *to, const double slides[][4], int n, double factor)
{
    for (int v = 0; v < n; v++) {
        for (int i = 0; i < 4 && to->n_slides < SLIDES; i++)
            to->slides[to->n_slides][i] = factor * slides[v][i];
        to->n_slides += to->n_slides <= SLIDES;
    }
}

/* Finds the errors of a corner that a cut makes between corners a and b. OpenGL starts at the end
 * that is nearer to the plane, and adds a part of the edge: it rounds the edge, the product and the
 * sum. */
static struct cut_corner cut_edge(const struct clip_plane *plane, const struct polygon *from, int a,
                                  int b, const double clip[4])
{
    const double *p = from->corner[a].clip, *q = from->corner[b].clip;
    const struct cut_corner *of_p = &from->cut[a], *of_q = &from->cut[b];
    double rounding_p, rounding_q, rounded = 0;
    const struct bounded at_p = corner_distance(plane, p, of_p, &rounding_p),
                         at_q = corner_distance(plane, q, of_q, &rounding_q);
    const double apart = at_p.value + at_q.value, t = apart > 0 ? at_p.value / apart : 0,
                 error = (1 - t) * at_p.error + t * at_q.error,
                 e_t = apart > 2 * error ? error / (apart - error) + roundings(2) : 1;
    struct cut_corner out = {.cuts = 1 + (of_p->cuts > of_q->cuts ? of_p->cuts : of_q->cuts),
                             .planes = of_p->planes & of_q->planes,
                             .whole = -1};
    const double edge[1][4] = {{q[0] - p[0], q[1] - p[1], q[2] - p[2], q[3] - p[3]}};
    add_slides(&out, of_p->slides, of_p->n_slides, 1 - t);
    add_slides(&out, of_q->slides, of_q->n_slides, t);
    add_slides(&out, edge, 1, e_t);
    for (int i = 0; i < 4; i++) {
        double step = fabs(clip[i] - (t < 0.5 ? p[i] : q[i])),
               rounding = roundings(1) * (2 * step + fabs(clip[i]));
        out.e[i] = (1 - t) * of_p->e[i] + t * of_q->e[i] + rounding;
        rounded += rounding;
    }
    out.off =
        fmax((1 - t) * rounding_p + t * rounding_q, (1 - t) * of_p->off + t * of_q->off) + rounded;
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

void clip_planes(const struct tile *tile, const struct screen_triangle *screen,
                 struct clip_plane planes[CLIP_PLANES])
{
    const struct plan *plan = tile->lit->plan;
    const struct rectangle *at = &tile->at;
    double width = plan->view.width, height = plan->view.height;
    double near_w = plan->scene->camera.perspective ? plan->near : 1;
    double error = largest_e_clip(tile->lit, screen, CLIP_Z);
    double left = 2 * at->x / width - 1, right = 2 * (at->x + at->width) / width - 1;
    double top = 1 - 2 * at->y / height, bottom = 1 - 2 * (at->y + at->height) / height;
    planes[0] = (struct clip_plane){{-1, 0, 0, right}, 0};
    planes[1] = (struct clip_plane){{1, 0, 0, -left}, 0};
    planes[2] = (struct clip_plane){{0, -1, 0, top}, 0};
    planes[3] = (struct clip_plane){{0, 1, 0, -bottom}, 0};
    planes[4] = (struct clip_plane){{0, 0, 1, 1}, fmin(2 * error, 0.25 * near_w)};
    planes[5] = (struct clip_plane){{0, 0, -1, 1}, 2 * error};
}

/* Clips the whole triangle by these planes. */
static struct polygon clip_whole(const struct tile *tile, const struct screen_triangle *screen,
                                 const struct clip_plane planes[CLIP_PLANES])
{
    struct corner whole[3];
    struct polygon out = {.tile = tile, .screen = screen, .n = 3};
    whole_corners(screen->surface, screen->vertex, whole);
    for (int i = 0; i < 3; i++) {
        int corner = screen->clockwise ? i : (3 - i) % 3;
        const float *e_clip = vertex_bounds(tile->lit, screen, corner)->e_clip;
        out.corner[i] = whole[corner];
        out.cut[i] = (struct cut_corner){.whole = corner};
        for (int k = 0; k < 4; k++)
            out.cut[i].e[k] = (double)e_clip[k];
    }
    for (int p = 0; p < CLIP_PLANES && out.n > 0; p++)
        clip(&out, &planes[p], p);
    return out;
}

struct polygon polygon_of(const struct tile *tile, const struct screen_triangle *screen)
{
    struct clip_plane planes[CLIP_PLANES];
    clip_planes(tile, screen, planes);
    return clip_whole(tile, screen, planes);
}

struct polygon doubtful_polygon_of(const struct tile *tile, const struct screen_triangle *screen)
{
    struct clip_plane planes[CLIP_PLANES];
    bool any = false;
    clip_planes(tile, screen, planes);
    const struct polygon whole = clip_whole(tile, screen, planes);
    for (int p = 4; p < CLIP_PLANES; p++) {
        double deepest = 0, rounding;
        for (int i = 0; i < whole.n; i++) {
            const struct bounded from =
                corner_distance(&planes[p], whole.corner[i].clip, &whole.cut[i], &rounding);
            if ((whole.cut[i].planes >> p & 1) == 0 && from.value <= from.error)
                deepest = fmax(deepest, from.error);
        }
        planes[p].offset -= 2 * deepest; /* so that the corner is outside, whatever its error */
        any = any || deepest > 0;
    }
    return any ? clip_whole(tile, screen, planes) : (struct polygon){.n = 0};
}

/* ---- bounds of corners ---- */

/* The slack of a corner whose clip coordinates have these errors. A tile's clip space is shifted
 * against the picture's by at most w. */
static struct slack corner_slack(const struct plan *plan, const double clip[4], const double e[4])
{
    struct bounded bounded[4];
    for (int i = 0; i < 4; i++)
        bounded[i] = (struct bounded){clip[i], e[i] + (i < CLIP_Z && plan->tiled ? e[CLIP_W] : 0)};
    return window_slack(bounded, 0.5 * plan->view.width, 0.5 * plan->view.height);
}

struct slack polygon_slack(const struct polygon *polygon, int i)
{
    const struct cut_corner *cut = &polygon->cut[i];
    const struct lit_scene *lit = polygon->tile->lit;
    return cut->whole >= 0 ? whole_slack(lit, polygon->screen, cut->whole)
                           : corner_slack(lit->plan, polygon->corner[i].clip, cut->e);
}

/* Bounds how far a corner slides in the window; HUGE_VAL: anywhere. */
static double slide_px(const struct view *view, const double clip[4], const struct cut_corner *cut)
{
    const double half[2] = {0.5 * view->width, 0.5 * view->height};
    double sums[2] = {0, 0}, of_w = 0;
    for (int v = 0; v < cut->n_slides && v < SLIDES; v++) {
        const double *slide = cut->slides[v];
        for (int i = 0; i < 2; i++)
            sums[i] += fabs(slide[i] - clip[i] / clip[3] * slide[3]);
        of_w += fabs(slide[3]);
    }
    return cut->n_slides <= SLIDES && of_w < clip[3]
               ? fmax(half[0] * sums[0], half[1] * sums[1]) / (clip[3] - of_w)
               : HUGE_VAL;
}

/* A corner of the tile, made by a side and by the top or the bottom, is fixed by both, however far
 * the triangle's corners are off. */
double moved_px(const struct polygon *polygon, int i)
{
    const struct plan *plan = polygon->tile->lit->plan;
    const struct cut_corner *cut = &polygon->cut[i];
    const double *clip = polygon->corner[i].clip, off[4] = {cut->off, cut->off, 0, 0};
    if (cut->whole < 0 && (cut->planes & 3) != 0 && (cut->planes & 12) != 0)
        return corner_slack(plan, clip, off).px;
    return polygon_slack(polygon, i).px + slide_px(&plan->view, clip, cut);
}
