/* SPDX-License-Identifier: MIT */
/* Adaptive sampling (after P. Deville, S. Merzouk, D. Cazier and J. C. Paul, Spectral data modeling
 * for a lighting application, Computer Graphics Forum 13 (3), 97-106, 1994): the range is cut at
 * emission peaks, and every segment has the fewest nodes that its spectra allow. Beyond Deville's,
 * segments are joined again where they have no need of a cut. Nodes are wavelengths of the grid:
 * there spectra are known, and pages are exactly what the errors were judged by. */
#include "data/sampling/inside.h"

/* Cells from..to - 1 of the grid, and the nodes that stand for them. */
enum { MOST_NODES = 8 };
struct segment {
    int from, to, n;
    double nm[MOST_NODES];
    int cell[MOST_NODES];
    double weight[3][MOST_NODES]; /* in each channel */
};
struct adaptive {
    struct sampling *sampling;
    const struct fine_spectra *spectra;
    double tolerance; /* for each segment alone, of its part of what the detector sees */
    int n_spectra;    /* lights, then products */
    double *scale;    /* [spectrum]: the response that its errors are parts of; owned, with `seen`
                         behind it */
    double *seen;     /* [cell]: what the detector sees of the range before it; n_nm + 1 */
    bool *cut;        /* [cell]: a segment begins with it; n_nm + 1; owned */
    struct segment *segments; /* now; owned, with the best behind them */
    struct segment *best;     /* of the fewest pages that keep the tolerance */
    int n, n_best, fewest;
};

static const double *spectrum_row(const struct adaptive *a, int i)
{
    const size_t n_nm = (size_t)a->spectra->n_nm;
    return i < a->spectra->n_lights
               ? a->spectra->lights + (size_t)i * n_nm
               : a->spectra->products + (size_t)(i - a->spectra->n_lights) * n_nm;
}

/* ---- emission peaks ---- */

/* A sample is a summit if it is the largest up to some distance of at most 10 nm, and above the
 * mean of its neighbours there by half of the spectrum's mean. Daylight (d65) exceeds its
 * neighbours by less than a sixth, smooth spectra by less. Lines between two nm of the grid are not
 * seen. */
enum { FARTHEST_NEIGHBOUR = 10 };
static const double least_excess = 0.5;

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

/* Walks down from a summit, which may be flat. Returns the foot: the cell from which the next step
 * falls by less than a hundredth of the summit. */
static int foot_of(const double *row, int n, int j, int step)
{
    const double slope = row[j] / 100;
    while (j + step >= 0 && j + step < n && row[j] - row[j + step] > slope)
        j += step;
    return j;
}

/* Cuts the range around the peaks of a light. Marks their summits. */
static void cut_at_peaks(struct adaptive *a, const double *row, bool *summit)
{
    const int n = a->spectra->n_nm;
    double mean = 0;
    for (int j = 0; j < n; j++)
        mean += row[j] / n;
    for (int j = 0; j < n; j++)
        if (is_summit(row, n, j, least_excess * mean)) {
            summit[j] = a->cut[j] = a->cut[foot_of(row, n, j, -1)] = true;
            a->cut[foot_of(row, n, j, 1) + 1] = true;
        }
}

static bool find_peaks(struct adaptive *a, struct error *err)
{
    struct sampling *out = a->sampling;
    const int n = a->spectra->n_nm;
    bool *summit;
    if (!sampling_numbers(&out->peak_nm, (size_t)n, err) ||
        !MAKE_ARRAY(summit, n, err, "the peaks of the spectra"))
        return false;
    for (int i = 0; i < a->spectra->n_lights; i++)
        cut_at_peaks(a, spectrum_row(a, i), summit);
    for (int j = 0; j < n; j++)
        if (summit[j])
            out->peak_nm[out->n_peaks++] = out->fine.nm[j];
    free(summit);
    return true;
}

/* ---- scales of errors ---- */

