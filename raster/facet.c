/* SPDX-License-Identifier: MIT */
/* A triangle as it lies in a tile: in window coordinates, cut at the near and far plane where it
 * crosses them, with the bounds that hold for all of it. */
#include <math.h>
#include <string.h>

#include "coverage.h"

static const double u = 1.0 / 16777216;

static bool in_front(const struct surface *surface, const int32_t vertex[3])
{
    for (int i = 0; i < 3; i++)
        if (!(surface->vertices[vertex[i]].clip[3] > 0))
            return false;
    return true;
}

/* Nothing of a triangle in front of the eye reaches a pixel centre of the rows. Centres lie half a
 * pixel inside, so that slack below that is of no matter. */
static bool beside(const struct surface *surface, const int32_t vertex[3], const struct tile *rows)
{
    const struct lit_vertex *a = &surface->vertices[vertex[0]], *b = &surface->vertices[vertex[1]],
                            *c = &surface->vertices[vertex[2]];
    double slack = fmax((double)a->slack_px, fmax((double)b->slack_px, (double)c->slack_px));
    return fmax(a->x, fmax(b->x, c->x)) + slack < rows->x ||
           fmin(a->x, fmin(b->x, c->x)) - slack > rows->x + rows->width ||
           fmax(a->y, fmax(b->y, c->y)) + slack < rows->y ||
           fmin(a->y, fmin(b->y, c->y)) - slack > rows->y + rows->height;
}

/* The corners of a whole triangle in the order in which OpenGL gets them, which decides how it cuts
 * them into pieces. turned: they lie in vertex[] the other way round. */
static void whole_corners(const struct surface *surface, const int32_t vertex[3], bool turned,
                          struct corner out[3])
{
    for (int i = 0; i < 3; i++) {
        int whole = turned ? (3 - i) % 3 : i;
        out[i] = (struct corner){.whole = whole};
        memcpy(out[i].clip, surface->vertices[vertex[whole]].clip, sizeof out[i].clip);
        out[i].share[whole] = 1;
    }
}

/* The planes in Mesa's order: right, left, top, bottom of the tile, then near, far. The last two
 * are widened by what single precision may be off there, so that no possible pixel is lost; near
 * not so far that w = 0 comes in, which is of no matter: see check_near in surface.c. */
static void planes_of(const struct plan *plan, const struct surface *surface,
                      const int32_t vertex[3], const struct tile *tile,
                      struct clip_plane planes[CLIP_PLANES])
{
    double width = plan->scene->width, height = plan->scene->height, error = 0;
    double near_w = plan->scene->camera.perspective ? plan->near : 1;
    for (int i = 0; i < 3; i++)
        error = fmax(error, (double)surface->vertices[vertex[i]].e_clip[CLIP_Z]);
    double left = 2 * tile->x / width - 1, right = 2 * (tile->x + tile->width) / width - 1;
    double top = 1 - 2 * tile->y / height, bottom = 1 - 2 * (tile->y + tile->height) / height;
    planes[0] = (struct clip_plane){{-1, 0, 0, right}, 0};
    planes[1] = (struct clip_plane){{1, 0, 0, -left}, 0};
    planes[2] = (struct clip_plane){{0, -1, 0, top}, 0};
    planes[3] = (struct clip_plane){{0, 1, 0, -bottom}, 0};
    planes[4] = (struct clip_plane){{0, 0, 1, 1}, fmin(2 * error, 0.25 * near_w)};
    planes[5] = (struct clip_plane){{0, 0, -1, 1}, 2 * error};
}

/* ---- one facet ---- */

static void set_corner(const struct plan *plan, const struct surface *surface,
                       const struct corner *corner, int i, struct facet *out)
{
    memcpy(out->share[i], corner->share, sizeof corner->share);
    if (corner->whole >= 0) {
        const struct lit_vertex *vertex = &surface->vertices[out->vertex[corner->whole]];
        out->x[i] = vertex->x;
        out->y[i] = vertex->y;
        out->z[i] = vertex->z;
        out->inverse_w[i] = vertex->inverse_w;
        return;
    }
    double w = corner->clip[3];
    out->x[i] = (corner->clip[0] / w + 1) * 0.5 * plan->scene->width;
    out->y[i] = (1 - corner->clip[1] / w) * 0.5 * plan->scene->height;
    out->z[i] = (corner->clip[2] / w + 1) * 0.5;
    out->inverse_w[i] = 1 / w;
}

