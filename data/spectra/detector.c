/* SPDX-License-Identifier: MIT */
/* Detectors: three sensitivities, and the weights by which the radiances of a picture count in
 * them. */
#include "data/spectra/inside.h"

/* ---- wavelengths ---- */

/* The range that a wavelength stands for: half-way to its neighbours, as far beyond the ends. */
struct range {
    double first, last;
};
static struct range range_of(const double *nm, int n, int i)
{
    const double left = i > 0 ? nm[i] - nm[i - 1] : n > 1 ? nm[1] - nm[0] : 1;
    const double right = i < n - 1 ? nm[i + 1] - nm[i] : left;
    return (struct range){nm[i] - left / 2, nm[i] + right / 2};
}

/* Returns the integral of a sensitivity, or of its magnitude, over its table outside a range. */
static double sum_outside(const struct spectrum *s, bool magnitude, struct range picture)
{
    double sum = 0;
    for (int i = 0; i < s->count; i++) {
        const struct range own = range_of(s->wavelength_nm, s->count, i);
        const double first = fmax(own.first, picture.first), last = fmin(own.last, picture.last);
        const double outside = own.last - own.first - fmax(0, last - first);
        sum += outside * (magnitude ? fabs(s->value[i]) : s->value[i]);
    }
    return sum;
}

static const struct range nowhere = {HUGE_VAL, HUGE_VAL};

/* ---- reading ---- */

/* Refuses a sensitivity that is 0 everywhere. It may be negative at some wavelengths. */
static bool check_sensitivity(const struct spectrum *s, int column, bool is_y, struct error *err)
{
    const double sum = sum_outside(s, false, nowhere), magnitude = sum_outside(s, true, nowhere);
    if (!(magnitude > 0))
        return error_at(err, s->place, "value column %d is 0 everywhere", column);
    if (!isfinite(magnitude))
        return error_at(err, s->place, "value column %d is too large to be summed", column);
    return !is_y || sum > 0 ||
           error_at(err, s->place, "the sum of y is %.6g; an observer's is positive", sum);
}

/* The places are in a file that is closed at the end: their path becomes the detector's name. */
bool channels_read(const char *name, struct detector *out, struct error *err)
{
    *out = (struct detector){.name = NULL};
    bool done = string_copy(name, &out->name, err) && spectra_read(name, 0, NULL, out, err);
    if (done && out->n > MOST_CHANNELS)
        return error_usage(err, "%s has %d channels; a detector has at most %d", name, out->n,
                           MOST_CHANNELS);
    for (int channel = 0; channel < out->n; channel++) {
        struct spectrum *s = &out->sensitivity[channel];
        s->place.path = out->name;
        done = done && check_sensitivity(s, channel + 1, out->observer && channel == 1, err);
    }
    return done;
}

bool detector_read(const char *name, struct detector *out, struct error *err)
{
    return channels_read(name, out, err) &&
           (out->n == 3 ||
            error_usage(err,
                        "%s has %d channel%s; expected 3, as 'wavelength,x,y,z' (develop --raw "
                        "and probe take any number, and --matrix any to XYZ)",
                        name, out->n, out->n == 1 ? "" : "s"));
}

void detector_free(struct detector *detector)
{
    set_free(detector->sensitivity, detector->n);
    FREE_ALL(detector->channel, detector->name);
    *detector = (struct detector){0};
}

/* ---- a picture's wavelengths ---- */

void detector_weights(const struct detector *detector, const double *wavelengths_nm, int n,
                      double *out)
{
    const double k =
        detector->observer ? 100 / sum_outside(&detector->sensitivity[1], false, nowhere) : 1;
    for (int i = 0; i < n; i++) {
        const struct range range = range_of(wavelengths_nm, n, i);
        const double width = k * (range.last - range.first);
        for (int channel = 0; channel < detector->n; channel++)
            out[channel * n + i] = width * spectrum_at(&detector->sensitivity[channel],
                                                       wavelengths_nm[i], SPECTRUM_ZERO);
    }
}

double detector_luminance(const struct detector *detector)
{
    return 683 * sum_outside(&detector->sensitivity[1], false, nowhere) / 100;
}

bool observer_read(const char *name, struct detector *out, struct error *err)
{
    return detector_read(name, out, err) &&
           (out->observer || error_usage(err,
                                         "%s is a camera or film, which has no tristimulus values;"
                                         " expected an observer",
                                         name));
}

void detector_response(const double *weights, const double *radiance, int n, double out[3])
{
    for (int channel = 0; channel < 3; channel++) {
        out[channel] = 0;
        for (int i = 0; i < n; i++)
            out[channel] += weights[channel * n + i] * (radiance != NULL ? radiance[i] : 1);
    }
}

void detector_lost(const struct detector *detector, const double *wavelengths_nm, int n,
                   double *out)
{
    detector_lost_outside(detector, range_of(wavelengths_nm, n, 0).first,
                          range_of(wavelengths_nm, n, n - 1).last, out);
}

void detector_lost_outside(const struct detector *detector, double first_nm, double last_nm,
                           double *out)
{
    const struct range picture = {first_nm, last_nm};
    for (int channel = 0; channel < detector->n; channel++) {
        const struct spectrum *s = &detector->sensitivity[channel];
        out[channel] = sum_outside(s, true, picture) / sum_outside(s, true, nowhere);
    }
}
