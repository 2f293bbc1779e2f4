/* SPDX-License-Identifier: MIT */
/* The room "chart": charts as SVG. */
#ifndef CHART_H
#define CHART_H

#include "data/base/base.h"

/* ---- chart.c: curves ---- */

struct chart_line {
    const char *name;
    int n;
    const double *x, *y;
    const double *spread; /* shaded from y - spread to y + spread, but not below 0 if y >= 0; NULL:
                             none */
    bool right;           /* uses the axis on the right, e.g. a reflectance */
};
struct chart {
    const char *title, *x_label, *y_label, *right_label; /* right_label NULL: no such axis */
    const struct chart_line *lines;
    int n_lines;
    bool wavelengths; /* x is in nm: a strip shows the colours of the visible range */
};
void chart_svg(const struct chart *chart, struct printed *to); /* prints a whole SVG 1.1 file */

/* ---- frontier.c: what accuracy costs ---- */

struct frontier_point {
    const char *name;
    double cost, cost_low, cost_high; /* above 0 */
    double error;                     /* 0 or more */
    bool best;                        /* on the frontier */
    bool uncertain;                   /* noise might move it onto the frontier, or off it */
};
struct frontier {
    const char *title, *cost_label, *error_label;
    const struct frontier_point *points;
    int n;
};
/* Prints a whole SVG 1.1 file. Fails without memory. Both axes are logarithmic. Errors below
 * 1/1000 of the largest, and 0, lie on the lower edge, which has a label that says so. Points have
 * numbers, and a legend names them. Steps join the points of the frontier; the others are pale. */
bool frontier_svg(const struct frontier *frontier, struct printed *to, struct error *err);

/* ---- Inside this room: how all charts look, in chart.c ---- */

/* Lengths in SVG's pixels, 96 an inch. */
enum {
    CHART_WIDTH = 800,
    CHART_LEFT = 84,
    CHART_TOP = 52,
    CHART_MARGIN = 28,     /* on the right, without an axis there */
    CHART_RIGHT_AXIS = 72, /* on the right, with an axis there */
    CHART_TICK = 5,
    CHART_LEGEND_ROW = 20,
    CHART_TITLE_SIZE = 16,
    CHART_LABEL_SIZE = 13,
    CHART_TEXT_SIZE = 12
};

/* The rectangle that the axes enclose. Its left edge is at CHART_LEFT, its top at CHART_TOP. */
struct chart_area {
    struct printed *to; /* the SVG file */
    double width;
    int height;
};
/* Writes the beginning of a file of this height, with the title. */
void chart_head(struct printed *to, const char *title, int height);
void chart_frame(const struct chart_area *area); /* draws its border */
/* Writes a text, escaped. The last of more than `most` characters becomes an ellipsis. A character
 * that XML cannot hold becomes U+FFFD. */
void chart_text(struct printed *to, const char *text, int most);
/* Writes a decimal exponent: ×10 and raised digits. */
void chart_exponent(struct printed *to, int exponent);
int chart_fitting(double width, int size); /* characters that fit into a width */
int chart_text_length(const char *text);   /* in characters of UTF-8 */
/* Cells of a legend, filled column by column. */
struct chart_grid {
    int rows;
    double column; /* width */
};
/* Makes a grid of n cells in 1 to 3 columns. Each cell has room for a sample of this width and a
 * text of `longest` characters, unless there is one column only. */
struct chart_grid chart_grid(int n, int longest, double sample);

/* ---- Inside this room: axes of all charts, in axis.c ---- */

/* An axis from `low` to `high` on its scale: values over the unit, or decimal logarithms. */
struct axis {
    bool logarithmic;
    double low, high;
    double unit, step; /* linear: the unit is a power of ten; the step between ticks is in units */
    int exponent;      /* of the unit; 0: labels are values */
    int decimals;      /* of a label */
    bool clipped;      /* logarithmic: smaller values lie at the low end, */
    double least;      /* whose value is this one */
};
/* Makes a linear axis from low to high with about so many steps; from 0 to 1 if low > high. */
struct axis axis_linear(double low, double high, int steps);
/* Makes a linear axis that contains 0 and ends at whole steps. */
struct axis axis_from_zero(double low, double high, int steps);
/* Makes a logarithmic axis with some room beyond the decimal logarithms low and high; from 0.1 to 1
 * if low > high. */
struct axis axis_logarithmic(double low, double high);
double decimal_logarithm(double value); /* of a finite value above 0 */
/* Return the place of a value in the SVG file. On a logarithmic axis values below its low end, and
 * 0, lie at that end. */
double chart_x(const struct chart_area *area, const struct axis *axis, double value);
double chart_y(const struct chart_area *area, const struct axis *axis, double value);
/* Draw the ticks of an axis, their grid lines and labels, and the label of the axis. The x axis
 * lies below the area and a strip of this height. A y axis on the right has no grid lines. */
void axis_draw_x(const struct chart_area *area, const struct axis *axis, const char *label,
                 int strip);
void axis_draw_y(const struct chart_area *area, const struct axis *axis, const char *label,
                 bool right);

#endif
