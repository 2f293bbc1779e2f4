/* SPDX-License-Identifier: MIT */
/* Cost over accuracy: every setting a point between two logarithmic axes, those that nothing
 * cheaper beats joined by steps. Labels find places where they cover nothing. */
#include <math.h>
#include <stdlib.h>

#include "data/chart/chart.h"
#include "data/maths/maths.h"

enum {
    HEIGHT = 440,     /* of the plot */
    NUMBER_SIZE = 10, /* of the numbers that stand for names */
    NAME_LENGTH = 40, /* characters of a name in the plot */
    KEY_LENGTH = 60,  /* and in the key */
    SAMPLE = 26,      /* a number in the key */
    PAST_DECADES = 3  /* smaller errors, in parts of the largest, lie on the edge */
};
static const double width = CHART_WIDTH - CHART_LEFT - CHART_MARGIN;
static const char strong[] = "#0072b2", pale[] = "#8a8a8a";

struct scale {
    double low, high; /* decimal logarithms */
    bool clipped;     /* some values lie below */
    double edge;      /* the value that `low` stands for where it is clipped */
};
struct plot {
    const struct frontier *frontier;
    FILE *to;
    struct scale cost, error;
    struct chart_labels labels; /* of each point; lines: the steps, then the error bars */
    int n_steps;
    int *order; /* points of the frontier, by cost */
    int n_best;
    int *number; /* in the key; 0: named in the plot */
    int n_numbers;
};

/* ---- logarithmic axes ---- */

static double decimal_logarithm(double value)
{
    const double of_10 = 3.32192809488736234787; /* log2 10 */
    return binary_logarithm(value) / of_10;
}

/* 1, 2 or 5 times a power of ten: tick 3k is 10^k. */
static double tick_at(int tick)
{
    static const double part[] = {0, 0.30102999566398119521, 0.69897000433601880479};
    const int decade = (int)floor(tick / 3.0);
    return decade + part[tick - 3 * decade];
}

static int tick_below(double logarithm)
{
    int tick = 3 * ((int)floor(logarithm) + 1);
    while (tick_at(tick) > logarithm)
        tick--;
    return tick;
}

/* Ticks that leave some room beyond the values; 0.1 to 1 where there is none (low > high). */
static struct scale scale_make(double low, double high)
{
    const double room = 0.04;
    if (low > high)
        return (struct scale){.low = -1, .high = 0};
    return (struct scale){.low = tick_at(tick_below(low - room)),
                          .high = tick_at(tick_below(high + room) + 1)};
}

static struct scale cost_scale(const struct frontier *frontier)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < frontier->n; i++) {
        const struct frontier_point *point = &frontier->points[i];
        low = fmin(low, decimal_logarithm(fmin(point->cost, point->cost_low)));
        high = fmax(high, decimal_logarithm(fmax(point->cost, point->cost_high)));
    }
    return scale_make(low, high);
}

static struct scale error_scale(const struct frontier *frontier)
{
    double largest = 0, least = HUGE_VAL;
    for (int i = 0; i < frontier->n; i++)
        largest = fmax(largest, frontier->points[i].error);
    const double high = largest > 0 ? decimal_logarithm(largest) : -HUGE_VAL;
    bool clipped = false;
    for (int i = 0; i < frontier->n; i++) {
        const double error = frontier->points[i].error;
        const bool below = !(error > 0) || decimal_logarithm(error) < high - PAST_DECADES;
        clipped = clipped || below;
        least = below ? least : fmin(least, decimal_logarithm(error));
    }
    struct scale scale = scale_make(least, high);
    scale.clipped = clipped;
    scale.edge = largest / 1000;
    if (clipped && largest > 0)
        scale.low = high - PAST_DECADES;
    return scale;
}

static double part_of(const struct scale *scale, double logarithm)
{
    return (logarithm - scale->low) / (scale->high - scale->low);
}

