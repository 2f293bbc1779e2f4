/* SPDX-License-Identifier: MIT */
/* A triangle as it lies in a tile: the reference's, cut where single precision may cut it, with the
 * bounds that hold for all of it; and the triangles that OpenGL sets up for it. */
#include <math.h>
#include <string.h>

#include "raster/bounds/bounds.h"

/* Cutting an edge in single precision: weight and sum round three times, relative to both ends. */
enum { CUT_ROUNDINGS = 3 };

const struct surface_bounds *bounds_of(const struct lit_scene *lit,
                                       const struct screen_triangle *screen)
{
    return &lit->bounds[screen->surface - lit->surfaces];
}

static const struct vertex_bounds *vertex_bounds(const struct lit_scene *lit,
                                                 const struct screen_triangle *screen, int corner)
{
    return &bounds_of(lit, screen)->vertices[screen->vertex[corner]];
}

static struct slack whole_slack(const struct lit_scene *lit, const struct screen_triangle *screen,
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

/* True where nothing of a triangle in front of the eye reaches a pixel centre of the rows. Centres
 * lie half a pixel inside, so that slack below that is of no matter. */
static bool is_beside(const struct surface *surface, const struct surface_bounds *bounds,
                      const int32_t vertex[3], const struct rectangle *rows)
{
    int beside = ~0;
    for (int i = 0; i < 3; i++)
        beside &= outcode(&surface->vertices[vertex[i]], rows,
                          (double)bounds->vertices[vertex[i]].slack_px);
    return beside != 0;
}

/* ---- clipping, with the errors that it makes ---- */

/* Corners of a polygon, and bounds on OpenGL's errors in their clip coordinates from cutting. */
struct polygon {
    int n;
    struct corner corner[CLIP_CORNERS];
    int whole[CLIP_CORNERS];       /* 0..2: this corner of the triangle; -1: made by a cut */
    double e_cut[CLIP_CORNERS][3]; /* CLIP_XY, CLIP_Z, CLIP_W */
};

/* A cut adds its own error to the larger one of the ends of its edge. */
static void clip(struct polygon *polygon, const struct clip_plane *plane)
{
    const struct polygon from = *polygon;
    polygon->n = clip_polygon(plane, from.corner, from.n, polygon->corner);
    for (int i = 0; i < polygon->n; i++) {
        int inner = polygon->corner[i].inner, outer = polygon->corner[i].outer;
        const double *a = from.corner[inner].clip, *b = from.corner[outer].clip;
        polygon->whole[i] = inner == outer ? from.whole[inner] : -1;
        const double sums[3] = {[CLIP_XY] = fmax(fabs(a[0]) + fabs(b[0]), fabs(a[1]) + fabs(b[1])),
                                [CLIP_Z] = fabs(a[2]) + fabs(b[2]),
                                [CLIP_W] = fabs(a[3]) + fabs(b[3])};
        for (int k = 0; k < 3; k++)
            polygon->e_cut[i][k] = fmax(from.e_cut[inner][k], from.e_cut[outer][k]) +
                                   (inner == outer ? 0 : roundings(CUT_ROUNDINGS) * sums[k]);
    }
}

/* The planes in Mesa's order: right, left, top, bottom of the tile, then near, far. The last two
 * are widened by what single precision may be off there, so that no possible pixel is lost; near
 * not so far that w = 0 comes in. That limit loses no pixel: see check_near in vertex.c. */
static void planes_of(const struct lit_scene *lit, const struct screen_triangle *screen,
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

/* Clips the whole triangle by all planes. Its corners come in the order in which OpenGL gets
 * them, which decides how it fans the polygon. */
static struct polygon polygon_of(const struct lit_scene *lit, const struct screen_triangle *screen,
                                 const struct rectangle *tile)
{
    struct clip_plane planes[CLIP_PLANES];
    struct corner whole[3];
    struct polygon out = {.n = 3};
    whole_corners(screen->surface, screen->vertex, whole);
    for (int i = 0; i < 3; i++) {
        out.whole[i] = screen->clockwise ? i : (3 - i) % 3;
        out.corner[i] = whole[out.whole[i]];
    }
    planes_of(lit, screen, tile, planes);
    for (int p = 0; p < CLIP_PLANES && out.n > 0; p++)
        clip(&out, &planes[p]);
    return out;
}

/* ---- bounds of corners ---- */

/* A cut adds its own error to those of the whole corners, in clip coordinates. A tile's clip space
 * is shifted against the picture's by at most w. */
static struct slack slack_of(const struct lit_scene *lit, const struct screen_triangle *screen,
                             const struct polygon *polygon, int i)
{
    const double half = 0.5 * fmax(lit->plan->scene->width, lit->plan->scene->height);
    const double *clip = polygon->corner[i].clip, *e_cut = polygon->e_cut[i];
    const double shift = lit->plan->tiled, w = clip[3];
    double e[3];
    if (polygon->whole[i] >= 0)
        return whole_slack(lit, screen, polygon->whole[i]);
    for (int k = 0; k < 3; k++)
        e[k] = largest_e_clip(lit, screen, k) + e_cut[k];
    const double e_xy = e[CLIP_XY] + shift * (e_cut[CLIP_W] + e[CLIP_W]);
    const struct bounded xy = {fmax(fabs(clip[0]), fabs(clip[1])), e_xy};
    const struct bounded bounded[4] = {xy, xy, {w, e[CLIP_Z]}, {w, e[CLIP_W]}}; /* |z| <= w */
    return window_slack(bounded, half, half);
}

static void widen(struct slack *to, struct slack by)
{
    to->px = fmax(to->px, by.px);
    to->depth = fmax(to->depth, by.depth);
    to->w = fmax(to->w, by.w);
}

/* True if OpenGL may take the front for the back: moving a corner by e in x and y changes twice the
 * area by at most e times the 1-norm of the edge opposite, all together by 8 e^2 more. */
static bool is_edge_on(const struct bounded_triangle *triangle)
{
    const double *x = triangle->screen.x, *y = triangle->screen.y;
    double worst = most_of(triangle->edge_px), change = 8 * worst * worst;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        change += triangle->edge_px[i] * (fabs(x[k] - x[j]) + fabs(y[k] - y[j]));
    }
    return triangle->screen.twice_area <= change;
}

/* ---- triangles that OpenGL sets up ---- */

/* The error with which OpenGL follows an edge. It may move the ends to its grid. */
static double edge_error(const struct driver *driver, const struct rectangle *tile)
{
    return driver->grid_px + roundings(driver->edge_roundings) * fmax(tile->width, tile->height);
}

/* True if all corners lie on the driver's grid, without any error. Corners of cuts do not. */
static bool is_exact(const struct lit_scene *lit, const struct bounded_triangle *triangle)
{
    bool exact = lit->driver->fill_rule != FILL_ANY && !triangle->straddles;
    for (int i = 0; i < 3; i++)
        exact = exact && vertex_bounds(lit, &triangle->screen, i)->exact;
    return exact;
}

static struct clipped_triangle clipped(const struct lit_scene *lit,
                                       const struct bounded_triangle *from,
                                       const struct rectangle *tile, const double slack_px[3])
{
    struct clipped_triangle out = {.grid_px = edge_error(lit->driver, tile),
                                   .slack = from->slack,
                                   .reach_x = tile->width + 1.0,
                                   .reach_y = tile->height + 1.0};
    memcpy(out.x, from->screen.x, sizeof out.x);
    memcpy(out.y, from->screen.y, sizeof out.y);
    memcpy(out.z, from->screen.z, sizeof out.z);
    memcpy(out.inverse_w, from->screen.inverse_w, sizeof out.inverse_w);
    memcpy(out.share, from->screen.share, sizeof out.share);
    memcpy(out.slack_px, slack_px, sizeof out.slack_px);
    for (int i = 0; i < 3; i++)
        out.edge_px[i] = slack_px[i] + out.grid_px;
    bound_inverse_w(&out);
    return out;
}

/* Sets up the triangles that clipping at the tile's border and in depth makes. Where hardly
 * anything of the triangle is in the tile, it has no bound. */
static int clip_to_tile(const struct lit_scene *lit, const struct rectangle *tile,
                        const struct bounded_triangle *triangle,
                        struct clipped_triangle out[CLIP_CORNERS - 2])
{
    const struct screen_triangle *screen = &triangle->screen;
    struct polygon polygon = polygon_of(lit, screen, tile);
    struct bounded_triangle part = *triangle;
    double slacks[CLIP_CORNERS];
    part.slack = (struct slack){0, 0, 0};
    for (int i = 0; i < polygon.n; i++) {
        struct slack slack = slack_of(lit, screen, &polygon, i);
        slacks[i] = slack.px;
        widen(&part.slack, slack);
    }
    for (int i = 2; i < polygon.n; i++) {
        const int corners[3] = {0, i - 1, i};
        double slack_px[3];
        for (int c = 0; c < 3; c++) {
            screen_corner(&lit->plan->view, &polygon.corner[corners[c]], c, &part.screen);
            slack_px[c] = slacks[corners[c]];
        }
        out[i - 2] = clipped(lit, &part, tile, slack_px);
    }
    if (polygon.n >= 3)
        return polygon.n - 2;
    const double slack_px[3] = {triangle->slack.px, triangle->slack.px, triangle->slack.px};
    out[0] = clipped(lit, triangle, tile, slack_px);
    out[0].magnification = HUGE_VAL;
    return 1;
}

/* Sets up the triangles of a part; returns how many. */
static int set_up(const struct lit_scene *lit, const struct rectangle *tile,
                  const struct bounded_triangle *triangle,
                  struct clipped_triangle out[CLIP_CORNERS - 2])
{
    double slack_px[3];
    if (triangle->straddles)
        return clip_to_tile(lit, tile, triangle, out);
    for (int i = 0; i < 3; i++)
        slack_px[i] = whole_slack(lit, &triangle->screen, i).px;
    out[0] = clipped(lit, triangle, tile, slack_px);
    return 1;
}

/* The difference between a stored depth and the computed one, at most. */
static double depth_rounding(const struct driver *driver)
{
    return roundings(driver->depth_roundings);
}

/* Corners that are cut off lie nowhere for OpenGL; those that cutting makes are off by slack_px. */
static void set_edge_errors(const struct lit_scene *lit, const struct rectangle *tile,
                            struct bounded_triangle *triangle)
{
    bool exact = is_exact(lit, triangle);
    for (int i = 0; i < 3; i++) {
        double slack =
            triangle->straddles ? triangle->slack.px : whole_slack(lit, &triangle->screen, i).px;
        triangle->edge_px[i] = exact ? 0 : slack + edge_error(lit->driver, tile);
    }
}

/* Sets up a part's triangles, and finds the bounds that hold for all of them but those too thin for
 * one. Where all are too thin, the depth has no bound. */
static void complete(const struct lit_scene *lit, const struct rectangle *tile,
                     struct triangle_part *part)
{
    struct bounded_triangle *triangle = &part->bounded;
    double error = -1;
    triangle->n_clipped = set_up(lit, tile, triangle, part->clipped);
    triangle->slack.px = 0; /* only the corners that OpenGL has in the tile count */
    for (int i = 0; i < triangle->n_clipped; i++) {
        const struct clipped_triangle *clipped = &part->clipped[i];
        triangle->slack.px = fmax(triangle->slack.px, most_of(clipped->slack_px));
        if (clipped->magnification < HUGE_VAL)
            error = fmax(error, clipped->magnification *
                                    bound_linear(clipped, clipped->z, clipped->slack.depth));
    }
    triangle->depth_error = error < 0 ? HUGE_VAL : error + depth_rounding(lit->driver);
    set_edge_errors(lit, tile, triangle);
    triangle->edge_on = is_edge_on(triangle);
}

/* ---- the parts of a triangle ---- */

static bool crosses_depth(const struct lit_scene *lit, const struct screen_triangle *screen)
{
    for (int i = 0; i < 3; i++) {
        const struct window_vertex *vertex = &screen->surface->vertices[screen->vertex[i]];
        double slack = whole_slack(lit, screen, i).depth + depth_rounding(lit->driver);
        if (!(vertex->clip[3] > 0) || vertex->z < slack || vertex->z > 1 - slack)
            return true;
    }
    return false;
}

static bool crosses_border(const struct lit_scene *lit, const struct screen_triangle *screen,
                           const struct rectangle *tile)
{
    for (int i = 0; i < 3; i++) {
        const struct window_vertex *v = &screen->surface->vertices[screen->vertex[i]];
        double slack = whole_slack(lit, screen, i).px;
        if (v->x - slack < tile->x || v->x + slack > tile->x + tile->width ||
            v->y - slack < tile->y || v->y + slack > tile->y + tile->height)
            return true;
    }
    return false;
}

/* The whole triangle, or where it may be cut in depth the parts that the near and the far plane
 * leave, widened by what single precision may be off. */
static int place_parts(const struct lit_scene *lit, const struct rectangle *tile,
                       const struct screen_triangle *whole, bool cut,
                       struct triangle_part out[TRIANGLE_PARTS])
{
    struct screen_triangle parts[SCREEN_TRIANGLES];
    struct clip_plane planes[CLIP_PLANES];
    planes_of(lit, whole, tile, planes);
    int n = screen_triangles(&lit->plan->view, whole->surface, whole->triangle, planes + 4,
                             cut ? 2 : 0, parts);
    for (int i = 0; i < n; i++) {
        struct bounded_triangle *triangle = &out[i].bounded;
        *triangle = (struct bounded_triangle){.screen = parts[i], .cut = cut};
        triangle->straddles = cut || crosses_border(lit, whole, tile);
        for (int v = 0; v < 3 && !cut; v++)
            widen(&triangle->slack, whole_slack(lit, whole, v));
        complete(lit, tile, &out[i]);
    }
    return n;
}

/* Triangles seen edge-on may show their other side as well. */
static int add_other_sides(const struct surface *surface, int n,
                           struct triangle_part parts[TRIANGLE_PARTS])
{
    int n_out = n;
    for (int i = 0; i < n && surface->n_sides == 2; i++)
        if (parts[i].bounded.edge_on) {
            struct bounded_triangle *other = &parts[n_out].bounded;
            parts[n_out++] = parts[i];
            other->other_side = true;
            other->screen.side = !other->screen.side;
        }
    return n_out;
}

int triangle_parts(const struct lit_scene *lit, int surface, int triangle,
                   const struct rectangle *tile, const struct rectangle *rows,
                   struct triangle_part out[TRIANGLE_PARTS])
{
    const struct surface *of = &lit->surfaces[surface];
    struct screen_triangle whole = {.surface = of, .triangle = triangle};
    memcpy(whole.vertex, of->instance->triangles[triangle], sizeof whole.vertex);
    if (is_beside(of, &lit->bounds[surface], whole.vertex, rows))
        return 0;
    int n = place_parts(lit, tile, &whole, crosses_depth(lit, &whole), out);
    return add_other_sides(of, n, out);
}