/* Bounds on OpenGL's errors in a corner's place, w and depth. */
struct slack {
    double px, w, depth;
};

/* A cut adds its own error to those of the whole corners, in clip coordinates. */
static struct slack slack_of(const struct plan *plan, const struct surface *surface,
                             const struct facet *facet, const struct corner *corner)
{
    if (corner->whole >= 0) {
        const struct lit_vertex *vertex = &surface->vertices[facet->vertex[corner->whole]];
        return (struct slack){(double)vertex->slack_px, (double)vertex->slack_w,
                              (double)vertex->slack_depth};
    }
    double half = 0.5 * fmax(plan->scene->width, plan->scene->height), w = corner->clip[3];
    double n = fmax(fabs(corner->clip[0]), fabs(corner->clip[1])) / w, e[3];
    for (int k = 0; k < 3; k++) {
        e[k] = 0;
        for (int i = 0; i < 3; i++)
            e[k] = fmax(e[k], (double)surface->vertices[facet->vertex[i]].e_clip[k]);
        e[k] += corner->cut_error[k];
    }
    /* a tile's clip space is shifted against the picture's by at most w */
    double shift = plan->tiled, e_xy = e[CLIP_XY] + shift * corner->cut_error[CLIP_W];
    return (struct slack){
        .px = half * ((e_xy + (n + shift) * e[CLIP_W]) / w + 8 * u),
        .w = e[CLIP_W] / w + 2 * u,
        .depth = 0.5 * (e[CLIP_Z] + e[CLIP_W]) / w + 4 * u /* |z| <= w */
    };
}

static void widen(struct facet *facet, const struct slack *slack)
{
    facet->slack_px = fmax(facet->slack_px, slack->px);
    facet->slack_w = fmax(facet->slack_w, slack->w);
    facet->slack_depth = fmax(facet->slack_depth, slack->depth);
}

/* True if the corners turned the other way, counter-clockwise with y upwards. */
static bool turn(struct facet *facet)
{
    double area = (facet->x[1] - facet->x[0]) * (facet->y[2] - facet->y[0]) -
                  (facet->x[2] - facet->x[0]) * (facet->y[1] - facet->y[0]);
    facet->twice_area = fabs(area);
    if (area >= 0)
        return false;
    struct facet old = *facet;
    static const int order[3] = {0, 2, 1};
    for (int i = 0; i < 3; i++) {
        facet->x[i] = old.x[order[i]];
        facet->y[i] = old.y[order[i]];
        facet->z[i] = old.z[order[i]];
        facet->inverse_w[i] = old.inverse_w[order[i]];
        facet->vertex[i] = old.vertex[order[i]];
        for (int j = 0; j < 3; j++)
            facet->share[i][j] = old.share[order[i]][order[j]];
    }
    return true;
}

/* Whether OpenGL may take the front for the back: moving a corner by e in x and y changes twice the
 * area by at most e times the 1-norm of the edge opposite, all together by 8 e^2 more. */
static bool is_edge_on(const struct facet *facet)
{
    double worst = most_of(facet->edge_px), change = 8 * worst * worst;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        change +=
            facet->edge_px[i] * (fabs(facet->x[k] - facet->x[j]) + fabs(facet->y[k] - facet->y[j]));
    }
    return facet->twice_area <= change;
}

/* ---- what OpenGL sets up ---- */

/* How far off OpenGL follows an edge, whose ends it may move to its grid. */
static double edge_error(const struct surface *surface, const struct tile *tile)
{
    const struct driver *driver = surface->driver;
    return driver->grid_px + driver->edge_roundings * u * fmax(tile->width, tile->height);
}

/* All corners lie on the driver's grid, without any error; one that was cut lies anywhere. */
static bool is_exact(const struct surface *surface, const struct facet *facet)
{
    bool exact = surface->driver->fill_rule != FILL_ANY && !facet->straddles;
    for (int i = 0; i < 3; i++)
        exact = exact && surface->vertices[facet->vertex[i]].exact;
    return exact;
}

