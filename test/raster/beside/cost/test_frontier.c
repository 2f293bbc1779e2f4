/* SPDX-License-Identifier: MIT */
/* The chart of accuracy and cost is well-formed XML for any values; points lie where their values
 * put them; the legend names the number of each; no number of the frontier covers another point. */
#include "raster/beside/cost/inside.h"
#include "svg.h"

enum { MANY = 60 };

struct point {
    const char *name;
    double cost, error;
    bool best, uncertain;
};

static char *svg_of(const struct point *points, int n)
{
    static struct cost_entry entries[MANY];
    static char scene[] = "cost & <accuracy>";
    const struct cost cost = {.observer = "cie1931", .scene = scene, .entries = entries, .n = n};
    for (int i = 0; i < n; i++) {
        entries[i] = (struct cost_entry){.seconds = points[i].cost,
                                         .fastest = 0.95 * points[i].cost,
                                         .slowest = 1.1 * points[i].cost,
                                         .accuracy.quantile_95 = points[i].error,
                                         .best = points[i].best,
                                         .uncertain = points[i].uncertain};
        snprintf(entries[i].name, sizeof entries[i].name, "%s", points[i].name);
    }
    struct printed printed = {.text = NULL};
    cost_svg(&cost, &printed);
    return svg_end(&printed);
}

static struct point point_of(const char *name, double cost, double error, bool best)
{
    return (struct point){name, cost, error, best, false};
}

/* ---- reading the file ---- */

struct item {
    double x, y, left, right, top, bottom;
    bool turned;
    char text[128];
};

static double attribute(const char *element, const char *name, double otherwise)
{
    const char *end = strchr(element, '>'), *at = strstr(element, name);
    return at != NULL && at < end ? strtod(at + strlen(name), NULL) : otherwise;
}

/* Finds the next element of this kind. Its characters are at most 0.6 of their size wide. */
static const char *next_text(const char *at, struct item *out)
{
    at = strstr(at, "<text");
    if (at == NULL)
        return NULL;
    const char *end = strchr(at, '>');
    const double size = attribute(at, " font-size=\"", 12);
    const char *middle = strstr(at, "text-anchor=\"middle\""), *last = strstr(at, "=\"end\"");
    int length = 0;
    snprintf(out->text, sizeof out->text, "%.*s", (int)strcspn(end + 1, "<"), end + 1);
    for (const char *c = out->text; *c != '\0'; c++) {
        length += ((unsigned char)*c & 0xc0) != 0x80;
        if (*c == '&')
            c += strcspn(c, ";");
    }
    const double width = length * 0.6 * size;
    const double part = middle != NULL && middle < end ? 0.5 : last != NULL && last < end ? 1 : 0;
    out->turned = strstr(at, "rotate") != NULL && strstr(at, "rotate") < end;
    out->x = attribute(at, " x=\"", 0);
    out->y = attribute(at, " y=\"", 0);
    out->left = out->x - part * width;
    out->right = out->left + width;
    out->top = out->y - 0.85 * size;
    out->bottom = out->y + 0.15 * size;
    return end;
}

/* Returns the drawing of the point with this name; sets its end. */
static const char *drawing_of(const char *svg, const char *name, const char **end)
{
    char title[256];
    snprintf(title, sizeof title, "<g><title>%s</title>", name);
    const char *at = strstr(svg, title);
    *end = at != NULL ? strstr(at, "</g>") : NULL;
    return at;
}

static bool find_marker(const char *svg, const char *name, double *x, double *y)
{
    const char *end, *at = drawing_of(svg, name, &end);
    at = at != NULL ? strstr(at, "<circle") : NULL;
    if (at == NULL)
        return false;
    *x = attribute(at, " cx=\"", HUGE_VAL);
    *y = attribute(at, " cy=\"", HUGE_VAL);
    return true;
}

/* ---- truths ---- */

