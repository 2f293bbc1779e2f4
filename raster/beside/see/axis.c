/* SPDX-License-Identifier: MIT */
/* The axes of all charts, linear and logarithmic: scales that hold the values, ticks at round
 * numbers, grid lines and labels. Numbers are rounded to decimals only, so that the bytes are the
 * same everywhere. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/beside/see/inside.h"

/* ---- linear scales ---- */

/* Returns the decimal exponent of a value, and its first digit, as printf rounds them. */
static int decimal_exponent(double value, int *digit)
{
    char text[32];
    snprintf(text, sizeof text, "%.0e", value);
    *digit = text[0] - '0';
    return atoi(strchr(text, 'e') + 1);
}

static double power_of_ten(int exponent)
{
    char text[32];
    snprintf(text, sizeof text, "1e%d", exponent);
    return strtod(text, NULL);
}

/* Chooses a unit other than 1 for values that would need more than five digits before the point, or
 * three zeros behind it. */
static void choose_unit(struct axis *axis, double largest)
{
    int digit, exponent = largest > 0 ? decimal_exponent(largest, &digit) : 0;
    if (exponent > 4 || exponent < -2)
        axis->exponent = exponent > -323 ? exponent : -323; /* the least whose power is not 0 */
    axis->unit = power_of_ten(axis->exponent);
}

/* Chooses 1, 2 or 5 times a power of ten, for about n steps. */
static void choose_step(struct axis *axis, int n)
{
    int digit, exponent = decimal_exponent((axis->high - axis->low) / n, &digit);
    const int round = digit < 2 ? 1 : digit < 3 ? 2 : digit < 6 ? 5 : 10;
    axis->step = round * power_of_ten(exponent);
    exponent += round == 10;
    axis->decimals = exponent < 0 ? -exponent : 0;
}

struct axis axis_linear(double low, double high, int steps)
{
    struct axis axis = {.logarithmic = false};
    if (low > high) {
        low = 0;
        high = 1;
    }
    choose_unit(&axis, fmax(fabs(low), fabs(high)));
    axis.low = low / axis.unit;
    axis.high = high / axis.unit;
    const double size = fmax(fabs(axis.low), fabs(axis.high));
    if (axis.high - axis.low <= 1e-9 * size) { /* one value: with some room around it */
        axis.low -= size > 0 ? size / 20 : 1;
        axis.high += size > 0 ? size / 20 : 1;
    }
    choose_step(&axis, steps);
    return axis;
}

struct axis axis_from_zero(double low, double high, int steps)
{
    if (low <= high) {
        low = fmin(low, 0);
        high = fmax(high, 0);
    }
    if (low == 0 && high == 0)
        high = 1;
    struct axis axis = axis_linear(low, high, steps);
    axis.low = floor(axis.low / axis.step) * axis.step;
    axis.high = ceil(axis.high / axis.step) * axis.step;
    return axis;
}

/* ---- logarithmic scales ---- */

double decimal_logarithm(double value)
{
    const double of_10 = 3.32192809488736234787; /* log2 10 */
    return binary_logarithm(value) / of_10;
}

/* Ticks of a logarithmic axis are 1, 2 and 5 times a power of ten: tick 3k is 10^k. */
static int decade_of(long tick)
{
    return (int)floor((double)tick / 3);
}

static double logarithm_of_tick(long tick)
{
    static const double part[] = {0, 0.30102999566398119521, 0.69897000433601880479};
    const int decade = decade_of(tick);
    return decade + part[tick - 3 * decade];
}

/* Returns the last tick at or below a logarithm. */
static long tick_below(double logarithm)
{
    long tick = 3 * ((long)floor(logarithm) + 1);
    while (logarithm_of_tick(tick) > logarithm)
        tick--;
    return tick;
}

struct axis axis_logarithmic(double low, double high)
{
    const double room = 0.04; /* beyond the values */
    if (low > high)
        return (struct axis){.logarithmic = true, .low = -1, .high = 0};
    return (struct axis){.logarithmic = true,
                         .low = logarithm_of_tick(tick_below(low - room)),
                         .high = logarithm_of_tick(tick_below(high + room) + 1)};
}

