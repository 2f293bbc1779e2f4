/* SPDX-License-Identifier: MIT */
/* Compares samplings with the sum over every nm: they are exact where they must be, keep their
 * tolerance, and survive hard cases. sampling.py computes each method once more;
 * test/cases/bad/commands.cases has those that are refused. */
#include "data/base/base.h"
#include "data/files/files.h"
#include "data/maths/maths.h"
#include "data/sampling/inside.h"
#include "spectral.h"
#include "spectra.h"

/* ---- scenes of one light and some reflectances ---- */

enum { MOST_SURFACES = 32, MOST_NM = 601, MOST_PAGES = MOST_NM };
struct stage {
    struct fine_spectra fine;
    struct spectrum light, surface[MOST_SURFACES];
    int n; /* surfaces */
};

static void put_light(struct stage *stage, const char *light, double first, int n_nm)
{
    struct fine_spectra *fine = &stage->fine;
    stage->light = spectrum_of(light);
    *fine = (struct fine_spectra){.first_nm = first, .n_nm = n_nm, .n_lights = 1};
    fine->lights = calloc((size_t)n_nm, sizeof *fine->lights);
    fine->products = calloc((size_t)n_nm * MOST_SURFACES, sizeof *fine->products);
    for (int j = 0; j < n_nm; j++)
        fine->lights[j] = spectrum_at(&stage->light, first + j, SPECTRUM_ZERO);
}

static void put_surface(struct stage *stage, const char *text)
{
    struct fine_spectra *fine = &stage->fine;
    stage->surface[stage->n] = spectrum_of(text);
    for (int j = 0; j < fine->n_nm; j++)
        fine->products[stage->n * fine->n_nm + j] =
            fine->lights[j] *
            spectrum_at(&stage->surface[stage->n], fine->first_nm + j, SPECTRUM_HOLD);
    fine->n_products = ++stage->n;
}

/* Makes a scene of the ColorChecker's patches under a light. */
static struct stage chart(const char *light, double first, int n_nm)
{
    static const char folder[] = "materials/colorchecker/";
    struct stage stage = {.n = 0};
    put_light(&stage, light, first, n_nm);
    for (size_t i = 0; i < builtin_file_count && stage.n < MOST_SURFACES; i++) {
        char path[256];
        if (strncmp(builtin_files[i].name, folder, strlen(folder)) == 0 &&
            strstr(builtin_files[i].name, ".txt") != NULL) {
            snprintf(path, sizeof path, "builtin:%s", builtin_files[i].name);
            put_surface(&stage, path);
        }
    }
    return stage;
}

static struct stage single(const char *light, const char *surface, double first, int n_nm)
{
    struct stage stage = {.n = 0};
    put_light(&stage, light, first, n_nm);
    put_surface(&stage, surface);
    return stage;
}

static void clear(struct stage *stage)
{
    spectrum_free(&stage->light);
    for (int i = 0; i < stage->n; i++)
        spectrum_free(&stage->surface[i]);
    FREE_ALL(stage->fine.lights, stage->fine.products);
}

/* ---- making and using samplings ---- */

/* Returns a zeroed sampling and fills err after an error. */
static struct sampling sampling_of(const struct stage *stage, const char *text,
                                   const char *detector, struct error *err)
{
    struct sampling_method method;
    struct sampling out = {.detector = NULL};
    *err = (struct error){0};
    if (sampling_read("--sampling", text, &method, err))
        sampling_make(&method, detector, &stage->fine, &out, err);
    return out;
}

static struct sampling made(const struct stage *stage, const char *text)
{
    struct error err;
    struct sampling out = sampling_of(stage, text, "cie1931", &err);
    if (out.pages.n == 0)
        printf("# %s\n", err.text);
    return out;
}

/* Computes one page of a surface in the light: the product of both page values, or a component of
 * the product. */
