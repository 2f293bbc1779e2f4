/* SPDX-License-Identifier: MIT */
/* A triangle as it lies in a tile: the reference's, cut where single precision may cut it, with the
 * bounds that hold for all of it; and the triangles that OpenGL sets up for it. */
#include <math.h>
#include <string.h>

#include "data/maths/maths.h"
#include "raster/candidates/inside.h"
#include "raster/renderers/renderers.h"

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

static void widen(struct slack *to, struct slack by)
{
    to->px = fmax(to->px, by.px);
    to->depth = fmax(to->depth, by.depth);
    to->w = fmax(to->w, by.w);
}

/* ---- triangles that OpenGL sets up ---- */

/* True if all corners lie on the driver's grid, without any error. Corners of cuts do not. */
static bool is_exact(const struct lit_scene *lit, const struct bounded_triangle *triangle)
{
    bool exact = lit->driver->fill_rule != FILL_ANY && !triangle->straddles;
    for (int i = 0; i < 3; i++)
        exact = exact && vertex_bounds(lit, &triangle->screen, i)->exact;
    return exact;
}

/* OpenGL's origin may be the tile's upper or its lower left corner, of a driver that is not known
 * any corner. A pixel lies beside the triangle by less than 1. */
static void set_reach(const struct tile *tile, struct clipped_triangle *out)
{
    const struct rectangle *at = &tile->at;
    double right = most_of(out->x) - at->x, below = most_of(out->y) - at->y,
           above = at->y + at->height - least_of(out->y),
           left = tile->lit->driver->left_origin ? 0 : at->x + at->width - least_of(out->x);
    out->reach_x = fmin(fmax(right, left), at->width) + 1;
    out->reach_y = fmin(fmax(below, above), at->height) + 1;
}

/* The error with which OpenGL follows an edge in a tile. */
static double tile_edge_error(const struct tile *tile)
{
    return edge_error(tile->lit->driver, tile->at.width, tile->at.height);
}

static struct clipped_triangle clipped(const struct tile *tile, const struct bounded_triangle *from,
                                       const double slack_px[3], const double moved[3])
{
    const struct driver *driver = tile->lit->driver;
    struct clipped_triangle out = {.grid_px = tile_edge_error(tile),
                                   .value_roundings = driver->value_roundings,
                                   .slack = from->slack};
    memcpy(out.x, from->screen.x, sizeof out.x);
    memcpy(out.y, from->screen.y, sizeof out.y);
    memcpy(out.z, from->screen.z, sizeof out.z);
    memcpy(out.inverse_w, from->screen.inverse_w, sizeof out.inverse_w);
    memcpy(out.share, from->screen.share, sizeof out.share);
    for (int i = 0; i < 3; i++) {
        out.slack_px[i] = slack_px[i] + driver->corner_px;
        out.moved_px[i] = moved[i] + driver->corner_px;
    }
    set_reach(tile, &out);
    bound_inverse_w(&out);
    return out;
}

/* Sets up one triangle of the fan of a polygon, from corners 0, i - 1 and i. */
static struct clipped_triangle fan_triangle(const struct bounded_triangle *of,
                                            const struct polygon *polygon, int i)
{
    const int corners[3] = {0, i - 1, i};
    struct bounded_triangle part = *of;
    double slack_px[3], moved[3];
    int cuts = 0;
    for (int c = 0; c < 3; c++) {
        screen_corner(&polygon->tile->lit->plan->view, &polygon->corner[corners[c]], c,
                      &part.screen);
        slack_px[c] = polygon_slack(polygon, corners[c]).px;
        moved[c] = moved_px(polygon, corners[c]);
        if (polygon->cut[corners[c]].cuts > cuts)
            cuts = polygon->cut[corners[c]].cuts;
    }
    struct clipped_triangle out = clipped(polygon->tile, &part, slack_px, moved);
    out.cuts = cuts;
    return out;
}

/* Sets up what OpenGL makes besides if it cuts a corner in doubt, but only what is too thin for a
 * bound: the rest is as the triangles that it makes otherwise. Returns how many. */
static int set_up_slivers(const struct tile *tile, const struct bounded_triangle *triangle,
                          struct clipped_triangle *out)
{
    const struct polygon polygon = doubtful_polygon_of(tile, &triangle->screen);
    int n = 0;
    for (int i = 2; i < polygon.n; i++) {
        out[n] = fan_triangle(triangle, &polygon, i);
        n += !(out[n].magnification < HUGE_VAL);
    }
    return n;
}

/* Sets up the triangles that clipping at the tile's border and in depth makes. Where hardly
 * anything of the triangle is in the tile, it has no bound. */
