/* SPDX-License-Identifier: MIT */
/* Plots are well-formed XML for any values, and axes have round steps. probe.py reads plots of
 * spectra back: every point lies where its numbers put it, and the bytes are the same each time. */
#include "raster/beside/see/inside.h"
#include "svg.h"

static char *svg_of(const struct probe *probe)
{
    struct printed printed = {.text = NULL};
    probe_svg(probe, &printed);
    return svg_end(&printed);
}

/* Returns the probe of a pixel with n radiances. */
static struct probe probe_of(int n, const double *x, const double *y)
{
    static char source[] = "source";
    static double zero[8];
    static struct probe_column columns[CURVES + 64];
    struct probe probe = {
        .width = 1, .height = 1, .source = source, .n = n, .columns = columns, .n_columns = CURVES};
    probe.columns[WAVELENGTH] = (struct probe_column){.values = (double *)(uintptr_t)x};
    probe.columns[MEAN] =
        (struct probe_column){.name = "radiance", .values = (double *)(uintptr_t)y};
    probe.columns[SPREAD] = (struct probe_column){.values = zero};
    return probe;
}

/* Makes it that of a region, with these deviations. */
static void spread(struct probe *probe, const double *deviations)
{
    probe->width = 2;
    probe->columns[SPREAD].values = (double *)(uintptr_t)deviations;
}

static void test_ticks(void)
{
    static const struct {
        double y[2];
        const char *name, *labels[4];
    } axes[] = {
        {{0.1, 0.71}, "round wavelengths and radiances, from 0", {"450", "700", "0.2", "0.8"}},
        {{0.1, 1111}, "no decimals where steps are whole", {"400", "0", "200", "1200"}},
        {{1e307, 2.1e307},
         "large numbers are multiples of a power of ten",
         {"0.0", "0.5", "2.0", "×10³⁰⁷"}},
        {{0, 7e-308},
         "small numbers are multiples of a power of ten",
         {"400", "0", "5", "×10⁻³⁰⁸"}},
        {{-0.04, -0.001},
         "an axis of negative numbers ends at 0",
         {"400", "-0.04", "-0.02", "0.00"}},
        {{0, 1.6}, "steps of 1, 2 or 5", {"400", "0.0", "0.5", "1.5"}},
        {{0, 94000}, "labels have up to five digits", {"400", "0", "20000", "80000"}},
        {{0, 100000}, "labels never have more than five digits", {"400", "0.0", "0.2", "×10⁵"}},
    };
    for (size_t i = 0; i < sizeof axes / sizeof axes[0]; i++) {
        const struct probe probe = probe_of(2, (double[]){380, 730}, axes[i].y);
        char *svg = svg_of(&probe), text[64];
        bool all = true;
        for (int k = 0; k < 4; k++) {
            snprintf(text, sizeof text, ">%s</text>", axes[i].labels[k]);
            all = all && strstr(svg, text) != NULL;
        }
        CHECK(all && svg_is_sound(svg), "%s", axes[i].name);
        free(svg);
    }
}