/* ---- from values and ticks to places ---- */

/* Returns the part of the axis that lies below a place on its scale: 0 at its low end, 1 at its
 * high one. */
static double part_below(const struct axis *axis, double on_scale)
{
    return (on_scale - axis->low) / (axis->high - axis->low);
}

static double part_of(const struct axis *axis, double value)
{
    if (!axis->logarithmic)
        return part_below(axis, value / axis->unit);
    return value > 0 ? fmax(part_below(axis, decimal_logarithm(value)), 0) : 0;
}

double chart_x(const struct chart_area *area, double value)
{
    return CHART_LEFT + area->width * part_of(&area->x, value);
}

double chart_y(const struct chart_area *area, const struct axis *axis, double value)
{
    return CHART_TOP + area->height * (1 - part_of(axis, value));
}

/* Ticks of a linear axis are whole multiples of its step. */
static double tick_part(const struct axis *axis, long tick)
{
    return part_below(axis,
                      axis->logarithmic ? logarithm_of_tick(tick) : (double)tick * axis->step);
}

static long first_tick(const struct axis *axis)
{
    return axis->logarithmic ? tick_below(axis->low - 1e-9) + 1
                             : (long)ceil(axis->low / axis->step - 1e-6);
}

static long last_tick(const struct axis *axis)
{
    return axis->logarithmic ? tick_below(axis->high + 1e-9)
                             : (long)floor(axis->high / axis->step + 1e-6);
}

/* ---- axes drawn ---- */

/* Returns whether a tick has a label on an axis of this length in pixels. On a logarithmic axis
 * ticks at 2 and 5 have one where there is room, and powers of ten where they are not too many. */
static bool is_labelled(const struct axis *axis, long tick, double length)
{
    const double decade = length / (axis->high - axis->low);
    const int skip = 1 + (int)(60 / decade);
    return !axis->logarithmic || decade > 120 || (tick % 3 == 0 && tick / 3 % skip == 0);
}

static const char *grid_colour(const struct axis *axis, long tick)
{
    return !axis->logarithmic ? "#e4e4e4" : tick % 3 == 0 ? "#dcdcdc" : "#f0f0f0";
}

/* Writes the value of a logarithmic tick in digits, or as a power of ten where there are too many.
 */
static void put_logarithmic(struct printed *to, long tick)
{
    static const int digits[] = {1, 2, 5};
    const int decade = decade_of(tick), digit = digits[tick - 3 * decade];
    if (decade < -4 || decade > 4) {
        print(to, "%d", digit);
        chart_exponent(to, decade);
    } else if (decade < 0)
        print(to, "0.%0*d", -decade, digit);
    else
        print(to, "%d%.*s", digit, decade, "0000");
}

/* Writes the value of a tick, and ends its text. */
static void put_value(struct printed *to, const struct axis *axis, long tick)
{
    if (axis->logarithmic)
        put_logarithmic(to, tick);
    else
        print(to, "%.*f", axis->decimals, (double)tick * axis->step);
    print_text(to, "</text>");
}

static void draw_x(const struct chart_area *area, const char *label, int strip)
{
    const struct axis *axis = &area->x;
    const int bottom = CHART_TOP + area->height, below = bottom + strip + CHART_TICK;
    struct printed *to = area->to;
    print_text(to, "<g text-anchor=\"middle\">\n");
    for (long tick = first_tick(axis); tick <= last_tick(axis); tick++) {
        const double x = CHART_LEFT + area->width * tick_part(axis, tick);
        const bool labelled = is_labelled(axis, tick, area->width);
        print(to,
              "<path d=\"M%.2f,%dV%d\" stroke=\"%s\"/><path d=\"M%.2f,%dv%d\" "
              "stroke=\"#333\"/>",
              x, CHART_TOP, bottom, grid_colour(axis, tick), x, bottom + strip,
              labelled ? CHART_TICK : CHART_TICK / 2);
        if (labelled) {
            print(to, "<text x=\"%.2f\" y=\"%d\">", x, below + CHART_TEXT_SIZE + 1);
            put_value(to, axis, tick);
        }
        print_text(to, "\n");
    }
    print(to, "<text x=\"%.2f\" y=\"%d\" font-size=\"%d\">", CHART_LEFT + area->width / 2,
          below + CHART_TEXT_SIZE + CHART_LABEL_SIZE + 10, CHART_LABEL_SIZE);
    chart_text(to, label, chart_fitting(area->width, CHART_LABEL_SIZE));
    if (axis->exponent != 0) {
        print_text(to, " ");
        chart_exponent(to, axis->exponent);
    }
    print_text(to, "</text>\n</g>\n");
}

