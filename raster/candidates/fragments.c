/* SPDX-License-Identifier: MIT */
/* Finds the fragments that OpenGL may have at each pixel of a chunk: those that it may show there,
 * and how many it may draw, hidden ones included. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/candidates/inside.h"

/* ---- presence ---- */

/* A triangle at a pixel centre. */
struct visit {
    struct fragments *of;
    const struct volume *volume; /* a facet of this shadow volume; NULL: of an object */
    int facet;                   /* its number in the volume */
    int32_t triangle;
    bool any;      /* some pixel's list has it */
    bool is_plain; /* a facet: see is_plain */
    struct fragment_list *pixel;
    double x, y;
    struct edge_functions edges;
    bool on_seam; /* OpenGL may set two clipped triangles side by side there */
};

static const struct bounded_triangle *visited(const struct visit *visit)
{
    return &visit->of->triangles[visit->triangle];
}

/* OpenGL has a fragment at a point not, perhaps, or for sure. With p the point and a, b
 * two corners minus p, moving a by up to e and b by up to f, which differ in x and y, changes the
 * edge function a x b by at most e_x |b_y| + e_y |b_x| + f_x |a_y| + f_y |a_x| + e_x f_y + e_y f_x:
 * the slack. */
enum presence { IMPOSSIBLE, POSSIBLE, DEFINITE };

/* Bounds OpenGL's errors in the edge functions at a point, where corners are off in x and y. */
static void edge_slack(const struct edge_functions *edges, const double errors[3][2],
                       double slack[3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double *e = errors[j], *f = errors[k];
        slack[i] = e[0] * fabs(edges->dy[k]) + e[1] * fabs(edges->dx[k]) +
                   f[0] * fabs(edges->dy[j]) + f[1] * fabs(edges->dx[j]) + e[0] * f[1] +
                   e[1] * f[0];
    }
}

/* Finds the edge functions at a point, and the presence there; or that the point lies beside the
 * box around the triangle: edges no longer than their errors may run in any direction, and do not
 * exclude it. turned: the corners are turned so that edge functions are positive inside. A triangle
 * without area touches its longest edge only. */
static enum presence presence_at(const struct screen_triangle *screen,
                                 const struct edge_errors *errors, bool turned, double px,
                                 double py, struct edge_functions *edges)
{
    enum presence presence = DEFINITE;
    const double *most = errors->most;
    double slack[3];
    if (least_of(screen->x) - most[0] > px || px > most_of(screen->x) + most[0] ||
        least_of(screen->y) - most[1] > py || py > most_of(screen->y) + most[1])
        return IMPOSSIBLE;
    edges_at(screen->x, screen->y, px, py, edges);
    edge_slack(edges, errors->px, slack);
    const double turn = turned || edges->e[0] + edges->e[1] + edges->e[2] >= 0 ? 1 : -1;
    for (int i = 0; i < 3; i++) {
        const bool on_edge = slack[i] <= 0 && edges->e[i] == 0; /* without any error */
        if (turn * edges->e[i] < -slack[i] || (on_edge && !owns_edge(screen, i, 1)))
            return IMPOSSIBLE;
        if (!(turn * edges->e[i] > slack[i]) && !on_edge)
            presence = POSSIBLE;
    }
    return presence;
}

/* The room is a power of two. It suffices if the last element that is there and the last one that
 * comes have the same highest bit. An array without elements has room for one: pointers into it are
 * not null. */
bool array_grow(void *array, size_t n, size_t more, size_t size)
{
    const size_t needed = n + more;
    size_t room = 1;
    if (n > 1 && ((n - 1) ^ (needed - 1)) < n - 1)
        return true;
    while (room < needed)
        room *= 2;
    return room <= INT32_MAX && memory_resize(array, room, size);
}

/* ---- visibility ---- */

