/* SPDX-License-Identifier: MIT */
/* Draws the tiles of a region, in chunks of some rows, which threads share, by the reference. With
 * a check every pixel then gets bounds on OpenGL's error. A pixel that may show several triangles
 * gets candidates, each with its own bounds. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/candidates/inside.h"

/* The state of a chunk while its pixels get their bounds. */
struct bounding {
    struct fragments fragments;
    struct chunk *chunk;
    struct bounded_pixel pixel;
};

size_t chunk_pixels(const struct chunk *chunk)
{
    return (size_t)chunk->picture.at.width * (size_t)chunk->picture.at.height;
}

/* ---- ambiguous pixels ---- */

/* Returns a bound on OpenGL's error relative to a depth that is stored in single precision. */
static float stored_depth_error(double error, double depth)
{
    return (float)(error + roundings(1) * fabs(depth));
}

static bool make_room(struct chunk *out, size_t n_rows)
{
    const size_t n = out->n_numbers;
    return array_grow(&out->candidates, out->n_candidates, 1, sizeof *out->candidates) &&
           array_grow(&out->candidate_rows, n, n_rows, sizeof *out->candidate_rows) &&
           array_grow(&out->candidate_errors, n, n_rows, sizeof *out->candidate_errors) &&
           array_grow(&out->candidate_own, n, n_rows, sizeof *out->candidate_own);
}

/* Adds the pixel's triangle as it is lit now, at one place of its texture. */
static bool add_candidate(struct bounding *bounding, const struct fragment *fragment,
                          unsigned gates, const struct texel_point *place)
{
    struct chunk *out = bounding->chunk;
    const struct bounded_triangle *triangle = &bounding->fragments.triangles[fragment->triangle];
    const size_t first = out->n_numbers,
                 n_rows = (size_t)pixel_rows(triangle->screen.surface->instance);
    if (!make_room(out, n_rows))
        return false;
    pixel_take_place(&bounding->pixel, place);
    pixel_put(&bounding->pixel, out->candidate_rows + first, 1);
    struct mean_bound mean =
        pixel_errors(&bounding->pixel, out->candidate_rows + first, 1,
                     out->candidate_errors + first, out->candidate_own + first);
    if (fragment->loose)
        mean.cause = fragment->has_no_shadow            ? CAUSE_SHADOW
                     : fragment->depth_error < HUGE_VAL ? CAUSE_FAR
                                                        : CAUSE_THIN;
    out->candidates[out->n_candidates++] = (struct candidate){
        .surface = (int32_t)(triangle->screen.surface - bounding->fragments.tile->lit->surfaces),
        .triangle = triangle->screen.triangle,
        .depth = (float)fragment->depth,
        .depth_error = stored_depth_error(fragment->depth_error, fragment->depth),
        .loose = fragment->loose,
        .covers = fragment->covers,
        .vanishes = fragment->vanishes,
        .gates = gates,
        .dark = bounding->pixel.dark,
        .mean = mean,
        .first = first};
    out->n_numbers += n_rows;
    return true;
}

/* Finds which of these lights do not reach a point of the pixel's triangle. */
static uint32_t dark_at(const struct bounded_pixel *pixel, const double share[3], uint32_t lights)
{
    const struct lit_scene *lit = pixel->lit;
    struct seen_point point = seen_point(lit->surfaces, &pixel->triangle->screen, share);
    point.asked = lights;
    lights_block(&lit->occluders, &lit->plan->view, &point, 1);
    return point.dark;
}

/* Finds the lights that do not reach the pixel for sure, and those whose shadow OpenGL may count
 * otherwise: an edge of it is near, or lies between the triangle and a centre beside it. OpenGL may
 * show a triangle that only comes near the centre, so that its nearest point counts, too. */
static uint32_t find_dark(const struct bounded_pixel *pixel, const struct fragment *fragment,
                          uint32_t *in_doubt)
{
    const uint32_t shadowed = lights_weighed(&pixel->lit->plan->view, pixel->surface->instance,
                                             pixel->attributes, 1),
                   asked = shadowed & ~fragment->in_doubt;
    double nearest[3], sum = 0;
    *in_doubt = shadowed & fragment->in_doubt;
    for (int i = 0; i < 3; i++)
        sum += nearest[i] = fmax(0, pixel->share[i]);
    for (int i = 0; i < 3; i++)
        nearest[i] /= sum;
    const uint32_t near = dark_at(pixel, nearest, asked),
                   centre = least_of(pixel->share) < 0 ? dark_at(pixel, pixel->share, asked) : near;
    *in_doubt |= near ^ centre;
    return near & centre;
}

