/* SPDX-License-Identifier: MIT */
/* One geometry explains all bands: errors that weights, or a place in a texture, have in common in
 * all bands are explained within the bound, whatever each band rounds by itself; and an error of
 * one band alone, of twice the floor, is always found. */

#include "data/images/images.h"
#include "raster/check/inside.h"
#include "raster/counts/counts.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "test.h"

enum { MOST_TERMS = 4, BANDS_TRIED = 31, TRIALS = 20000, SIDE = 4 };

/* A plan with one material, and one pixel of it. */
struct bench {
    struct plan plan;
    struct lit_scene lit;
    struct shaded_material shaded;
    struct texture texture;
    struct fit fit;
    struct run run;
    float texels[BANDS_TRIED][2 * SIDE * SIDE];
    double spectra[MOST_TERMS * BANDS_TRIED], rows[MOST_TERMS + TEXEL_PLACE],
        off[MOST_TERMS + TEXEL_PLACE];
    float errors[MOST_TERMS + TEXEL_PLACE], own[MOST_TERMS + TEXEL_PLACE], estimate[MOST_TERMS + 9];
    double difference[BANDS_TRIED], bound[BANDS_TRIED];
    struct textured_sample textured;
};

/* Loads the planes of a band's pass, as plan_load_textures does. */
static void load(struct bench *bench, int band)
{
    for (int c = 0; c < BANDS_PER_PASS; c++) {
        int of = band / BANDS_PER_PASS * BANDS_PER_PASS + c;
        bench->texture.plane[c] = bench->texels[of < bench->plan.n_bands ? of : 0];
    }
}

/* Lets the run keep what the fit asks for. Returns the bound in this band. */
static float evaluate(struct bench *bench, int band)
{
    double expected;
    float bound;
    load(bench, band);
    expect_counts(&bench->lit, &bench->run, band, &expected, &bound);
    return bound;
}

/* `alike`: all terms have nearly the same spectrum, and texels change along the diagonal only.
 * n_levels: of a texture; 0: there is none. */
static bool make(struct bench *bench, uint64_t *state, int n_terms, int n_bands, bool alike,
                 int n_levels)
{
    struct error err;
    *bench = (struct bench){.shaded = {.n_terms = n_terms}};
    bench->shaded.made.spectra = bench->spectra;
    bench->texture =
        (struct texture){.spectral = true, .linear = true, .largest = 1, .n_levels = n_levels};
    bench->texture.image.width = bench->texture.image.height = SIDE;
    bench->shaded.texture = n_levels > 0 ? &bench->texture : NULL;
    bench->plan = (struct plan){.n_bands = n_bands,
                                .n_passes = (n_bands + BANDS_PER_PASS - 1) / BANDS_PER_PASS,
                                .n_materials = 1,
                                .n_light_groups = 1,
                                .max_rows = n_terms + (n_levels > 0 ? TEXEL_PLACE : 0),
                                .materials = &bench->shaded};
    for (int b = 0; b < n_bands; b++) {
        double shared = test_random(state, 0, 1);
        for (int t = 0; t < n_terms; t++)
            bench->spectra[t * n_bands + b] =
                alike ? shared * (1 + test_random(state, 0, 0.01)) : test_random(state, 0, 1);
        for (int i = 0; i < 2 * SIDE * SIDE; i++)
            bench->texels[b][i] = alike ? (float)(shared * (i % SIDE + i / SIDE) / (3 * SIDE))
                                        : (float)test_random(state, 0, 1);
    }
    bench->lit =
        (struct lit_scene){.plan = &bench->plan, .driver = driver_of(NULL), .full_scale = 1};
    return fit_make(&bench->lit, &bench->fit, &err);
}

/* Sets a pixel: weights, the errors that all bands have in common, and those of each band. */
static void draw_pixel(struct bench *bench, uint64_t *state)
{
    int n = bench->shaded.n_terms;
    bool textured = bench->shaded.texture != NULL;
    for (int t = 0; t < n; t++) {
        bench->rows[t] = test_random(state, 0, 1);
        bench->own[t] = (float)(1e-6 * bench->rows[t] + 1e-8);
        double common = textured ? 0 : pow(10, test_random(state, -8, -3)) * bench->rows[t];
        bench->errors[t] = bench->own[t] + (float)common;
        bench->off[t] = test_random(state, -common, common);
    }
    for (int i = n; i < n + TEXEL_PLACE && textured; i++) {
        double error = pow(10, test_random(state, -6, -2));
        bench->rows[i] = (i - n == PLACE_DETAIL ? bench->texture.n_levels - 1 : SIDE) *
                         test_random(state, 0.02, 0.98);
        bench->errors[i] = (float)error;
        bench->off[i] = test_random(state, -error, error);
    }
    bench->run = (struct run){&bench->shaded,  bench->rows, bench->errors, bench->own, 1, 1,
                              &bench->textured};
}

