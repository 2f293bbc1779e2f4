/* SPDX-License-Identifier: MIT */
/* Adaptive sampling (after P. Deville, S. Merzouk, D. Cazier and J. C. Paul, Spectral data modeling
 * for a lighting application, Computer Graphics Forum 13 (3), 97-106, 1994): the range is cut at
 * emission peaks, and every segment has the fewest nodes that its spectra allow. Beyond Deville's,
 * segments are joined again where they have no need of a cut. Nodes are wavelengths of the grid:
 * there spectra are known, and pages are exactly what the errors were judged by. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/sampling/sampling.h"
#include "data/spectra/spectra.h"
#include "spectral.h"

/* Cells from..to - 1 of the grid. */
struct segment {
    int from, to, nodes;
};
struct adaptive {
    const struct sampling *sampling;
    const struct fine_spectra *spectra;
    double tolerance;   /* for each segment alone, of its part of what the detector sees */
    int n_spectra;      /* lights, then products */
    double *scale;      /* of each: the response that its errors are parts of */
    double *total;      /* of each and each channel: the error of all segments */
    double *seen;       /* up to each cell, what the detector sees of the range; n_nm + 1 */
    bool *cut, *summit; /* whether a segment begins with a cell; whether it is a peak's summit */
    struct segment *segments, *best; /* now, and of the fewest pages that keep the tolerance */
    int n, n_best, fewest;
};

static const double *spectrum_row(const struct adaptive *a, int i)
{
    const size_t n_nm = (size_t)a->sampling->n_nm;
    return i < a->spectra->n_lights
               ? a->spectra->lights + (size_t)i * n_nm
               : a->spectra->products + (size_t)(i - a->spectra->n_lights) * n_nm;
}

/* ---- emission peaks ---- */

/* A sample is a summit if it is the largest up to some distance of at most 10 nm, and above the
 * mean of its neighbours there by half of the spectrum's mean. Daylight (d65) is nowhere above by a
 * sixth, smooth spectra by less. Lines between two nm of the grid are not seen. */
enum { FARTHEST_NEIGHBOUR = 10 };
static const double least_excess = 0.5;

static double mean_of(const double *row, int n)
{
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += row[j] / n;
    return sum;
}

static bool is_summit(const double *row, int n, int j, double threshold)
{
    for (int away = 1; away <= FARTHEST_NEIGHBOUR && j - away >= 0 && j + away < n; away++) {
        if (!(row[j] > row[j - away] && row[j] >= row[j + away]))
            return false;
        if (row[j] - row[j - away] / 2 - row[j + away] / 2 > threshold)
            return true;
    }
    return false;
}

/* From a summit, which may be flat, downwards: the foot is where it falls no more, by a hundredth
 * of its height. */
static int foot_of(const double *row, int n, int j, int step)
{
    const double slope = row[j] / 100;
    while (j + step >= 0 && j + step < n && row[j] - row[j + step] > slope)
        j += step;
    return j;
}

static void find_peaks(struct adaptive *a)
{
    const int n = a->sampling->n_nm;
    a->cut[0] = true;
    for (int i = 0; i < a->spectra->n_lights; i++) {
        const double *row = spectrum_row(a, i), threshold = least_excess * mean_of(row, n);
        for (int j = 0; j < n; j++)
            if (is_summit(row, n, j, threshold)) {
                const int behind = foot_of(row, n, j, 1) + 1;
                a->summit[j] = a->cut[j] = a->cut[foot_of(row, n, j, -1)] = true;
                if (behind < n)
                    a->cut[behind] = true;
            }
    }
}

/* ---- what errors are measured by ---- */

static double largest_response(const struct adaptive *a, int i)
{
    const int n = a->sampling->n_nm;
    const double *row = spectrum_row(a, i);
    double response[3];
    detector_response(a->sampling->detector_weights, row, n, response);
    return fmax(fabs(response[0]), fmax(fabs(response[1]), fabs(response[2])));
}

static bool is_below(const double *a, const double *b, int n)
{
    int j = 0;
    while (j < n && a[j] <= b[j])
        j++;
    return j == n;
}

/* A product's light is the dimmest that is nowhere below it; without one it is its own. */
static void find_scales(struct adaptive *a)
{
    const int lights = a->spectra->n_lights;
    for (int i = 0; i < a->n_spectra; i++) {
        bool found = i < lights;
        a->scale[i] = largest_response(a, i);
        for (int light = 0; light < lights && i >= lights; light++)
            if (is_below(spectrum_row(a, i), spectrum_row(a, light), a->sampling->n_nm)) {
                a->scale[i] = found ? fmin(a->scale[i], a->scale[light]) : a->scale[light];
                found = true;
            }
    }
    for (int j = 0; j < a->sampling->n_nm; j++)
        a->seen[j + 1] = a->seen[j] + sampling_seen(a->sampling, j);
}