/* So many lights in doubt have a candidate each way; more leave the pixel without a bound. */
enum { MOST_IN_DOUBT = 6 };

/* Adds the pixel's triangle, which has its bounds, with its gates turned: in each way in which
 * lights may reach it, and with each place in the texture that OpenGL may sample. */
static bool add_shadowed(struct bounding *bounding, const struct fragment *fragment, unsigned gates)
{
    struct bounded_pixel *pixel = &bounding->pixel;
    struct texel_point choices[TEXEL_CHOICES];
    struct fragment added = *fragment;
    uint32_t in_doubt;
    pixel_turn_gates(pixel, gates);
    const uint32_t dark = find_dark(pixel, fragment, &in_doubt);
    added.has_no_shadow = count_bits(in_doubt) > MOST_IN_DOUBT;
    added.loose = added.loose || added.has_no_shadow;
    in_doubt = added.loose ? 0 : in_doubt;
    const int n = pixel_choices(pixel, choices);
    for (uint32_t more = in_doubt;; more = (more - 1) & in_doubt) {
        pixel->dark = dark | more;
        for (int i = 0; i < n; i++)
            if (!add_candidate(bounding, &added, gates, &choices[i]))
                return false;
        if (more == 0)
            return true;
    }
}

/* Adds a triangle that may be visible at a pixel: one candidate for each outcome of its gates and
 * of its shadows, and each place in the texture that OpenGL may sample. */
static bool add_candidates(struct bounding *bounding, const struct fragment *fragment, int x, int y)
{
    unsigned gates = 0;
    do {
        pixel_bound(&bounding->pixel, fragment, x, y, true);
        if (!add_shadowed(bounding, fragment, gates))
            return false;
    } while (++gates < 1U << bounding->pixel.n_gated);
    return true;
}

/* Returns whether the reference shows this fragment. */
static bool is_shown(const struct bounding *bounding, const struct fragment *fragment, size_t index)
{
    const struct picture *picture = &bounding->chunk->picture;
    const struct screen_triangle *screen =
        &bounding->fragments.triangles[fragment->triangle].screen;
    return picture->surface[index] == screen->surface - bounding->fragments.tile->lit->surfaces &&
           picture->triangle[index] == screen->triangle;
}

/* Returns whether the reference shows a triangle that should be hidden. OpenGL does not draw it:
 * then nothing explains the pixel. */
static bool shows_hidden(const struct bounding *bounding, size_t index)
{
    const struct lit_scene *lit = bounding->fragments.tile->lit;
    const struct picture *picture = &bounding->chunk->picture;
    const int32_t surface = picture->surface[index];
    return surface >= 0 && lit->bounds[surface].hidden &&
           lit->bounds[surface].hidden[picture->triangle[index]];
}

/* ---- rivals ---- */

/* Returns whether OpenGL may show `b` where it may show `a`, and not for the place of an edge: they
 * are one triangle, in two lights or places of its texture; or their depths may be the same, and
 * one is there for sure, or they are no neighbours; or the depth of the one in front may be lost.
 * Where an edge decides which of two triangles a pixel has, it is open by a rounding of the edge,
 * and OpenGL says which it is. */
static bool are_rivals(const struct lit_scene *lit, const struct candidate *a,
                       const struct candidate *b)
{
    const double behind = (double)b->depth - (double)a->depth,
                 either = (double)a->depth_error + (double)b->depth_error;
    if (a->loose || b->loose)
        return false;
    if (a->surface == b->surface && a->triangle == b->triangle)
        return true;
    if (fabs(behind) <= either)
        return a->covers || b->covers ||
               !share_corner(&lit->surfaces[a->surface], a->triangle, &lit->surfaces[b->surface],
                             b->triangle);
    return behind > 0 ? a->vanishes : b->vanishes;
}

/* Returns why OpenGL may show a rival instead; NULL: the background. What has no texture and has
 * one light is seen from two sides. */
static enum bound_cause rival_cause(const struct candidate *of, const struct candidate *rival,
                                    bool textured)
{
    if (!rival || fabs((double)rival->depth - (double)of->depth) >
                      (double)rival->depth_error + (double)of->depth_error)
        return CAUSE_DEPTH;
    if (rival->surface != of->surface || rival->triangle != of->triangle)
        return CAUSE_UPON;
    return rival->dark != of->dark     ? CAUSE_SHADOW
           : rival->gates != of->gates ? CAUSE_LIGHT
           : textured                  ? CAUSE_TEXTURE
                                       : CAUSE_THIN;
}

/* Bounds how far two candidates are apart in any band, in radiance; NULL: the background. A texture
 * that differs from band to band changes by its largest value per texel, at most. */
