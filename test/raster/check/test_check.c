/* SPDX-License-Identifier: MIT */
/* The check judges pixels that a false OpenGL shows: those of the reference agree; one step of
 * depth beyond the bound, another triangle, a fragment too many, or an error of twice the floor is
 * found; and the limit of the mean follows from the sums of bounds. */

#include "data/scene/inside.h"
#include "raster/check/inside.h"
#include "raster/plan/plan.h"
#include "raster/renderers/renderers.h"
#include "test.h"

enum { WIDTH = 24, HEIGHT = 16, PIXELS = WIDTH * HEIGHT, BANDS = 7 };

static const double steps = 16777215; /* of a depth */

/* A pixel that shows something else than the reference. */
struct change {
    size_t pixel;
    int surface, triangle, depth, fragments, band; /* differences */
    double counts;                                 /* in this band */
};
/* A renderer that shows the reference's picture, which is one chunk, but for a change. */
struct false_renderer {
    struct renderer base;
    const struct chunk *chunk;
    struct change change;
};
struct bench {
    struct scene scene;
    struct plan plan;
    struct lit_scene lit;
    struct check_scene checked;
    struct verdict_limits limits;
};

/* The nearest step of the reference's depth, as the check takes it. */
static double depth_of(const struct chunk *chunk, size_t pixel)
{
    return chunk->picture.surface[pixel] < 0 ? 1 : (double)(float)chunk->picture.depth[pixel];
}

static struct shown shown(const struct renderer *of, int x, int y)
{
    const struct false_renderer *renderer = (const struct false_renderer *)of;
    const struct chunk *chunk = renderer->chunk;
    const size_t pixel = (size_t)(y * WIDTH + x);
    const struct change *change = &renderer->change;
    struct shown out = {chunk->picture.surface[pixel], chunk->picture.triangle[pixel],
                        (uint32_t)nearbyint(depth_of(chunk, pixel) * steps),
                        chunk->pixels[pixel].overdraw.meant};
    if (pixel == change->pixel) {
        out.surface += change->surface;
        out.triangle += change->triangle;
        out.depth += (uint32_t)change->depth;
        out.fragments = (uint8_t)(out.fragments + change->fragments);
    }
    return out;
}

/* Draws a pass in parts of full scale, as OpenGL would draw the reference's radiances. */
static void draw_pass(const struct bench *bench, const struct chunk *chunk, int pass,
                      const struct change *change, float *pixels)
{
    for (size_t i = 0; i < PIXELS; i++)
        for (int c = 0; c < BANDS_PER_PASS; c++) {
            const int32_t surface = chunk->picture.surface[i];
            const int band = pass * BANDS_PER_PASS + c;
            double counts = 0;
            if (surface >= 0 && band < BANDS) {
                const struct run run = {.shaded = bench->lit.bounds[surface].shaded,
                                        .rows = chunk->picture.rows + i,
                                        .stride = PIXELS,
                                        .n = 1};
                expect_counts(&bench->lit, &run, band, &counts, NULL);
            }
            if (i == change->pixel && band == change->band)
                counts += change->counts;
            pixels[4 * i + (size_t)c] = (float)(counts / FULL_COUNT);
        }
}

/* Judges the picture with a change. *floor becomes that of one band alone, at the changed pixel. */
static struct check_verdict judge(const struct bench *bench, const struct tile *tile,
                                  struct change change, float *floor)
{
    static const struct renderer_kind kind = {.shown = shown};
    static float pixels[4 * PIXELS];
    const struct chunk *chunk = tile->chunks;
    struct false_renderer renderer = {.base = {.kind = &kind}, .chunk = chunk, .change = change};
    const struct fit *fit = &bench->checked.fit;
    struct error err = {.text = ""};
    struct check check;
    struct check_totals totals;
    test_need(tile->n_chunks == 1 && check_open(&bench->checked, chunk, &check, &err) &&
                  totals_open(&bench->checked, &totals, &err),
              err.text);
    check_identity(&check, &renderer.base, &tile->at);
    for (int i = 0; i < fit->n_passes + bench->plan.n_passes; i++) {
        const bool learns = i < fit->n_passes;
        const int pass = learns ? fit->passes[i] : i - fit->n_passes;
        draw_pass(bench, chunk, pass, &change, pixels);
        check_pass(&check, pass * BANDS_PER_PASS, pixels, WIDTH, learns);
    }
    check_settle(&check, tile, &totals);
    const struct check_verdict out = totals.verdict;
    if (floor)
        *floor = check.band_floor[change.pixel];
    check_free(&check);
    totals_free(&totals);
    return out;
}

/* Finds a pixel of an object with one candidate, or one where triangles meet. */
static size_t find_pixel(const struct chunk *chunk, bool meeting)
{
    for (size_t i = PIXELS / 3; i < PIXELS; i++) {
        const struct overdraw *overdraw = &chunk->pixels[i].overdraw;
        if (chunk->picture.surface[i] >= 0 &&
            (meeting ? overdraw->closed && overdraw->spread > 1
                     : !chunk->is_ambiguous[i] && overdraw->spread == 0))
            return i;
    }
    test_need(false, "no such pixel");
    return 0;
}