/* ---- the fewest nodes ---- */

/* Legendre's nodes, each at the nearest cell; what they count in each channel. */
enum { MOST_NODES = 8 };
struct weighed {
    double nm[MOST_NODES];
    int at[MOST_NODES]; /* the cell */
    double weight[3][MOST_NODES];
};
/* False: two nodes would be the same. */
static bool place_nodes(const struct sampling *sampling, const struct segment *s,
                        struct weighed *out)
{
    struct quadrature rule;
    bool distinct = true;
    quadrature_legendre(s->from, s->to, s->nodes, &rule);
    for (int i = 0; i < s->nodes; i++) {
        out->at[i] = (int)floor(rule.node[i]);
        out->nm[i] = sampling_grid(sampling, out->at[i]);
        distinct = distinct && (i == 0 || out->at[i] > out->at[i - 1]);
    }
    return distinct;
}

static void weigh(const struct adaptive *a, const struct segment *s, struct weighed *out)
{
    const struct sampling *sampling = a->sampling;
    for (int i = 0; i < s->nodes; i++) {
        out->weight[0][i] = out->weight[1][i] = out->weight[2][i] = 0;
        for (int j = s->from; j < s->to; j++) {
            const double part =
                quadrature_lagrange(out->nm, s->nodes, i, sampling_grid(sampling, j));
            for (int channel = 0; channel < 3; channel++)
                out->weight[channel][i] +=
                    part * sampling->detector_weights[channel * sampling->n_nm + j];
        }
    }
}

static void errors_of(const struct adaptive *a, const struct segment *s, const struct weighed *w,
                      int spectrum, double out[3])
{
    const struct sampling *sampling = a->sampling;
    const double *row = spectrum_row(a, spectrum);
    for (int channel = 0; channel < 3; channel++) {
        const double *weights = sampling->detector_weights + channel * sampling->n_nm;
        out[channel] = 0;
        for (int i = 0; i < s->nodes; i++)
            out[channel] += w->weight[channel][i] * row[w->at[i]];
        for (int j = s->from; j < s->to; j++)
            out[channel] -= weights[j] * row[j];
    }
}

static bool fits(const struct adaptive *a, const struct segment *s)
{
    struct weighed w;
    const double part = (a->seen[s->to] - a->seen[s->from]) / a->seen[a->sampling->n_nm];
    if (!place_nodes(a->sampling, s, &w))
        return false;
    weigh(a, s, &w);
    for (int i = 0; i < a->n_spectra; i++) {
        double error[3];
        errors_of(a, s, &w, i, error);
        for (int channel = 0; channel < 3; channel++)
            if (fabs(error[channel]) > a->tolerance * part * a->scale[i])
                return false;
    }
    return true;
}

/* Fewer than `limit` with which the cells fit; 0: there are none. */
static int fewest_nodes(const struct adaptive *a, int from, int to, int limit)
{
    struct segment s = {from, to, 1};
    while (s.nodes < limit && s.nodes <= MOST_NODES && !fits(a, &s))
        s.nodes++;
    return s.nodes < limit && s.nodes <= MOST_NODES ? s.nodes : 0;
}

/* As one segment, or in halves if these have fewer nodes; a cell is exact. Returns how many. */
static int divide(struct adaptive *a, int from, int to)
{
    const int before = a->n, whole = to - from == 1 ? 1 : fewest_nodes(a, from, to, to - from);
    if (whole == 0 || whole > 2) {
        const int middle = (from + to) / 2;
        const int halves = divide(a, from, middle) + divide(a, middle, to);
        if (whole == 0 || halves < whole)
            return halves;
    }
    a->n = before;
    a->segments[a->n++] = (struct segment){from, to, whole};
    return whole;
}

static void divide_all(struct adaptive *a)
{
    const int n = a->sampling->n_nm;
    a->n = 0;
    for (int from = 0, to; from < n; from = to) {
        to = from + 1;
        while (to < n && !a->cut[to])
            to++;
        divide(a, from, to);
    }
}

/* Neighbours become one where that has fewer nodes, until there are none. */
static void join_all(struct adaptive *a)
{
    for (int before = 0; before != a->n;) {
        int n = 1;
        before = a->n;
        for (int i = 1; i < before; i++) {
            struct segment *last = &a->segments[n - 1];
            const struct segment next = a->segments[i];
            const int nodes = fewest_nodes(a, last->from, next.to, last->nodes + next.nodes);
            if (nodes > 0)
                *last = (struct segment){last->from, next.to, nodes};
            else
                a->segments[n++] = next;
        }
        a->n = n;
    }
}

