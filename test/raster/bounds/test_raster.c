/* SPDX-License-Identifier: MIT */
/* Clipping neither loses nor doubles any area; counts, floors and exactness are judged as they
 * should be. */

#include "data/maths/maths.h"
#include "raster/bounds/inside.h"
#include "raster/candidates/inside.h"
#include "raster/check/inside.h"
#include "raster/counts/counts.h"
#include "raster/reference/reference.h"
#include "raster/renderers/renderers.h"
#include "test.h"

static void random_triangle(uint64_t *state, struct corner out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = (struct corner){.inner = i, .outer = i};
        for (int j = 0; j < 4; j++)
            out[i].clip[j] = test_random(state, -2, 2);
        out[i].share[i] = 1;
    }
}

/* Clips a triangle by planes, one after the other. */
static int clip_triangle(const struct corner whole[3], const struct clip_plane *planes,
                         int n_planes, struct corner out[CLIP_CORNERS])
{
    struct corner from[CLIP_CORNERS];
    int n = 3;
    memcpy(out, whole, 3 * sizeof *out);
    for (int p = 0; p < n_planes && n > 0; p++) {
        memcpy(from, out, (size_t)n * sizeof *out);
        n = clip_polygon(&planes[p], from, n, out);
    }
    return n;
}

/* Returns the area in barycentric coordinates, as a fraction of the whole triangle's. */
static double part_of(const struct corner *corners, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) {
        const double *a = corners[i].share, *b = corners[(i + 1) % n].share;
        sum += a[0] * b[1] - b[0] * a[1];
    }
    return sum;
}

static void check_clipping(void)
{
    uint64_t state = 1;
    double worst_area = 0, worst_share = 0;
    bool same = true;
    for (int i = 0; i < 1000; i++) {
        struct corner whole[3], inner[CLIP_CORNERS], outer[CLIP_CORNERS];
        struct clip_plane plane = {{0, 0, 0, 1}, 0.25}, other = plane;
        random_triangle(&state, whole);
        for (int j = 0; j < 4; j++) {
            plane.normal[j] = test_random(&state, -1, 1);
            other.normal[j] = -plane.normal[j];
        }
        other.offset = -plane.offset;
        int n_inner = clip_triangle(whole, &plane, 1, inner);
        int n_outer = clip_triangle(whole, &other, 1, outer);
        worst_area = fmax(worst_area, fabs(part_of(inner, n_inner) + part_of(outer, n_outer) - 1));
        for (int c = 0; c < n_inner; c++)
            worst_share = fmax(worst_share,
                               fabs(inner[c].share[0] + inner[c].share[1] + inner[c].share[2] - 1));
        /* the neighbour across edge 0-1 runs along it the other way */
        struct corner neighbour[3] = {whole[1], whole[0], whole[2]}, its[CLIP_CORNERS];
        int n_its = clip_triangle(neighbour, &plane, 1, its), found = 0, cuts = 0;
        for (int a = 0; a < n_inner; a++)
            for (int b = 0; b < n_its && inner[a].inner != inner[a].outer; b++)
                found += memcmp(inner[a].clip, its[b].clip, sizeof its[b].clip) == 0;
        for (int a = 0; a < n_inner; a++)
            cuts += inner[a].inner != inner[a].outer;
        same = same && found == cuts;
    }
    CHECK_NEAR(worst_area, 0, 1e-13, "the parts on both sides of a plane add up to the triangle");
    CHECK_NEAR(worst_share, 0, 1e-14, "the barycentric coordinates of cut corners add up to 1");
    CHECK(same, "an edge is cut at the same corner, to the bit, in either direction");

    struct corner whole[3], left[CLIP_CORNERS];
    struct clip_plane behind = {{0, 0, 0, 0}, -1};
    random_triangle(&state, whole);
    CHECK(clip_triangle(whole, &behind, 1, left) == 0, "a triangle outside leaves nothing");
    CHECK(clip_triangle(whole, NULL, 0, left) == 3 && memcmp(left, whole, sizeof whole) == 0,
          "clipping without planes does not change the triangle");
}