static double radiance_of(struct bench *bench, int band, double part)
{
    int n = bench->shaded.n_terms;
    double sum = 0, place[TEXEL_PLACE];
    for (int i = 0; i < TEXEL_PLACE; i++)
        place[i] = bench->rows[n + i] + part * bench->off[n + i];
    for (int t = 0; t < n; t++)
        sum += (bench->rows[t] + part * bench->off[t]) *
               bench->spectra[t * bench->plan.n_bands + band];
    if (!bench->shaded.texture)
        return FULL_COUNT * sum;
    load(bench, band);
    const struct texels texels = plan_texels(&bench->texture, band % BANDS_PER_PASS);
    return FULL_COUNT * sum * texel_at(&texels, place);
}

static void draw_differences(struct bench *bench, uint64_t *state)
{
    for (int b = 0; b < bench->plan.n_bands; b++) {
        double own = 0;
        for (int t = 0; t < bench->shaded.n_terms; t++)
            own += (double)bench->own[t] * bench->spectra[t * bench->plan.n_bands + b] * FULL_COUNT;
        if (bench->shaded.texture)
            own *= 0.5 * radiance_of(bench, b, 0) / FULL_COUNT; /* less than its bound */
        bench->bound[b] = (double)evaluate(bench, b);
        bench->difference[b] =
            radiance_of(bench, b, 1) - radiance_of(bench, b, 0) + test_random(state, -own, own);
    }
}

static bool is_explained(struct bench *bench, int band, double *floor)
{
    struct fit_block block;
    const float bound = evaluate(bench, band);
    bool fitted = fit_explain(&bench->fit, &bench->run, band, bench->estimate, &bound, &block);
    *floor = fitted ? fmin((double)block.floor[0], bench->bound[band]) : bench->bound[band];
    return fabs(bench->difference[band]) <= bench->bound[band] &&
           (!fitted ||
            fabs(bench->difference[band] - (double)block.explained[0]) <= (double)block.limit[0]);
}

/* Learns from the pilots. Returns how many bands are explained; floors: of each band. */
static int judge(struct bench *bench, double floors[BANDS_TRIED])
{
    int n = 0;
    memset(bench->estimate, 0, sizeof bench->estimate);
    for (int p = 0; p < bench->fit.n_passes; p++)
        for (int c = 0; c < BANDS_PER_PASS; c++) {
            const int b = bench->fit.passes[p] * BANDS_PER_PASS + c;
            if (b >= bench->plan.n_bands)
                continue;
            evaluate(bench, b);
            fit_add(&bench->fit, &bench->run, b, &bench->difference[b], bench->estimate);
        }
    for (int b = 0; b < bench->plan.n_bands; b++)
        n += is_explained(bench, b, &floors[b]);
    return n;
}

static void check_fit(const char *name, int n_terms, int n_bands, bool alike, int n_levels)
{
    uint64_t state = 1;
    int explained = 0, found = 0, narrower = 0, trials = TRIALS / n_bands;
    struct bench bench;
    if (!CHECK(make(&bench, &state, n_terms, n_bands, alike, n_levels), "%s: there are gains",
               name))
        return;
    for (int i = 0; i < trials; i++) {
        double floors[BANDS_TRIED], changed[BANDS_TRIED];
        int band = (int)test_random(&state, 0, n_bands);
        draw_pixel(&bench, &state);
        draw_differences(&bench, &state);
        explained += judge(&bench, floors) == n_bands;
        narrower += floors[band] < 0.5 * bench.bound[band];
        bench.difference[band] += (i % 2 ? 2.001 : -2.001) * floors[band];
        found += judge(&bench, changed) < n_bands;
    }
    CHECK(explained == trials, "%s: errors that all bands have in common are explained", name);
    CHECK(found == trials, "%s: an error of one band, of twice the floor, is found", name);
    if (n_bands > 3 * n_terms)
        CHECK(narrower > trials * (n_levels > 0 ? 3 : 1) / 4,
              "%s: the floor of one band is often less than half the bound", name);
    printf("# %s: %d of %d explained, %d found, %d narrower\n", name, explained, trials, found,
           narrower);
    fit_free(&bench.fit);
}

/* A buffer of steps cuts each of two passes off at full scale: of 1.5 full scales it keeps 1
 * to 1.5.
 */
static void check_steps(void)
{
    uint64_t state = 2;
    struct bench bench;
    test_need(make(&bench, &state, 1, 1, false, 0), "no memory");
    bench.plan.n_light_groups = 2;
    bench.plan.options.buffer_bits = 8;
    draw_pixel(&bench, &state);
    bench.rows[0] = 1.5 / bench.spectra[0];
    bench.errors[0] = 0;
    double expected;
    float bound;
    expect_counts(&bench.lit, &bench.run, 0, &expected, &bound);
    CHECK_NEAR(expected, 1.25 * FULL_COUNT, 0.01,
               "what a buffer cuts off is expected in the middle");
    CHECK_NEAR((double)bound, (0.25 + 2 * (0.5 / 255)) * FULL_COUNT, 0.1,
               "its bound takes in all that it may keep, and half a step of each pass");
    fit_free(&bench.fit);
}

