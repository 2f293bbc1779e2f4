/* SPDX-License-Identifier: MIT */
/* A triangle as it lies in a tile: the reference's, cut where single precision may cut it, with the
 * bounds that hold for all of it; and the triangles that OpenGL sets up for it, whose corners
 * clipping makes, with the errors that it makes. */
#include <math.h>
#include <string.h>

#include "raster/candidates/inside.h"

/* ---- corners of the triangle ---- */

static const struct vertex_bounds *vertex_bounds(const struct lit_scene *lit,
                                                 const struct screen_triangle *screen, int corner)
{
    return &bounds_of(lit, screen)->vertices[screen->vertex[corner]];
}

/* ---- cuts ---- */

/* A corner of a polygon. OpenGL's corner lies on the same edge of its triangle, but perhaps not at
 * the same place there: the cut depends on how far the ends of the edge are from the plane. Values
 * that are interpolated keep their plane when a corner slides in the plane of the triangle. */
enum { SLIDES = 31 }; /* a corner that five planes cut, one after the other */
struct cut_corner {
    double e[4];              /* of clip coordinates, off the plane of the triangle */
    double slides[SLIDES][4]; /* it may be off by any part, up to all, of each of these vectors */
    int n_slides;             /* SLIDES + 1: too many */
    double off;               /* distance from the planes that cut it */
    int planes;               /* those that cut it: bit i for plane i */
    int cuts;                 /* how many made it; 0: a corner of the triangle */
    int whole;                /* 0..2: that corner; -1: it was made by a cut */
};
struct polygon {
    const struct tile *tile;
    const struct screen_triangle *screen; /* it is what is left of this one */
    int n;
    double least_part; /* the least part of its area that a triangle of OpenGL's fan has */
    bool slivers;      /* OpenGL may draw others, which are too thin for any bound */
    struct corner corner[CLIP_CORNERS];
    struct cut_corner cut[CLIP_CORNERS];
};

/* A corner's distance from a plane; negative: it lies outside. */
static double signed_distance(const struct clip_plane *plane, const double clip[4])
{
    const double *normal = plane->normal;
    return normal[0] * clip[0] + normal[1] * clip[1] + normal[2] * clip[2] + normal[3] * clip[3] +
           plane->offset;
}

/* Returns a corner's distance from a plane, with a bound on OpenGL's error in it: of the corner's
 * place, and of the sum of four products. A tile's clip space is shifted by at most w, which comes
 * into the sum. The offset is only ours. */