static double largest_response(const struct adaptive *a, int i)
{
    const struct fine_detector *fine = &a->sampling->fine;
    double response[3];
    detector_response(fine->weights, spectrum_row(a, i), fine->n, response);
    return fmax(fabs(response[0]), fmax(fabs(response[1]), fabs(response[2])));
}

static bool is_below(const double *a, const double *b, int n)
{
    int j = 0;
    while (j < n && a[j] <= b[j])
        j++;
    return j == n;
}

/* Errors of a light are parts of its own response, those of a product of its light's. That is the
 * dimmest light nowhere below the product; without one it is the product itself. */
static void find_scales(struct adaptive *a)
{
    const int lights = a->spectra->n_lights, n_nm = a->spectra->n_nm;
    for (int i = 0; i < a->n_spectra; i++) {
        double dimmest = HUGE_VAL;
        for (int light = 0; light < lights && i >= lights; light++)
            if (is_below(spectrum_row(a, i), spectrum_row(a, light), n_nm))
                dimmest = fmin(dimmest, a->scale[light]);
        a->scale[i] = dimmest < HUGE_VAL ? dimmest : largest_response(a, i);
    }
    for (int j = 0; j < n_nm; j++)
        a->seen[j + 1] = a->seen[j] + sampling_seen(a->sampling, j);
}

/* ---- the fewest nodes ---- */

/* Weighs the nodes of a segment that has no weights yet. */
static void weigh_nodes(const struct adaptive *a, struct segment *s)
{
    const struct fine_detector *fine = &a->sampling->fine;
    for (int i = 0; i < s->n; i++)
        for (int j = s->from; j < s->to; j++) {
            const double part = quadrature_lagrange(s->nm, s->n, i, fine->nm[j]);
            for (int channel = 0; channel < 3; channel++)
                s->weight[channel][i] += part * fine->weights[channel * fine->n + j];
        }
}

/* Places nodes at the cells nearest to Legendre's. Returns false if two would be the same. */
static bool place_nodes(const struct adaptive *a, struct segment *s)
{
    struct quadrature rule;
    quadrature_legendre(s->from, s->to, s->n, &rule);
    for (int i = 0; i < s->n; i++) {
        s->cell[i] = (int)floor(rule.node[i]);
        s->nm[i] = a->sampling->fine.nm[s->cell[i]];
        if (i > 0 && s->cell[i] <= s->cell[i - 1])
            return false;
    }
    weigh_nodes(a, s);
    return true;
}

/* Finds the error that a segment adds to each channel of a spectrum. */
static void errors_of(const struct adaptive *a, const struct segment *s, int spectrum,
                      double out[3])
{
    const struct fine_detector *fine = &a->sampling->fine;
    const double *row = spectrum_row(a, spectrum);
    for (int channel = 0; channel < 3; channel++) {
        const double *weights = fine->weights + channel * fine->n;
        out[channel] = 0;
        for (int i = 0; i < s->n; i++)
            out[channel] += s->weight[channel][i] * row[s->cell[i]];
        for (int j = s->from; j < s->to; j++)
            out[channel] -= weights[j] * row[j];
    }
}

static bool is_small(const double error[3], double limit)
{
    return !(fabs(error[0]) > limit || fabs(error[1]) > limit || fabs(error[2]) > limit);
}

static bool fits(const struct adaptive *a, struct segment *s)
{
    const double part = (a->seen[s->to] - a->seen[s->from]) / a->seen[a->spectra->n_nm];
    bool good = place_nodes(a, s);
    for (int i = 0; good && i < a->n_spectra; i++) {
        double error[3];
        errors_of(a, s, i, error);
        good = is_small(error, a->tolerance * part * a->scale[i]);
    }
    return good;
}

/* Finds the fewest nodes, fewer than `limit`, with which the cells fit. Returns their number; 0:
 * there are none. */
static int fewest_nodes(const struct adaptive *a, int from, int to, int limit, struct segment *out)
{
    for (int n = 1; n < limit && n <= MOST_NODES; n++) {
        *out = (struct segment){.from = from, .to = to, .n = n};
        if (fits(a, out))
            return n;
    }
    return 0;
}