static double plot_x(const struct plot *plot, double cost)
{
    return CHART_LEFT + width * part_of(&plot->cost, decimal_logarithm(cost));
}

static double plot_y(const struct plot *plot, double error)
{
    const double part = error > 0 ? part_of(&plot->error, decimal_logarithm(error)) : 0;
    return CHART_TOP + HEIGHT * (1 - fmax(part, 0));
}

/* ---- axes drawn ---- */

/* A tick's value in digits, or as a power of ten where these are too many. */
static void put_tick(FILE *to, int tick)
{
    static const int digits[] = {1, 2, 5};
    const int decade = (int)floor(tick / 3.0), digit = digits[tick - 3 * decade];
    if (decade < -4 || decade > 4) {
        fprintf(to, "%d", digit);
        chart_exponent(to, decade);
    } else if (decade < 0)
        fprintf(to, "0.%0*d", -decade, digit);
    else
        fprintf(to, "%d%.*s", digit, decade, "0000");
}

/* Returns whether a tick is labelled on an axis of this length: 2 and 5 where there is room, and
 * not too many powers of ten. */
static bool is_labelled(const struct scale *scale, int tick, double length)
{
    const double decade = length / (scale->high - scale->low);
    const int skip = 1 + (int)(60 / decade);
    return decade > 120 || (tick % 3 == 0 && tick / 3 % skip == 0);
}

static bool has_tick(const struct scale *scale, int tick)
{
    return tick_at(tick) <= scale->high + 1e-9;
}

static int first_tick(const struct scale *scale)
{
    return tick_below(scale->low - 1e-9) + 1;
}

static void draw_cost_axis(const struct plot *plot)
{
    const int bottom = CHART_TOP + HEIGHT;
    fputs("<g text-anchor=\"middle\">\n", plot->to);
    for (int tick = first_tick(&plot->cost); has_tick(&plot->cost, tick); tick++) {
        const double x = CHART_LEFT + width * part_of(&plot->cost, tick_at(tick));
        const bool labelled = is_labelled(&plot->cost, tick, width);
        fprintf(plot->to, "<path d=\"M%.2f,%dV%d\" stroke=\"%s\"/>", x, CHART_TOP, bottom,
                tick % 3 == 0 ? "#dcdcdc" : "#f0f0f0");
        fprintf(plot->to, "<path d=\"M%.2f,%dv%d\" stroke=\"#333\"/>", x, bottom,
                labelled ? CHART_TICK : CHART_TICK / 2);
        if (labelled) {
            fprintf(plot->to, "<text x=\"%.2f\" y=\"%d\">", x,
                    bottom + CHART_TICK + CHART_TEXT_SIZE + 1);
            put_tick(plot->to, tick);
            fputs("</text>", plot->to);
        }
        putc('\n', plot->to);
    }
    chart_x_label(plot->to, plot->frontier->cost_label, width, bottom);
    fputs("</text>\n</g>\n", plot->to);
}

/* Labels the edge: markers on it stand for values at most this large. */
static void draw_edge(const struct plot *plot)
{
    if (plot->error.clipped)
        fprintf(plot->to, "<text x=\"%d\" y=\"%.2f\">≤ %.2g</text>\n", CHART_LEFT - CHART_TICK - 4,
                CHART_TOP + HEIGHT + 0.35 * CHART_TEXT_SIZE, plot->error.edge);
}

