/* SPDX-License-Identifier: MIT */
/* Finds places for labels beside their points. A label takes the nearest free place on rings around
 * its point; beyond the first ring a line leads to it. */
#include <math.h>

#include "data/chart/chart.h"
#include "data/maths/maths.h"

enum {
    RING_STEP = 7, /* between the rings of places around a point */
    NEAR_DIRECTIONS = 8,
    DIRECTIONS = 32 /* beyond the first ring */
};

/* ---- boxes and segments that meet ---- */

static bool boxes_meet(const struct chart_box *a, const struct chart_box *b)
{
    return a->left < b->right && b->left < a->right && a->top < b->bottom && b->top < a->bottom;
}

/* Cuts a segment at two limits of one coordinate. *first and *last bound the part, from 0 to 1,
 * that is left; no part is left if *first >= *last. */
static void cut(double from, double to, double low, double high, double *first, double *last)
{
    if (from == to) {
        *last = from > low && from < high ? *last : -1;
        return;
    }
    const double a = (low - from) / (to - from), b = (high - from) / (to - from);
    *first = fmax(*first, fmin(a, b));
    *last = fmin(*last, fmax(a, b));
}

static bool segment_meets(const struct chart_segment *segment, const struct chart_box *box)
{
    double first = 0, last = 1;
    cut(segment->x[0], segment->x[1], box->left, box->right, &first, &last);
    cut(segment->y[0], segment->y[1], box->top, box->bottom, &first, &last);
    return first < last;
}

static struct chart_box marker_box(const struct chart_label *label)
{
    return (struct chart_box){label->x - label->radius, label->y - label->radius,
                              label->x + label->radius, label->y + label->radius};
}

struct chart_segment chart_leader(const struct chart_label *label)
{
    return (struct chart_segment){
        {label->x, fmax(label->box.left, fmin(label->x, label->box.right))},
        {label->y, fmax(label->box.top, fmin(label->y, label->box.bottom))}};
}

/* ---- places ---- */

/* The rules that a label may break if it finds no other place. A label never covers a point or
 * another label. */
enum freedom {
    OFF_LINES, /* none */
    ON_LINES,  /* it may cover the chart's lines */
    ACROSS     /* its own line may cross anything, and lines of other labels may cross it */
};

/* Returns whether a box covers a point, a label or the frame. */
static bool covers(const struct chart_labels *labels, const struct chart_box *box)
{
    const struct chart_box *frame = &labels->frame;
    bool meets = box->left < frame->left + 2 || box->right > frame->right - 2 ||
                 box->top < frame->top + 2 || box->bottom > frame->bottom - 2;
    for (int i = 0; !meets && i < labels->n; i++) {
        const struct chart_label *other = &labels->label[i];
        const struct chart_box marker = marker_box(other);
        meets = boxes_meet(box, &marker) || (other->placed && boxes_meet(box, &other->box));
    }
    return meets;
}

/* Returns whether the label's line crosses a point or another label, or another label's line
 * crosses this label. */
static bool crosses(const struct chart_labels *labels, const struct chart_label *label)
{
    const struct chart_segment line = chart_leader(label);
    bool meets = false;
    for (int i = 0; !meets && i < labels->n; i++) {
        const struct chart_label *other = &labels->label[i];
        const struct chart_box marker = marker_box(other);
        const struct chart_segment others = chart_leader(other);
        meets = (label->led && other != label && segment_meets(&line, &marker)) ||
                (label->led && other->placed && segment_meets(&line, &other->box)) ||
                (other->led && other->placed && segment_meets(&others, &label->box));
    }
    return meets;
}

static bool is_free(const struct chart_labels *labels, const struct chart_label *label,
                    enum freedom freedom)
{
    if (covers(labels, &label->box) || (freedom < ACROSS && crosses(labels, label)))
        return false;
    for (int i = 0; freedom == OFF_LINES && i < labels->n_lines; i++)
        if (segment_meets(&labels->lines[i], &label->box))
            return false;
    return true;
}

/* Returns the box of a label of this size at a distance from its point. A label without a line
 * stands beside, above or below the point, or at a corner; a label with a line in any direction. */
static struct chart_box box_at(const struct chart_label *label, int direction, double distance,
                               double width, double height)
{
    static const double to_x[NEAR_DIRECTIONS] = {1, 1, 1, -1, -1, -1, 0, 0};
    static const double to_y[NEAR_DIRECTIONS] = {-1, 0, 1, -1, 0, 1, -1, 1};
    double x, y;
    if (label->led)
        sine_cosine_of_turn(direction, DIRECTIONS, &y, &x);
    else {
        x = to_x[direction];
        y = to_y[direction];
        distance *= x != 0 && y != 0 ? 0.7 : 1;
    }
    x = label->x + x * (distance + width / 2);
    y = label->y + y * (distance + height / 2);
    return (struct chart_box){x - width / 2, y - height / 2, x + width / 2, y + height / 2};
}

/* Takes the nearest place that is free under these rules. Returns false if there is none. */
static bool place_within(struct chart_labels *labels, struct chart_label *label, double width,
                         double height, enum freedom freedom)
{
    static const int rings[] = {[OFF_LINES] = 12, [ON_LINES] = 20, [ACROSS] = 100};
    label->placed = false;
    for (int ring = 0; ring < rings[freedom]; ring++) {
        const double distance = label->radius + 2 + ring * RING_STEP;
        label->led = ring > 0;
        for (int i = 0; i < (label->led ? DIRECTIONS : NEAR_DIRECTIONS); i++) {
            label->box = box_at(label, i, distance, width, height);
            if (is_free(labels, label, freedom))
                return label->placed = true;
        }
    }
    return false;
}

bool chart_place_label(struct chart_labels *labels, int index, double width, double height)
{
    struct chart_label *label = &labels->label[index];
    for (enum freedom freedom = OFF_LINES; freedom <= ACROSS; freedom++)
        if (place_within(labels, label, width, height, freedom))
            return true;
    return false;
}
