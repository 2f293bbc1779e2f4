/* SPDX-License-Identifier: MIT */
/* The room "chart": charts as SVG. */
#ifndef CHART_H
#define CHART_H

#include <stdbool.h>
#include <stdio.h>

/* ---- chart.c: curves ---- */

struct chart_line {
    const char *name;
    int n;
    const double *x, *y;
    const double *spread; /* drawn as a band of y - spread to y + spread; where y >= 0 the part
                             below 0 is cut off; NULL: none */
    bool right;           /* belongs to the axis on the right, e.g. a reflectance */
};
struct chart {
    const char *title, *x_label, *y_label, *right_label; /* right_label NULL: no such axis */
    const struct chart_line *lines;
    int n_lines;
    bool wavelengths; /* x is in nm: the visible range is shown in its colours */
};
/* Returns a whole SVG 1.1 file, allocated; NULL: no memory. */
char *chart_svg(const struct chart *chart);

/* ---- frontier.c: what accuracy costs ---- */

struct frontier_point {
    const char *name;
    double cost, cost_low, cost_high; /* above 0 */
    double error;                     /* 0 or more */
    bool best;                        /* on the frontier */
    bool uncertain;                   /* within noise of being on it or not */
};
struct frontier {
    const char *title, *cost_label, *error_label;
    const struct frontier_point *points;
    int n;
};
/* Returns a whole SVG 1.1 file, allocated; NULL: no memory. Both axes are logarithmic; errors below
 * 1/1000 of the largest, or 0, lie on the lower edge, which says so. All points are labelled; those
 * of the frontier have their names and are joined by steps, the others are pale. */
char *frontier_svg(const struct frontier *frontier);

/* ---- Inside this room: how all charts look, in chart.c ---- */

/* In SVG's pixels, 96 an inch. */
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
    FILE *to; /* the SVG file */
    double width;
    int height;
};
/* Draws into an SVG file, allocated; NULL: no memory. */
char *chart_file(void (*draw)(void *plot, FILE *to), void *plot);
/* Writes the beginning of a file of this height, with the title. */
void chart_head(FILE *to, const char *title, int height);
/* Draws the frame around the area. */
void chart_frame(const struct chart_area *area);
/* Writes at most so many characters of a text, escaped. A character that XML cannot hold becomes
 * U+FFFD. */
void chart_text(FILE *to, const char *text, int most);
/* Writes a decimal exponent: ×10 and small digits. */
void chart_exponent(FILE *to, int exponent);
/* How many characters fit beside each other, and the width of n characters. */
int chart_fitting(double width, int size);
double chart_text_width(int n, int size);
int chart_text_length(const char *text);
/* Cells of a legend, filled column by column. */
struct chart_grid {
    int rows;
    double column; /* width */
};
/* Makes a grid of n cells, in 1 to 3 columns: as many as let texts of `longest` characters stand
 * beside each other, each behind a sample of this width. */
struct chart_grid chart_grid(int n, int longest, double sample);

/* ---- Inside this room: axes of all charts, in axis.c ---- */

/* An axis from `low` to `high` on its scale: values over the unit, or decimal logarithms. */
struct axis {
    bool logarithmic;
    double low, high;
    double unit, step; /* linear: a power of ten; between ticks, in units */
    int exponent;      /* of the unit; 0: labels are values */
    int decimals;      /* of a label */
    bool clipped;      /* logarithmic: smaller values lie at the low end, */
    double least;      /* which stands for this value */
};
/* A linear axis from low to high with about so many steps; from 0 to 1 if low > high. */
struct axis axis_linear(double low, double high, int steps);
/* A linear axis that contains 0 and ends at whole steps. */
struct axis axis_from_zero(double low, double high, int steps);
/* A logarithmic axis with some room beyond the decimal logarithms low and high; from 0.1 to 1 if
 * low > high. */
struct axis axis_logarithmic(double low, double high);
double decimal_logarithm(double value); /* of a finite value above 0 */
/* The place of a value in the SVG file. On a logarithmic axis values below its low end, and 0, lie
 * at that end. */
double chart_x(const struct chart_area *area, const struct axis *axis, double value);
double chart_y(const struct chart_area *area, const struct axis *axis, double value);
/* Draw ticks, their grid lines and labels, and the label of the axis: below the area and a strip of
 * this height, or on its left or right, where there are no grid lines. */
void axis_draw_x(const struct chart_area *area, const struct axis *axis, const char *label,
                 int strip);
void axis_draw_y(const struct chart_area *area, const struct axis *axis, const char *label,
                 bool right);

/* ---- Inside this room: places of labels, in labels.c ---- */

struct chart_box {
    double left, top, right, bottom;
};
struct chart_segment {
    double x[2], y[2];
};
struct chart_label {
    double x, y, radius;  /* of the marker of its point */
    struct chart_box box; /* its place, if it has one */
    bool placed, led;     /* led: by a line from the point */
};
/* The labels of a chart. They never cover the frame, a marker, or each other. */
struct chart_labels {
    struct chart_box frame;
    struct chart_label *label; /* of each point */
    int n;
    struct chart_segment *lines; /* covered by labels only where no other place is left */
    int n_lines;
};
/* Finds the place of a label of this size. Returns false where there is none. */
bool chart_place_label(struct chart_labels *labels, int index, double width, double height);
/* The line from a point to the nearest place of its label. */
struct chart_segment chart_leader(const struct chart_label *label);

#endif