static double apart(const struct bounding *bounding, const struct candidate *of,
                    const struct candidate *from)
{
    const struct lit_scene *lit = bounding->fragments.tile->lit;
    const struct shaded_material *shaded = lit->bounds[of->surface].shaded;
    const struct instance *instance = lit->surfaces[of->surface].instance;
    const bool alike = from && lit->bounds[from->surface].shaded == shaded;
    const double *rows = bounding->chunk->candidate_rows + of->first,
                 *other = bounding->chunk->candidate_rows + (alike ? from : of)->first;
    double sum = 0, all = 0, moved = 0;
    for (int t = 0; t < instance->n_terms; t++) {
        const double peak = shaded->made.terms[t].peak;
        sum += fabs(rows[t] - (alike ? other[t] : 0)) * peak;
        all += fabs(rows[t]) * peak;
    }
    for (int i = instance->n_terms; i < pixel_rows(instance); i++)
        moved += fabs(rows[i] - other[i]);
    if (instance->varied)
        sum = (sum + fmin(moved, 1) * all) * shaded->texture->largest;
    return from && !alike ? fmax(sum, apart(bounding, from, NULL)) : sum;
}

/* More candidates are not compared with each other, but all with the first one. */
enum { MOST_COMPARED = 64 };

/* Bounds how far any candidate of a pixel is apart from its first one. */
static double most_apart(const struct bounding *bounding, const struct ambiguous_pixel *pixel)
{
    const struct candidate *of = bounding->chunk->candidates + pixel->first;
    double most = 0;
    for (int i = 1; i < pixel->count; i++)
        most = fmax(most, apart(bounding, &of[i], of));
    return most;
}

/* Finds what the candidates of an ambiguous pixel leave open; number -1 stands for the background.
 */
static void find_open(struct bounding *bounding, const struct ambiguous_pixel *pixel)
{
    struct candidate *of = bounding->chunk->candidates + pixel->first;
    const struct lit_scene *lit = bounding->fragments.tile->lit;
    float *most = &bounding->chunk->pixels[pixel->pixel].open;
    const int n_compared = pixel->count <= MOST_COMPARED ? pixel->count : 0;
    const double others = n_compared == 0 ? most_apart(bounding, pixel) : 0;
    for (int i = 0; i < pixel->count; i++) {
        of[i].open = n_compared == 0 ? (float)(apart(bounding, &of[i], of) + others) : 0;
        of[i].open_cause = CAUSE_UPON;
        const bool textured = lit->surfaces[of[i].surface].instance->textured;
        for (int j = -1; j < n_compared; j++) {
            const struct candidate *rival = j < 0 ? NULL : &of[j];
            if (j < 0 ? !pixel->background || !of[i].vanishes
                      : i == j || !are_rivals(lit, &of[i], &of[j]))
                continue;
            const float open = (float)apart(bounding, &of[i], rival);
            if (open > of[i].open) {
                of[i].open = open;
                of[i].open_cause = rival_cause(&of[i], rival, textured);
            }
        }
        *most = of[i].loose ? HUGE_VALF : fmaxf(*most, of[i].open);
    }
}

static bool add_ambiguous(struct bounding *bounding, size_t index, int x, int y)
{
    const struct fragment_list *pixel = &bounding->fragments.pixels[index];
    struct chunk *out = bounding->chunk;
    if (!array_grow(&out->ambiguous, out->n_ambiguous, 1, sizeof *out->ambiguous))
        return false;
    struct ambiguous_pixel *ambiguous = &out->ambiguous[out->n_ambiguous++];
    *ambiguous =
        (struct ambiguous_pixel){.pixel = (int32_t)index, .first = (int32_t)out->n_candidates};
    if (shows_hidden(bounding, index))
        return true;
    /* triangles that meet without a gap surely cover the pixel, if the driver is watertight */
    ambiguous->background =
        pixel->limit == HUGE_VAL && !(is_closed(&pixel->seam) && pixel->seam.n_covered > 0 &&
                                      bounding->fragments.tile->lit->driver->watertight);
    /* slivers first: a bounded candidate that explains the pixel as well is taken instead */
    for (int slivers = 1; slivers >= 0; slivers--)
        for (int32_t f = pixel->head; f >= 0; f = bounding->fragments.fragments[f].next) {
            struct fragment fragment = bounding->fragments.fragments[f];
            fragment.loose = fragment.loose || slivers;
            fragment.depth_error = slivers ? HUGE_VAL : fragment.depth_error;
            ambiguous->may_vanish = ambiguous->may_vanish ||
                                    (fragment.vanishes && is_shown(bounding, &fragment, index));
            if ((fragment.sliver || !slivers) && !add_candidates(bounding, &fragment, x, y))
                return false;
        }
    ambiguous->count = (int32_t)out->n_candidates - ambiguous->first;
    find_open(bounding, ambiguous);
    return true;
}