static void test_degenerate(void)
{
    const double x[] = {400, 500, 600, 700}, zero[4] = {0}, flat[] = {5, 5, 5, 5};
    const double nan = (double)NAN;
    const double holed[] = {1, nan, 3, HUGE_VAL}, none[] = {nan, nan, nan, nan};
    const double extreme[] = {-1.7e308, 1.7e308, 5e-324, 0}, least[] = {5e-324, 5e-324, 0, 0};
    const double close[] = {550, 550.0000000001, 550, 550};
    const struct {
        int n;
        const double *x, *y;
        const char *part, *name;
    } cases[] = {
        {1, x, flat, "<circle", "one point is a dot"},
        {4, x, zero, "L", "zeros draw a line"},
        {4, x, flat, "L", "a constant draws a line"},
        {4, x, holed, "<circle", "a value that is not finite interrupts the line"},
        {4, x, none, "</svg>", "a line without finite values is not drawn"},
        {0, NULL, NULL, "</svg>", "a line without points is not drawn"},
        {4, x, extreme, "L", "the largest numbers draw a line"},
        {4, x, least, "L", "the smallest numbers draw a line"},
        {4, close, flat, "L", "points at one place draw a line"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct probe probe = probe_of(cases[i].n, cases[i].x, cases[i].y);
        spread(&probe, cases[i].y);
        char *svg = svg_of(&probe);
        CHECK(svg_is_sound(svg) && strstr(svg, cases[i].part) != NULL, "%s", cases[i].name);
        free(svg);
    }
}

static void test_bands(void)
{
    const double x[] = {400, 500, 600}, y[] = {0, 2, 1};
    struct probe probe = probe_of(3, x, y);
    char *svg = svg_of(&probe);
    CHECK(strstr(svg, "fill-opacity") == NULL, "the chart of a pixel has no grey band");
    free(svg);
    spread(&probe, (double[]){0, 0.5, 0});
    svg = svg_of(&probe);
    const char *band = strstr(svg, "fill-opacity"), *spectrum = strstr(svg, "url(#visible)");
    CHECK(band != NULL && strstr(band + 1, "fill-opacity") == NULL && spectrum != NULL &&
              strstr(spectrum + 1, "url(#visible)") == NULL,
          "the chart of a region has a grey band and a spectrum");
    CHECK(strstr(svg, "<stop offset=\"0.0000\"") != NULL &&
              strstr(svg, "<stop offset=\"1.0000\"") != NULL,
          "the coloured spectrum begins and ends with the axis");
    free(svg);
    spread(&probe, (double[]){3, 3, 3});
    svg = svg_of(&probe);
    CHECK(strstr(svg, ">-") == NULL, "the grey band around values that are not negative ends at 0");
    free(svg);
}

static void test_text(void)
{
    const double x[] = {400, 500}, y[] = {0, 1};
    struct probe probe = probe_of(2, x, y);
    char *svg, longest[4001];
    snprintf(probe.columns[MEAN].name, sizeof probe.columns[MEAN].name, "%s",
             "<b> & \"quotes\" \x01 \xff \xef\xbf\xbf \xc3\xa4");
    svg = svg_of(&probe);
    CHECK(svg_is_sound(svg), "names are escaped");
    CHECK(strstr(svg, "&lt;b&gt; &amp; &quot;quotes&quot; \xef\xbf\xbd \xef\xbf\xbd \xef\xbf\xbd "
                      "\xc3\xa4</text>") != NULL,
          "bytes that XML cannot hold are replaced");
    free(svg);
    memset(longest, 'w', sizeof longest - 1);
    longest[sizeof longest - 1] = '\0';
    probe.object = probe.source = longest;
    for (int i = 0; i < 3; i++)
        memset(probe.columns[probe.n_columns++].name, 'w', sizeof probe.columns[0].name - 1);
    for (int i = CURVES; i < probe.n_columns; i++)
        probe.columns[i].values = probe.columns[MEAN].values;
    svg = svg_of(&probe);
    CHECK(svg_is_sound(svg) && strlen(svg) < 20000 && strstr(svg, "w…</text>") != NULL,
          "long texts are cut to the room");
    free(svg);
}

static void test_strokes(void)
{
    enum { LINES = 35 };
    const double x[] = {400, 500}, y[] = {0, 1};
    struct probe probe = probe_of(2, x, y);
    char strokes[LINES][200];
    bool alike = false;
    while (probe.n_columns < LINES + SPREAD)
        probe.columns[probe.n_columns++] = probe.columns[MEAN];
    char *svg = svg_of(&probe), *legend = strstr(svg, "<path fill=\"none\"");
    for (int i = 0; i < LINES; i++) {
        const char *from = strstr(legend, "stroke=\""), *to = strstr(from, " d=\"");
        snprintf(strokes[i], sizeof strokes[i], "%.*s", (int)(to - from), from);
        legend = strstr(to, "<path");
        for (int j = 0; j < i; j++)
            alike = alike || strcmp(strokes[i], strokes[j]) == 0;
    }
    CHECK(!alike, "no two of 35 lines look alike");
    free(svg);
}

int main(void)
{
    test_ticks();
    test_degenerate();
    test_bands();
    test_text();
    test_strokes();
    return test_end();
}