/* Takes out of a pixel's list the fragments behind its limit. */
static void drop_hidden(struct fragments *of, struct fragment_list *pixel)
{
    int32_t *link = &pixel->head;
    while (*link >= 0) {
        struct fragment *fragment = &of->fragments[*link];
        if (fragment->depth - fragment->depth_error <= pixel->limit) {
            link = &fragment->next;
            continue;
        }
        int32_t dropped = *link;
        *link = fragment->next;
        fragment->next = of->unused;
        of->unused = dropped;
    }
}

/* Adds a possible or definite fragment to a pixel's list. */
static bool add_fragment(struct visit *visit, const struct fragment *fragment)
{
    struct fragments *of = visit->of;
    struct fragment_list *pixel = visit->pixel;
    if (fragment->depth - fragment->depth_error > pixel->limit)
        return true;
    if (fragment->is_definite && fragment->depth + fragment->depth_error < pixel->limit) {
        pixel->limit = fragment->depth + fragment->depth_error;
        drop_hidden(of, pixel);
    }
    int32_t place = of->unused;
    if (place >= 0) {
        of->unused = of->fragments[place].next;
    } else {
        if (!array_grow(&of->fragments, of->n_fragments, 1, sizeof *of->fragments))
            return false;
        place = (int32_t)of->n_fragments++;
    }
    of->fragments[place] = *fragment;
    of->fragments[place].next = pixel->head;
    pixel->head = place;
    visit->any = true;
    return true;
}

/* ---- counting fragments ---- */

static uint64_t corner_number(const struct screen_triangle *triangle, int i, uint64_t object)
{
    uint64_t x, y;
    memcpy(&x, &triangle->x[i], sizeof x);
    memcpy(&y, &triangle->y[i], sizeof y);
    return hash_bits(hash_bits(hash_bits(object) + x) + y);
}

/* Adds the edges that OpenGL may put on either side of the centre. Triangles of one object that
 * meet have corners of the same bits there. */
static void add_edges(const struct visit *visit)
{
    const struct lit_scene *lit = visit->of->tile->lit;
    const struct screen_triangle *screen = &visited(visit)->screen;
    uint64_t object =
        (uint64_t)(bounds_of(lit, screen)->placed->object - lit->plan->scene->objects);
    double slack[3];
    edge_slack(&visit->edges, visited(visit)->edges.px, slack);
    for (int i = 0; i < 3; i++) {
        if (visit->edges.e[i] > slack[i])
            continue;
        uint64_t from = corner_number(screen, (i + 1) % 3, object),
                 to = corner_number(screen, (i + 2) % 3, object);
        visit->pixel->seam.edge_sum[screen->clockwise] +=
            hash_bits(from + 2 * to) - hash_bits(to + 2 * from);
    }
}

static void count_fragment(const struct visit *visit, enum presence presence, bool covered)
{
    const struct bounded_triangle *triangle = visited(visit);
    struct fragment_list *pixel = visit->pixel;
    if (triangle->other_side) /* the same fragment, which its own side counts */
        return;
    pixel->n_possible++;
    if (presence == DEFINITE) {
        pixel->n_definite++;
        return;
    }
    visit->pixel->seam.n_covered += covered;
    visit->pixel->seam.open = visit->pixel->seam.open || triangle->edge_on || triangle->cut;
    add_edges(visit);
}

bool is_closed(const struct seam *seam)
{
    return !seam->open && seam->edge_sum[0] == 0 && seam->edge_sum[1] == 0;
}

/* ---- clipped triangles ---- */

/* Adds a part to the lists of triangles, behind the last one, and visits its pixels. */
static bool visit_part(struct visit *visit, const struct triangle_part *part,
                       bool (*at_pixel)(void *context, int x, int y))
{
    struct fragments *of = visit->of;
    size_t n_clipped = (size_t)(part->bounded.n_clipped + part->bounded.n_slivers);
    if (!array_grow(&of->triangles, of->n_triangles, 1, sizeof *of->triangles) ||
        !array_grow(&of->clipped, of->n_clipped, n_clipped, sizeof *of->clipped))
        return false;
    struct bounded_triangle *triangle = &of->triangles[of->n_triangles];
    *triangle = part->bounded;
    triangle->first_clipped = (int32_t)of->n_clipped;
    memcpy(of->clipped + of->n_clipped, part->clipped, n_clipped * sizeof *of->clipped);
    visit->triangle = (int32_t)of->n_triangles;
    return scan_triangle(&triangle->screen, &of->rows, triangle->edges.most[0], at_pixel, visit);
}