/* ---- settled pixels ---- */

/* Returns whether a pixel is settled: it has one candidate, which is definite, bounded and shown by
 * the reference; or it has no candidate, and the reference shows the background. */
static bool is_settled(const struct bounding *bounding, size_t index)
{
    const struct fragment_list *pixel = &bounding->fragments.pixels[index];
    const struct picture *picture = &bounding->chunk->picture;
    if (pixel->head < 0)
        return picture->surface[index] < 0;
    const struct fragment *only = &bounding->fragments.fragments[pixel->head];
    return only->next < 0 && pixel->limit < HUGE_VAL && !only->loose &&
           is_shown(bounding, only, index);
}

/* Stores the bounds of a settled pixel. Returns whether OpenGL may light its triangle in several
 * ways, or sample several places of its texture. */
static bool settle(struct bounding *bounding, size_t index, int x, int y)
{
    struct chunk *out = bounding->chunk;
    const struct fragment_list *list = &bounding->fragments.pixels[index];
    const size_t n_pixels = chunk_pixels(out);
    struct texel_point choices[TEXEL_CHOICES];
    if (list->head < 0)
        return false;
    const struct fragment *only = &bounding->fragments.fragments[list->head];
    pixel_bound(&bounding->pixel, only, x, y, false);
    const uint32_t dark = bounding->pixel.dark = out->dark ? out->dark[index] : 0;
    if (bounding->pixel.surface->instance->texels.n_levels > 1)
        pixel_put(&bounding->pixel, out->rows + index, n_pixels);
    const uint32_t in_doubt =
        only->in_doubt &
        (dark | lights_weighed(&bounding->pixel.lit->plan->view, bounding->pixel.surface->instance,
                               out->rows + index, n_pixels));
    if (bounding->pixel.n_gated > 0 || in_doubt != 0 ||
        pixel_choices(&bounding->pixel, choices) > 1)
        return true;
    pixel_take_place(&bounding->pixel, &choices[0]);
    struct pixel_bounds *bounds = &out->pixels[index];
    bounds->depth_error = stored_depth_error(only->depth_error, out->picture.depth[index]);
    bounds->steepness = (float)pixel_steepness(&bounding->pixel);
    bounds->mean = pixel_errors(&bounding->pixel, out->rows + index, n_pixels, out->errors + index,
                                out->own + index);
    return false;
}

static bool resolve_pixel(struct bounding *bounding, size_t index)
{
    struct chunk *out = bounding->chunk;
    const struct rectangle *at = &out->picture.at;
    const struct fragment_list *pixel = &bounding->fragments.pixels[index];
    const int x = at->x + (int)index % at->width, y = at->y + (int)index / at->width;
    const uint32_t spread = pixel->n_possible - pixel->n_definite;
    out->pixels[index].overdraw =
        (struct overdraw){.least = (uint8_t)pixel->n_definite,
                          .spread = spread < UINT8_MAX ? (uint8_t)spread : UINT8_MAX,
                          .meant = (uint8_t)(pixel->n_definite + pixel->seam.n_covered),
                          .closed = is_closed(&pixel->seam)};
    const bool settled = is_settled(bounding, index) && !settle(bounding, index, x, y);
    out->is_ambiguous[index] = !settled;
    return settled || add_ambiguous(bounding, index, x, y);
}

/* ---- a chunk ---- */

/* Checked rows have the driver's levels of detail; stored ones have the specification's, on every
 * machine. */
static bool make_rows(struct chunk *out, const struct plan *plan)
{
    const size_t n = chunk_pixels(out) * (size_t)plan->max_rows;
    out->rows = out->picture.rows;
    if (!checks_other_rows(plan))
        return true;
    if (!memory_make(&out->rows, n, sizeof *out->rows))
        return false;
    memcpy(out->rows, out->picture.rows, n * sizeof *out->rows);
    return true;
}

static bool allocate(struct bounding *bounding)
{
    struct chunk *out = bounding->chunk;
    const struct plan *plan = bounding->fragments.tile->lit->plan;
    const size_t n_pixels = chunk_pixels(out), n_rows = (size_t)plan->max_rows;
    return pixel_open(&bounding->fragments, &bounding->pixel) &&
           memory_make(&out->errors, n_pixels * n_rows, sizeof *out->errors) &&
           memory_make(&out->own, n_pixels * n_rows, sizeof *out->own) &&
           memory_make(&out->pixels, n_pixels, sizeof *out->pixels) &&
           memory_make(&out->is_ambiguous, n_pixels, sizeof *out->is_ambiguous) &&
           make_rows(out, plan);
}