static double page_of(const struct stage *stage, const struct sampling *s, int surface, int page)
{
    const struct spectral_pages pages = s->pages;
    double sum = 0;
    if (!s->pages.of_products)
        return page_value(&pages, &stage->light, page, SPECTRUM_ZERO) *
               page_value(&pages, &stage->surface[surface], page, SPECTRUM_HOLD);
    for (int j = 0; j < s->fine.n; j++)
        sum +=
            s->pages.analysis[page * s->fine.n + j] * stage->fine.products[surface * s->fine.n + j];
    return sum;
}

static void channels_of(const struct stage *stage, const struct sampling *s, int surface,
                        double out[3])
{
    double pages[MOST_PAGES];
    for (int page = 0; page < s->pages.n; page++)
        pages[page] = page_of(stage, s, surface, page);
    detector_response(s->weights, pages, s->pages.n, out);
}

/* Returns the largest error of all channels of all surfaces, relative to the light's largest
 * response. */
static double worst_error(const struct stage *stage, const struct sampling *s)
{
    const int n = s->fine.n;
    double worst = 0, light[3];
    if (s->pages.n == 0)
        return HUGE_VAL;
    detector_response(s->fine.weights, stage->fine.lights, n, light);
    const double scale = fmax(light[0], fmax(light[1], light[2]));
    for (int i = 0; i < stage->n; i++) {
        double seen[3], exact[3];
        channels_of(stage, s, i, seen);
        detector_response(s->fine.weights, stage->fine.products + i * n, n, exact);
        for (int channel = 0; channel < 3; channel++)
            worst = fmax(worst, fabs(seen[channel] - exact[channel]) / scale);
    }
    return worst;
}

static int pages_of(const struct stage *stage, const char *text)
{
    struct sampling s = made(stage, text);
    const int n = s.pages.n;
    sampling_free(&s);
    return n;
}

/* ---- known errors ---- */

static void test_tolerances(const char *light, int n_peaks)
{
    static const char *const names[] = {"adaptive:0.1", "adaptive:0.01", "adaptive:0.001",
                                        "adaptive:1e-06", "adaptive:1e-09"};
    struct stage stage = chart(light, 360, 441);
    int most = 0;
    bool within = true;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct sampling s = made(&stage, names[i]);
        within = within && worst_error(&stage, &s) <= s.method.number;
        most = s.pages.n > most ? s.pages.n : most;
        if (i == 0)
            CHECK(s.n_peaks == n_peaks, "%s has %d emission peaks", light, n_peaks);
        sampling_free(&s);
    }
    CHECK(within, "%s: adaptive keeps every tolerance", light);
    CHECK(most <= 441, "%s: adaptive has at most one page for each nm", light);
    clear(&stage);
}

static void test_adaptive(void)
{
    test_tolerances("d65", 0);
    test_tolerances("a", 0);
    test_tolerances("1", 0);
    test_tolerances("blackbody:2000", 0);
    test_tolerances("blackbody:20000", 0);
    test_tolerances("gaussian:546,4", 1);
    test_tolerances("gaussian:546.5,1", 1);
    test_tolerances("fluorescent", 3);
}

/* Pages cost time. The sufficient number is known for simple lights. */
static void test_few_pages(void)
{
    struct stage tube = chart("fluorescent", 380, 401), day = chart("d65", 380, 401);
    struct stage narrow = chart("gaussian:546.5,0.5", 380, 401);
    const int coarse = pages_of(&tube, "adaptive:0.1"), fine = pages_of(&tube, "adaptive:0.01");
    CHECK(pages_of(&narrow, "adaptive:0.001") <= 4,
          "a line of 2 nm has a page for each nm, and one on either side");
    CHECK(coarse <= 8 && fine <= 34 && fine > coarse,
          "the tube needs at most 8 pages, and 34 for the smaller tolerance");
    CHECK(pages_of(&day, "adaptive:0.01") <= 17, "daylight needs at most 17 pages");
    printf("# tube %d and %d\n", coarse, fine);
    clear(&tube);
    clear(&day);
    clear(&narrow);
}