static void set_piece(const struct surface *surface, const struct facet *from,
                      const struct tile *tile, const double slack_px[3], struct piece *out)
{
    out->outline = (struct outline){.grid_px = edge_error(surface, tile),
                                    .slack_w = from->slack_w,
                                    .reach_x = tile->width + 1.0,
                                    .reach_y = tile->height + 1.0};
    memcpy(out->outline.x, from->x, sizeof from->x);
    memcpy(out->outline.y, from->y, sizeof from->y);
    memcpy(out->outline.slack_px, slack_px, sizeof out->outline.slack_px);
    for (int i = 0; i < 3; i++)
        out->outline.edge_px[i] = slack_px[i] + out->outline.grid_px;
    memcpy(out->outline.inverse_w, from->inverse_w, sizeof from->inverse_w);
    out->slack_depth = from->slack_depth;
    memcpy(out->z, from->z, sizeof from->z);
    memcpy(out->share, from->share, sizeof from->share);
    out->magnification = bound_magnification(&out->outline);
    out->inverse_w_bound = bound_inverse_w(&out->outline);
    out->inverse_w_bound.fixed *= out->magnification;
    out->inverse_w_bound.per_d *= out->magnification;
}

int facet_pieces(const struct plan *plan, const struct surface *surfaces, const struct tile *tile,
                 const struct facet *facet, struct piece out[CLIP_CORNERS - 2])
{
    const struct surface *surface = &surfaces[facet->surface];
    if (!facet->straddles) {
        double slack_px[3];
        for (int i = 0; i < 3; i++)
            slack_px[i] = (double)surface->vertices[facet->vertex[i]].slack_px;
        set_piece(surface, facet, tile, slack_px, &out[0]);
        return 1;
    }
    struct corner whole[3], left[CLIP_CORNERS];
    struct clip_plane planes[CLIP_PLANES];
    whole_corners(surface, facet->vertex, !facet->clockwise, whole);
    planes_of(plan, surface, facet->vertex, tile, planes);
    int n = clip_triangle(whole, planes, CLIP_PLANES, left);
    struct facet part = *facet;
    part.slack_px = part.slack_w = part.slack_depth = 0;
    double slacks[CLIP_CORNERS];
    for (int i = 0; i < n; i++) {
        struct slack slack = slack_of(plan, surface, facet, &left[i]);
        slacks[i] = slack.px;
        widen(&part, &slack);
    }
    for (int i = 2; i < n; i++) {
        set_corner(plan, surface, &left[0], 0, &part);
        set_corner(plan, surface, &left[i - 1], 1, &part);
        set_corner(plan, surface, &left[i], 2, &part);
        const double slack_px[3] = {slacks[0], slacks[i - 1], slacks[i]};
        set_piece(surface, &part, tile, slack_px, &out[i - 2]);
    }
    if (n < 3) { /* hardly any of it is in the tile: nothing is known of it */
        double slack_px[3] = {facet->slack_px, facet->slack_px, facet->slack_px};
        set_piece(surface, facet, tile, slack_px, &out[0]);
        out[0].magnification = HUGE_VAL;
        return 1;
    }
    return n - 2;
}

/* How far a stored depth may be off from the one computed. */
static double depth_rounding(const struct surface *surface)
{
    return surface->driver->depth_roundings * u;
}

/* Corners that are cut off lie nowhere for OpenGL; those that cutting makes are off by slack_px. */
static void set_edge_errors(const struct surface *surface, const struct tile *tile,
                            struct facet *facet)
{
    bool exact = is_exact(surface, facet);
    for (int i = 0; i < 3; i++) {
        double slack = facet->straddles ? facet->slack_px
                                        : (double)surface->vertices[facet->vertex[i]].slack_px;
        facet->edge_px[i] = exact ? 0 : slack + edge_error(surface, tile);
    }
}

/* Bounds that hold for all pieces but those too thin for one, and the side that is seen. Where all
 * are too thin, the depth has no bound. */