/* True if OpenGL may set up one of these clipped triangles turned around: it then lies upon its
 * neighbours, and both have a fragment. */
static bool may_fold(const struct visit *visit, unsigned clipped)
{
    const struct bounded_triangle *triangle = visited(visit);
    for (int32_t i = 0; i < triangle->n_clipped && triangle->n_clipped > 1; i++)
        if ((clipped >> i & 1) && visit->of->clipped[triangle->first_clipped + i].folds)
            return true;
    return false;
}

unsigned count_bits(unsigned bits)
{
    unsigned n = 0;
    for (; bits != 0; bits &= bits - 1)
        n++;
    return n;
}

/* Finds which of n clipped triangles OpenGL may have at a point: bit i stands for number i.
 * *on_seam: it has one of them only perhaps. */
static unsigned possible_at(const struct clipped_triangle *clipped, int n, double px, double py,
                            bool *on_seam)
{
    unsigned some = 0;
    *on_seam = false;
    for (int i = 0; i < n; i++) {
        struct edge_functions edges;
        const enum presence presence =
            presence_at(&clipped[i].screen, &clipped[i].edges, false, px, py, &edges);
        some |= (unsigned)(presence != IMPOSSIBLE) << i;
        *on_seam = *on_seam || presence == POSSIBLE;
    }
    return some;
}

/* Finds the clipped triangles that OpenGL may have at the pixel. Beyond the near and the far plane
 * all are possible. Where OpenGL may cut an edge anywhere, these meet anywhere. */
static unsigned clipped_at(struct visit *visit)
{
    const struct bounded_triangle *triangle = visited(visit);
    const struct clipped_triangle *clipped = &visit->of->clipped[triangle->first_clipped];
    const int n = triangle->n_clipped;
    visit->on_seam = false;
    const unsigned some = n > 1 ? possible_at(clipped, n, visit->x, visit->y, &visit->on_seam) : 1;
    visit->on_seam = visit->on_seam || triangle->slides;
    return some == 0 && triangle->cut ? (1u << n) - 1 : some;
}

/* True if OpenGL's error has no bound at a point: on a clipped triangle that is too thin for one,
 * where depth has none either, or so far away that roundings of 1 / w, made where it is larger, may
 * be nearly all of it. */
static bool is_loose(const struct visit *visit, unsigned clipped, bool *thin)
{
    const struct bounded_triangle *triangle = visited(visit);
    double sum = 0, inverse_w = 0;
    bool far = false, ignored;
    for (int i = 0; i < 3; i++) {
        sum += visit->edges.e[i];
        inverse_w += visit->edges.e[i] * triangle->screen.inverse_w[i];
    }
    /* OpenGL may set up a sliver there, besides the clipped triangles */
    *thin = possible_at(&visit->of->clipped[triangle->first_clipped + triangle->n_clipped],
                        triangle->n_slivers, visit->x, visit->y, &ignored) != 0;
    for (int32_t i = 0; i < triangle->n_clipped; i++) {
        const struct clipped_triangle *part = &visit->of->clipped[triangle->first_clipped + i];
        const struct colour_bound *bound = &part->inverse_w_bound;
        if (!(clipped >> i & 1))
            continue;
        *thin = *thin || !(part->magnification < HUGE_VAL);
        far = far || !(1.125 * (bound->fixed * sum + bound->per_d * inverse_w) <= inverse_w);
    }
    return *thin || far;
}

/* ---- triangles ---- */

static void go_to(struct visit *visit, int x, int y)
{
    const struct rectangle *rows = &visit->of->rows;
    visit->x = x + 0.5;
    visit->y = y + 0.5;
    visit->pixel =
        &visit->of->pixels[(size_t)(y - rows->y) * (size_t)rows->width + (size_t)(x - rows->x)];
}

