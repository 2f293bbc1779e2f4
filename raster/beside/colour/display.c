/* SPDX-License-Identifier: MIT */
/* Displays: sRGB; any other by its numbers, as the monitor of the 1998 thesis. */
#include "raster/beside/colour/colour.h"

static const struct display_curve srgb_curve = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};

/* ---- values ---- */

double display_largest(const struct display *of, int channel)
{
    const struct display_curve *curve = &of->curve[channel];
    return of->is_srgb ? 1 : power(curve->gain + curve->offset, curve->exponent);
}

double display_encode(const struct display *of, int channel, double linear)
{
    const struct display_curve *curve = &of->curve[channel];
    if (!(linear > 0))
        return 0;
    if (linear >= display_largest(of, channel))
        return 1;
    if (linear <= curve->slope * curve->from)
        return linear / curve->slope;
    return fmax(0, fmin(1, (power(linear, 1 / curve->exponent) - curve->offset) / curve->gain));
}

bool display_store(const struct display *of, int bits, const double linear[3], void *out)
{
    const double slack = 1e-6;
    bool clipped = false;
    for (int channel = 0; channel < 3; channel++) {
        const double value = display_encode(of, channel, linear[channel]);
        if (bits == 16)
            ((uint16_t *)out)[channel] = (uint16_t)(value * 65535 + 0.5);
        else
            ((uint8_t *)out)[channel] = (uint8_t)(value * 255 + 0.5);
        clipped = clipped || linear[channel] < -slack ||
                  linear[channel] > display_largest(of, channel) + slack;
    }
    return clipped;
}

/* ---- profiles ---- */

/* Writes numbers as ICC.1:2010, 4.6 (s15Fixed16Number): 16 bits and 16 behind the point. Returns
 * false if one has no place there. */
static bool put_fixed(const double *values, int n, unsigned char *out)
{
    for (int i = 0; i < n; i++) {
        if (!(fabs(values[i]) < 32767))
            return false;
        const int64_t fixed = (int64_t)floor(values[i] * 65536 + 0.5);
        for (int byte = 0; byte < 4; byte++)
            out[4 * i + byte] = (unsigned char)((uint64_t)fixed >> (24 - 8 * byte));
    }
    return true;
}

/* Puts the display's numbers into the profile. Its tags are, in this order, a name, a copyright,
 * the white, the adaptation, three colorants, three curves. A curve is of function type 1, (a x +
 * b)^g, and ends at 1 (ICC.1:2010, 10.15). Returns false if the primaries add up to no white. */
static bool put_numbers(struct display *of)
{
    enum { TABLE = 132, ROW = 12, ADAPTATION_TAG = 3, COLORANT = 4, CURVE = 7 };
    static const double d50[3] = {0.9642, 1, 0.8249};
    const double y = of->primaries[0][1] + of->primaries[1][1] + of->primaries[2][1];
    double white[3] = {0}, of_white[3], of_d50[3], colorant[3], adapt[3][3], back[3][3];
    unsigned char *tag[CURVE + 3];
    for (int i = 0; i < CURVE + 3; i++) {
        const unsigned char *place = of->profile + TABLE + ROW * i + 4;
        tag[i] = of->profile + 256 * place[2] + place[3]; /* it is small */
    }
    for (int i = 0; i < 9; i++)
        white[i % 3] += of->primaries[i / 3][i % 3] / y;
    adaptation_cones(ADAPTATION_BRADFORD, adapt);
    tristimulus_inverse(adapt, back);
    tristimulus_apply(adapt, white, of_white);
    tristimulus_apply(adapt, d50, of_d50);
    for (int i = 0; i < 9; i++)
        adapt[i / 3][i % 3] *= of_d50[i / 3] / of_white[i / 3];
    tristimulus_apply_all(back, 3, adapt[0]);
    bool done = y > 0 && put_fixed(adapt[0], 9, tag[ADAPTATION_TAG] + 8);
    for (int i = 0; done && i < 3; i++) {
        const struct display_curve *curve = &of->curve[i];
        const double range = curve->gain + curve->offset;
        tristimulus_apply(adapt, of->primaries[i], colorant);
        for (int j = 0; j < 3; j++)
            colorant[j] /= y;
        done = of_white[i] > 0 && put_fixed(colorant, 3, tag[COLORANT + i] + 8) &&
               put_fixed((double[]){curve->exponent, curve->gain / range, curve->offset / range}, 3,
                         tag[CURVE + i] + 12);
    }
    return done;
}