static void finish_facet(const struct plan *plan, const struct surface *surfaces,
                         const struct tile *tile, struct facet *facet)
{
    struct piece pieces[CLIP_CORNERS - 2];
    const struct surface *surface = &surfaces[facet->surface];
    double error = -1;
    facet->clockwise = !turn(facet);
    facet->side = surface->n_sides == 2 && facet->clockwise != surface->body->mirrored;
    int n = facet_pieces(plan, surfaces, tile, facet, pieces);
    facet->slack_px = 0; /* what counts is the corners that OpenGL has in the tile */
    for (int i = 0; i < n; i++) {
        const struct piece *piece = &pieces[i];
        facet->slack_px = fmax(facet->slack_px, most_of(piece->outline.slack_px));
        if (piece->magnification < HUGE_VAL)
            error = fmax(error, piece->magnification *
                                    bound_linear(&piece->outline, piece->z, piece->slack_depth));
    }
    facet->depth_error = error < 0 ? HUGE_VAL : error + depth_rounding(surface);
    set_edge_errors(surface, tile, facet);
    facet->edge_on = is_edge_on(facet);
}

/* ---- a triangle's facets ---- */

static bool crosses_depth(const struct surface *surface, const int32_t vertex[3])
{
    for (int i = 0; i < 3; i++) {
        const struct lit_vertex *v = &surface->vertices[vertex[i]];
        double slack = (double)v->slack_depth + depth_rounding(surface);
        if (v->z < slack || v->z > 1 - slack)
            return true;
    }
    return false;
}

static bool crosses_border(const struct surface *surface, const int32_t vertex[3],
                           const struct tile *tile)
{
    for (int i = 0; i < 3; i++) {
        const struct lit_vertex *v = &surface->vertices[vertex[i]];
        double slack = (double)v->slack_px;
        if (v->x - slack < tile->x || v->x + slack > tile->x + tile->width ||
            v->y - slack < tile->y || v->y + slack > tile->y + tile->height)
            return true;
    }
    return false;
}

/* What the near and far planes leave, fanned from its first corner. */
static int depth_pieces(const struct plan *plan, const struct surface *surfaces,
                        const struct tile *tile, const struct facet *triangle,
                        struct facet out[FACETS_PER_TRIANGLE])
{
    const struct surface *surface = &surfaces[triangle->surface];
    struct corner whole[3], left[CLIP_CORNERS];
    struct clip_plane planes[CLIP_PLANES];
    whole_corners(surface, triangle->vertex, false, whole);
    planes_of(plan, surface, triangle->vertex, tile, planes);
    int n = clip_triangle(whole, planes + 4, 2, left), n_out = 0;
    for (int i = 2; i < n; i++) {
        struct facet *piece = &out[n_out++];
        *piece = *triangle;
        piece->straddles = piece->cut = true;
        set_corner(plan, surface, &left[0], 0, piece);
        set_corner(plan, surface, &left[i - 1], 1, piece);
        set_corner(plan, surface, &left[i], 2, piece);
        finish_facet(plan, surfaces, tile, piece);
    }
    return n_out;
}

/* Facets seen edge-on may show their other side as well. */
static int add_other_sides(const struct surface *surface, int n,
                           struct facet facets[FACETS_PER_TRIANGLE])
{
    int n_out = n;
    for (int i = 0; i < n && surface->n_sides == 2; i++)
        if (facets[i].edge_on) {
            facets[n_out] = facets[i];
            facets[n_out].other_side = true;
            facets[n_out++].side = !facets[i].side;
        }
    return n_out;
}

int facets_of(const struct plan *plan, const struct surface *surfaces, int surface, int triangle,
              const struct tile *tile, const struct tile *rows,
              struct facet out[FACETS_PER_TRIANGLE])
{
    const struct surface *of = &surfaces[surface];
    const int32_t *vertex = of->mesh->triangles[triangle];
    bool front = in_front(of, vertex);
    if (front && beside(of, vertex, rows))
        return 0;
    struct facet *facet = &out[0];
    *facet = (struct facet){.surface = surface, .triangle = triangle, .provoking = vertex[2]};
    memcpy(facet->vertex, vertex, sizeof facet->vertex);
    if (!front || crosses_depth(of, vertex)) {
        struct facet whole = *facet;
        return add_other_sides(of, depth_pieces(plan, surfaces, tile, &whole, out), out);
    }
    struct corner corners[3];
    whole_corners(of, vertex, false, corners);
    for (int i = 0; i < 3; i++) {
        struct slack slack = slack_of(plan, of, facet, &corners[i]);
        set_corner(plan, of, &corners[i], i, facet);
        widen(facet, &slack);
    }
    facet->straddles = crosses_border(of, vertex, tile);
    finish_facet(plan, surfaces, tile, facet);
    return add_other_sides(of, 1, out);
}