/* Finds the presence at the pixel. Returns the clipped triangles that OpenGL may have there; 0: it
 * has none. */
static unsigned present_at(struct visit *visit, enum presence *presence)
{
    const struct bounded_triangle *triangle = visited(visit);
    *presence =
        presence_at(&triangle->screen, &triangle->edges, true, visit->x, visit->y, &visit->edges);
    return *presence == IMPOSSIBLE ? 0 : clipped_at(visit);
}

/* Counts and lists the fragment that OpenGL has there, or may have. */
static bool visit_pixel(void *context, int x, int y)
{
    struct visit *visit = context;
    const struct bounded_triangle *triangle = visited(visit);
    enum presence presence;
    go_to(visit, x, y);
    const unsigned clipped = present_at(visit, &presence);
    if (clipped == 0)
        return true;
    struct fragment fragment = {.triangle = visit->triangle,
                                .clipped = clipped,
                                .depth = depth_at(&triangle->screen, &visit->edges)};
    bool thin, covered = fragment.depth >= 0 && fragment.depth < 1 &&
                         (presence == DEFINITE || edges_cover(&triangle->screen, &visit->edges));
    const bool leaks = !visit->of->tile->lit->driver->watertight && visit->on_seam,
               folds = may_fold(visit, clipped);
    fragment.sliver = triangle->slivers && presence == POSSIBLE;
    if (leaks || folds || fragment.sliver) {
        presence = POSSIBLE;
        visit->pixel->seam.open = visit->pixel->seam.open || folds || fragment.sliver;
        /* a fragment by each clipped triangle, and one by a triangle that is not among them */
        const unsigned more = count_bits(clipped) - 1 + (triangle->slides || fragment.sliver);
        visit->pixel->n_possible += triangle->other_side ? 0 : more;
    }
    fragment.covers = presence == DEFINITE;
    fragment.loose = is_loose(visit, clipped, &thin);
    fragment.depth_error = thin ? HUGE_VAL : triangle->depth_error;
    /* the near or the far plane may cut it off; a sliver that may cover nothing is not lost by that
     */
    if (!(fragment.depth > fragment.depth_error && fragment.depth < 1 - fragment.depth_error)) {
        fragment.vanishes = !thin || presence == DEFINITE;
        presence = POSSIBLE;
        visit->pixel->seam.open = true;
    }
    fragment.is_definite = presence == DEFINITE;
    count_fragment(visit, presence, covered);
    return bounds_of(visit->of->tile->lit, &triangle->screen)->placed->twin ||
           add_fragment(visit, &fragment);
}

/* Triangles that no list has are forgotten at once: there may be a million to a pixel. */
static bool visit_triangle(struct fragments *of, int surface, int triangle)
{
    struct triangle_part parts[TRIANGLE_PARTS];
    int n = triangle_parts(of->tile, surface, triangle, &of->rows, parts);
    for (int i = 0; i < n; i++) {
        const struct bounded_triangle *bounded = &parts[i].bounded;
        struct visit visit = {.of = of};
        if (!visit_part(&visit, &parts[i], visit_pixel))
            return false;
        of->n_triangles += visit.any;
        of->n_clipped += visit.any ? (size_t)(bounded->n_clipped + bounded->n_slivers) : 0;
    }
    return true;
}

/* ---- shadows ---- */

bool share_corner(const struct surface *a, int32_t of_a, const struct surface *b, int32_t of_b)
{
    const int32_t *v = a->instance->triangles[of_a], *w = b->instance->triangles[of_b];
    for (int i = 0; i < 9; i++)
        if (memcmp(a->vertices[v[i / 3]].clip, b->vertices[w[i % 3]].clip,
                   sizeof a->vertices->clip) == 0)
            return true;
    return false;
}

/* Returns whether a facet is the cap that a fragment's triangle is itself, by the same numbers,
 * and has its depth; or the cap of a neighbour that has the pixel only where the fragment's
 * triangle has not. */