/* Draws the ticks of an axis that stands at x. Labels end, or on the right begin, at label_x. */
static void draw_y_ticks(const struct chart_area *area, const struct axis *axis, double x,
                         double label_x)
{
    const int side = label_x < x ? -1 : 1, bottom = CHART_TOP + area->height;
    for (long tick = first_tick(axis); tick <= last_tick(axis); tick++) {
        const double y = CHART_TOP + area->height * (1 - tick_part(axis, tick));
        const bool covered = axis->clipped && y > bottom - 1.2 * CHART_TEXT_SIZE;
        const bool labelled = is_labelled(axis, tick, area->height) && !covered;
        if (side < 0)
            print(area->to, "<path d=\"M%.2f,%.2fh%.2f\" stroke=\"%s\"/>", x, y, area->width,
                  grid_colour(axis, tick));
        print(area->to, "<path d=\"M%.2f,%.2fh%d\" stroke=\"#333\"/>", x, y,
              side * (labelled ? CHART_TICK : CHART_TICK / 2));
        if (labelled) {
            print(area->to, "<text x=\"%.2f\" y=\"%.2f\">", label_x, y + 0.35 * CHART_TEXT_SIZE);
            put_value(area->to, axis, tick);
        }
        print_text(area->to, "\n");
    }
    if (axis->clipped)
        print(area->to, "<text x=\"%.2f\" y=\"%.2f\">≤ %.2g</text>\n", label_x,
              bottom + 0.35 * CHART_TEXT_SIZE, axis->least);
}

static void draw_y(const struct chart_area *area, const char *label, bool right)
{
    const struct axis *axis = right ? &area->right : &area->y;
    const int side = right ? 1 : -1;
    const double x = right ? CHART_LEFT + area->width : CHART_LEFT;
    const double label_x = x + side * (CHART_TICK + 4);
    struct printed *to = area->to;
    print(to, "<g text-anchor=\"%s\">\n", right ? "start" : "end");
    draw_y_ticks(area, axis, x, label_x);
    if (axis->exponent != 0) {
        print(to, "<text x=\"%.2f\" y=\"%d\">", label_x, CHART_TOP - 10);
        chart_exponent(to, axis->exponent);
        print_text(to, "</text>\n");
    }
    print(to,
          "<text text-anchor=\"middle\" font-size=\"%d\" transform=\"translate(%.2f,%d) "
          "rotate(-90)\">",
          CHART_LABEL_SIZE, right ? x + CHART_RIGHT_AXIS - 14 : 20, CHART_TOP + area->height / 2);
    chart_text(to, label, chart_fitting(area->height + CHART_TOP, CHART_LABEL_SIZE));
    print_text(to, "</text>\n</g>\n");
}

void chart_axes(const struct chart_area *area, const char *const labels[3], int strip)
{
    draw_x(area, labels[0], strip);
    draw_y(area, labels[1], false);
    if (labels[2])
        draw_y(area, labels[2], true);
    print(area->to,
          "<rect x=\"%d\" y=\"%d\" width=\"%.2f\" height=\"%d\" fill=\"none\" "
          "stroke=\"#333\"/>\n",
          CHART_LEFT, CHART_TOP, area->width, area->height);
}