/* Makes one segment of the cells, or divides them in halves if these have fewer nodes; a cell alone
 * is exact. Returns the number of nodes. */
static int divide(struct adaptive *a, int from, int to)
{
    struct segment segment;
    const int before = a->n, cells = to - from;
    const int whole = fewest_nodes(a, from, to, cells > 1 ? cells : 2, &segment);
    if (whole == 0 || whole > 2) {
        const int middle = (from + to) / 2;
        const int halves = divide(a, from, middle) + divide(a, middle, to);
        if (whole == 0 || halves < whole)
            return halves;
    }
    a->n = before;
    a->segments[a->n++] = segment;
    return whole;
}

static void divide_all(struct adaptive *a)
{
    const int n = a->spectra->n_nm;
    a->n = 0;
    for (int from = 0, to; from < n; from = to) {
        to = from + 1;
        while (to < n && !a->cut[to])
            to++;
        divide(a, from, to);
    }
}

/* Joins neighbours where one segment has fewer nodes, until there are none. */
static void join_all(struct adaptive *a)
{
    for (int before = 0; before != a->n;) {
        int n = 1;
        before = a->n;
        for (int i = 1; i < before; i++) {
            struct segment joined, *last = &a->segments[n - 1];
            const struct segment *next = &a->segments[i];
            if (fewest_nodes(a, last->from, next->to, last->n + next->n, &joined) > 0)
                *last = joined;
            else
                a->segments[n++] = *next;
        }
        a->n = n;
    }
}

/* Returns whether all segments together keep the tolerance. */
static bool is_within(const struct adaptive *a, double tolerance)
{
    bool good = true;
    for (int i = 0; good && i < a->n_spectra; i++) {
        double total[3] = {0}, error[3];
        for (int s = 0; s < a->n; s++) {
            errors_of(a, &a->segments[s], i, error);
            for (int channel = 0; channel < 3; channel++)
                total[channel] += error[channel];
        }
        good = is_small(total, tolerance * a->scale[i]);
    }
    return good;
}

static void keep_fewest(struct adaptive *a, double tolerance)
{
    int n_pages = 0;
    for (int s = 0; s < a->n; s++)
        n_pages += a->segments[s].n;
    if ((a->fewest == 0 || n_pages < a->fewest) && is_within(a, tolerance)) {
        a->fewest = n_pages;
        a->n_best = a->n;
        memcpy(a->best, a->segments, (size_t)a->n * sizeof *a->best);
    }
}

/* Errors of segments cancel: so each segment is first allowed far more than its part of the
 * tolerance. If none exceeds its part, the sum is within the tolerance, but for rounding; single
 * cells are exact. */
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

static bool make_room(struct adaptive *a, struct error *err)
{
    const size_t n_nm = (size_t)a->spectra->n_nm, count = (size_t)a->n_spectra;
    if (!sampling_numbers(&a->scale, count + n_nm + 1, err) ||
        !MAKE_ARRAY(a->cut, n_nm + 1, err, "the segments of a sampling") ||
        !MAKE_ARRAY(a->segments, 2 * n_nm, err, "the segments of a sampling"))
        return false;
    a->seen = a->scale + count;
    a->best = a->segments + n_nm;
    return true;
}

static bool set_pages(const struct adaptive *a, struct sampling *out, struct error *err)
{
    int n = 0;
    if (!sampling_room(out, a->fewest, SEGMENTS, err))
        return false;
    for (int s = 0; s < a->n_best; s++) {
        const struct segment *segment = &a->best[s];
        for (int i = 0; i < segment->n; i++, n++) {
            out->pages.wavelength_nm[n] = segment->nm[i];
            out->segment_nm[n][0] = out->pages.first_nm + segment->from - 0.5;
            out->segment_nm[n][1] = out->pages.first_nm + segment->to - 0.5;
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
    bool done = make_room(&a, err) && find_peaks(&a, err);
    if (done) {
        find_scales(&a);
        find_segments(&a, out->method.number);
        done = set_pages(&a, out, err);
    }
    FREE_ALL(a.scale, a.cut, a.segments);
    return done;
}