/* A triangle lies in the plane z = w: rounding puts its corners inside and outside in turns. */
static void check_flat_clipping(void)
{
    static const struct clip_plane planes[CLIP_PLANES] = {{{-1, 0, 0, 1}, 0}, {{1, 0, 0, 1}, 0},
                                                          {{0, -1, 0, 1}, 0}, {{0, 1, 0, 1}, 0},
                                                          {{0, 0, 1, 1}, 0},  {{0, 0, -1, 1}, 0}};
    struct corner whole[3] = {{.clip = {0x1.310f317f9f898p+0, 0x1.30f8f02e9aa14p+0,
                                        0x1.ca49ed019493ep-1, 0x1.ca49ed019493ep-1}},
                              {.clip = {-0x1.fd9714106d45p+0, 0x1.5aba43a7a9ecp-4,
                                        0x1.1c0cfbe1381a1p+0, 0x1.1c0cfbe1381ap+0}},
                              {.clip = {0x1.24b883bb506edp-2, -0x1.a9367f3ec2542p-1,
                                        0x1.0ddf47381bbeap-1, 0x1.0ddf47381bbe9p-1}}};
    struct corner left[CLIP_CORNERS];
    int most = clip_triangle(whole, planes, CLIP_PLANES, left);
    uint64_t state = 3;
    for (int i = 0; i < 300000; i++) {
        random_triangle(&state, whole);
        for (int c = 0; c < 3; c++) {
            double *clip = whole[c].clip;
            clip[3] = fabs(clip[3]);
            clip[2] = clip[3] * (1 + (double)(i % 3 - 1) * 0x1p-52);
        }
        int n = clip_triangle(whole, planes, CLIP_PLANES, left);
        most = n > most ? n : most;
    }
    CHECK(most > 5 && most <= CLIP_CORNERS,
          "a triangle in a clipping plane keeps at most as many corners as there is room for");
}

static void check_exactness(void)
{
    const double last_bit[] = {1, 0x1p-23}, beyond[] = {1, 0x1p-24}, signs[] = {1, -1, 0x1p-30},
                 halves[] = {0.5, 0.25, 8192}, denormal[] = {0x1p-140}, zeros[] = {0, 0};
    CHECK(exact_sum(last_bit, 2) && !exact_sum(beyond, 2),
          "a sum that spans 24 bits is exact, a wider one is not");
    CHECK(!exact_sum(signs, 3),
          "terms that cancel count, too, since the driver may add them in another order");
    CHECK(exact_sum(halves, 3) && exact_sum(zeros, 2), "short fractions and zeros are exact");
    CHECK(!exact_sum(denormal, 1), "a value that single precision flushes to 0 is not exact");
    const double row[4] = {0.5, -0.25, 3, 1}, tenth[4] = {0.1, 0, 0, 1}, v[4] = {1, 2, 3, 1};
    CHECK(exact_row(row, v) && !exact_row(tenth, v), "single precision does not hold a tenth");
    struct matrix turned = matrix_rotation(30, (struct vector){0, 0, 1}),
                  doubled = matrix_scaling((struct vector){2, 2, 2});
    CHECK(exact_product(&doubled, &doubled) && !exact_product(&doubled, &turned),
          "single precision does not hold a rotation by 30 degrees");
}

static void check_drivers(void)
{
    const struct driver *llvmpipe = driver_of("llvmpipe (LLVM 15.0.6, 256 bits)"),
                        *softpipe = driver_of("softpipe"), *unknown = driver_of("Mesa Foo");
    CHECK_TEXT(llvmpipe->name, "llvmpipe", "a driver is identified by the beginning of its name");
    CHECK_TEXT(unknown->name, "unknown", "any other name is an unknown driver");
    CHECK(driver_of(NULL) == unknown, "a missing name is an unknown driver");
    CHECK(unknown->grid_px >= llvmpipe->grid_px && unknown->grid_px >= softpipe->grid_px &&
              unknown->edge_roundings >= llvmpipe->edge_roundings &&
              unknown->edge_roundings >= softpipe->edge_roundings &&
              unknown->depth_roundings >= llvmpipe->depth_roundings &&
              unknown->depth_roundings >= softpipe->depth_roundings && !unknown->watertight &&
              unknown->fill_rule == FILL_ANY,
          "an unknown driver gets the widest of all bounds");
    struct driver now = *softpipe, older = *softpipe;
    driver_of_version(&now, "3.3 (Compatibility Profile) Mesa 22.3.6");
    driver_of_version(&older, "3.1 Mesa 20.3.5");
    CHECK(now.detail.logarithm == LOGARITHM_TABLE && now.detail_error == 0 &&
              older.detail.logarithm == LOGARITHM_EXACT && older.detail_error > 0,
          "softpipe of an older Mesa has another logarithm");
}