static void check_settled(struct bench *bench, const struct tile *tile)
{
    const struct chunk *chunk = tile->chunks;
    const size_t pixel = find_pixel(chunk, false);
    const double depth = depth_of(chunk, pixel), error = (double)chunk->pixels[pixel].depth_error,
                 at = nearbyint(depth * steps), last = floor((depth + error) * steps) - at,
                 first = ceil((depth - error) * steps) - at;
    float floor_counts;
    struct check_verdict verdict =
        judge(bench, tile, (struct change){.pixel = pixel}, &floor_counts);
    CHECK(verdict.unexplained == 0 && verdict.pixels == PIXELS &&
              verdict.samples.n == PIXELS * BANDS && verdict.samples.largest < 0.01,
          "the reference's own pixels agree");
    for (int side = 0; side < 2; side++) {
        const int off = (int)(side ? last : first), more = side ? 1 : -1;
        verdict = judge(bench, tile, (struct change){.pixel = pixel, .depth = off}, NULL);
        CHECK(verdict.unexplained == 0, "a depth at the bound, %d steps off, agrees", off);
        verdict = judge(bench, tile, (struct change){.pixel = pixel, .depth = off + more}, NULL);
        CHECK(verdict.unexplained == 1 && verdict.first.kind == FAILURE_DEPTH,
              "a depth one step beyond, %d off, differs", off + more);
    }
    for (int i = 0; i < 2; i++) {
        verdict = judge(bench, tile,
                        (struct change){.pixel = pixel, .surface = i, .triangle = 1 - i}, NULL);
        CHECK(verdict.unexplained == 1 && verdict.first.kind == FAILURE_TRIANGLE &&
                  verdict.first.x == (int)pixel % WIDTH && verdict.first.y == (int)pixel / WIDTH,
              "another %s differs, at its pixel", i ? "object" : "triangle");
        verdict = judge(bench, tile, (struct change){.pixel = pixel, .fragments = 2 * i - 1}, NULL);
        CHECK(verdict.unexplained == 1 && verdict.first.kind == FAILURE_FRAGMENTS,
              "a fragment too %s differs", i ? "many" : "few");
    }
    for (int band = 0; band < BANDS; band++) {
        struct change change = {
            .pixel = pixel, .band = band, .counts = 2.001 * (double)floor_counts};
        verdict = judge(bench, tile, change, NULL);
        const struct check_failure *failure = &verdict.first;
        bool named = failure->kind == FAILURE_RADIANCE && failure->band == band;
        for (int i = 0; i < failure->n_odd; i++)
            named = named || (failure->odd[i].first == band && failure->odd[i].last == band &&
                              fabs(failure->odd[i].off / change.counts - 1) < 0.5);
        CHECK(verdict.unexplained == 1, "an error of twice the floor differs, in band %d", band);
        CHECK(named, "the band is named, alone or as one of two");
    }
}

/* Where triangles of an object meet, a driver that leaks may lose a fragment or double it. */
static void check_meeting(struct bench *bench, const struct tile *tile)
{
    const struct chunk *chunk = tile->chunks;
    const size_t pixel = find_pixel(chunk, true);
    double last = 0;
    for (size_t i = 0; i < chunk->n_ambiguous; i++)
        for (int c = 0; c < chunk->ambiguous[i].count; c++) {
            const struct candidate *candidate = &chunk->candidates[chunk->ambiguous[i].first + c];
            if (chunk->ambiguous[i].pixel == (int32_t)pixel &&
                candidate->triangle == chunk->picture.triangle[pixel])
                last = floor(((double)candidate->depth + (double)candidate->depth_error) * steps) -
                       nearbyint(depth_of(chunk, pixel) * steps);
        }
    for (int more = 0; more < 2; more++) {
        const struct check_verdict verdict =
            judge(bench, tile, (struct change){.pixel = pixel, .depth = (int)last + more}, NULL);
        CHECK(last > 0 && verdict.unexplained == (uint64_t)more,
              "a depth %s the bound of a candidate %s", more ? "beyond" : "at",
              more ? "differs" : "agrees");
    }
    for (int strict = 0; strict < 2; strict++)
        for (int off = -1; off <= 1; off += 2) {
            bench->limits.strict = strict;
            const struct check_verdict verdict =
                judge(bench, tile, (struct change){.pixel = pixel, .fragments = off}, NULL);
            CHECK(verdict.edge_holes == (off < 0) && verdict.edge_doubles == (off > 0),
                  "%s fragment where triangles meet is counted", off < 0 ? "a lost" : "a doubled");
            CHECK(verdict.unexplained == (uint64_t)strict, "it %s",
                  strict ? "differs where that is asked for" : "is no difference of this driver");
        }
}