static void draw_error_axis(const struct plot *plot)
{
    fputs("<g text-anchor=\"end\">\n", plot->to);
    for (int tick = first_tick(&plot->error); has_tick(&plot->error, tick); tick++) {
        const double y = CHART_TOP + HEIGHT * (1 - part_of(&plot->error, tick_at(tick)));
        const bool covered = plot->error.clipped && y > CHART_TOP + HEIGHT - 1.2 * CHART_TEXT_SIZE;
        const bool labelled = is_labelled(&plot->error, tick, HEIGHT) && !covered;
        fprintf(plot->to, "<path d=\"M%d,%.2fh%.2f\" stroke=\"%s\"/>", CHART_LEFT, y, width,
                tick % 3 == 0 ? "#dcdcdc" : "#f0f0f0");
        fprintf(plot->to, "<path d=\"M%d,%.2fh-%d\" stroke=\"#333\"/>", CHART_LEFT, y,
                labelled ? CHART_TICK : CHART_TICK / 2);
        if (labelled) {
            fprintf(plot->to, "<text x=\"%d\" y=\"%.2f\">", CHART_LEFT - CHART_TICK - 4,
                    y + 0.35 * CHART_TEXT_SIZE);
            put_tick(plot->to, tick);
            fputs("</text>", plot->to);
        }
        putc('\n', plot->to);
    }
    draw_edge(plot);
    chart_y_label(plot->to, plot->frontier->error_label, 20, HEIGHT);
    fputs("</g>\n", plot->to);
}

/* ---- the frontier ---- */

static int compare_cost(const struct frontier_point *a, const struct frontier_point *b)
{
    return a->cost != b->cost ? (a->cost > b->cost) - (a->cost < b->cost)
                              : (a->error < b->error) - (a->error > b->error);
}

/* Keeps the points of the frontier by cost, and numbers the others. */
static void sort_points(struct plot *plot)
{
    const struct frontier_point *points = plot->frontier->points;
    for (int i = 0; i < plot->frontier->n; i++) {
        if (!points[i].best) {
            plot->number[i] = ++plot->n_numbers;
            continue;
        }
        int at = plot->n_best++;
        for (; at > 0 && compare_cost(&points[plot->order[at - 1]], &points[i]) > 0; at--)
            plot->order[at] = plot->order[at - 1];
        plot->order[at] = i;
    }
}

/* Lines along the cost, then down to the next point's error. */
static void find_steps(struct plot *plot)
{
    for (int i = 0; i + 1 < plot->n_best; i++) {
        const struct chart_label *here = &plot->labels.label[plot->order[i]];
        const struct chart_label *next = &plot->labels.label[plot->order[i + 1]];
        plot->labels.lines[plot->n_steps++] =
            (struct chart_segment){{here->x, next->x}, {here->y, here->y}};
        plot->labels.lines[plot->n_steps++] =
            (struct chart_segment){{next->x, next->x}, {here->y, next->y}};
    }
}

static void find_bars(struct plot *plot)
{
    plot->labels.n_lines = plot->n_steps;
    for (int i = 0; i < plot->frontier->n; i++) {
        const struct frontier_point *point = &plot->frontier->points[i];
        plot->labels.lines[plot->labels.n_lines++] =
            (struct chart_segment){{plot_x(plot, point->cost_low), plot_x(plot, point->cost_high)},
                                   {plot->labels.label[i].y, plot->labels.label[i].y}};
    }
}

static void draw_steps(const struct plot *plot)
{
    if (plot->n_steps == 0)
        return;
    fprintf(plot->to, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"2\" d=\"M%.2f,%.2f", strong,
            plot->labels.lines[0].x[0], plot->labels.lines[0].y[0]);
    for (int i = 0; i < plot->n_steps; i++)
        fprintf(plot->to, "L%.2f,%.2f", plot->labels.lines[i].x[1], plot->labels.lines[i].y[1]);
    fputs("\"/>\n", plot->to);
}

/* ---- points drawn ---- */

static void draw_marker(FILE *to, double x, double y, bool best, bool uncertain)
{
    if (uncertain)
        fprintf(to,
                "<circle cx=\"%.2f\" cy=\"%.2f\" r=\"6.5\" fill=\"none\" stroke=\"%s\" "
                "stroke-dasharray=\"2 1.5\"/>",
                x, y, strong);
    fprintf(to, "<circle cx=\"%.2f\" cy=\"%.2f\" r=\"%s\" fill=\"%s\" stroke=\"%s\"/>", x, y,
            best ? "4.5" : "2.8", best ? strong : "#fff", best ? strong : pale);
}

