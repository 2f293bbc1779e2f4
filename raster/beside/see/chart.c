/* SPDX-License-Identifier: MIT */
/* Curves as SVG 1.1, to be printed: lines differ in colour and in dashes, so that colour-blind eyes
 * and prints without colours keep them apart. Here is also the look that all charts share. */
#include <math.h>
#include <string.h>

#include "raster/beside/see/inside.h"

enum {
    PLOT_HEIGHT = 340,
    STRIP = 9,  /* height of the spectral colours */
    SAMPLE = 36 /* length of a line in the legend */
};
/* The width of a character over the font's size. Few characters are wider. */
static const double character = 0.6;

/* ---- text ---- */

void chart_text(struct printed *to, const char *text, int most)
{
    const unsigned char *at = (const unsigned char *)text;
    for (; *at != '\0' && most > 0; most--) {
        const int length = utf8_length(at);
        const bool last = most == 1 && at[length > 0 ? length : 1] != '\0';
        char one[5] = "";
        if (last)
            print_text(to, "…");
        else if (printable_length(at) == 0)
            print_text(to, "\xef\xbf\xbd");
        else
            print_xml(to, memcpy(one, at, (size_t)length));
        at += length > 0 ? length : 1;
    }
}

int chart_fitting(double width, int size)
{
    return (int)(width / (character * size));
}

int chart_text_length(const char *text)
{
    int length = 0;
    for (; *text != '\0'; text++)
        length += ((unsigned char)*text & 0xc0) != 0x80;
    return length;
}

void chart_exponent(struct printed *to, int exponent)
{
    static const char *const digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    char text[16];
    snprintf(text, sizeof text, "%d", exponent);
    print_text(to, "×10");
    for (const char *c = text; *c != '\0'; c++)
        print_text(to, *c == '-' ? "⁻" : digits[*c - '0']);
}

/* ---- what all charts have ---- */

void chart_head(struct printed *to, const char *title, int height)
{
    print(to,
          "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
          "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"%d\" height=\"%d\" "
          "viewBox=\"0 0 %d %d\" font-family=\"system-ui, sans-serif\" font-size=\"%d\" "
          "fill=\"#222\">\n<title>",
          CHART_WIDTH, height, CHART_WIDTH, height, CHART_TEXT_SIZE);
    chart_text(to, title, 200);
    print(to,
          "</title>\n<rect width=\"%d\" height=\"%d\" fill=\"#fff\"/>\n"
          "<text x=\"%d\" y=\"26\" font-size=\"%d\" font-weight=\"600\">",
          CHART_WIDTH, height, CHART_LEFT, CHART_TITLE_SIZE);
    chart_text(to, title, chart_fitting(CHART_WIDTH - CHART_LEFT, CHART_TITLE_SIZE));
    print_text(to, "</text>\n");
}

struct chart_legend chart_legend(int n, int longest, double sample)
{
    const int room = chart_fitting(CHART_WIDTH - CHART_LEFT, CHART_TEXT_SIZE);
    const int fitting = room / (longest + chart_fitting(sample + 24, CHART_TEXT_SIZE));
    const int columns = fitting < 1 ? 1 : fitting > 3 ? 3 : fitting;
    return (struct chart_legend){(n + columns - 1) / columns,
                                 (CHART_WIDTH - CHART_LEFT) / (double)columns};
}

double legend_x(const struct chart_legend *legend, int cell)
{
    return CHART_LEFT + legend->column * (cell / legend->rows);
}

double legend_y(const struct chart_legend *legend, int top, int cell)
{
    return top + CHART_LEGEND_ROW * (cell % legend->rows);
}

/* ---- the plot ---- */

/* Curves over wavelengths: the radiance, shaded up to its standard deviation over a region, and
 * what explains it. */
struct plot {
    const struct probe *probe;
    struct chart_area area;
};

static int lines_of(const struct probe *probe)
{
    return probe->n_columns - SPREAD;
}