static void test_peaks(void)
{
    test_write("lamp.csv",
               "nm,power\n380,1\n439,1\n440,9\n442,9\n443,1\n545,1\n550,3\n555,1\n640,1\n"
               "645,1.7\n650,1\n680,1\n700,2.3\n720,1\n745,1\n750,1.45\n755,1\n780,1\n");
    struct stage stage = single("lamp.csv", "0.5", 380, 401);
    struct sampling s = made(&stage, "adaptive:0.01");
    CHECK(s.n_peaks == 4 && s.peak_nm[0] == 440 && s.peak_nm[1] == 550 && s.peak_nm[2] == 645 &&
              s.peak_nm[3] == 700,
          "a peak exceeds its neighbours by half the mean; a flat one lies at its first nm");
    sampling_free(&s);
    clear(&stage);
}

/* A scene has a dim light and then a bright one: errors under the dim light are relative to the dim
 * light. */
static void test_dim_light(void)
{
    struct stage stage = single("1*0.001", "gaussian:610,6", 380, 401);
    double *lights = realloc(stage.fine.lights, 2 * 401 * sizeof *lights);
    for (int j = 0; lights != NULL && j < 401; j++)
        lights[401 + j] = 1;
    stage.fine.lights = lights;
    stage.fine.n_lights = 2;
    struct sampling s = made(&stage, "adaptive:0.001");
    CHECK(worst_error(&stage, &s) <= 0.001, "the tolerance is relative to the light that shines");
    sampling_free(&s);
    clear(&stage);
}

/* Returns the sum of squared errors of a surface's radiances, made again from its pages. */
static double squared_error(const struct stage *stage, const struct sampling *s, int surface)
{
    double sum = 0;
    for (int j = 0; j < s->fine.n; j++) {
        double error = -stage->fine.products[surface * s->fine.n + j];
        for (int page = 0; page < s->pages.n; page++)
            error += s->synthesis[j * s->pages.n + page] * page_of(stage, s, surface, page);
        sum += error * error;
    }
    return sum;
}

/* Returns by how much rounding of pages up to `largest_page` changes radiances, relative to the
 * brightest. */
static double magnified(const struct stage *stage, const struct sampling *s, double largest_page)
{
    double brightest = 0, worst = 0;
    for (int i = 0; i < stage->n * s->fine.n; i++)
        brightest = fmax(brightest, stage->fine.products[i]);
    for (int j = 0; j < s->fine.n; j++) {
        double sum = 0;
        for (int page = 0; page < s->pages.n; page++)
            sum += fabs(s->synthesis[j * s->pages.n + page]);
        worst = fmax(worst, sum * largest_page / brightest);
    }
    return worst;
}

static void check_basis(const char *light, struct stage stage)
{
    double least = 0, largest = 0, before = HUGE_VAL, worst = 0, most = 0;
    bool falls = true;
    for (int k = 1; k <= 24; k++) {
        char name[32];
        double sum = 0;
        snprintf(name, sizeof name, "basis:%d", k);
        struct sampling s = made(&stage, name);
        for (int i = 0; i < stage.n; i++) {
            sum += squared_error(&stage, &s, i);
            for (int page = 0; page < s.pages.n; page++) {
                const double value = page_of(&stage, &s, i, page);
                least = fmin(least, value);
                largest = fmax(largest, value);
            }
        }
        falls = falls && (sum < before || s.pages.n < k);
        before = sum;
        worst = worst_error(&stage, &s);
        most = fmax(most, magnified(&stage, &s, largest));
        sampling_free(&s);
    }
    CHECK(least >= -1e-13 * largest, "%s: no product has a negative component", light);
    CHECK(most <= 30, "%s: rounding errors are magnified by at most 30: %g", light, most);
    CHECK(falls, "%s: with every component the rms error of radiances falls", light);
    CHECK_NEAR(sqrt(before), 0, 1e-10,
               "%s: with as many components as the rank, radiances are exact", light);
    CHECK_NEAR(worst, 0, 1e-10, "%s: with as many components as the rank, channels are exact",
               light);
    clear(&stage);
}

