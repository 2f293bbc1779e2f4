/* SPDX-License-Identifier: MIT */
/* Charts as SVG 1.1, to be printed: lines differ in colour and in dashes, so that colour-blind eyes
 * and prints without colours keep them apart. Ticks are round numbers, and axes end at ticks.
 * Numbers are rounded to decimals only, so that the bytes are the same everywhere. Texts that are
 * too long end at the edge of the picture. */
#include "raster/beside/see/inside.h"

/* In SVG's pixels, 96 an inch: the edges of the area that the axes enclose; then in the legend. */
enum { WIDTH = 800, LEFT = 84, RIGHT = 728, TOP = 52, BOTTOM = 412, ROW = 20, SAMPLE = 36 };

/* The colours of Okabe and Ito, "Color Universal Design" (2008), without its yellow, which is too
 * pale on white. With five dashes no two of 35 lines are alike. */
static const char *const colours[] = {"#000000", "#0072b2", "#d55e00", "#009e73",
                                      "#cc79a7", "#e69f00", "#56b4e9"};
static const char *const dashes[] = {"none", "9 4", "2 3", "9 3 2 3", "5 3"};
enum { N_COLOURS = 7, N_DASHES = 5 };

/* Tick k of a linear axis is k steps; of a logarithmic one, k / 3 is the power of ten, and the rest
 * makes it 1, 2 or 5 times as large. */
struct axis {
    bool logarithmic;
    double low, high; /* of all values */
    double step;
    long first, last, stride; /* the ends of the axis; every so many ticks have a label */
};
enum side { ACROSS, ON_LEFT, ON_RIGHT, SIDES };
struct plot {
    const struct chart *chart;
    struct axis axes[SIDES];
    struct printed *to;
};

/* Prints a text that a file may have chosen. */
static void put_text(struct printed *to, const char *text)
{
    char shown[512];
    snprintf(shown, sizeof shown, "%s", text);
    hide_unprintable(shown, "");
    print_xml(to, shown);
}

/* ---- axes ---- */

/* Returns whether a number can be drawn. */
static bool fits(const struct chart *chart, double value)
{
    const double largest = 1e305;
    return value <= largest && value >= (chart->logarithmic ? 1 / largest : -largest);
}

static enum side side_of(const struct chart_series *series)
{
    return series->right ? ON_RIGHT : ON_LEFT;
}

static bool is_drawn(const struct plot *plot, const struct chart_series *series, int i)
{
    return i >= 0 && i < series->n && fits(plot->chart, series->x[i]) &&
           fits(plot->chart, series->y[i]);
}

static double tick_value(const struct axis *axis, long tick)
{
    const long decade = (long)floor((double)tick / 3);
    char text[32];
    if (!axis->logarithmic)
        return (double)tick * axis->step;
    snprintf(text, sizeof text, "%ce%ld", "125"[tick - 3 * decade], decade);
    return strtod(text, NULL);
}

static void choose_powers(struct axis *axis, double length)
{
    char text[32];
    snprintf(text, sizeof text, "%.0e", axis->low);
    axis->first = 3 * (atol(strchr(text, 'e') + 1) + 1);
    while (tick_value(axis, axis->first) > axis->low)
        axis->first--;
    axis->last = axis->first + 1;
    while (tick_value(axis, axis->last) < axis->high)
        axis->last++;
    const double decade = 3 * length / (double)(axis->last - axis->first);
    if (decade < 120) /* powers of ten only, or some of them */
        axis->stride = 3 * (1 + (long)(60 / decade));
}

/* Chooses steps of 1, 2 or 5 times a power of ten: 5 to 13. One value gets some room around it. */
static void choose_steps(struct axis *axis)
{
    const double size = fmax(fabs(axis->low), fabs(axis->high));
    const bool tiny = size < 1e-100;
    char text[32];
    if (tiny || axis->high - axis->low < 1e-6 * size) {
        axis->low -= size / 20;
        axis->high += tiny ? 1 : size / 20;
    }
    snprintf(text, sizeof text, "%.0e", (axis->high - axis->low) / 5);
    text[0] = text[0] < '2' ? '1' : text[0] < '5' ? '2' : '5';
    axis->step = strtod(text, NULL);
    axis->first = (long)floor(axis->low / axis->step);
    axis->last = (long)ceil(axis->high / axis->step);
}

static void stretch(struct axis *axis, double value)
{
    axis->low = fmin(axis->low, value);
    axis->high = fmax(axis->high, value);
}