/* (r + e)(v + f) - r v, of a radiance r off by e and a texture's value v off by f. */
static void check_textured(void)
{
    uint64_t state = 3;
    struct bench bench;
    test_need(make(&bench, &state, 1, 1, false, 1), "no memory");
    draw_pixel(&bench, &state);
    bench.errors[0] = (float)(0.5 * bench.rows[0]);
    bench.errors[1] = bench.errors[2] = 0.4F;
    const double bound = (double)evaluate(&bench, 0), r = bench.textured.radiance,
                 v = bench.textured.texel.value, f = bench.textured.texel.error;
    CHECK_NEAR(bound / ((1.5 * r) * (v + f) - r * v), 1, 1e-6,
               "the bound of a textured sample takes in both errors, and their product");
    fit_free(&bench.fit);
}

/* Lets the run keep a straight texture of this slope, off by `rest` besides. */
static void keep_slope(struct bench *bench, const double slope[TEXEL_PLACE], double rest)
{
    bench->textured = (struct textured_sample){.texel = {.is_straight = true, .rest = rest}, 1, 0};
    memcpy(bench->textured.texel.slope, slope, sizeof bench->textured.texel.slope);
}

/* Places as far off as they may be, where slopes are more and more alike in all bands, and up to
 * 10^5 times what each band is off by itself, so that sums in single precision are too rough. */
static void check_alike(void)
{
    uint64_t state = 4;
    int wrong = 0;
    double slope[BANDS_TRIED][TEXEL_PLACE], rest[BANDS_TRIED];
    struct bench bench;
    test_need(make(&bench, &state, 1, 30, false, 3), "no memory");
    draw_pixel(&bench, &state);
    for (int i = 0; i < TRIALS / 30; i++) {
        const double apart = pow(10, test_random(&state, -6, 0)),
                     ratio = pow(10, test_random(&state, 0, 5));
        double base[TEXEL_PLACE], off[TEXEL_PLACE];
        for (int k = 0; k < TEXEL_PLACE; k++) {
            base[k] = test_random(&state, -1, 1);
            bench.errors[1 + k] = (float)pow(10, test_random(&state, -3, -0.3));
            off[k] = (double)bench.errors[1 + k] * (test_random(&state, -1, 1) < 0 ? -1 : 1);
        }
        for (int b = 0; b < bench.plan.n_bands; b++) {
            const double size = test_random(&state, 0.2, 1);
            bench.difference[b] = rest[b] = 0;
            for (int k = 0; k < TEXEL_PLACE; k++) {
                slope[b][k] = size * base[k] + apart * test_random(&state, -1, 1);
                rest[b] += fabs(slope[b][k] * off[k]) / ratio;
                bench.difference[b] += slope[b][k] * off[k];
            }
            bench.difference[b] += test_random(&state, -rest[b], rest[b]);
        }
        memset(bench.estimate, 0, sizeof bench.estimate);
        for (int p = 0; p < bench.fit.n_pilots; p++) {
            const int b = bench.fit.pilots[p];
            keep_slope(&bench, slope[b], rest[b]);
            fit_add(&bench.fit, &bench.run, b, &bench.difference[b], bench.estimate);
        }
        for (int b = 0; b < bench.plan.n_bands; b++) {
            const float none = HUGE_VALF;
            struct fit_block block;
            keep_slope(&bench, slope[b], rest[b]);
            wrong +=
                !fit_explain(&bench.fit, &bench.run, b, bench.estimate, &none, &block) ||
                !(fabs(bench.difference[b] - (double)block.explained[0]) <= (double)block.limit[0]);
        }
    }
    CHECK(wrong == 0, "slopes that are alike in all bands explain them within the bound: %d do not",
          wrong);
    fit_free(&bench.fit);
}

int main(void)
{
    check_steps();
    check_alike();
    check_textured();
    check_fit("one term", 1, 31, false, 0);
    check_fit("two terms", 2, 31, false, 0);
    check_fit("four terms", 4, 31, false, 0);
    check_fit("two terms that are nearly alike", 2, 31, true, 0);
    check_fit("more terms than bands", 4, 3, false, 0);
    check_fit("one band", 1, 1, false, 0);
    check_fit("bands that fill no pass", 2, 7, false, 0);
    check_fit("a texture that differs from band to band", 2, 30, false, 1);
    check_fit("a texture that changes along its diagonal", 2, 30, true, 1);
    check_fit("a texture with mipmaps", 2, 30, false, 3);
    return test_end();
}