static const struct probe_column *column_of(const struct plot *plot, int line)
{
    return &plot->probe->columns[line == 0 ? MEAN : line + SPREAD];
}

static bool has_spread(const struct plot *plot, int line)
{
    return line == 0 && (plot->probe->width > 1 || plot->probe->height > 1);
}

static const char *name_of(const struct plot *plot, int line)
{
    return has_spread(plot, line) ? "radiance ± standard deviation" : column_of(plot, line)->name;
}

static const struct axis *axis_of(const struct plot *plot, int line)
{
    return column_of(plot, line)->relative ? &plot->area.right : &plot->area.y;
}

static bool is_drawn(const struct plot *plot, int line, int i)
{
    return i < plot->probe->n && isfinite(plot->probe->columns[WAVELENGTH].values[i]) &&
           isfinite(column_of(plot, line)->values[i]);
}

static double spread_at(const struct plot *plot, int line, int i)
{
    const double y = column_of(plot, line)->values[i],
                 spread = has_spread(plot, line) ? plot->probe->columns[SPREAD].values[i] : 0;
    return isfinite(y - spread) && isfinite(y + spread) ? spread : 0;
}

/* Returns the lower end of the spread at a point. It is not below 0 if the value is not, because
 * radiances are not negative. */
static double band_low(const struct plot *plot, int line, int i)
{
    const double y = column_of(plot, line)->values[i];
    return fmax(y - spread_at(plot, line, i), fmin(y, 0));
}

/* Returns the upper end. */
static double band_high(const struct plot *plot, int line, int i)
{
    return column_of(plot, line)->values[i] + spread_at(plot, line, i);
}

static void fit_axes(struct plot *plot)
{
    double x[2] = {HUGE_VAL, -HUGE_VAL}, left[2] = {HUGE_VAL, -HUGE_VAL}, right[2] = {0, 1};
    for (int line = 0; line < lines_of(plot->probe); line++) {
        double *y = axis_of(plot, line) == &plot->area.right ? right : left;
        for (int i = 0; i < plot->probe->n; i++)
            if (is_drawn(plot, line, i)) {
                const double nm = plot->probe->columns[WAVELENGTH].values[i];
                x[0] = fmin(x[0], nm);
                x[1] = fmax(x[1], nm);
                y[0] = fmin(y[0], band_low(plot, line, i));
                y[1] = fmax(y[1], band_high(plot, line, i));
            }
    }
    plot->area.x = axis_linear(x[0], x[1], 10);
    plot->area.y = axis_from_zero(left[0], left[1], 6);
    plot->area.right = axis_from_zero(right[0], right[1], 6);
}

static double x_at(const struct plot *plot, int i)
{
    return chart_x(&plot->area, plot->probe->columns[WAVELENGTH].values[i]);
}

static double y_of(const struct plot *plot, int line, double value)
{
    return chart_y(&plot->area, axis_of(plot, line), value);
}

/* ---- colours of wavelengths ---- */

/* The colours of monochromatic light from 380 nm in steps of 10 nm, in sRGB, as the CIE 1931
 * observer sees them. White is added until no channel is negative; the largest channel of all is 1.
 */
enum { VISIBLE_FIRST = 380, VISIBLE_STEP = 10, N_VISIBLE = 36 };
static const unsigned visible[N_VISIBLE] = {
    0x03000a, 0x080019, 0x170033, 0x2d0059, 0x500097, 0x6f00d4, 0x7400ea, 0x6500e9, 0x3d00df,
    0x004cca, 0x007cb3, 0x009aa0, 0x00b99b, 0x00d9a0, 0x00ef9e, 0x00f38e, 0x00e86c, 0x22d100,
    0x81c700, 0xb4b700, 0xd99e00, 0xf27d00, 0xff5400, 0xfe1500, 0xf40033, 0xdb003a, 0xbd0036,
    0x9b002d, 0x790023, 0x5a0018, 0x42000f, 0x2d0008, 0x1f0004, 0x140002, 0x0b0001, 0x050001,
};

