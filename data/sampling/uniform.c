/* SPDX-License-Identifier: MIT */
/* Samplings by steps, by boxes, and by three numbers. */
#include "data/sampling/inside.h"

bool sampling_refuse(const struct sampling_task *task, int most, struct error *err)
{
    return error_usage(err, "%s: more samples than the %d nm that %s", task->name, most,
                       most < task->out->fine.n ? "the detector sees" : "there are");
}

/* ---- steps ---- */

/* A step may not exceed the range: a single wavelength would stand for 1 nm alone. */
bool sample_riemann(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    const double step = out->method.number, range = out->fine.n - 1;
    if (range > 0 && step > range)
        return error_usage(err, "%s: the range is %g nm long; a step is no more than that",
                           task->name, range);
    if (!sampling_room(out, (int)floor(range / step + 1e-9) + 1, 0, err))
        return false;
    for (int i = 0; i < out->pages.n; i++)
        out->pages.wavelength_nm[i] = out->fine.nm[0] + i * step;
    detector_weights(task->detector, out->pages.wavelength_nm, out->pages.n, out->weights);
    return true;
}

/* ---- boxes ---- */

/* Returns the cell at which the area of all boxes so far reaches their part. */
static int box_end(const struct sampling *out, int first, int last, int box, double total)
{
    double area = 0;
    int end = first;
    while (end < last && area * out->pages.n < total * (box + 1))
        area += sampling_seen(out, end++);
    return end;
}

/* Each box has a cell at least. */
static void cut_boxes(struct sampling *out, int first, int last)
{
    const double *nm = out->fine.nm;
    const size_t n = (size_t)out->pages.n, n_nm = (size_t)out->fine.n;
    double total = 0;
    for (int j = first; j < last; j++)
        total += sampling_seen(out, j);
    for (int box = 0, start = first; box < out->pages.n; box++) {
        const int left = out->pages.n - 1 - box;
        int end = left == 0 ? last : box_end(out, first, last, box, total);
        end = end < start + 1 ? start + 1 : end > last - left ? last - left : end;
        out->segment_nm[box][0] = nm[start] - 0.5;
        out->segment_nm[box][1] = out->pages.first_nm + end - 0.5;
        out->pages.wavelength_nm[box] = (nm[start] + nm[end - 1]) / 2;
        for (int j = start; j < end; j++)
            out->pages.analysis[(size_t)box * n_nm + (size_t)j] = 1.0 / (end - start);
        for (int j = box == 0 ? 0 : start; j < (left == 0 ? out->fine.n : end); j++)
            out->synthesis[(size_t)j * n + (size_t)box] = 1;
        start = end;
    }
}

/* Unlike Hall's boxes, which he found by trying, these have equal areas under the detector's
 * functions. Cells at the ends that the detector does not see belong to none. */
bool sample_box(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    int first = 0, last = out->fine.n;
    while (sampling_seen(out, first) == 0)
        first++;
    while (sampling_seen(out, last - 1) == 0)
        last--;
    if (task->count > last - first)
        return sampling_refuse(task, last - first, err);
    if (!sampling_room(out, task->count, SEGMENTS | ANALYSIS | SYNTHESIS, err))
        return false;
    cut_boxes(out, first, last);
    return true;
}

/* ---- three numbers ---- */

/* Makes the analysis of reflectances: the numbers of the light that a surface reflects of d65, in
 * parts of d65's own. */
static bool divide_by_d65(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    const int n = out->fine.n;
    struct spectrum d65;
    const struct word word = {.start = "d65", .length = 3};
    if (!spectrum_read(&word, 0, HUGE_VAL, &d65, err))
        return false;
    bool good = true;
    for (int page = 0; page < 3; page++) {
        const double *light = out->pages.analysis + page * n;
        double *reflectance = out->pages.reflectance_analysis + page * n, sum = 0;
        for (int j = 0; j < n; j++) {
            reflectance[j] = light[j] * spectrum_at(&d65, out->fine.nm[j], SPECTRUM_ZERO);
            sum += reflectance[j];
        }
        good = good && sum > 0;
        for (int j = 0; j < n && good; j++)
            reflectance[j] /= sum;
    }
    spectrum_free(&d65);
    return good || error_usage(err,
                               "%s divides by the three numbers of d65, which are not all above 0 "
                               "from %.6g to %.6g nm; take a wider range",
                               task->name, out->fine.nm[0], out->fine.nm[n - 1]);
}

bool sample_tristimulus(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    double to[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, back[3][3];
    const size_t n = 3 * (size_t)out->fine.n;
    out->pages.clips = out->method.kind == SAMPLING_RGB;
    if (out->pages.clips)
        tristimulus_to_srgb(to);
    tristimulus_inverse(to, back);
    if (!sampling_room(out, 3, ANALYSIS, err) ||
        !sampling_numbers(&out->pages.reflectance_analysis, n, err))
        return false;
    memcpy(out->pages.analysis, out->fine.weights, n * sizeof *out->pages.analysis);
    tristimulus_apply_all(to, out->fine.n, out->pages.analysis);
    memcpy(out->weights, back, sizeof back);
    return divide_by_d65(task, err);
}