static int pages_of(const struct adaptive *a)
{
    int n = 0;
    for (int s = 0; s < a->n; s++)
        n += a->segments[s].nodes;
    return n;
}

/* True if all segments together keep the tolerance. */
static bool is_within(struct adaptive *a, double tolerance)
{
    for (int i = 0; i < 3 * a->n_spectra; i++)
        a->total[i] = 0;
    for (int s = 0; s < a->n; s++) {
        struct weighed w;
        place_nodes(a->sampling, &a->segments[s], &w);
        weigh(a, &a->segments[s], &w);
        for (int i = 0; i < a->n_spectra; i++) {
            double error[3];
            errors_of(a, &a->segments[s], &w, i, error);
            for (int channel = 0; channel < 3; channel++)
                a->total[3 * i + channel] += error[channel];
        }
    }
    for (int i = 0; i < 3 * a->n_spectra; i++)
        if (fabs(a->total[i]) > tolerance * a->scale[i / 3])
            return false;
    return true;
}

static void keep_fewest(struct adaptive *a, double tolerance)
{
    if ((a->fewest == 0 || pages_of(a) < a->fewest) && is_within(a, tolerance)) {
        a->fewest = pages_of(a);
        a->n_best = a->n;
        memcpy(a->best, a->segments, (size_t)a->n * sizeof *a->best);
    }
}

/* Errors of segments cancel: so each is first allowed far more than its part. With no more than
 * that the sum is within the tolerance, but for rounding; and cells alone are exact. */
static void find_segments(struct adaptive *a, double tolerance)
{
    for (double slack = 64; slack >= 1 || a->fewest == 0; slack *= 0.75) {
        a->tolerance = slack * tolerance;
        divide_all(a);
        keep_fewest(a, tolerance);
        join_all(a);
        keep_fewest(a, tolerance);
    }
}

/* ---- the sampling ---- */

static bool adaptive_room(struct adaptive *a, struct error *err)
{
    const size_t n_nm = (size_t)a->sampling->n_nm, count = (size_t)a->n_spectra;
    a->scale = calloc(count + 1, sizeof *a->scale);
    a->total = calloc(3 * count + 1, sizeof *a->total);
    a->seen = calloc(n_nm + 1, sizeof *a->seen);
    a->cut = calloc(n_nm, sizeof *a->cut);
    a->summit = calloc(n_nm, sizeof *a->summit);
    a->segments = calloc(n_nm, sizeof *a->segments);
    a->best = calloc(n_nm, sizeof *a->best);
    return (a->scale != NULL && a->total != NULL && a->seen != NULL && a->cut != NULL &&
            a->summit != NULL && a->segments != NULL && a->best != NULL) ||
           error_memory(err);
}

static bool set_peaks(const struct adaptive *a, struct sampling *out, struct error *err)
{
    out->peak_nm = calloc((size_t)out->n_nm, sizeof *out->peak_nm);
    if (out->peak_nm == NULL)
        return error_memory(err);
    for (int j = 0; j < out->n_nm; j++)
        if (a->summit[j])
            out->peak_nm[out->n_peaks++] = sampling_grid(out, j);
    return true;
}

static bool set_pages(const struct adaptive *a, struct sampling *out, struct error *err)
{
    int n = 0;
    if (!sampling_room(out, a->fewest, true, true, err))
        return false;
    for (int s = 0; s < a->n_best; s++) {
        const struct segment *segment = &a->best[s];
        const double first = sampling_grid(out, segment->from) - 0.5;
        const double last = sampling_grid(out, segment->to) - 0.5;
        struct weighed nodes;
        place_nodes(out, segment, &nodes);
        for (int i = 0; i < segment->nodes; i++, n++) {
            out->wavelength_nm[n] = nodes.nm[i];
            out->segment_nm[n][0] = first;
            out->segment_nm[n][1] = last;
        }
    }
    return true;
}

bool sample_adaptive(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    struct adaptive a = {.sampling = out,
                         .spectra = task->spectra,
                         .n_spectra = task->spectra->n_lights + task->spectra->n_products};
    bool done = adaptive_room(&a, err);
    if (done) {
        find_peaks(&a);
        find_scales(&a);
        find_segments(&a, task->method->tolerance);
        done = set_peaks(&a, out, err) && set_pages(&a, out, err);
    }
    free(a.scale);
    free(a.total);
    free(a.seen);
    free(a.cut);
    free(a.summit);
    free(a.segments);
    free(a.best);
    if (!done)
        return false;
    sampling_weights(task->detector, out->wavelength_nm, out->segment_nm, out->n, out->weights);
    sampling_linear(out);
    out->spectral = true;
    return true;
}