static void draw_visible(const struct plot *plot)
{
    const double end = VISIBLE_FIRST + VISIBLE_STEP * (N_VISIBLE - 1);
    const double left = fmax(chart_x(&plot->area, VISIBLE_FIRST), CHART_LEFT);
    const double right = fmin(chart_x(&plot->area, end), CHART_LEFT + plot->area.width);
    if (right <= left)
        return;
    print(plot->area.to,
          "<defs><linearGradient id=\"visible\" gradientUnits=\"userSpaceOnUse\" x1=\"%.2f\" "
          "y1=\"0\" x2=\"%.2f\" y2=\"0\">\n",
          chart_x(&plot->area, VISIBLE_FIRST), chart_x(&plot->area, end));
    for (int i = 0; i < N_VISIBLE; i++)
        print(plot->area.to, "<stop offset=\"%.4f\" stop-color=\"#%06x\"/>\n",
              i / (N_VISIBLE - 1.0), visible[i]);
    print(plot->area.to,
          "</linearGradient></defs>\n<rect x=\"%.2f\" y=\"%d\" width=\"%.2f\" height=\"%d\" "
          "fill=\"url(#visible)\"/>\n",
          left, CHART_TOP + PLOT_HEIGHT, right - left, STRIP);
}

/* ---- lines drawn ---- */

/* The colours of Okabe and Ito, "Color Universal Design" (2008), without its yellow, which is too
 * pale on white. With five dashes no two of 35 lines are alike. */
static const char *const colours[] = {"#000000", "#0072b2", "#d55e00", "#009e73",
                                      "#cc79a7", "#e69f00", "#56b4e9"};
static const char *const dashes[] = {"", "9 4", "2 3", "9 3 2 3", "5 3"};
enum { N_COLOURS = 7, N_DASHES = 5 };

/* Writes the stroke of a line. The first line is thicker: the others explain it. */
static void put_stroke(struct printed *to, int line)
{
    print(to, "fill=\"none\" stroke=\"%s\" stroke-width=\"%s\" stroke-linejoin=\"round\"",
          colours[line % N_COLOURS], line == 0 ? "2.2" : "1.6");
    if (line % N_DASHES > 0)
        print(to, " stroke-dasharray=\"%s\"", dashes[line % N_DASHES]);
}

/* Writes the path through points from first to end - 1; upper: through the upper ends of their
 * spread. */
static void put_path(const struct plot *plot, int line, int first, int end, bool upper)
{
    for (int i = first; i < end; i++)
        print(
            plot->area.to, "%c%.2f,%.2f", i == first ? 'M' : 'L', x_at(plot, i),
            y_of(plot, line, upper ? band_high(plot, line, i) : column_of(plot, line)->values[i]));
}

/* Draws neighbouring points from first to end - 1, and their spread, from the first to the last
 * point and back. A single point is a dot, and its spread a bar. */
static void draw_run(const struct plot *plot, int line, int first, int end)
{
    const char *colour = colours[line % N_COLOURS];
    struct printed *to = plot->area.to;
    if (end - first == 1) {
        print(to,
              "<path stroke=\"%s\" d=\"M%.2f,%.2fV%.2f\"/><circle fill=\"%s\" cx=\"%.2f\" "
              "cy=\"%.2f\" r=\"4\"/>\n",
              colour, x_at(plot, first), y_of(plot, line, band_low(plot, line, first)),
              y_of(plot, line, band_high(plot, line, first)), colour, x_at(plot, first),
              y_of(plot, line, column_of(plot, line)->values[first]));
        return;
    }
    if (has_spread(plot, line)) {
        print(to, "<path fill=\"%s\" fill-opacity=\"0.18\" d=\"", colour);
        put_path(plot, line, first, end, true);
        for (int i = end - 1; i >= first; i--)
            print(to, "L%.2f,%.2f", x_at(plot, i), y_of(plot, line, band_low(plot, line, i)));
        print_text(to, "Z\"/>\n");
    }
    print_text(to, "<path ");
    put_stroke(to, line);
    print_text(to, " d=\"");
    put_path(plot, line, first, end, false);
    print_text(to, "\"/>\n");
}