static struct bounded corner_distance(const struct clip_plane *plane, const double clip[4],
                                      const struct cut_corner *cut, double *rounding)
{
    struct bounded out = {fabs(signed_distance(plane, clip)), fabs(plane->offset)};
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

/* ---- bounds of corners ---- */

/* The bounds of any corner, off the plane of its triangle. */
static struct slack polygon_slack(const struct polygon *polygon, int i)
{
    const struct cut_corner *cut = &polygon->cut[i];
    const struct lit_scene *lit = polygon->tile->lit;
    return cut->whole >= 0 ? vertex_bounds(lit, polygon->screen, cut->whole)->slack
                           : clip_slack(lit->plan, polygon->corner[i].clip, cut->e);
}

/* Bounds how far a corner slides in the window, in x and in y; HUGE_VAL: anywhere. */
static void slide_px(const struct view *view, const double clip[4], const struct cut_corner *cut,
                     double out[2])
{
    const double half[2] = {0.5 * view->width, 0.5 * view->height};
    double sums[2] = {0, 0}, of_w = 0;
    for (int v = 0; v < cut->n_slides && v < SLIDES; v++) {
        const double *slide = cut->slides[v];
        for (int i = 0; i < 2; i++)
            sums[i] += fabs(slide[i] - clip[i] / clip[3] * slide[3]);
        of_w += fabs(slide[3]);
    }
    const bool bounded = cut->n_slides <= SLIDES && of_w < clip[3];
    for (int i = 0; i < 2; i++)
        out[i] = bounded ? half[i] * sums[i] / (clip[3] - of_w) : HUGE_VAL;
}

/* How far a corner may be from its place in the window, in the plane of its triangle, too: in x and
 * in y. A corner on the left or right side of the tile is fixed in x, one on the top or the bottom
 * in y, however far the triangle's corners are off. */
static void moved_px(const struct polygon *polygon, int i, double out[2])
{
    const struct view *view = &polygon->tile->lit->plan->view;
    const struct cut_corner *cut = &polygon->cut[i];
    const double *clip = polygon->corner[i].clip, slack = polygon_slack(polygon, i).px,
                 size[2] = {view->width, view->height};
    slide_px(view, clip, cut, out);
    for (int axis = 0; axis < 2; axis++)
        if (cut->whole < 0 && (cut->planes >> 2 * axis & 3) != 0)
            out[axis] = 0.5 * size[axis] * (cut->off / clip[3] + roundings(8));
        else
            out[axis] += slack;
}

/* ---- clipping ---- */

/* True if OpenGL moves every place within the error of a corner to the same point of its grid, so
 * that a triangle with two such corners has no area, and is not drawn. */
static bool is_one_point(const struct polygon *polygon, int i)
{
    enum { GRID = 256 };
    const struct lit_scene *lit = polygon->tile->lit;
    const double slack = polygon_slack(polygon, i).px * GRID;
    struct screen_triangle at;
    screen_corner(&lit->plan->view, &polygon->corner[i], 0, &at);
    return lit->driver->fill_rule != FILL_ANY &&
           fabs(at.x[0] * GRID - nearbyint(at.x[0] * GRID)) < 0.5 - slack &&
           fabs(at.y[0] * GRID - nearbyint(at.y[0] * GRID)) < 0.5 - slack;
}

/* A corner that lies on a side of the tile, within its error, may be cut off by OpenGL or not. What
 * is cut off is smaller than a rounding, and planes stay what they are; so it is kept, and the side
 * moved outwards by the largest such error. But the polygon's fan may then have other triangles.
 * One has two corners where this one was, and hardly any area: see is_one_point. If both ends of an
 * edge are in doubt, it may be cut anywhere: between its ends' distances d < 0 <= e from the side,
 * at d / (d - e) of its length. Distances are differences of two numbers about as large as w, and
 * so multiples of half a rounding of w: the cut leaves no smaller part of the edge than that over
 * the sum of the errors, or none. Ends at one distance, made of the same numbers, are cut off both
 * or neither. An error beyond half a pixel is none of rounding at the side: the corner slides. */
static void keep_doubtful(struct polygon *polygon, struct clip_plane *side)
{
    const struct rectangle *at = &polygon->tile->at;
    const struct view *view = &polygon->tile->lit->plan->view;
    const double unit =
        roundings(0.5) * fmin(1.0 * at->width / view->width, 1.0 * at->height / view->height);
    const double half_pixel = 1.0 / (view->width > view->height ? view->width : view->height);
    const int axis = side->normal[CLIP_X] != 0 ? CLIP_X : CLIP_Y;
    double deepest = 0, rounding;
    const double *before = NULL; /* the corner before, where it is in doubt */
    for (int i = 0; i <= polygon->n && polygon->n > 0; i++) {
        const int c = i % polygon->n;
        const double *clip = polygon->corner[c].clip;
        const struct bounded away = corner_distance(side, clip, &polygon->cut[c], &rounding);
        const bool doubtful = away.value <= away.error && away.error <= half_pixel * clip[CLIP_W];
        if (doubtful) {
            deepest = fmax(deepest, away.error);
            polygon->slivers = polygon->slivers || !is_one_point(polygon, c);
        }
        if (doubtful && before && (clip[axis] != before[axis] || clip[CLIP_W] != before[CLIP_W]))
            polygon->least_part = fmin(polygon->least_part, unit * clip[CLIP_W] / (2 * deepest));
        before = doubtful ? clip : NULL;
    }
    side->offset += deepest;
}

/* Returns whether all corners lie inside a plane, whatever their errors: it cuts nothing. */
static bool is_inside(const struct polygon *polygon, const struct clip_plane *plane)
{
    for (int i = 0; i < polygon->n; i++) {
        const double *at = polygon->corner[i].clip;
        double rounding;
        if (!(signed_distance(plane, at) >
              corner_distance(plane, at, &polygon->cut[i], &rounding).error))
            return false;
    }
    return true;
}

/* Cuts by plane number p. */
static void clip(struct polygon *polygon, struct clip_plane plane, int p)
{
    if (is_inside(polygon, &plane))
        return;
    const struct polygon from = *polygon;
    if (p < 4)
        keep_doubtful(polygon, &plane);
    polygon->n = clip_polygon(&plane, from.corner, from.n, polygon->corner);
    for (int i = 0; i < polygon->n; i++) {
        int inner = polygon->corner[i].inner, outer = polygon->corner[i].outer;
        polygon->cut[i] = from.cut[inner];
        if (inner == outer)
            continue;
        polygon->cut[i] = cut_edge(&plane, &from, inner, outer, polygon->corner[i].clip);
        polygon->cut[i].planes |= 1 << p;
    }
}

/* Finds the planes in Mesa's order: right, left, top, bottom of the tile, then near, far. The last
 * two are widened by what single precision may be off there, so that no possible pixel is lost;
 * near not so far that w = 0 comes in. That limit loses no pixel: see check_near in vertex.c. */
static void clip_planes(const struct tile *tile, const struct screen_triangle *screen,
                        struct clip_plane planes[CLIP_PLANES])
{
    const struct plan *plan = tile->lit->plan;
    const struct rectangle *at = &tile->at;
    double width = plan->view.width, height = plan->view.height;
    double near_w = plan->scene->camera.perspective ? plan->near : 1;
    double error = 0; /* the largest of any corner's z */
    for (int i = 0; i < 3; i++)
        error = fmax(error, (double)vertex_bounds(tile->lit, screen, i)->e_clip[CLIP_Z]);
    double left = 2 * at->x / width - 1, right = 2 * (at->x + at->width) / width - 1;
    double top = 1 - 2 * at->y / height, bottom = 1 - 2 * (at->y + at->height) / height;
    planes[0] = (struct clip_plane){{-1, 0, 0, right}, 0};
    planes[1] = (struct clip_plane){{1, 0, 0, -left}, 0};
    planes[2] = (struct clip_plane){{0, -1, 0, top}, 0};
    planes[3] = (struct clip_plane){{0, 1, 0, -bottom}, 0};
    planes[4] = (struct clip_plane){{0, 0, 1, 1}, fmin(2 * error, 0.25 * near_w)};
    planes[5] = (struct clip_plane){{0, 0, -1, 1}, 2 * error};
}

/* Clips the whole triangle by these planes. Its corners come in the order in which OpenGL gets
 * them, which decides how it fans the polygon. */
static struct polygon clip_whole(const struct tile *tile, const struct screen_triangle *screen,
                                 const struct clip_plane planes[CLIP_PLANES])
{
    struct corner whole[3];
    struct polygon out = {.tile = tile, .screen = screen, .n = 3, .least_part = 1};
    whole_corners(screen->surface, screen->vertex, whole);
    for (int i = 0; i < 3; i++) {
        int corner = screen->clockwise ? i : (3 - i) % 3;
        const float *e_clip = vertex_bounds(tile->lit, screen, corner)->e_clip;
        out.corner[i] = whole[corner];
        out.cut[i] = (struct cut_corner){.whole = corner};
        for (int k = 0; k < 4; k++)
            out.cut[i].e[k] = (double)e_clip[k];
    }
    for (int p = 0; p < (tile->lit->are_volumes ? 4 : CLIP_PLANES) && out.n > 0; p++)
        clip(&out, planes[p], p);
    for (int i = 0; i < out.n; i++)
        if (!(out.corner[i].clip[CLIP_W] > 0)) /* the eye's plane, where nothing has a bound */
            out.n = 0;
    return out;
}

/* Clips deeper by the near and the far plane where a corner lies so near to one of them that OpenGL
 * may cut it off. n is 0 where there is no such corner. */
static struct polygon doubtful_polygon_of(const struct tile *tile,
                                          const struct screen_triangle *screen,
                                          const struct clip_plane from[CLIP_PLANES])
{
    const struct polygon whole = clip_whole(tile, screen, from);
    struct clip_plane planes[CLIP_PLANES];
    bool any = false;
    memcpy(planes, from, sizeof planes);
    for (int p = 4; p < CLIP_PLANES; p++) {
        double deepest = 0, rounding;
        for (int i = 0; i < whole.n; i++) {
            const struct bounded at =
                corner_distance(&planes[p], whole.corner[i].clip, &whole.cut[i], &rounding);
            if ((whole.cut[i].planes >> p & 1) == 0 && at.value <= at.error)
                deepest = fmax(deepest, at.error);
        }
        planes[p].offset -= 2 * deepest; /* so that the corner is outside, whatever its error */
        any = any || deepest > 0;
    }
    return any ? clip_whole(tile, screen, planes) : (struct polygon){.n = 0};
}

/* ---- triangles in a tile ---- */

/* True where nothing of a triangle in front of the eye reaches a pixel centre of the rows. Centres
 * lie half a pixel inside, so that slack below that is of no matter. */
static bool is_beside(const struct surface *surface, const struct surface_bounds *bounds,
                      const int32_t vertex[3], const struct rectangle *rows)
{
    int beside = ~0;
    for (int i = 0; i < 3; i++)
        beside &=
            outcode(&surface->vertices[vertex[i]], rows, bounds->vertices[vertex[i]].slack.px);
    return beside != 0;
}

static void widen(struct slack *to, struct slack by)
{
    to->px = fmax(to->px, by.px);
    to->depth = fmax(to->depth, by.depth);
    to->w = fmax(to->w, by.w);
}

/* ---- triangles that OpenGL sets up ---- */

static void set_edge_error(struct edge_errors *out, int corner, int axis, double px)
{
    out->px[corner][axis] = px;
    out->most[axis] = fmax(out->most[axis], px);
}

/* Sets up a triangle. OpenGL's origin may be the tile's upper or its lower left corner, of a driver
 * that is not known any corner. A pixel lies beside the triangle by less than 1. */
static struct clipped_triangle clipped(const struct tile *tile, const struct bounded_triangle *from,
                                       const double slack_px[3], double moved[3][2],
                                       double least_part)
{
    const struct driver *driver = tile->lit->driver;
    const struct rectangle *at = &tile->at;
    const double right = most_of(from->screen.x) - at->x, below = most_of(from->screen.y) - at->y,
                 above = at->y + at->height - least_of(from->screen.y),
                 left = driver->left_origin ? 0 : at->x + at->width - least_of(from->screen.x);
    struct clipped_triangle out = {.screen = from->screen,
                                   .grid_px = edge_error(driver, at->width, at->height),
                                   .value_roundings = driver->value_roundings,
                                   .slack = from->slack,
                                   .least_part = least_part,
                                   .reach_x = fmin(fmax(right, left), at->width) + 1,
                                   .reach_y = fmin(fmax(below, above), at->height) + 1};
    for (int i = 0; i < 3; i++) {
        out.slack_px[i] = slack_px[i] + driver->corner_px;
        for (int axis = 0; axis < 2; axis++) {
            out.moved_px[i][axis] = moved[i][axis] + driver->corner_px;
            set_edge_error(&out.edges, i, axis, out.moved_px[i][axis] + out.grid_px);
        }
    }
    bound_inverse_w(&out);
    return out;
}

/* Sets up one triangle of the fan of a polygon, from corners 0, i - 1 and i. */
static struct clipped_triangle fan_triangle(const struct bounded_triangle *of,
                                            const struct polygon *polygon, int i)
{
    const int corners[3] = {0, i - 1, i};
    struct bounded_triangle part = *of;
    double slack_px[3], moved[3][2];
    int cuts = 0;
    for (int c = 0; c < 3; c++) {
        screen_corner(&polygon->tile->lit->plan->view, &polygon->corner[corners[c]], c,
                      &part.screen);
        slack_px[c] = polygon_slack(polygon, corners[c]).px;
        moved_px(polygon, corners[c], moved[c]);
        if (polygon->cut[corners[c]].cuts > cuts)
            cuts = polygon->cut[corners[c]].cuts;
    }
    struct clipped_triangle out =
        clipped(polygon->tile, &part, slack_px, moved, polygon->least_part);
    out.cuts = cuts;
    return out;
}

/* Sets up what OpenGL makes besides if it cuts a corner in doubt, but only what is too thin for a
 * bound: the rest is as the triangles that it makes otherwise. Returns how many. */
static int set_up_slivers(const struct tile *tile, const struct bounded_triangle *triangle,
                          const struct clip_plane planes[CLIP_PLANES], struct clipped_triangle *out)
{
    const struct polygon polygon = doubtful_polygon_of(tile, &triangle->screen, planes);
    int n = 0;
    for (int i = 2; i < polygon.n; i++) {
        out[n] = fan_triangle(triangle, &polygon, i);
        n += !(out[n].magnification < HUGE_VAL);
    }
    return n;
}

/* Sets up the triangles that clipping at the tile's border and in depth makes. Returns how many. */
static int clip_to_tile(const struct tile *tile, struct bounded_triangle *triangle,
                        const struct clip_plane planes[CLIP_PLANES], struct clipped_triangle *out)
{
    const struct polygon polygon = clip_whole(tile, &triangle->screen, planes);
    struct bounded_triangle part = *triangle;
    part.slack = (struct slack){0, 0, 0};
    for (int i = 0; i < polygon.n; i++)
        widen(&part.slack, polygon_slack(&polygon, i));
    for (int i = 2; i < polygon.n; i++)
        out[i - 2] = fan_triangle(&part, &polygon, i);
    triangle->slides = polygon.least_part < 1;
    triangle->slivers = polygon.slivers;
    return polygon.n < 3 ? 0 : polygon.n - 2;
}

static double corner_slack_px(const struct tile *tile, const struct bounded_triangle *triangle,
                              int i)
{
    return triangle->straddles ? triangle->slack.px
                               : vertex_bounds(tile->lit, &triangle->screen, i)->slack.px;
}

/* Sets up the triangles of a part; returns how many. Where hardly anything of a clipped triangle is
 * in the tile, it has no bound. */
static int set_up(const struct tile *tile, struct bounded_triangle *triangle,
                  const struct clip_plane planes[CLIP_PLANES], struct clipped_triangle *out)
{
    const int n = triangle->straddles ? clip_to_tile(tile, triangle, planes, out) : 0;
    double slack_px[3], moved[3][2];
    if (n > 0)
        return n;
    for (int i = 0; i < 3; i++)
        slack_px[i] = moved[i][0] = moved[i][1] = corner_slack_px(tile, triangle, i);
    out[0] = clipped(tile, triangle, slack_px, moved, 1);
    if (triangle->straddles)
        out[0].magnification = HUGE_VAL;
    return 1;
}

/* Corners that are cut off lie nowhere for OpenGL; those that cutting makes are off by slack_px. */
static void set_edge_errors(const struct tile *tile, struct bounded_triangle *triangle)
{
    const struct lit_scene *lit = tile->lit;
    /* all corners lie on the driver's grid, without any error; those of cuts do not */
    bool exact = lit->driver->fill_rule != FILL_ANY && !triangle->straddles;
    const double grid_px = edge_error(lit->driver, tile->at.width, tile->at.height);
    double e[3];
    for (int i = 0; i < 3; i++)
        exact = exact && vertex_bounds(lit, &triangle->screen, i)->exact;
    for (int i = 0; i < 3; i++) {
        e[i] = exact ? 0 : corner_slack_px(tile, triangle, i) + grid_px;
        set_edge_error(&triangle->edges, i, 0, e[i]);
        set_edge_error(&triangle->edges, i, 1, e[i]);
    }
    triangle->edge_on = may_turn(&triangle->screen, e);
}

/* Sets up a part's triangles, and finds the bounds that hold for all of them but those too thin for
 * one. Where all are too thin, the depth has no bound. */
static void complete(const struct tile *tile, const struct clip_plane planes[CLIP_PLANES],
                     struct triangle_part *part)
{
    struct bounded_triangle *triangle = &part->bounded;
    double error = -1;
    triangle->n_clipped = set_up(tile, triangle, planes, part->clipped);
    if (triangle->cut)
        triangle->n_slivers =
            set_up_slivers(tile, triangle, planes, part->clipped + triangle->n_clipped);
    triangle->slack.px = 0; /* only the corners that OpenGL has in the tile count */
    for (int i = 0; i < triangle->n_clipped; i++) {
        const struct clipped_triangle *clipped = &part->clipped[i];
        triangle->slack.px = fmax(triangle->slack.px, most_of(clipped->slack_px));
        if (clipped->magnification < HUGE_VAL)
            error = fmax(error, clipped->magnification *
                                    bound_linear(clipped, clipped->screen.z, clipped->slack.depth));
    }
    triangle->depth_error =
        error < 0 ? HUGE_VAL : error + roundings(tile->lit->driver->depth_roundings);
    set_edge_errors(tile, triangle);
}

/* ---- the parts of a triangle ---- */

static bool crosses_depth(const struct lit_scene *lit, const struct screen_triangle *screen)
{
    for (int i = 0; i < 3; i++) {
        const struct window_vertex *vertex = &screen->surface->vertices[screen->vertex[i]];
        double slack =
            vertex_bounds(lit, screen, i)->slack.depth + roundings(lit->driver->depth_roundings);
        if (!(vertex->clip[3] > 0) || vertex->z < slack || vertex->z > 1 - slack)
            return true;
    }
    return false;
}

static bool crosses_border(const struct tile *tile, const struct screen_triangle *screen)
{
    const struct rectangle *at = &tile->at;
    for (int i = 0; i < 3; i++) {
        const struct window_vertex *v = &screen->surface->vertices[screen->vertex[i]];
        double slack = vertex_bounds(tile->lit, screen, i)->slack.px;
        if (v->x - slack < at->x || v->x + slack > at->x + at->width || v->y - slack < at->y ||
            v->y + slack > at->y + at->height)
            return true;
    }
    return false;
}

/* The whole triangle, or where it may be cut in depth the parts that the near and the far plane
 * leave, widened by what single precision may be off. */
static int place_parts(const struct tile *tile, const struct screen_triangle *whole,
                       struct triangle_part out[TRIANGLE_PARTS])
{
    struct screen_triangle parts[SCREEN_TRIANGLES];
    struct clip_plane planes[CLIP_PLANES];
    const bool cut = crosses_depth(tile->lit, whole);
    clip_planes(tile, whole, planes);
    const int n_cuts = !cut                     ? 0
                       : tile->lit->are_volumes ? 1
                                                : 2; /* what lies behind the far plane counts */
    int n = screen_triangles(&tile->lit->plan->view, whole->surface, whole->triangle, planes + 4,
                             n_cuts, parts);
    for (int i = 0; i < n; i++) {
        struct bounded_triangle *triangle = &out[i].bounded;
        *triangle =
            (struct bounded_triangle){.screen = parts[i], .cut = cut && !tile->lit->are_volumes};
        triangle->straddles = cut || crosses_border(tile, whole);
        for (int v = 0; v < 3 && !cut; v++)
            widen(&triangle->slack, vertex_bounds(tile->lit, whole, v)->slack);
        complete(tile, planes, &out[i]);
    }
    return n;
}

int triangle_parts(const struct tile *tile, int surface, int triangle, const struct rectangle *rows,
                   struct triangle_part out[TRIANGLE_PARTS])
{
    const struct surface *of = &tile->lit->surfaces[surface];
    struct screen_triangle whole = {.surface = of, .triangle = triangle};
    memcpy(whole.vertex, of->instance->triangles[triangle], sizeof whole.vertex);
    if (is_beside(of, &tile->lit->bounds[surface], whole.vertex, rows))
        return 0;
    const int n = place_parts(tile, &whole, out);
    int n_out = n;
    for (int i = 0; i < n && of->n_sides == 2; i++)
        if (out[i].bounded.edge_on) { /* it may show its other side as well */
            struct bounded_triangle *other = &out[n_out].bounded;
            out[n_out++] = out[i];
            other->other_side = true;
            other->screen.side = !other->screen.side;
        }
    return n_out;
}
