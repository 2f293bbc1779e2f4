/* SPDX-License-Identifier: MIT */
/* Compares weights and losses of detectors with values worked by hand. tables.py compares the
 * tables with published white points. test/cases/bad/detectors.cases has the files that are
 * refused. */
#include "data/files/files.h"
#include "spectral.h"
#include "data/spectra/spectra.h"
#include "test.h"

enum { MOST = 1024 };

/* Returns a zeroed detector after an error. */
static struct detector read_detector(const char *name, struct error *err)
{
    struct detector out;
    *err = (struct error){0};
    if (!detector_read(name, &out, err)) {
        detector_free(&out);
        CHECK(out.name == NULL && out.sensitivity == NULL, "a refused detector can be freed");
    }
    return out;
}

static struct detector detector_of(const char *name)
{
    struct error err;
    struct detector out = read_detector(name, &err);
    if (err.text[0] != '\0')
        printf("# %s\n", err.text);
    return out;
}

static struct detector content(const char *text)
{
    return detector_of(test_write("./detector", text));
}

static int grid(double first, double last, double step, double out[MOST])
{
    int n = 0;
    while (n < MOST && first + n * step <= last) {
        out[n] = first + n * step;
        n++;
    }
    return n;
}

/* Computes a detector's channels for a radiance of 1. */
static void channels(const struct detector *detector, const double *nm, int n, double out[3])
{
    static double weights[3 * MOST], ones[MOST];
    for (int i = 0; i < n; i++)
        ones[i] = 1;
    detector_weights(detector, nm, n, weights);
    detector_response(weights, ones, n, out);
}

/* ---- the CIE's tables ---- */

static void check_tables(void)
{
    static const struct {
        const char *name;
        bool observer;
        double first, last, step;
    } tables[] = {
        {"cie1931", true, 360, 830, 1},
        {"cie1964", true, 360, 830, 1},
        {"cie2006-2", true, 390, 830, 1},
        {"cie2006-10", true, 390, 830, 1},
        {"cie-standard-deviate", true, 300, 760, 5},
        {"dcs200-camera", false, 300, 760, 5},
        {"transparency-film", false, 300, 760, 5},
    };
    int built_in = 0;
    for (size_t i = 0; i < sizeof tables / sizeof tables[0]; i++) {
        struct detector detector = detector_of(tables[i].name);
        const struct spectrum *y = &detector.sensitivity[1];
        double nm[MOST], xyz[3], lost[3];
        int n = grid(tables[i].first, tables[i].last, tables[i].step, nm);
        CHECK(detector.observer == tables[i].observer && y->count == n &&
                  memcmp(y->wavelength_nm, nm, (size_t)n * sizeof *nm) == 0,
              "%s: %d samples from %g to %g nm", tables[i].name, n, nm[0], nm[n - 1]);
        channels(&detector, nm, n, xyz);
        CHECK(!tables[i].observer || fabs(xyz[1] - 100) < 1e-11, "equal energy has Y = 100");
        n = grid(300, 760, 5, nm);
        channels(&detector, nm, n, xyz);
        detector_lost(&detector, nm, n, lost);
        CHECK(!tables[i].observer || fabs(xyz[1] - 100) < 0.01,
              "sums from 300 to 760 nm every 5 nm are within 0.01");
        CHECK(lost[0] < 3e-4 && lost[1] < 3e-4 && lost[2] < 3e-4,
              "these sums lose less than 0.03 %%");
        detector_free(&detector);
    }
    for (size_t i = 0; i < builtin_file_count; i++)
        built_in += table_is_detector(&builtin_files[i]);
    CHECK(built_in == sizeof tables / sizeof tables[0], "any other table is refused as a detector");
}

/* ---- weights ---- */

/* develop.py and sampling.py compute the weights of observers and cameras once more. */
static void check_weights(void)
{
    static const double uneven[] = {400, 410, 440};
    struct detector lobed = content("nm,x,y,z\n300 1 3 4\n600 1 -1 4\n");
    double out[9];
    detector_weights(&lobed, uneven, 3, out); /* the sum of y is 600, and k = 1/6 */
    CHECK_NEAR(out[0], 10 / 6., 1e-14, "a negative y reduces the sum");
    detector_free(&lobed);
}