static bool find_candidates(const struct tile *tile, struct chunk *chunk)
{
    struct bounding bounding = {.chunk = chunk,
                                .fragments = {.tile = tile, .rows = chunk->picture.at}};
    bool done = fragments_find(&bounding.fragments) && allocate(&bounding);
    for (size_t i = 0; i < chunk_pixels(chunk) && done; i++)
        done = resolve_pixel(&bounding, i);
    fragments_free(&bounding.fragments);
    pixel_close(&bounding.pixel);
    return done;
}

/* Draws the rows of a tile by the reference, with their shadows. False: no memory. */
static bool draw_rows(const struct lit_scene *lit, struct chunk *out)
{
    const struct plan *plan = lit->plan;
    const struct rectangle rows = out->picture.at;
    if (!picture_draw(&plan->view, lit->surfaces, plan->n_instances, &rows, plan->max_rows,
                      &out->picture))
        return false;
    if (plan->view.n_shadowed == 0)
        return true;
    if (!memory_make(&out->dark, chunk_pixels(out), sizeof *out->dark))
        return false;
    picture_shadow(&plan->view, &lit->occluders, &out->picture, out->dark);
    return true;
}

static void chunk_free(struct chunk *chunk)
{
    if (chunk->rows != chunk->picture.rows)
        free(chunk->rows);
    picture_free(&chunk->picture);
    FREE_ALL(chunk->dark, chunk->errors, chunk->own, chunk->pixels, chunk->is_ambiguous,
             chunk->ambiguous, chunk->candidates, chunk->candidate_rows, chunk->candidate_errors,
             chunk->candidate_own);
    *chunk = (struct chunk){.errors = NULL};
}

/* ---- tiles ---- */

/* Draws a chunk of a tile. Finds its candidates if the plan asks for a check. A plan that neither
 * checks nor stores the reference's pixels gets no picture: only picture.at is set. No pixel
 * depends on how a picture is cut into chunks; sums and ratios may round otherwise. chunk_free
 * accepts what a failure left. */
static void draw_chunk(void *context, int i)
{
    struct tile *tile = context;
    const struct plan_options *options = &tile->lit->plan->options;
    const int most = tile->lit->plan->chunk_rows, above = i * most, left = tile->at.height - above;
    struct chunk *out = &tile->chunks[i];
    *out = (struct chunk){.picture = {.at = {tile->at.x, tile->at.y + above, tile->at.width,
                                             left < most ? left : most}}};
    if (((options->check || options->store_raster) && !draw_rows(tile->lit, out)) ||
        (options->check && !find_candidates(tile, out)))
        counter_add(&tile->failures, 1);
}

/* Memory grows with the triangles that lie upon each other: names the object that has the most. */
static bool tile_lacks_memory(const struct tile *tile, struct error *err)
{
    const struct placed_instance *of = tile->lit->plan->instances;
    int most = -1;
    char object[256];
    for (int s = 0; s < tile->lit->plan->n_instances; s++)
        if (of[s].in_view &&
            (most < 0 || of[s].instance.n_triangles > of[most].instance.n_triangles))
            most = s;
    object_text(tile->lit->plan, most, object, sizeof object);
    return memory_lacks(err, 0,
                        "a tile of %d x %d pixels; the object with the most triangles is %s: "
                        "render it larger, or with fewer of them",
                        tile->at.width, tile->at.height, object);
}

bool tiles_each(const struct lit_scene *lit, const struct rectangle *region, tile_work *work,
                void *context, struct error *err)
{
    const int n = plan_tiles(lit->plan, region), rows = lit->plan->chunk_rows;
    bool done = true;
    for (int i = 0; done && i < n; i++) {
        struct tile tile = {.lit = lit, .at = plan_tile(lit->plan, region, i), .failures = COUNTER};
        tile.n_chunks = (tile.at.height + rows - 1) / rows;
        if (!MAKE_ARRAY(tile.chunks, tile.n_chunks, err, "a tile"))
            return false;
        threads_each(lit->plan->options.threads, tile.n_chunks, draw_chunk, &tile);
        done = (tile.failures.n == 0 || tile_lacks_memory(&tile, err)) && work(context, &tile, err);
        for (int c = 0; c < tile.n_chunks; c++)
            chunk_free(&tile.chunks[c]);
        free(tile.chunks);
    }
    return done;
}