/* Draws a line. Values that are not finite interrupt it. */
static void draw_line(const struct plot *plot, int line)
{
    print_text(plot->area.to, "<g><title>");
    chart_text(plot->area.to, name_of(plot, line), 200);
    print_text(plot->area.to, "</title>\n");
    for (int first = 0, end; first < plot->probe->n; first = end) {
        for (end = first; is_drawn(plot, line, end);)
            end++;
        if (end > first)
            draw_run(plot, line, first, end);
        else
            end++;
    }
    print_text(plot->area.to, "</g>\n");
}

/* ---- legend ---- */

static const char *legend_note(const struct plot *plot, int line)
{
    return axis_of(plot, line) == &plot->area.right ? " (right axis)" : "";
}

static struct chart_legend legend_of(const struct plot *plot)
{
    int longest = 1;
    for (int line = 0; line < lines_of(plot->probe); line++) {
        const int length =
            chart_text_length(name_of(plot, line)) + chart_text_length(legend_note(plot, line));
        longest = length > longest ? length : longest;
    }
    return chart_legend(lines_of(plot->probe), longest, SAMPLE);
}

static void draw_legend(const struct plot *plot, int top)
{
    const struct chart_legend legend = legend_of(plot);
    for (int line = 0; line < lines_of(plot->probe); line++) {
        const char *note = legend_note(plot, line);
        const double x = legend_x(&legend, line), y = legend_y(&legend, top, line);
        print(plot->area.to, "<path ");
        put_stroke(plot->area.to, line);
        print(plot->area.to, " d=\"M%.2f,%.2fh%d\"/><text x=\"%.2f\" y=\"%.2f\">", x, y, SAMPLE,
              x + SAMPLE + 8, y + 0.35 * CHART_TEXT_SIZE);
        chart_text(plot->area.to, name_of(plot, line),
                   chart_fitting(legend.column - SAMPLE - 16, CHART_TEXT_SIZE) -
                       chart_text_length(note));
        print(plot->area.to, "%s</text>\n", note);
    }
}

/* ---- the file ---- */

void probe_svg(const struct probe *probe, struct printed *to)
{
    const int legend =
        CHART_TOP + PLOT_HEIGHT + STRIP + CHART_TICK + CHART_TEXT_SIZE + CHART_LABEL_SIZE + 44;
    struct plot plot = {.probe = probe, .area = {.to = to, .height = PLOT_HEIGHT}};
    char region[96], title[512];
    bool right = false; /* there is an axis there */
    for (int column = MEAN; column < probe->n_columns; column++)
        right = right || probe->columns[column].relative;
    plot.area.width = CHART_WIDTH - CHART_LEFT - (right ? CHART_RIGHT_AXIS : CHART_MARGIN);
    fit_axes(&plot);
    region_text(probe, region, sizeof region);
    snprintf(title, sizeof title, "%s%s%s%s%s", probe->object ? probe->object : "",
             probe->object ? ", " : "", probe->width > 0 ? region : "",
             probe->width > 0 ? ": " : "", probe->source);
    chart_head(to, title, legend + CHART_LEGEND_ROW * legend_of(&plot).rows);
    draw_visible(&plot);
    chart_axes(&plot.area,
               (const char *const[]){"wavelength (nm)",
                                     probe->width == 0 ? "value"
                                     : probe->absolute ? "radiance (W sr⁻¹ m⁻² nm⁻¹)"
                                                       : "radiance (W sr⁻¹ m⁻² nm⁻¹, relative)",
                                     right ? "reflectance, excitation, emission" : NULL},
               STRIP);
    for (int line = lines_of(probe) - 1; line >= 0; line--) /* the first one on top */
        draw_line(&plot, line);
    draw_legend(&plot, legend);
    print_text(to, "</svg>\n");
}