/* ---- losses ---- */

static double lost_of(const char *text, double first, double last, double step)
{
    struct detector detector = content(text);
    double nm[MOST], out[3];
    detector_lost(&detector, nm, grid(first, last, step, nm), out);
    CHECK(out[1] == out[0] && out[2] == out[0], "equal channels lose equal shares");
    detector_free(&detector);
    return out[0];
}

static void check_lost(void)
{
    static const char level[] = "nm r g b\n400 1 1 1\n410 1 1 1\n420 1 1 1\n430 1 1 1\n";
    static const char odd[] = "nm r g b\n400 1 1 1\n410 -3 -3 -3\n";
    CHECK(lost_of(level, 400, 430, 10) == 0, "a detector loses nothing on its own grid");
    CHECK(lost_of(level, 300, 700, 3) == 0, "a detector loses nothing on a wider grid");
    CHECK(lost_of(level, 500, 600, 10) == 1, "a detector loses everything on a distant grid");
    CHECK(lost_of(level, 380, 390, 10) == 1,
          "a detector loses everything on a grid just beside its own");
    CHECK(lost_of(level, 397.5, 412.5, 5) == 0.5,
          "the grid from 395 to 415 nm loses half of 395 to 435 nm");
    CHECK_NEAR(lost_of(level, 420, 420, 1), 39. / 40, 1e-15,
               "one wavelength loses all but 1 nm of 40");
    CHECK(lost_of(odd, 400, 405, 10) == lost_of(odd, 400, 400.5, 1) &&
              fabs(lost_of(odd, 400, 400, 1) - (1 - 1. / 40)) < 1e-15,
          "negative sensitivities count by their size");
}

/* ---- reading ---- */

static void check_heads(void)
{
    static const struct {
        const char *text;
        bool observer;
    } files[] = {
        {"nm,x,y,z\n400,1,2,3\n500,1,2,3\n", true},
        {"# mine\n\n\"Wavelength (nm)\";\"x\";\"y\";\"z\"\r\n400;1;2;3\r\n", true},
        {"nm,X,Y,Z\n400,1,2,3\n", true},
        {"lambda xbar ybar zbar\n400 1 2 3\n", true},
        {"nm\tx_10(2deg)\ty_10(2deg)\tz_10(2deg)\n400\t1\t2\t3\n", true},
        {"nm;CIE x\xCC\x84;CIE \xC8\xB3;CIE z\xCC\x84\n400;1;2;3\n", true},
        {"nm,z,y,x\n400,3,2,1\n", true},
        {"nm,Blue,g,R\n400,3,2,1\n", false},
        {"nm,xenon,y,z\n400,1,2,3\n", false},
        {"nm,r,g,b\n400,1,2,3\n", false},
        {"nm r g b\n400 1 2 3\n500 0 -1 0\n", false},
    };
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        struct detector detector = content(files[i].text);
        CHECK(detector.observer == files[i].observer && detector.sensitivity[2].count > 0 &&
                  detector.sensitivity[0].value[0] == 1 && detector.sensitivity[1].value[0] == 2 &&
                  detector.sensitivity[2].value[0] == 3,
              "file %zu is read as %s", i, files[i].observer ? "an observer" : "a camera");
        detector_free(&detector);
        detector_free(&detector);
    }
}

static void check_odd_names(void)
{
    static const char *const names[] = {"./a:1", "./a*2", "./a b.csv", "./0.5"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct detector detector = detector_of(test_write(names[i], "nm r g b\n400 1 2 3\n"));
        CHECK(detector.sensitivity[1].count == 1, "a file named '%s' is read", names[i]);
        detector_free(&detector);
    }
}

static void check_refused(void)
{
    struct error err;
    read_detector("nobody", &err);
    CHECK(strstr(err.text, " cie2006-10, ") != NULL && strstr(err.text, "d65") == NULL,
          "an unknown name lists the detectors");
}

int main(void)
{
    test_enter();
    check_tables();
    check_weights();
    check_lost();
    check_heads();
    check_odd_names();
    check_refused();
    return test_end();
}