static bool check_tile(void *context, const struct tile *tile, struct error *err)
{
    (void)err;
    check_settled(context, tile);
    check_meeting(context, tile);
    return true;
}

/* Hoeffding's inequality leaves 10^-9: 2 exp(-s^2 / (2 sum b_i^2)) = 10^-9. */
static void check_mean(const struct bench *bench)
{
    struct check_totals totals;
    struct error err = {.text = ""};
    test_need(totals_open(&bench->checked, &totals, &err), err.text);
    totals.shared = 3;
    totals.varying[0] = 4;
    totals.varying[totals.n_triangles - 1] = 12;
    totals.verdict.pixels = 10;
    totals_finish(&totals);
    CHECK_NEAR(totals.verdict.mean_limit, (3 + sqrt(2 * log(2e9) * (16 + 144))) / 10, 1e-5,
               "the limit of the mean follows from the sums of bounds");
    totals.verdict.samples =
        (struct check_samples){.n = 100, .sum = 100.001 * totals.verdict.mean_limit};
    CHECK(is_biased(&totals.verdict), "a larger mean is a difference");
    totals.verdict.samples.sum = -99.999 * totals.verdict.mean_limit;
    CHECK(!is_biased(&totals.verdict), "a smaller one is none");
    totals_free(&totals);
}

/* The verdict of a picture: what its tiles count, the worst that they have, and the first fault. */
static void check_sum(void)
{
    struct check_verdict sum = {.worst_depth_ratio = -1};
    const struct check_verdict tiles[3] = {{.pixels = 5, .objects = 4, .worst_depth_ratio = 0.2},
                                           {.pixels = 6,
                                            .unchecked = 2,
                                            .unexplained = 1,
                                            .first = {.found = true, .x = 7},
                                            .worst_depth_ratio = 0.7},
                                           {.pixels = 7,
                                            .ambiguous = 3,
                                            .unexplained = 1,
                                            .first = {.found = true, .x = 9},
                                            .worst_depth_ratio = -1}};
    for (int i = 0; i < 3; i++)
        verdict_add(&sum, &tiles[i]);
    CHECK(sum.pixels == 18 && sum.objects == 4 && sum.ambiguous == 3 && sum.unchecked == 2 &&
              sum.unexplained == 2,
          "pixels of tiles add up");
    CHECK_NEAR(sum.worst_depth_ratio, 0.7, 0, "the worst depth of a picture is that of a tile");
    CHECK(sum.first.found && sum.first.x == 7, "the first fault is that of the first tile");
}

/* Bounds are parts of the largest value of a term, and of its mean. */
static void check_terms(const struct plan *plan)
{
    const struct material_terms *made = &plan->materials[0].made;
    CHECK(plan->materials[0].n_colours == 3,
          "ambient light and two lights of one spectrum are three colours, each rounded");
    for (int t = 0; t < made->n; t++) {
        double sum = 0, peak = 0;
        for (int band = 0; band < BANDS; band++) {
            sum += made->spectra[t * BANDS + band];
            peak = fmax(peak, made->spectra[t * BANDS + band]);
        }
        CHECK_NEAR(made->terms[t].mean, sum / BANDS, 1e-15, "the mean of term %d", t);
        CHECK_NEAR(made->terms[t].peak, peak, 0, "its peak");
    }
}

int main(void)
{
    static const char text[] =
        "size 24 16\nwavelengths 400 700 50\ncamera ortho 12\nambient a 0.2\n"
        "light d65 1 position 2 3 8\nlight d65*0.5 0.3 direction 1 0 2\nmaterial m { diffuse 0.5 "
        "}\n"
        "object plane 13 9 material m translate 0 0 -3\n"
        "object sphere 3.1 12 8 material m rotate 20 1 1 0\n";
    const struct plan_options options = {.check = true, .threads = 1};
    struct bench bench = {.limits = {.strict = false}};
    struct error err = {.text = ""};
    test_enter();
    test_need(scene_read(test_write("check.scene", text), &bench.scene, &err) &&
                  plan_make(&bench.scene, NULL, &options, &bench.plan, &err) &&
                  lit_make(&bench.plan, driver_of("softpipe"), &bench.lit, &err) &&
                  find_full_scale(&bench.lit, &err),
              err.text);
    bench.checked = (struct check_scene){.lit = &bench.lit, .limits = &bench.limits};
    const struct rectangle at = {0, 0, WIDTH, HEIGHT};
    test_need(fit_make(&bench.lit, &bench.checked.fit, &err) &&
                  tiles_each(&bench.lit, &at, check_tile, &bench, &err),
              err.text);
    check_mean(&bench);
    check_sum();
    check_terms(&bench.plan);
    fit_free(&bench.checked.fit);
    lit_free(&bench.lit);
    plan_free(&bench.plan);
    scene_free(&bench.scene);
    return test_end();
}