/* Counts that agree are counted as they are stored, whether a block needs clamping or not, and
 * whether or not other blocks had larger errors before. */
static void check_agreement(const char *name, const double *seen, const double *expected, size_t n,
                            double worst)
{
    static struct block block;
    float parts[BLOCK];
    struct check_samples samples = {
        .largest = fmax(worst, 0), .worst_ratio = worst, .worst_fit_ratio = worst};
    uint64_t exact = 0, within_1 = 0;
    block.n = n;
    block.seen = parts;
    for (size_t i = 0; i < n; i++) {
        parts[i] = (float)(seen[i] / FULL_COUNT);
        block.fit.explained[i] = 0;
        block.fit.limit[i] = HUGE_VALF;
        const int apart = counts_round((double)parts[i] * FULL_COUNT) - counts_round(expected[i]);
        block.expected[i] = expected[i];
        block.bound[i] = 4;
        exact += apart == 0;
        within_1 += apart >= -1 && apart <= 1;
    }
    const bool within = samples_compare(&samples, &block);
    CHECK(samples.n == n && samples.exact == exact && samples.within_1 == within_1,
          "%s: %llu of %zu are exact, %llu within 1", name, (unsigned long long)exact, n,
          (unsigned long long)within_1);
    bool all = true;
    for (size_t i = 0; i < n; i++)
        all = all && fabs(seen[i] - expected[i]) <= 4;
    CHECK(within == all, "%s: samples outside of their bounds are noticed, NaN too", name);
}

static void check_agreements(void)
{
    const double ties[] = {0.5, 1.5, 2.5, 0.49999999, 32767.5, 65534.5, 65535, 0},
                 near[] = {0.5, 1.4999, 2.5001, 0.5, 32767.4, 65534.6, 65535.2, -0.3};
    const double outside[] = {-1, 65536, 70000, 0, 65535.4, (double)NAN, 3, 5, 131070},
                 beside[] = {0, 65535, 65534, -0.6, 65535.6, 0, 4.2, 3, 131070};
    const double close[] = {0.49, 0.51, 1.5, 65534.49, 65534.51, 300.2},
                 by[] = {0.51, 0.49, 1.49, 65534.51, 65534.49, 300.21};
    const double white[] = {65535.4, 65536.6, 65535, 3}, whiter[] = {65535.6, 65536.4, 65535.2, 3},
                 black[] = {-1.6, -0.6, 0, 3}, blacker[] = {-1.4, -0.4, -0.2, 3};
    for (int worst = -1; worst <= 1; worst += 2) {
        check_agreement("ties", ties, near, 8, worst);
        check_agreement("ties, the other way round", near, ties, 8, worst);
        check_agreement("samples that are close", close, by, 6, worst);
        check_agreement("samples that are close beyond white", white, whiter, 4, worst);
        check_agreement("samples that are close beyond black", black, blacker, 4, worst);
        check_agreement("samples beyond black and white", outside, beside, 9, worst);
        check_agreement("samples far apart", outside + 6, beside + 6, 2, worst);
    }
}

static void check_floor(void)
{
    static struct check_floor floor;
    for (int i = 1; i <= 1000; i++)
        floor_note(&floor, i * 0.01);
    CHECK(floor.n == 1000 && floor.worst >= 10 && floor.worst <= 10,
          "a floor counts pixels and keeps the worst");
    for (int part = 1; part <= 9; part++) {
        double at = floor_quantile(&floor, 0.1 * part);
        CHECK(
            at >= part * 0.9999 && at <= part * 1.13,
            "%d0 %% of the pixels lie below the printed bound, which is at most an eighth too high",
            part);
    }
    floor_note(&floor, HUGE_VAL);
    CHECK(floor.bins[FLOOR_BINS - 1] == 1 && isinf(floor.worst), "an infinite floor is the worst");
}

int main(void)
{
    check_exactness();
    check_drivers();
    check_agreements();
    check_floor();
    check_clipping();
    check_flat_clipping();
    struct clipped_triangle line = {
        .screen = {.x = {0, 10, 20}, .y = {0, 10, 20}, .inverse_w = {1, 1, 1}},
        .slack_px = {1e-4, 1e-4, 1e-4},
        .reach_x = 100,
        .reach_y = 100};
    bound_inverse_w(&line);
    CHECK(line.magnification == HUGE_VAL, "a triangle without area has no bound");
    return test_end();
}