static void draw_point(const struct plot *plot, int index)
{
    const struct frontier_point *point = &plot->frontier->points[index];
    const struct chart_label *label = &plot->labels.label[index];
    fputs("<g><title>", plot->to);
    chart_text(plot->to, point->name, 200);
    fprintf(plot->to, "</title><path stroke=\"%s\" stroke-width=\"0.8\" d=\"M%.2f,%.2fH%.2f\"/>",
            point->best ? strong : pale, plot_x(plot, point->cost_low), label->y,
            plot_x(plot, point->cost_high));
    draw_marker(plot->to, label->x, label->y, point->best, point->uncertain);
    fputs("</g>\n", plot->to);
}

/* ---- labels ---- */

static int shown_length(const char *name, int most)
{
    const int length = chart_text_length(name);
    return length < most ? length : most;
}

static int digits_of(int number)
{
    return number < 10 ? 1 : 1 + digits_of(number / 10);
}

/* The names of the frontier first: they are the largest. What finds no place gets a number. */
static void place_labels(struct plot *plot)
{
    for (int i = 0; i < plot->n_best; i++) {
        const int index = plot->order[i];
        const int length = shown_length(plot->frontier->points[index].name, NAME_LENGTH);
        if (!chart_place_label(&plot->labels, index, chart_text_width(length, CHART_TEXT_SIZE),
                               CHART_TEXT_SIZE + 2))
            plot->number[index] = ++plot->n_numbers;
    }
    for (int i = 0; i < plot->frontier->n; i++)
        if (plot->number[i] > 0)
            chart_place_label(&plot->labels, i,
                              chart_text_width(digits_of(plot->number[i]), NUMBER_SIZE) + 2,
                              NUMBER_SIZE);
}

static void draw_label(const struct plot *plot, int index)
{
    const struct chart_label *label = &plot->labels.label[index];
    const struct chart_segment line = chart_leader(label);
    const int size = plot->number[index] > 0 ? NUMBER_SIZE : CHART_TEXT_SIZE;
    if (!label->placed)
        return;
    if (label->led)
        fprintf(plot->to, "<path stroke=\"%s\" stroke-width=\"0.6\" d=\"M%.2f,%.2fL%.2f,%.2f\"/>",
                pale, line.x[0], line.y[0], line.x[1], line.y[1]);
    fprintf(plot->to, "<text text-anchor=\"middle\" x=\"%.2f\" y=\"%.2f\" font-size=\"%d\"%s>",
            (label->box.left + label->box.right) / 2,
            (label->box.top + label->box.bottom) / 2 + 0.35 * size, size,
            plot->number[index] > 0 ? " fill=\"#555\"" : "");
    if (plot->number[index] > 0)
        fprintf(plot->to, "%d", plot->number[index]);
    else
        chart_text(plot->to, plot->frontier->points[index].name, NAME_LENGTH);
    fputs("</text>\n", plot->to);
}

/* ---- the key ---- */

static struct chart_grid key_grid(const struct plot *plot)
{
    int longest = 1;
    for (int i = 0; i < plot->frontier->n; i++) {
        const int length = shown_length(plot->frontier->points[i].name, KEY_LENGTH);
        longest = plot->number[i] > 0 && length > longest ? length : longest;
    }
    return chart_grid(plot->n_numbers, longest, SAMPLE);
}

/* The legend of the markers, in one row. */
static void draw_markers(const struct plot *plot, int y)
{
    static const char *const meaning[] = {"on the frontier", "not on it: see the number",
                                          "either, within noise"};
    for (int i = 0; i < 3; i++) {
        const double x = CHART_LEFT + 10 + (CHART_WIDTH - CHART_LEFT) / 3.0 * i;
        draw_marker(plot->to, x, y, i == 0, i == 2);
        fprintf(plot->to, "<text x=\"%.2f\" y=\"%.2f\">%s</text>\n", x + 14,
                y + 0.35 * CHART_TEXT_SIZE, meaning[i]);
    }
}