static void test_basis(void)
{
    static const char *const lights[] = {"d65", "fluorescent", "gaussian:546,4"};
    struct stage apart = {.n = 0};
    for (int i = 0; i < 3; i++)
        check_basis(lights[i], chart(lights[i], 380, 401));
    put_light(&apart, "1", 430, 61);
    for (int i = 0; i < 12; i++) {
        char text[64];
        snprintf(text, sizeof text, "gaussian:%d,%d*1e-%d", 430 + 17 * i % 60, 4 + i % 7, i % 3);
        put_surface(&apart, text);
    }
    check_basis("separate spectra", apart);
}

/* Polynomials of the wavelength, up to a degree, give exact responses. */
static void check_polynomials(const struct stage *stage, const char *text, int degree)
{
    struct sampling s = made(stage, text);
    double worst = s.pages.n > 0 ? 0 : HUGE_VAL;
    for (int k = 0; k <= degree; k++)
        for (int channel = 0; channel < 3; channel++) {
            double exact = 0, seen = 0;
            for (int j = 0; j < s.fine.n; j++)
                exact += s.fine.weights[channel * s.fine.n + j] * power(s.fine.nm[j] / 800, k);
            for (int page = 0; page < s.pages.n; page++)
                seen += s.weights[channel * s.pages.n + page] *
                        power(s.pages.wavelength_nm[page] / 800, k);
            worst = fmax(worst, fabs(seen - exact));
        }
    CHECK_NEAR(worst, 0, 1e-9, "%s is exact for polynomials of degree %d", text, degree);
    sampling_free(&s);
}

static void test_polynomials(void)
{
    struct stage stage = chart("d65", 380, 401);
    check_polynomials(&stage, "gauss:8", 7);
    check_polynomials(&stage, "gauss:8,open", 7);
    check_polynomials(&stage, "gauss:9,xyz", 5);
    check_polynomials(&stage, "gauss:10,xyz", 5);
    check_polynomials(&stage, "gauss:9,lms", 5);
    check_polynomials(&stage, "gauss:6,acc", 3);
    check_polynomials(&stage, "gauss:7,acc", 3);
    clear(&stage);
}

/* ---- hard cases ---- */

static const char *const all[] = {
    "box:8",       "riemann:10",  "gauss:1",       "gauss:8",        "gauss:64", "gauss:8,open",
    "gauss:9,xyz", "gauss:9,lms", "adaptive:0.01", "adaptive:1e-09", "basis:1",  "basis:9",
    "rgb",         "xyz"};
static const char *const all_exact[] = {"riemann:1", "adaptive:0.0001", "basis:24"};
enum { ALL = sizeof all / sizeof all[0], EXACT = sizeof all_exact / sizeof all_exact[0] };

static bool finite_all(const double *values, size_t count)
{
    bool good = true;
    for (size_t i = 0; i < count && values != NULL; i++)
        good = good && isfinite(values[i]);
    return good;
}

static bool is_sound(const struct sampling *s)
{
    const size_t pages = (size_t)s->pages.n, cells = pages * (size_t)s->fine.n;
    bool good = s->pages.n >= 1 && finite_all(s->weights, 3 * pages) &&
                finite_all(s->pages.analysis, cells) && finite_all(s->synthesis, cells) &&
                finite_all(s->pages.reflectance_analysis, cells) &&
                finite_all(s->pages.wavelength_nm, pages);
    for (int i = 1; i < s->pages.n; i++)
        good = good && s->pages.wavelength_nm[i] > s->pages.wavelength_nm[i - 1];
    return good;
}