/* Linear axes of y contain 0. */
static void fit_axes(struct plot *plot)
{
    const bool logarithmic = plot->chart->logarithmic;
    for (int side = 0; side < SIDES; side++) {
        const double begin = side != ACROSS && !logarithmic ? 0 : HUGE_VAL;
        plot->axes[side] =
            (struct axis){.logarithmic = logarithmic, .low = begin, .high = -begin, .stride = 1};
    }
    for (int s = 0; s < plot->chart->n; s++) {
        const struct chart_series *series = &plot->chart->series[s];
        for (int i = 0; i < series->n; i++)
            if (is_drawn(plot, series, i)) {
                stretch(&plot->axes[ACROSS], series->x[i]);
                stretch(&plot->axes[side_of(series)], series->y[i]);
            }
    }
    for (int side = 0; side < SIDES; side++) {
        struct axis *axis = &plot->axes[side];
        if (axis->low > axis->high) /* there are no values */
            axis->low = axis->high = 1;
        if (logarithmic)
            choose_powers(axis, side == ACROSS ? RIGHT - LEFT : BOTTOM - TOP);
        else
            choose_steps(axis);
    }
}

static double on_scale(const struct axis *axis, double value)
{
    return axis->logarithmic ? binary_logarithm(value) : value;
}

/* Returns the place of a value along its axis. */
static double place_of(const struct plot *plot, enum side side, double value)
{
    const struct axis *axis = &plot->axes[side];
    const double first = on_scale(axis, tick_value(axis, axis->first)),
                 last = on_scale(axis, tick_value(axis, axis->last)),
                 part = (on_scale(axis, value) - first) / (last - first);
    return side == ACROSS ? LEFT + (RIGHT - LEFT) * part : BOTTOM - (BOTTOM - TOP) * part;
}

/* Draws grid lines, but short ones from the axis on the right; labels, and the title of the axis.
 */
static void draw_axis(const struct plot *plot, enum side side, const char *title)
{
    static const struct {
        const char *anchor;
        int x, y, grid_x, grid_y, title_x, title_y, turn;
    } places[SIDES] = {{"middle", 0, 18, 0, TOP - BOTTOM, (LEFT + RIGHT) / 2, BOTTOM + 40, 0},
                       {"end", -8, 4, RIGHT - LEFT, 0, 20, (TOP + BOTTOM) / 2, -90},
                       {"start", 8, 4, -5, 0, WIDTH - 14, (TOP + BOTTOM) / 2, -90}};
    const struct axis *axis = &plot->axes[side];
    for (long tick = axis->first; tick <= axis->last; tick++) {
        const double value = tick_value(axis, tick), at = place_of(plot, side, value),
                     x = side == ACROSS    ? at
                         : side == ON_LEFT ? LEFT
                                           : RIGHT,
                     y = side == ACROSS ? BOTTOM : at;
        if (tick % axis->stride == 0)
            print(plot->to,
                  "<path stroke=\"#ddd\" d=\"M%.2f,%.2fh%dv%d\"/>"
                  "<text text-anchor=\"%s\" x=\"%.2f\" y=\"%.2f\">%.10g</text>\n",
                  x, y, places[side].grid_x, places[side].grid_y, places[side].anchor,
                  x + places[side].x, y + places[side].y, value);
    }
    print(plot->to,
          "<text text-anchor=\"middle\" transform=\"translate(%d,%d) rotate(%d)\">%s</text>\n",
          places[side].title_x, places[side].title_y, places[side].turn, title);
}

/* ---- series ---- */

static const struct {
    bool line, thin, open;
    int radius; /* of circles at its points; 0: there are none */
} looks[] = {[CHART_LINE] = {.line = true},
             [CHART_BARS] = {.line = true, .thin = true},
             [CHART_STEPS] = {.line = true, .radius = 4},
             [CHART_CIRCLES] = {.open = true, .radius = 3},
             [CHART_RINGS] = {.open = true, .radius = 7}};

/* Begins a group. The first series is thicker: the others explain it. */
static void open_group(const struct plot *plot, int series)
{
    const bool thin = looks[plot->chart->series[series].kind].thin;
    print(plot->to, "<g fill=\"none\" stroke=\"%s\" stroke-width=\"%s\" stroke-dasharray=\"%s\">",
          colours[series % N_COLOURS],
          thin          ? "0.6"
          : series == 0 ? "2.2"
                        : "1.6",
          dashes[thin ? 0 : series % N_DASHES]);
}

static void draw_circle(const struct plot *plot, int series, double x, double y)
{
    const enum chart_kind kind = plot->chart->series[series].kind;
    print(plot->to,
          "<circle stroke-dasharray=\"none\" fill=\"%s\" cx=\"%.2f\" cy=\"%.2f\" r=\"%d\"/>",
          looks[kind].open ? "#fff" : colours[series % N_COLOURS], x, y,
          looks[kind].radius > 0 ? looks[kind].radius : 4);
}