static bool is_own_cap(const struct visit *visit, const struct bounded_triangle *triangle,
                       enum presence presence)
{
    const struct lit_scene *lit = visit->of->tile->lit;
    const struct occluder *cap = &visit->volume->caps[visit->facet];
    if (cap->surface < 0)
        return false;
    const struct surface *surface = &lit->surfaces[cap->surface];
    const struct instance *a = surface->instance, *b = triangle->screen.surface->instance;
    if (cap->triangle == triangle->screen.triangle && a->triangles == b->triangles &&
        memcmp(&a->model_view, &b->model_view, sizeof a->model_view) == 0)
        return true;
    return presence == POSSIBLE && lit->driver->watertight &&
           triangle->screen.clockwise == visited(visit)->screen.clockwise &&
           share_corner(surface, cap->triangle, triangle->screen.surface,
                        triangle->screen.triangle);
}

/* Returns whether a facet meets others at a pixel so that OpenGL may have none of them there, or
 * two. Where the far plane cuts a cap, the edges of its two parts are not those of its sides; and
 * at the plane OpenGL may have the cap, its part beyond, both, or none. farthest: its depth there.
 */
static bool facet_leaks(const struct visit *visit, enum presence presence, double farthest)
{
    const struct volume *volume = visit->volume;
    const bool is_cap = volume->caps[visit->facet].surface >= 0,
               is_beyond = visit->facet >= volume->first_beyond && visit->facet < volume->first_far,
               is_part = visited(visit)->cut || is_beyond;
    if ((is_part && presence == POSSIBLE) || (is_cap && farthest >= 1))
        return true;
    return !visit->of->tile->lit->driver->watertight && (presence == POSSIBLE || visit->on_seam);
}

/* Returns whether a plain facet may lie in front of a fragment of the pixel as well as behind it,
 * or meet one that OpenGL may not have. This is cheap, and of most facets that is all. */
static bool is_near(const struct visit *visit)
{
    const struct bounded_triangle *triangle = visited(visit);
    struct edge_functions edges;
    edges_at(triangle->screen.x, triangle->screen.y, visit->x, visit->y, &edges);
    const double depth = depth_at(&triangle->screen, &edges);
    for (int32_t f = visit->pixel->head; f >= 0; f = visit->of->fragments[f].next) {
        const struct fragment *fragment = &visit->of->fragments[f];
        if (!fragment->is_definite ||
            fabs(depth - fragment->depth) <= triangle->depth_error + fragment->depth_error)
            return true;
    }
    return false;
}

/* Doubts the shadow of each fragment that the facet may lie in front of or behind; and of one that
 * OpenGL may not have, where the facet has an edge, too: they may be neighbours. A fragment is in
 * a shadow by the number of facets behind it, and in doubt if these may leak. */
static bool visit_facet(void *context, int x, int y)
{
    struct visit *visit = context;
    struct fragments *of = visit->of;
    const struct bounded_triangle *triangle = visited(visit);
    enum presence presence;
    bool thin;
    go_to(visit, x, y);
    if (visit->pixel->head < 0 || (visit->is_plain && !is_near(visit)))
        return true;
    const unsigned clipped = present_at(visit, &presence);
    if (clipped == 0)
        return true;
    is_loose(visit, clipped, &thin);
    const double depth = depth_at(&triangle->screen, &visit->edges),
                 error = thin ? HUGE_VAL : triangle->depth_error;
    const bool leaks = facet_leaks(visit, presence, depth + triangle->depth_error);
    for (int32_t f = visit->pixel->head; f >= 0; f = of->fragments[f].next) {
        struct fragment *fragment = &of->fragments[f];
        const double behind = depth - fragment->depth, either = error + fragment->depth_error;
        const bool meets = presence == POSSIBLE && !fragment->is_definite;
        if ((fabs(behind) <= either || meets || (leaks && behind > -either)) &&
            (leaks || !is_own_cap(visit, &of->triangles[fragment->triangle], presence)))
            fragment->in_doubt |= (uint32_t)1 << visit->volume->shadowed;
    }
    return true;
}