/* Each sampling is finite, with increasing wavelengths, or refused; those that promise it are
 * exact. */
static void check_all(const char *what, const struct stage *stage)
{
    bool sound = true, exact = true;
    for (int i = 0; i < ALL + EXACT; i++) {
        struct error err;
        const char *name = i < ALL ? all[i] : all_exact[i - ALL];
        struct sampling s = sampling_of(stage, name, "cie1931", &err);
        const double worst = s.pages.n > 0 ? worst_error(stage, &s) : 0;
        sound =
            sound && (s.pages.n == 0 ? err.status == EXIT_INPUT : is_sound(&s) && isfinite(worst));
        exact = exact && (i < ALL || (s.pages.n > 0 && worst <= 1e-4));
        if (!sound || !exact)
            printf("# %s: %g %s\n", name, worst, err.text);
        sampling_free(&s);
    }
    CHECK(sound, "%s: all samplings are finite, with increasing wavelengths, or refused", what);
    CHECK(exact, "%s: samplings of every nm, within a tolerance, and of all components are exact",
          what);
}

static void test_hard(void)
{
    test_write("lamp.csv", "nm,power\n380,0\n540,0\n545,1\n550,0\n730,0\n");
    const struct {
        const char *what, *light, *one, *two;
        double first;
        int n;
    } cases[] = {
        {"identical spectra", "d65", "gaussian:600,80*0.8", "gaussian:600,80*0.8", 380, 351},
        {"nothing but black", "d65", "0", "0", 380, 351},
        {"one wavelength", "d65", "gaussian:600,80*0.8", "gaussian:520,90*0.6", 550, 1},
        {"two neighbours", "d65", "gaussian:600,80*0.8", "gaussian:520,90*0.6", 550, 2},
        {"a faint light", "d65*1e-30", "gaussian:600,80*0.8", "gaussian:520,90*0.6", 380, 351},
        {"a bright light", "d65*1e30", "gaussian:600,80*0.8", "gaussian:520,90*0.6", 380, 351},
        {"a line of 2 nm", "gaussian:546,2", "gaussian:600,80*0.8", "gaussian:520,90*0.6", 380,
         351},
        {"one sample in a coarse table", "lamp.csv", "gaussian:600,80*0.8", "gaussian:520,90*0.6",
         380, 351}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct stage stage = single(cases[i].light, cases[i].one, cases[i].first, cases[i].n);
        put_surface(&stage, cases[i].two);
        check_all(cases[i].what, &stage);
        clear(&stage);
    }
}

static void test_black(void)
{
    struct stage stage = single("0", "0.5", 380, 401);
    for (int i = 0; i < ALL; i++) {
        struct sampling s = made(&stage, all[i]);
        double seen[3] = {1, 1, 1};
        channels_of(&stage, &s, 0, seen);
        CHECK(is_sound(&s) && seen[0] == 0 && seen[1] == 0 && seen[2] == 0,
              "%s: an all-black scene is black", all[i]);
        if (s.method.kind == SAMPLING_BASIS)
            CHECK(s.pages.n == 1 && s.rank == 0, "an all-black scene has one component of rank 0");
        sampling_free(&s);
    }
    clear(&stage);
}

static void test_line(void)
{
    test_write("lamp.csv", "nm,power\n380,0\n554,0\n555,1\n556,0\n780,0\n");
    struct stage stage = chart("lamp.csv", 380, 401);
    struct sampling s = made(&stage, "adaptive:0.001"), basis = made(&stage, "basis:9");
    CHECK(s.n_peaks == 1 && s.peak_nm[0] == 555, "a light of a single sample is a peak");
    CHECK_NEAR(worst_error(&stage, &s), 0, 1e-3, "adaptive resolves the single sample");
    CHECK(basis.rank == 1 && basis.pages.n == 1, "its products have rank 1");
    CHECK_NEAR(worst_error(&stage, &basis), 0, 1e-12, "one component of the single line is exact");
    check_all("a single line", &stage);
    sampling_free(&s);
    sampling_free(&basis);
    clear(&stage);
}