/* Four corners of two decades: equal factors are equal distances. */
static void test_places(void)
{
    const struct point points[] = {point_of("one", 0.1, 1, true), point_of("two", 1, 0.1, true),
                                   point_of("three", 10, 0.01, true),
                                   point_of("beaten", 10, 1, false)};
    double x[4] = {0}, y[4] = {0};
    char *svg = svg_of(points, 4);
    for (int i = 0; i < 4; i++)
        CHECK(find_marker(svg, points[i].name, &x[i], &y[i]), "%s is there", points[i].name);
    CHECK_NEAR(x[1] - x[0], x[2] - x[1], 0.02, "equal factors of cost are equal distances");
    CHECK_NEAR(y[1] - y[0], y[2] - y[1], 0.02, "equal factors of error are equal distances");
    CHECK(x[1] > x[0] && y[1] > y[0], "cost grows to the right and error upwards");
    CHECK_NEAR(x[3], x[2], 0, "points of equal cost lie above each other");
    CHECK_NEAR(y[3], y[0], 0, "points of equal error lie beside each other");
    const char *const labels[] = {">0.1<",    ">1<",       ">10<",
                                  ">0.01<",   ">seconds<", ">CIEDE2000, 95 % of the pixels<",
                                  ">beaten<", ">three<"};
    for (size_t i = 0; i < sizeof labels / sizeof labels[0]; i++)
        CHECK(strstr(svg, labels[i]) != NULL, "%s is written", labels[i]);
    char steps[128];
    snprintf(steps, sizeof steps, "M%.2f,%.2fH%.2fV%.2fH%.2fV%.2f\"", x[0], y[0], x[1], y[1], x[2],
             y[2]);
    CHECK(strstr(svg, steps) != NULL,
          "steps join the frontier: first along cost, then along error");
    free(svg);
}

/* Returns whether the drawing of a point contains this text. */
static bool is_marked(const char *svg, const char *name, const char *part)
{
    const char *end, *at = drawing_of(svg, name, &end);
    const char *found = at != NULL ? strstr(at, part) : NULL;
    return found != NULL && found < end;
}

/* The marks differ without colours: a disk on the frontier, a circle off it, a dashed ring around a
 * point within noise of it. */
static void test_markers(void)
{
    struct point points[] = {point_of("best", 0.1, 5, true), point_of("beaten", 1, 6, false),
                             point_of("either", 2, 7, false)};
    points[2].uncertain = true;
    char *svg = svg_of(points, 3);
    CHECK(is_marked(svg, "best", "r=\"4.5\" fill=\"#0072b2\"") &&
              !is_marked(svg, "best", "stroke-dasharray"),
          "a point on the frontier is a disk");
    CHECK(is_marked(svg, "beaten", "r=\"2.8\" fill=\"#fff\"") &&
              !is_marked(svg, "beaten", "stroke-dasharray"),
          "a point off the frontier is a smaller circle");
    CHECK(is_marked(svg, "either", "r=\"2.8\" fill=\"#fff\"") &&
              is_marked(svg, "either", "stroke-dasharray"),
          "a ring surrounds a point within noise");
    free(svg);
}

static void test_edge(void)
{
    const struct point points[] = {point_of("coarse", 0.1, 5, true),
                                   point_of("fine", 1, 0.004, true), point_of("exact", 2, 0, true),
                                   point_of("close", 3, 0.006, false)};
    double x, fine = 0, exact = 0, close = 0;
    char *svg = svg_of(points, 4);
    CHECK(find_marker(svg, "fine", &x, &fine) && find_marker(svg, "exact", &x, &exact) &&
              find_marker(svg, "close", &x, &close),
          "all points are drawn");
    CHECK_NEAR(fine, exact, 0, "no error, and one below 1/1000 of the largest, lie on the edge");
    CHECK(close < exact, "an error above 1/1000 of the largest does not");
    CHECK(strstr(svg, ">≤ 0.005<") != NULL, "the edge's label names the errors it stands for");
    free(svg);
    svg = svg_of((struct point[]){point_of("coarse", 0.1, 9.9, true), points[2]}, 2);
    CHECK(strstr(svg, ">≤ 0.0099<") != NULL && strstr(svg, ">0.01<") == NULL,
          "a tick has no label where the edge's label would cover it");
    free(svg);
}

static void check_whole(const char *name, const struct point *points, int n)
{
    struct item item;
    char *svg = svg_of(points, n), *again = svg_of(points, n);
    const double height = attribute(strstr(svg, "<svg"), " height=\"", 0);
    bool inside = true;
    int texts = 0;
    for (const char *at = svg; (at = next_text(at, &item)) != NULL; texts++)
        inside = inside && (item.turned || (item.left >= 0 && item.right <= 800.5 &&
                                            item.top >= 0 && item.bottom <= height));
    CHECK(inside && texts > 5, "%s: no text lies outside the chart", name);
    CHECK(svg_is_sound(svg), "%s: an XML parser takes it, and all numbers are finite", name);
    CHECK_TEXT(again, svg, "%s: a second drawing has the same bytes", name);
    free(svg);
    free(again);
}

