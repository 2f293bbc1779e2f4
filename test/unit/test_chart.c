/* SPDX-License-Identifier: MIT */
/* Plots are well-formed XML for any values; axes have round steps; every point lies where its
 * numbers put it. test/run/probe.py reads plots of spectra back. */
#include "data/chart/chart.h"
#include "test.h"

static char *svg_of(const struct chart *chart)
{
    struct printed printed = {.text = NULL};
    chart_svg(chart, &printed);
    char *svg = printed_end(&printed);
    if (svg == NULL) {
        printf("Bail out! no memory\n");
        exit(1);
    }
    return svg;
}

static int count_of(const char *text, const char *part)
{
    int count = 0;
    for (const char *at = text; (at = strstr(at, part)) != NULL; at += strlen(part))
        count++;
    return count;
}

/* Returns whether elements close in order and no bare < or & occurs. Attributes hold no '>'. */
static bool is_well_formed(const char *text)
{
    enum { DEEPEST = 16 };
    const char *open[DEEPEST], *at = text;
    int depth = 0;
    if (strncmp(at, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n", 39) != 0)
        return false;
    for (at += 39; *at != '\0'; at++) {
        if (*at == '&' && strncmp(at, "&lt;", 4) != 0 && strncmp(at, "&gt;", 4) != 0 &&
            strncmp(at, "&amp;", 5) != 0 && strncmp(at, "&quot;", 6) != 0)
            return false;
        if ((unsigned char)*at < 0x20 && *at != '\n')
            return false;
        if (*at != '<')
            continue;
        const char *end = strchr(at, '>'), *name = at + 1 + (at[1] == '/');
        const size_t length = strcspn(name, " />");
        if (end == NULL || length == 0 || depth == DEEPEST)
            return false;
        if (at[1] == '/') {
            if (depth == 0 || strncmp(open[--depth], name, length + 1) > 0 ||
                strncmp(open[depth], name, length) != 0)
                return false;
        } else if (end[-1] != '/')
            open[depth++] = name;
        at = end;
    }
    return depth == 0;
}

/* Returns a chart of one line with n points. */
static struct chart chart_of(struct chart_line *line, int n, const double *x, const double *y)
{
    *line = (struct chart_line){.name = "line", .n = n, .x = x, .y = y};
    return (struct chart){.title = "title",
                          .x_label = "wavelength (nm)",
                          .y_label = "radiance",
                          .lines = line,
                          .n_lines = 1};
}

static void check_labels(const double x[2], const double y[2], const char *const *labels,
                         const char *name)
{
    struct chart_line line;
    const struct chart chart = chart_of(&line, 2, x, y);
    char *svg = svg_of(&chart);
    bool all = true;
    for (int i = 0; labels[i] != NULL; i++) {
        char text[64];
        snprintf(text, sizeof text, ">%s</text>", labels[i]);
        all = all && strstr(svg, text) != NULL;
    }
    CHECK(all && is_well_formed(svg), "%s", name);
    free(svg);
}

static void test_ticks(void)
{
    const double nm[] = {380, 730};
    const char *const visible[] = {"400", "450", "700", "0.0", "0.2", "0.8", NULL};
    const char *const large[] = {"0.0", "0.5", "2.0", "×10³⁰⁷", NULL};
    const char *const small[] = {"0", "5", "×10⁻³⁰⁸", NULL};
    const char *const negative[] = {"-0.04", "-0.02", "0.00", NULL};
    const char *const hundreds[] = {"0", "200", "1200", NULL};
    const char *const halves[] = {"0.0", "0.5", "1.5", NULL};
    const char *const most[] = {"0", "20000", "80000", NULL};
    const char *const more[] = {"0.0", "0.2", "×10⁵", NULL};
    check_labels(nm, (double[]){0.1, 0.71}, visible, "round wavelengths and radiances, from 0");
    check_labels(nm, (double[]){0.1, 1111}, hundreds, "no decimals where steps are whole");
    check_labels(nm, (double[]){1e307, 2.1e307}, large,
                 "large numbers are multiples of a power of ten");
    check_labels(nm, (double[]){0, 7e-308}, small, "small numbers are multiples of a power of ten");
    check_labels(nm, (double[]){-0.04, -0.001}, negative, "an axis of negative numbers ends at 0");
    check_labels(nm, (double[]){0, 1.6}, halves, "steps of 1, 2 or 5");
    check_labels(nm, (double[]){0, 94000}, most, "labels have up to five digits");
    check_labels(nm, (double[]){0, 100000}, more, "labels never have more than five digits");
}

static void check_degenerate(int n, const double *x, const double *y, const char *part,
                             const char *name)
{
    struct chart_line line;
    struct chart chart = chart_of(&line, n, x, y);
    char *svg;
    line.spread = y;
    chart.wavelengths = true;
    svg = svg_of(&chart);
    CHECK(is_well_formed(svg) && strstr(svg, part) != NULL && strstr(svg, "nan") == NULL &&
              strstr(svg, "inf") == NULL,
          "%s", name);
    free(svg);
}

static void test_degenerate(void)
{
    const double x[] = {400, 500, 600, 700}, zero[4] = {0}, flat[] = {5, 5, 5, 5};
    const double nan = (double)NAN;
    const double holed[] = {1, nan, 3, HUGE_VAL}, none[] = {nan, nan, nan, nan};
    const double extreme[] = {-1.7e308, 1.7e308, 5e-324, 0}, least[] = {5e-324, 5e-324, 0, 0};
    const double close[] = {550, 550.0000000001, 550, 550};
    check_degenerate(1, x, flat, "<circle", "one point is a dot");
    check_degenerate(4, x, zero, "L", "zeros draw a line");
    check_degenerate(4, x, flat, "L", "a constant draws a line");
    check_degenerate(4, x, holed, "<circle", "a value that is not finite interrupts the line");
    check_degenerate(4, x, none, "</svg>", "a line without finite values is not drawn");
    check_degenerate(0, NULL, NULL, "</svg>", "a line without points is not drawn");
    check_degenerate(4, x, extreme, "L", "the largest numbers draw a line");
    check_degenerate(4, x, least, "L", "the smallest numbers draw a line");
    check_degenerate(4, close, flat, "L", "points at one place draw a line");
    const struct chart empty = {.title = "", .x_label = "", .y_label = ""};
    char *svg = svg_of(&empty);
    CHECK(is_well_formed(svg), "a chart without lines is well-formed");
    free(svg);
}

static void test_places(void)
{
    const double x[] = {400, 500, 600}, y[] = {0, 2, 1}, spread[] = {0, 0.5, 0};
    struct chart_line line;
    struct chart chart = chart_of(&line, 3, x, y);
    char *svg = svg_of(&chart);
    const char *path = strstr(svg, "stroke-linejoin"), *d = path ? strstr(path, " d=\"") : NULL;
    double at[6] = {0};
    int n = d == NULL ? 0
                      : sscanf(d, " d=\"M%lf,%lfL%lf,%lfL%lf,%lf\"", &at[0], &at[1], &at[2], &at[3],
                               &at[4], &at[5]);
    CHECK(n == 6, "three points draw a path of three points");
    CHECK_NEAR(at[2] - at[0], at[4] - at[2], 0.011, "equal steps of x have equal widths");
    CHECK_NEAR(at[1] - at[3], 2 * (at[1] - at[5]), 0.021, "twice the value is twice as high");
    CHECK(strstr(svg, "fill-opacity") == NULL && strstr(svg, "visible") == NULL,
          "a chart without spread has no grey band, and without wavelengths no spectrum");
    free(svg);
    line.spread = spread;
    chart.wavelengths = true;
    svg = svg_of(&chart);
    CHECK(count_of(svg, "fill-opacity") == 1 && count_of(svg, "url(#visible)") == 1,
          "a chart with both has a grey band and a spectrum");
    CHECK(strstr(svg, "<stop offset=\"0.0000\"") != NULL &&
              strstr(svg, "<stop offset=\"1.0000\"") != NULL,
          "the coloured spectrum begins and ends with the axis");
    free(svg);
    line.spread = (double[]){3, 3, 3};
    svg = svg_of(&chart);
    CHECK(strstr(svg, ">-") == NULL, "the grey band around values that are not negative ends at 0");
    free(svg);
}

static void test_text(void)
{
    const double x[] = {400, 500}, y[] = {0, 1};
    struct chart_line line;
    struct chart chart = chart_of(&line, 2, x, y);
    char *svg, *again, longest[4001];
    line.name = "<b> & \"quotes\" \x01 \xff \xef\xbf\xbf \xc3\xa4";
    svg = svg_of(&chart);
    again = svg_of(&chart);
    CHECK(is_well_formed(svg), "names are escaped");
    CHECK(strstr(svg, "&lt;b&gt; &amp; &quot;quotes&quot; \xef\xbf\xbd \xef\xbf\xbd \xef\xbf\xbd "
                      "\xc3\xa4</text>") != NULL,
          "bytes that XML cannot hold are replaced");
    CHECK_TEXT(svg, again, "the same chart has the same bytes each time");
    free(svg);
    free(again);
    memset(longest, 'w', sizeof longest - 1);
    longest[sizeof longest - 1] = '\0';
    line.name = chart.title = chart.x_label = chart.y_label = longest;
    svg = svg_of(&chart);
    CHECK(is_well_formed(svg) && strlen(svg) < 20000 && strstr(svg, "w…</text>") != NULL,
          "long texts are cut to the room");
    free(svg);
}

static void test_strokes(void)
{
    enum { LINES = 35 };
    const double x[] = {400, 500}, y[] = {0, 1};
    struct chart_line lines[LINES];
    struct chart chart = chart_of(lines, 2, x, y);
    char strokes[LINES][200];
    bool alike = false;
    for (int i = 1; i < LINES; i++)
        lines[i] = lines[0];
    chart.n_lines = LINES;
    char *svg = svg_of(&chart), *legend = strstr(svg, "<path fill=\"none\"");
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
    test_places();
    test_text();
    test_strokes();
    return test_end();
}