static void test_rank(void)
{
    struct stage stage = single("1", "1", 380, 401);
    put_surface(&stage, "gaussian:450,100*1e-10");
    put_surface(&stage, "gaussian:650,100*1e-14");
    struct sampling s = made(&stage, "basis:3");
    CHECK(s.rank == 2 && s.pages.n == 2, "the rank counts components above 1e-12 of the largest");
    sampling_free(&s);
    clear(&stage);
}

static void test_apart(void)
{
    struct stage stage = {.n = 0};
    put_light(&stage, "1", 380, 401);
    put_surface(&stage, "gaussian:450,1*1e-200");
    put_surface(&stage, "gaussian:550,1*1e-200");
    put_surface(&stage, "gaussian:650,1*1e-200");
    struct sampling s = made(&stage, "basis:3"), fewer = made(&stage, "basis:2");
    CHECK(s.rank == 3 && is_sound(&s) && worst_error(&stage, &s) < 1e-210,
          "separate, tiny spectra are exact");
    CHECK(is_sound(&fewer), "separate, tiny spectra stay finite with fewer components");
    sampling_free(&s);
    sampling_free(&fewer);
    clear(&stage);
}

static void test_accepted(void)
{
    struct stage stage = chart("d65", 380, 401), dark = chart("d65", 300, 50);
    struct stage short_one = chart("d65", 400, 67);
    CHECK(pages_of(&dark, "gauss:8,open") == 8 && pages_of(&dark, "riemann:10") == 5,
          "a sampling without a fixed detector accepts one that sees nothing");
    CHECK(pages_of(&short_one, "riemann:1.1") == 61, /* 66 / 1.1 rounds to below 60 */
          "60 steps of 1.1 nm end at the last of 66 nm");
    CHECK(pages_of(&stage, "gauss:9,xyz") == 9 && pages_of(&stage, "gauss:10,lms") == 10,
          "three functions share the nodes");
    clear(&short_one);
    clear(&stage);
    clear(&dark);
}

/* ---- uses of samplings ---- */

/* Radiances are linear between pages and constant in boxes. */
static void test_synthesis(void)
{
    static const char *const names[] = {"box:8", "riemann:7", "gauss:8", "gauss:6,acc",
                                        "adaptive:0.1"};
    struct stage stage = chart("d65", 380, 401);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct sampling s = made(&stage, names[i]);
        double sums = 0, line = 0;
        for (int j = 0; j < s.fine.n; j++) {
            const double x = s.fine.nm[j], last = s.pages.wavelength_nm[s.pages.n - 1];
            double sum = 0, value = 0;
            for (int page = 0; page < s.pages.n; page++) {
                sum += s.synthesis[j * s.pages.n + page];
                value += s.synthesis[j * s.pages.n + page] * s.pages.wavelength_nm[page];
            }
            sums = fmax(sums, fabs(sum - 1));
            line = fmax(line, fabs(value - fmin(fmax(x, s.pages.wavelength_nm[0]), last)));
        }
        CHECK_NEAR(sums, 0, 1e-15, "%s: a constant radiance is reconstructed exactly", names[i]);
        if (s.method.kind != SAMPLING_BOX)
            CHECK_NEAR(line, 0, 1e-11,
                       "%s: a linear radiance is reconstructed exactly, and held at the ends",
                       names[i]);
        sampling_free(&s);
    }
    clear(&stage);
}

int main(void)
{
    test_enter();
    test_adaptive();
    test_few_pages();
    test_peaks();
    test_dim_light();
    test_polynomials();
    test_basis();
    test_black();
    test_line();
    test_hard();
    test_rank();
    test_apart();
    test_accepted();
    test_synthesis();
    return test_end();
}