static void draw_key(const struct plot *plot, int top)
{
    const struct chart_grid grid = key_grid(plot);
    const int fitting = chart_fitting(grid.column - SAMPLE - 8, CHART_TEXT_SIZE);
    for (int i = 0; i < plot->frontier->n; i++) {
        const int place = plot->number[i] - 1;
        if (place < 0)
            continue;
        const double x = CHART_LEFT + grid.column * (place / grid.rows);
        const double y = top + CHART_LEGEND_ROW * (place % grid.rows) + 0.35 * CHART_TEXT_SIZE;
        fprintf(plot->to,
                "<text text-anchor=\"end\" x=\"%.2f\" y=\"%.2f\" fill=\"#555\">%d</text>"
                "<text x=\"%.2f\" y=\"%.2f\">",
                x + SAMPLE - 8, y, plot->number[i], x + SAMPLE, y);
        chart_text(plot->to, plot->frontier->points[i].name,
                   fitting < KEY_LENGTH ? fitting : KEY_LENGTH);
        fputs("</text>\n", plot->to);
    }
}

/* ---- the file ---- */

static void draw(void *of, FILE *to)
{
    struct plot *plot = of;
    const int markers = CHART_TOP + HEIGHT + CHART_TICK + CHART_TEXT_SIZE + CHART_LABEL_SIZE + 36;
    const int key = markers + CHART_LEGEND_ROW + 6;
    plot->to = to;
    chart_head(to, plot->frontier->title, key + CHART_LEGEND_ROW * key_grid(plot).rows);
    draw_cost_axis(plot);
    draw_error_axis(plot);
    chart_frame(to, width, HEIGHT);
    for (int i = 0; i < plot->frontier->n; i++)
        if (!plot->frontier->points[i].best)
            draw_point(plot, i);
    draw_steps(plot);
    for (int i = 0; i < plot->n_best; i++)
        draw_point(plot, plot->order[i]);
    for (int i = 0; i < plot->frontier->n; i++)
        draw_label(plot, i);
    draw_markers(plot, markers);
    draw_key(plot, key);
}

/* Where all points, steps and labels are. */
static void find_places(struct plot *plot)
{
    plot->cost = cost_scale(plot->frontier);
    plot->error = error_scale(plot->frontier);
    for (int i = 0; i < plot->frontier->n; i++) {
        const struct frontier_point *point = &plot->frontier->points[i];
        plot->labels.label[i] = (struct chart_label){.x = plot_x(plot, point->cost),
                                                     .y = plot_y(plot, point->error),
                                                     .radius = point->uncertain ? 7
                                                               : point->best    ? 5
                                                                                : 3.3};
    }
    sort_points(plot);
    find_steps(plot);
    find_bars(plot);
    place_labels(plot);
}

char *frontier_svg(const struct frontier *frontier)
{
    const size_t n = (size_t)frontier->n + 1;
    struct plot plot = {
        .frontier = frontier,
        .labels = {.n = frontier->n,
                   .frame = {CHART_LEFT, CHART_TOP, CHART_LEFT + width, CHART_TOP + HEIGHT}}};
    char *text = NULL;
    plot.labels.label = calloc(n, sizeof *plot.labels.label);
    plot.order = calloc(n, sizeof *plot.order);
    plot.number = calloc(n, sizeof *plot.number);
    plot.labels.lines = calloc(3 * n, sizeof *plot.labels.lines);
    if (plot.labels.label != NULL && plot.order != NULL && plot.number != NULL &&
        plot.labels.lines != NULL) {
        find_places(&plot);
        text = chart_file(draw, &plot);
    }
    free(plot.labels.label);
    free(plot.order);
    free(plot.number);
    free(plot.labels.lines);
    return text;
}