/* Returns whether facet_leaks is false wherever a facet is, and its depth has a bound there. */
static bool is_plain(const struct visit *visit, const struct triangle_part *part)
{
    const struct volume *volume = visit->volume;
    bool plain = visit->of->tile->lit->driver->watertight && !part->bounded.cut &&
                 volume->caps[visit->facet].surface < 0 && part->bounded.n_slivers == 0 &&
                 (visit->facet < volume->first_beyond || visit->facet >= volume->first_far);
    for (int32_t i = 0; i < part->bounded.n_clipped; i++)
        plain = plain && part->clipped[i].magnification < HUGE_VAL;
    return plain;
}

/* The far end that lies beyond the far plane for sure is clamped to it, behind all. */
static bool visit_volume(struct fragments *of, const struct tile *tile, int index)
{
    const struct volume *volume = &of->tile->lit->volumes->list[index];
    const bool watertight = of->tile->lit->driver->watertight;
    struct triangle_part parts[TRIANGLE_PARTS];
    for (int t = 0; t < volume->n; t++) {
        const struct occluder *cap = &volume->caps[t];
        const bool is_cut = cap->surface >= 0,
                   is_far = t >= volume->first_far && t < volume->n_outward;
        const int n = triangle_parts(is_cut ? of->tile : tile, is_cut ? cap->surface : index,
                                     is_cut ? cap->triangle : t, &of->rows, parts);
        for (int i = 0; i < n; i++) {
            const struct bounded_triangle *bounded = &parts[i].bounded;
            struct visit visit = {.of = of, .volume = volume, .facet = t};
            if (watertight && is_far && least_of(bounded->screen.z) > 1 + bounded->depth_error)
                continue;
            visit.is_plain = is_plain(&visit, &parts[i]);
            if (!visit_part(&visit, &parts[i], visit_facet))
                return false;
        }
    }
    return true;
}

/* Finds the fragments whose shadows OpenGL may count otherwise: those that a facet of a volume may
 * lie in front of as well as behind; all, of a volume whose far end may lie too near. */
static bool doubt_shadows(struct fragments *of)
{
    const struct volumes *volumes = of->tile->lit->volumes;
    const struct tile tile = {.lit = &volumes->lit, .at = of->tile->at};
    for (int i = 0; i < volumes->n; i++) {
        const struct volume *volume = &volumes->list[i];
        for (size_t f = 0; volume->is_doubtful && f < of->n_fragments; f++)
            of->fragments[f].in_doubt |= (uint32_t)1 << volume->shadowed;
        if (!volume->is_doubtful && surface_reaches(&volumes->lit.bounds[i], &of->rows) &&
            !visit_volume(of, &tile, i))
            return false;
    }
    /* facets before the near plane have depth 0, which is not less than that */
    for (size_t f = 0; f < of->n_fragments; f++)
        if (of->fragments[f].depth <= of->fragments[f].depth_error)
            of->fragments[f].in_doubt = UINT32_MAX;
    return true;
}

bool fragments_find(struct fragments *out)
{
    size_t n_pixels = (size_t)out->rows.width * (size_t)out->rows.height;
    out->unused = -1;
    if (!memory_make(&out->pixels, n_pixels, sizeof *out->pixels))
        return false;
    for (size_t i = 0; i < n_pixels; i++)
        out->pixels[i] = (struct fragment_list){.head = -1, .limit = HUGE_VAL};
    for (int s = 0; s < out->tile->lit->plan->n_instances; s++) {
        if (!surface_reaches(&out->tile->lit->bounds[s], &out->rows))
            continue;
        int n_triangles = out->tile->lit->surfaces[s].instance->n_triangles;
        const bool *hidden = out->tile->lit->bounds[s].hidden;
        for (int t = 0; t < n_triangles; t++)
            if (!(hidden && hidden[t]) && !visit_triangle(out, s, t))
                return false;
    }
    return !out->tile->lit->volumes || doubt_shadows(out);
}

void fragments_free(struct fragments *fragments)
{
    FREE_ALL(fragments->pixels, fragments->triangles, fragments->fragments, fragments->clipped);
}
