/* SPDX-License-Identifier: MIT */
/* Displays: sRGB, and the monitor of the 1998 thesis. */
#include "data/files/files.h"
#include "data/maths/maths.h"
#include "raster/beside/colour/colour.h"

const char *const display_names[] = {[DISPLAY_SRGB] = "srgb", [DISPLAY_MONITOR] = "monitor", NULL};

/* The tone curve of a display: linear = (gain x value + offset)^exponent; for values below `from`
 * linear = slope x value. */
struct display_curve {
    double exponent, gain, offset, slope, from;
};
/* The monitor with the figures of the thesis's program. The text of the thesis prints them rounded,
 * and prints equation 14 with the inverse exponent and with offsets that were not used. */
static const double monitor[3][3] = {
    {0.03426, -0.01633, -0.005365}, {-0.01026, 0.01911, 0.0002522}, {0.000529, -0.001811, 0.00867}};
static const struct display_curve monitor_curves[3] = {
    {1.534, 1.035, 0, 0, 0}, {1.393, 1.053, 0, 0, 0}, {1.435, 1.047, 0, 0, 0}};
static const struct display_curve srgb_curve = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};

void display_matrix(enum display_kind kind, double out[3][3])
{
    if (kind == DISPLAY_SRGB)
        tristimulus_to_srgb(out);
    else
        memcpy(out, monitor, sizeof monitor);
}

static struct display_curve display_curve(enum display_kind kind, int channel)
{
    return kind == DISPLAY_SRGB ? srgb_curve : monitor_curves[channel];
}

double display_largest(enum display_kind kind, int channel)
{
    const struct display_curve curve = display_curve(kind, channel);
    return kind == DISPLAY_SRGB ? 1 : power(curve.gain, curve.exponent);
}

double display_encode(enum display_kind kind, int channel, double linear)
{
    const struct display_curve curve = display_curve(kind, channel);
    if (!(linear > 0))
        return 0;
    if (linear >= display_largest(kind, channel))
        return 1;
    if (linear <= curve.slope * curve.from)
        return linear / curve.slope;
    return fmin(1, (power(linear, 1 / curve.exponent) - curve.offset) / curve.gain);
}

bool display_store(enum display_kind kind, int bits, const double linear[3], void *out)
{
    const double slack = 1e-6;
    bool clipped = false;
    for (int channel = 0; channel < 3; channel++) {
        const double value = display_encode(kind, channel, linear[channel]);
        if (bits == 16)
            ((uint16_t *)out)[channel] = (uint16_t)(value * 65535 + 0.5);
        else
            ((uint8_t *)out)[channel] = (uint8_t)(value * 255 + 0.5);
        clipped = clipped || linear[channel] < -slack ||
                  linear[channel] > display_largest(kind, channel) + slack;
    }
    return clipped;
}

const struct builtin_file *display_profile(enum display_kind kind)
{
    const struct builtin_file *file;
    struct error none = {.status = EXIT_AGREED}; /* built-in files do not fail */
    char path[64];
    int descriptor;
    snprintf(path, sizeof path, BUILTIN_PREFIX "displays/%s.icc", display_names[kind]);
    file_open(path, (struct place){NULL, 0, 0}, &descriptor, &file, &none);
    return file;
}
