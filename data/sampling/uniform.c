/* SPDX-License-Identifier: MIT */
/* Samplings by steps, by boxes, and by three numbers. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/colour/colour.h"
#include "data/method/method.h"
#include "data/sampling/sampling.h"
#include "data/spectra/spectra.h"
#include "data/text/text.h"
#include "spectral.h"

bool sampling_refuse(const struct sampling_task *task, int most, struct error *err)
{
    return error_usage(err, "%s: more samples than the %d nm that %s", task->name, most,
                       most < task->out->n_nm ? "the detector sees" : "there are");
}

/* ---- steps ---- */

/* A single wavelength would stand for 1 nm alone. */
bool sample_riemann(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    const double step = task->method->step_nm, range = out->n_nm - 1;
    if (range > 0 && step > range)
        return error_usage(err, "%s: the range is %g nm long; a step is no more than that",
                           task->name, range);
    if (!sampling_room(out, (int)floor(range / step + 1e-9) + 1, false, true, err))
        return false;
    for (int i = 0; i < out->n; i++)
        out->wavelength_nm[i] = out->first_nm + i * step;
    detector_weights(task->detector, out->wavelength_nm, out->n, out->weights);
    sampling_linear(out);
    out->spectral = true;
    return true;
}

/* ---- boxes ---- */

/* Box by box, the cell where it ends: the first at which the area reaches its part, but so that
 * each box has a cell. Cells at the ends that the detector does not see belong to none. */
static int box_end(const struct sampling *out, int first, int last, int box, double total)
{
    double area = 0;
    int end = first;
    while (end < last && area * out->n < total * (box + 1))
        area += sampling_seen(out, end++);
    return end;
}

static void cut_boxes(struct sampling *out, int first, int last)
{
    double total = 0;
    for (int j = first; j < last; j++)
        total += sampling_seen(out, j);
    for (int box = 0, start = first; box < out->n; box++) {
        const int left = out->n - 1 - box;
        int end = left == 0 ? last : box_end(out, first, last, box, total);
        end = end < start + 1 ? start + 1 : end > last - left ? last - left : end;
        out->segment_nm[box][0] = sampling_grid(out, start) - 0.5;
        out->segment_nm[box][1] = sampling_grid(out, end) - 0.5;
        out->wavelength_nm[box] = (sampling_grid(out, start) + sampling_grid(out, end - 1)) / 2;
        for (int j = start; j < end; j++)
            out->light_mean[(size_t)box * (size_t)out->n_nm + (size_t)j] = 1.0 / (end - start);
        for (int j = box == 0 ? 0 : start; j < (left == 0 ? out->n_nm : end); j++)
            out->synthesis[(size_t)j * (size_t)out->n + (size_t)box] = 1;
        start = end;
    }
}

/* Hall's boxes were found by trial; these have equal areas under the detector's functions. */
bool sample_box(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    const size_t size = (size_t)task->method->count * (size_t)out->n_nm * sizeof(double);
    int first = 0, last = out->n_nm;
    while (sampling_seen(out, first) == 0)
        first++;
    while (sampling_seen(out, last - 1) == 0)
        last--;
    if (task->method->count > last - first)
        return sampling_refuse(task, last - first, err);
    if (!sampling_room(out, task->method->count, true, true, err))
        return false;
    out->light_mean = calloc(1, size);
    out->reflectance_mean = malloc(size);
    if (out->light_mean == NULL || out->reflectance_mean == NULL)
        return error_memory(err);
    cut_boxes(out, first, last);
    memcpy(out->reflectance_mean, out->light_mean, size);
    sampling_weights(task->detector, out->wavelength_nm, out->segment_nm, out->n, out->weights);
    out->spectral = true;
    return true;
}

/* ---- three numbers ---- */

void sampling_transform(double m[3][3], const double *rows, int n, double *out)
{
    for (int j = 0; j < n; j++)
        for (int i = 0; i < 3; i++)
            out[i * n + j] = m[i][0] * rows[j] + m[i][1] * rows[n + j] + m[i][2] * rows[2 * n + j];
}

/* A reflectance has the numbers of what it makes of d65, in parts of d65's own. */
static bool divide_by_d65(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    struct spectrum d65;
    const struct word word = {.start = "d65", .length = 3};
    if (!spectrum_read(&word, 0, HUGE_VAL, &d65, err))
        return false;
    bool good = true;
    for (int page = 0; page < 3; page++) {
        const double *light = out->light_mean + page * out->n_nm;
        double *reflectance = out->reflectance_mean + page * out->n_nm, sum = 0;
        for (int j = 0; j < out->n_nm; j++) {
            reflectance[j] = light[j] * spectrum_at(&d65, sampling_grid(out, j), SPECTRUM_ZERO);
            sum += reflectance[j];
        }
        good = good && sum > 0;
        for (int j = 0; j < out->n_nm && good; j++)
            reflectance[j] /= sum;
    }
    spectrum_free(&d65);
    return good || error_usage(err,
                               "%s divides by what d65 has of each number, and not all three are "
                               "above 0 from %.6g to %.6g nm; take a wider range",
                               task->name, out->first_nm, sampling_grid(out, out->n_nm - 1));
}

bool sample_tristimulus(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    const size_t count = 3 * (size_t)out->n_nm;
    double to[3][3], back[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            to[i][j] = i == j;
    if (task->method->kind == SAMPLING_RGB)
        display_matrix(DISPLAY_SRGB, to);
    colour_inverse(to, back);
    if (!sampling_room(out, 3, false, false, err))
        return false;
    out->light_mean = calloc(count, sizeof *out->light_mean);
    out->reflectance_mean = calloc(count, sizeof *out->reflectance_mean);
    if (out->light_mean == NULL || out->reflectance_mean == NULL)
        return error_memory(err);
    sampling_transform(to, out->detector_weights, out->n_nm, out->light_mean);
    for (int i = 0; i < 9; i++)
        out->weights[i] = back[i / 3][i % 3];
    for (int page = 0; page < 3; page++)
        out->wavelength_nm[page] = page + 1;
    out->fixed = true;
    out->clips = task->method->kind == SAMPLING_RGB;
    return divide_by_d65(task, err);
}
