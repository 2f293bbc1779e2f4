/* SPDX-License-Identifier: MIT */
/* Charts are well-formed XML for any values, and axes have round ticks. probe.py and cost.py read
 * charts back: every point lies where its numbers put it, and the bytes are the same each time. */
#include <unistd.h>

#include "data/base/base.h"
#include "raster/beside/see/inside.h"
#include "test.h"

/* Draws n series over their numbers. Returns the text. */
static char *svg_of_series(const struct chart_series *series, int n, bool logarithmic)
{
    const struct chart chart = {.title = "title",
                                .x_label = "x",
                                .y_label = "y",
                                .logarithmic = logarithmic,
                                .series = series,
                                .n = n};
    struct printed printed = {.text = NULL};
    chart_svg(&chart, &printed);
    char *svg = printed_end(&printed);
    test_need(svg != NULL, "no memory");
    return svg;
}

/* Returns whether Python's parser takes the text, and no number in it is infinite or NaN. */
static bool svg_is_sound(const char *svg)
{
    char path[256], command[400];
    snprintf(path, sizeof path, "%s/chart-%d.svg", test_folder(), (int)getpid());
    snprintf(command, sizeof command,
             "/usr/bin/python3 -ISc 'import sys, xml.parsers.expat as xml\n"
             "xml.ParserCreate().ParseFile(open(sys.argv[1], \"rb\"))' %s",
             test_write(path, svg));
    const bool parsed = system(command) == 0;
    remove(path);
    return parsed && strncmp(svg, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n", 39) == 0 &&
           strstr(svg, "nan") == NULL && strstr(svg, "inf") == NULL;
}

static void test_ticks(void)
{
    static const struct {
        double y[2];
        bool logarithmic;
        const char *name, *labels[4];
    } axes[] = {
        {{0.1, 0.71},
         false,
         "round wavelengths and radiances, from 0",
         {"350", "700", "0.2", "0.8"}},
        {{0.1, 1111}, false, "no decimals where steps are whole", {"400", "0", "200", "1200"}},
        {{-0.04, -0.001},
         false,
         "an axis of negative numbers ends at 0",
         {"400", "-0.04", "-0.03", "0"}},
        {{0, 1.6}, false, "steps of 1, 2 or 5", {"400", "0", "0.2", "1.6"}},
        {{0, 0}, false, "an axis without values other than 0 ends at 1", {"400", "0", "0.2", "1"}},
        {{5, 5}, false, "an axis of one value begins at 0", {"400", "0", "1", "5"}},
        {{1e300, 2.1e300},
         false,
         "large numbers have exponents",
         {"0", "2e+299", "2e+300", "2.2e+300"}},
        {{0.03, 0.9}, true, "1, 2 and 5 on a short logarithmic axis", {"200", "0.02", "0.05", "1"}},
        {{0.003, 900}, true, "powers of ten on a long one", {"500", "0.01", "1", "1000"}},
        {{1e-300, 1e300},
         true,
         "some powers of ten on a longer one",
         {"500", "1", "1e+101", "1e-101"}},
    };
    for (size_t i = 0; i < sizeof axes / sizeof axes[0]; i++) {
        const struct chart_series series = {
            .name = "a", .n = 2, .x = (double[]){380, 730}, .y = axes[i].y};
        char *svg = svg_of_series(&series, 1, axes[i].logarithmic), text[64];
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
        {4, x, extreme, "L", "the largest numbers leave a sound chart"},
        {4, x, least, "L", "the smallest numbers draw a line"},
        {4, close, flat, "L", "points at one place draw a line"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        for (int k = 0; k < 2; k++) {
            const struct chart_series series = {
                .name = "a", .n = cases[i].n, .x = cases[i].x, .y = cases[i].y};
            char *svg = svg_of_series(&series, 1, k == 1);
            CHECK(svg_is_sound(svg) && (k == 1 || strstr(svg, cases[i].part) != NULL), "%s%s",
                  cases[i].name, k == 1 ? ", logarithmic" : "");
            free(svg);
        }
}

static void test_text(void)
{
    char longest[501];
    struct chart_series series = {.name = "<b> & \"quotes\" \x01 \xff \xe2\x80\xae \xc3\xa4"};
    char *svg = svg_of_series(&series, 1, false);
    CHECK(svg_is_sound(svg), "names are escaped");
    CHECK(strstr(svg, "&lt;b&gt; &amp; &quot;quotes&quot; ? ? ? \xc3\xa4</text>") != NULL,
          "bytes that are no text, and marks that turn it around, are replaced");
    free(svg);
    memset(longest, 'w', sizeof longest - 1);
    longest[sizeof longest - 1] = '\0';
    series.name = longest;
    svg = svg_of_series(&series, 1, false);
    CHECK(svg_is_sound(svg) && strstr(svg, longest) != NULL,
          "a long name is whole in the title of its line");
    free(svg);
}

static void test_strokes(void)
{
    enum { LINES = 35 };
    struct chart_series series[LINES];
    char strokes[LINES][200];
    bool alike = false;
    for (int i = 0; i < LINES; i++)
        series[i] = (struct chart_series){.name = "a"};
    char *svg = svg_of_series(series, LINES, false), *group = svg;
    for (int i = 0; i < LINES; i++) {
        const char *from = strstr(group, "<g "), *to = strstr(from, ">");
        const char *colour = strstr(from, "stroke=\""), *dash = strstr(from, "stroke-dasharray=\"");
        snprintf(strokes[i], sizeof strokes[i], "%.16s%.*s", colour, (int)(to - dash), dash);
        group = strstr(to, "</g>");
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
    test_text();
    test_strokes();
    return test_end();
}