/* Draws the line through all points. A value that cannot be drawn interrupts it. */
static void draw_path(const struct plot *plot, const struct chart_series *series)
{
    const bool steps = series->kind == CHART_STEPS;
    print_text(plot->to, "<path stroke-linejoin=\"round\" d=\"");
    for (int i = 0; i < series->n; i++)
        if (is_drawn(plot, series, i)) {
            const bool begins = !is_drawn(plot, series, i - 1);
            print(plot->to, "%c%.2f%c%.2f",
                  begins  ? 'M'
                  : steps ? 'H'
                          : 'L',
                  place_of(plot, ACROSS, series->x[i]), begins || !steps ? ',' : 'V',
                  place_of(plot, side_of(series), series->y[i]));
        }
    print_text(plot->to, "\"/>");
}

/* Returns the number of a series' first label: numbers go on from series to series. */
static int first_number(const struct plot *plot, int series)
{
    int number = 1;
    for (int s = 0; s < series; s++)
        number += plot->chart->series[s].labels ? plot->chart->series[s].n : 0;
    return number;
}

/* A point of a line whose neighbours are missing is a dot. */
static void draw_series(const struct plot *plot, int index)
{
    const struct chart_series *series = &plot->chart->series[index];
    open_group(plot, index);
    print_text(plot->to, "<title>");
    put_text(plot->to, series->name);
    print_text(plot->to, "</title>\n");
    if (looks[series->kind].line)
        draw_path(plot, series);
    for (int i = 0; i < series->n; i++) {
        const bool alone = !is_drawn(plot, series, i - 1) && !is_drawn(plot, series, i + 1);
        if (!is_drawn(plot, series, i) || (looks[series->kind].radius == 0 && !alone))
            continue;
        const double x = place_of(plot, ACROSS, series->x[i]),
                     y = place_of(plot, side_of(series), series->y[i]);
        draw_circle(plot, index, x, y);
        if (series->labels)
            print(plot->to,
                  "<text stroke=\"none\" fill=\"#222\" text-anchor=\"end\" x=\"%.2f\" "
                  "y=\"%.2f\">%d</text>",
                  x - 6, fmin(y + 14, BOTTOM - 4), first_number(plot, index) + i);
    }
    print_text(plot->to, "</g>\n");
}

/* ---- the legend, and the file ---- */

static void draw_name(const struct plot *plot, int y, const char *name, const char *note)
{
    print(plot->to, "<text x=\"%d\" y=\"%d\">", LEFT + SAMPLE + 8, y + 4);
    put_text(plot->to, name);
    print(plot->to, "%s</text>\n", note);
}

/* Draws a row for each series, and for each point that has a label. */
static void draw_legend(const struct plot *plot, int y)
{
    for (int s = 0; s < plot->chart->n; s++, y += ROW) {
        const struct chart_series *series = &plot->chart->series[s];
        open_group(plot, s);
        if (looks[series->kind].line)
            print(plot->to, "<path d=\"M%d,%dh%d\"/>", LEFT, y, SAMPLE);
        if (looks[series->kind].radius > 0)
            draw_circle(plot, s, LEFT + SAMPLE / 2.0, y);
        print_text(plot->to, "</g>");
        draw_name(plot, y, series->name, series->right ? " (right axis)" : "");
        for (int i = 0; series->labels && i < series->n; i++) {
            y += ROW;
            print(plot->to, "<text text-anchor=\"end\" x=\"%d\" y=\"%d\">%d</text>", LEFT + SAMPLE,
                  y + 4, first_number(plot, s) + i);
            draw_name(plot, y, series->labels[i], "");
        }
    }
}

void chart_svg(const struct chart *chart, struct printed *to)
{
    struct plot plot = {.chart = chart, .to = to};
    const int legend = BOTTOM + 70;
    int height = legend;
    for (int s = 0; s < chart->n; s++)
        height += ROW * (1 + (chart->series[s].labels ? chart->series[s].n : 0));
    fit_axes(&plot);
    print(to,
          "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
          "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"%d\" height=\"%d\" "
          "viewBox=\"0 0 %d %d\" font-family=\"system-ui, sans-serif\" font-size=\"12\" "
          "fill=\"#222\">\n<title>",
          WIDTH, height, WIDTH, height);
    put_text(to, chart->title);
    print(to,
          "</title>\n<rect width=\"%d\" height=\"%d\" fill=\"#fff\"/>\n"
          "<text x=\"%d\" y=\"26\" font-size=\"16\" font-weight=\"600\">",
          WIDTH, height, LEFT);
    put_text(to, chart->title);
    print_text(to, "</text>\n");
    draw_axis(&plot, ACROSS, chart->x_label);
    draw_axis(&plot, ON_LEFT, chart->y_label);
    if (chart->right_label)
        draw_axis(&plot, ON_RIGHT, chart->right_label);
    print(to,
          "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"none\" stroke=\"#333\"/>\n",
          LEFT, TOP, RIGHT - LEFT, BOTTOM - TOP);
    for (int s = chart->n - 1; s >= 0; s--) /* the first one on top */
        draw_series(&plot, s);
    draw_legend(&plot, legend);
    print_text(to, "</svg>\n");
}
