/* SPDX-License-Identifier: MIT */
/* Private to data/chart.c, which has the functions, and data/frontier.c: how all charts look. */
#ifndef CHART_H
#define CHART_H

#include "spectral.h"

/* In SVG's pixels, 96 an inch. */
enum {
    WIDTH = 800,
    LEFT = 84,
    TOP = 52,
    MARGIN = 28, /* on the right, without an axis there */
    TICK = 5,
    LEGEND_ROW = 20,
    TITLE_SIZE = 16,
    LABEL_SIZE = 13,
    TEXT_SIZE = 12
};

/* Draws into an SVG file, allocated; NULL: no memory. */
char *chart_file(void (*draw)(void *plot, FILE *to), void *plot);
/* The beginning of a file of this height, with the title. */
void chart_head(FILE *to, const char *title, int height);
/* The frame around a plot. */
void chart_frame(FILE *to, double width, int height);
/* At most so many characters of a text, escaped; what XML cannot hold becomes U+FFFD. */
void chart_text(FILE *to, const char *text, int most);
/* A decimal exponent: ×10 and small digits. */
void chart_exponent(FILE *to, int exponent);
/* Begins the x axis's label, `below` the plot; the caller ends its text. */
void chart_x_label(FILE *to, const char *label, double width, int below);
/* In the middle of an axis that stands at x and is `height` high. */
void chart_y_label(FILE *to, const char *label, double x, int height);
/* Characters that fit beside each other, and what n of them take. */
int chart_fitting(double width, int size);
double chart_text_width(int n, int size);
int chart_text_length(const char *text);
/* Of a legend: as many as let texts of `longest` characters stand beside each other, each behind a
 * sample of this width; 1 to 3. */
int chart_columns(int longest, double sample);

#endif