static int clip_to_tile(const struct tile *tile, const struct bounded_triangle *triangle,
                        struct clipped_triangle *out)
{
    const struct polygon polygon = polygon_of(tile, &triangle->screen);
    struct bounded_triangle part = *triangle;
    part.slack = (struct slack){0, 0, 0};
    for (int i = 0; i < polygon.n; i++)
        widen(&part.slack, polygon_slack(&polygon, i));
    for (int i = 2; i < polygon.n; i++)
        out[i - 2] = fan_triangle(&part, &polygon, i);
    if (polygon.n >= 3)
        return polygon.n - 2;
    const double px = triangle->slack.px, slack_px[3] = {px, px, px};
    out[0] = clipped(tile, triangle, slack_px, slack_px);
    out[0].magnification = HUGE_VAL;
    return 1;
}

/* Sets up the triangles of a part; returns how many. */
static int set_up(const struct tile *tile, const struct bounded_triangle *triangle,
                  struct clipped_triangle *out)
{
    double slack_px[3];
    if (triangle->straddles)
        return clip_to_tile(tile, triangle, out);
    for (int i = 0; i < 3; i++)
        slack_px[i] = whole_slack(tile->lit, &triangle->screen, i).px;
    out[0] = clipped(tile, triangle, slack_px, slack_px);
    return 1;
}

/* The difference between a stored depth and the computed one, at most. */
static double depth_rounding(const struct driver *driver)
{
    return roundings(driver->depth_roundings);
}

/* Corners that are cut off lie nowhere for OpenGL; those that cutting makes are off by slack_px. */
static void set_edge_errors(const struct tile *tile, struct bounded_triangle *triangle)
{
    const bool exact = is_exact(tile->lit, triangle);
    for (int i = 0; i < 3; i++) {
        double slack = triangle->straddles ? triangle->slack.px
                                           : whole_slack(tile->lit, &triangle->screen, i).px;
        triangle->edge_px[i] = exact ? 0 : slack + tile_edge_error(tile);
    }
}

/* Sets up a part's triangles, and finds the bounds that hold for all of them but those too thin for
 * one. Where all are too thin, the depth has no bound. */
static void complete(const struct tile *tile, struct triangle_part *part)
{
    struct bounded_triangle *triangle = &part->bounded;
    double error = -1;
    triangle->n_clipped = set_up(tile, triangle, part->clipped);
    if (triangle->cut)
        triangle->n_slivers = set_up_slivers(tile, triangle, part->clipped + triangle->n_clipped);
    triangle->slack.px = 0; /* only the corners that OpenGL has in the tile count */
    for (int i = 0; i < triangle->n_clipped; i++) {
        const struct clipped_triangle *clipped = &part->clipped[i];
        triangle->slack.px = fmax(triangle->slack.px, most_of(clipped->slack_px));
        if (clipped->magnification < HUGE_VAL)
            error = fmax(error, clipped->magnification *
                                    bound_linear(clipped, clipped->z, clipped->slack.depth));
    }
    triangle->depth_error = error < 0 ? HUGE_VAL : error + depth_rounding(tile->lit->driver);
    set_edge_errors(tile, triangle);
    triangle->edge_on = may_turn(&triangle->screen, triangle->edge_px);
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

static bool crosses_border(const struct tile *tile, const struct screen_triangle *screen)
{
    const struct rectangle *at = &tile->at;
    for (int i = 0; i < 3; i++) {
        const struct window_vertex *v = &screen->surface->vertices[screen->vertex[i]];
        double slack = whole_slack(tile->lit, screen, i).px;
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
    int n = screen_triangles(&tile->lit->plan->view, whole->surface, whole->triangle, planes + 4,
                             cut ? 2 : 0, parts);
    for (int i = 0; i < n; i++) {
        struct bounded_triangle *triangle = &out[i].bounded;
        *triangle = (struct bounded_triangle){.screen = parts[i], .cut = cut};
        triangle->straddles = cut || crosses_border(tile, whole);
        for (int v = 0; v < 3 && !cut; v++)
            widen(&triangle->slack, whole_slack(tile->lit, whole, v));
        complete(tile, &out[i]);
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

int triangle_parts(const struct tile *tile, int surface, int triangle, const struct rectangle *rows,
                   struct triangle_part out[TRIANGLE_PARTS])
{
    const struct surface *of = &tile->lit->surfaces[surface];
    struct screen_triangle whole = {.surface = of, .triangle = triangle};
    memcpy(whole.vertex, of->instance->triangles[triangle], sizeof whole.vertex);
    if (is_beside(of, &tile->lit->bounds[surface], whole.vertex, rows))
        return 0;
    return add_other_sides(of, place_parts(tile, &whole, out), out);
}