static void test_crowd(void)
{
    static char names[MANY][32];
    struct point points[MANY];
    for (int i = 0; i < MANY; i++) {
        snprintf(names[i], sizeof names[i], "configuration %d of many", i);
        points[i] = point_of(names[i], 1 + 1e-3 * i, 1 - 1e-3 * i, true);
    }
    points[0].cost = 0.01;
    check_whole("a crowded frontier", points, MANY);
}

static void test_degenerate(void)
{
    static char name[200];
    struct point points[4] = {point_of("one", 1, 1, true)};
    memset(name, 'W', sizeof name - 1);
    check_whole("no point", points, 0);
    check_whole("one point", points, 1);
    points[0].error = 0;
    check_whole("one point without error", points, 1);
    for (int i = 0; i < 4; i++)
        points[i] = point_of("a <b> & \"c\" \x01\xff", 2, 3, i % 2 == 0);
    check_whole("equal costs, equal errors, names of all kinds", points, 4);
    for (int i = 0; i < 4; i++)
        points[i] = point_of(name, 1 + i, 4 - i, i != 2);
    check_whole("long names", points, 4);
    points[0] = point_of("fast", 1e-300, 1e-300, true);
    points[1] = point_of("slow", 1e300, 1e300, false);
    check_whole("points of any size", points, 2);
}

/* Draws points, a third of them crowded in one place. */
static void fill(struct point *points, char (*names)[64], int n)
{
    uint64_t random = 7;
    for (int i = 0; i < n; i++) {
        double uniform[2];
        for (int k = 0; k < 2; k++)
            uniform[k] = test_random(&random, 0, 1);
        const bool crowded = i % 3 == 0;
        const double cost = (crowded ? 0.2 + 0.02 * uniform[0] : 0.02 + uniform[0] * i / n);
        const double error = (crowded ? 0.3 + 0.05 * uniform[1] : 0.02 / cost * (0.3 + uniform[1]));
        snprintf(names[i], 64, "gauss:%d shading phong tessellation %d", i, i % 4);
        points[i] = point_of(names[i], cost, i == n - 1 ? 0 : error, false);
        points[i].uncertain = i % 9 == 0;
    }
    for (int i = 0; i < n; i++) {
        points[i].best = true;
        for (int k = 0; k < n; k++)
            points[i].best = points[i].best && (points[k].cost >= points[i].cost ||
                                                points[k].error > points[i].error);
    }
}

static bool meet(const struct item *a, const struct item *b)
{
    return a->left < b->right && b->left < a->right && a->top < b->bottom && b->top < a->bottom;
}

/* Finds the number in the drawing of a point. */
static bool find_number(const char *svg, const char *name, struct item *out)
{
    const char *end, *at = drawing_of(svg, name, &end);
    const char *text = at != NULL ? next_text(at, out) : NULL;
    return text != NULL && text < end;
}

/* The legend has a row for each number: its text is followed by that of the name. */
static bool is_named(const char *svg, const char *number, const char *name)
{
    struct item item;
    bool named = false;
    for (const char *at = strstr(svg, "within noise"); (at = next_text(at, &item)) != NULL;)
        if (strcmp(item.text, number) == 0 && next_text(at, &item) != NULL)
            named = named || strcmp(item.text, name) == 0;
    return named;
}

static void test_numbers(int n)
{
    static char names[MANY][64];
    struct point points[MANY] = {{.name = NULL}};
    int unnamed = 0, covered = 0, best = 0;
    fill(points, names, n);
    char *svg = svg_of(points, n);
    for (int i = 0; i < n; i++) {
        struct item number;
        if (!find_number(svg, names[i], &number) || !is_named(svg, number.text, names[i]))
            unnamed++;
        best += points[i].best;
        for (int k = 0; k < n && points[i].best; k++) {
            double x = HUGE_VAL, y = HUGE_VAL;
            if (k == i || points[k].best || !find_marker(svg, points[k].name, &x, &y))
                continue;
            const struct item marker = {
                .left = x - 2.8, .right = x + 2.8, .top = y - 2.8, .bottom = y + 2.8};
            covered += meet(&number, &marker);
        }
    }
    CHECK(best > 3 && best < n / 2, "%d of %d points are on the frontier", best, n);
    CHECK(unnamed == 0, "the legend has no name for %d of %d numbers", unnamed, n);
    CHECK(covered == 0, "numbers of the frontier cover %d points off it", covered);
    free(svg);
    check_whole("a crowd", points, n);
}

int main(void)
{
    test_places();
    test_edge();
    test_markers();
    test_crowd();
    test_degenerate();
    test_numbers(50);
    test_numbers(MANY);
    return test_end();
}