static bool make_profile(struct display *of)
{
    const struct builtin_file *file;
    struct error none = {.status = EXIT_AGREED}; /* built-in files do not fail */
    int descriptor;
    file_open(of->is_srgb ? BUILTIN_PREFIX "displays/srgb.icc" : BUILTIN_PREFIX "displays/own.icc",
              (struct place){NULL, 0, 0}, &descriptor, &file, &none);
    of->profile_length = file->length;
    memcpy(of->profile, file->bytes, file->length);
    return of->is_srgb || put_numbers(of);
}

/* ---- reading ---- */

static double largest_of(double m[3][3])
{
    double largest = 0;
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, fabs(m[i / 3][i % 3]));
    return largest;
}

/* The matrix to linear values follows from the primaries at full drive. */
static bool find_matrix(const char *path, struct display *of, struct error *err)
{
    const double most = 1e9; /* condition */
    double columns[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            columns[i][j] = of->primaries[j][i];
    tristimulus_inverse(columns, of->matrix);
    if (!(largest_of(columns) * largest_of(of->matrix) < most)) /* nor NaN */
        return error_usage(
            err, "%s: its primaries lie in a plane; expected X, Y, Z of red, green, blue", path);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            of->matrix[i][j] *= display_largest(of, i);
    return true;
}

/* No power of such numbers, and no number of the profile, becomes 0 or infinite. */
static bool check_curve(const char *path, const struct display_curve *curve, struct error *err)
{
    const double least = 0.01, most = 100;
    const double value[] = {curve->gain, curve->exponent, curve->gain + curve->offset};
    for (int i = 0; i < 3; i++)
        if (!(value[i] >= least && value[i] <= most))
            return error_usage(err,
                               "%s: gain, gamma and gain + offset lie from %g to %g; found %g, %g "
                               "and %g",
                               path, least, most, value[0], value[1], value[2]);
    return true;
}

bool display_is_known(const char *name)
{
    return strcmp(name, "srgb") == 0 || strcmp(name, "monitor") == 0;
}

bool display_read(const char *name, struct display *out, struct error *err)
{
    static const char *const names[] = {"red", "green", "blue", "gain", "offset", "gamma"};
    double row[6][3];
    const char *path = strcmp(name, "monitor") == 0 ? BUILTIN_PREFIX "displays/monitor.csv" : name;
    *out = (struct display){.name = name, .is_srgb = strcmp(name, "srgb") == 0};
    if (out->is_srgb) {
        tristimulus_to_srgb(out->matrix);
        for (int i = 0; i < 3; i++)
            out->curve[i] = srgb_curve;
        return make_profile(out);
    }
    if (!display_is_known(name) && file_is_missing(name))
        return error_at(err, VALUE_OF("--display"),
                        "no display '%.100s' and no such file; expected srgb, monitor, or a "
                        "file of a display's numbers",
                        name);
    if (!rows_of_three(path, names, 6, row, err))
        return false;
    memcpy(out->primaries, row, sizeof out->primaries);
    for (int i = 0; i < 3; i++) {
        out->curve[i] = (struct display_curve){row[5][i], row[3][i], row[4][i], 0, 0};
        if (!check_curve(path, &out->curve[i], err))
            return false;
    }
    if (!find_matrix(path, out, err))
        return false;
    return make_profile(out) ||
           error_usage(err,
                       "%s: its primaries add up to no white; expected X, Y, Z of red, green, blue",
                       path);
}
