/* SPDX-License-Identifier: MIT */
/* CIE daylight of a correlated colour temperature (CIE 015:2018): a mean and two directions
 * of variation, whose parts M1 and M2 follow from the chromaticity. The CIE rounds M1 and M2 to
 * three decimals, and so does this file. So daylight:6503.616 is D65 to one unit of its sixth
 * digit, and daylight:5002.782 is D50. (6503.616 K is 6500 K times 1.4388/1.4380, the ratio of
 * today's second radiation constant to that of the time when D65 was named.) At the round 6504 K M1
 * is -0.294, and for D65 it is -0.295: daylight:6504 differs from D65 by up to 0.0005, at 410 nm.
 */
#include <math.h>

#include "data/spectra/inside.h"

static const double coldest = 4000, hottest = 25000;

/* Rounds to three decimals. */
static double round_part(double part)
{
    return floor(part * 1000 + 0.5) / 1000;
}

/* Computes M1 and M2 from the chromaticity x, y. */
static void find_parts(double kelvin, double out[2])
{
    const double t = 1000 / kelvin;
    const double x = kelvin <= 7000 ? ((-4.6070 * t + 2.9678) * t + 0.09911) * t + 0.244063
                                    : ((-2.0064 * t + 1.9018) * t + 0.24748) * t + 0.237040;
    const double y = (-3.000 * x + 2.870) * x - 0.275;
    const double divisor = 0.0241 + 0.2562 * x - 0.7341 * y;
    out[0] = round_part((-1.3515 - 1.7703 * x + 5.9114 * y) / divisor);
    out[1] = round_part((0.0300 - 31.4424 * x + 30.0717 * y) / divisor);
}

static bool read_temperature(const struct word *word, double *out, struct error *err)
{
    if (word->length == 0)
        return error_at(err, word->place,
                        "expected a temperature from %g to %g K, as daylight:6504", coldest,
                        hottest);
    if (!word_number(word, "temperature", -HUGE_VAL, HUGE_VAL, out, err))
        return false;
    if (*out >= coldest && *out <= hottest)
        return true;
    if (*out > 0 && *out < coldest)
        return error_at(err, word->place,
                        "daylight has a temperature from %g to %g K; for %.15g K write "
                        "blackbody:%.15g",
                        coldest, hottest, *out, *out);
    return error_at(err, word->place, "daylight has a temperature from %g to %g K, not %.15g",
                    coldest, hottest, *out);
}

/* The first component is 100 at 560 nm, where the others are 0: daylight is 1 there. */
bool daylight_read(const struct word *temperature, struct spectrum *out, struct error *err)
{
    struct spectrum components[3] = {{0}};
    double kelvin, parts[2];
    bool xyz, done = read_temperature(temperature, &kelvin, err) &&
                     spectra_read("builtin:daylight/components.csv", components, &xyz, err);
    if (done)
        find_parts(kelvin, parts);
    for (int i = 0; done && i < components[0].count; i++)
        done = spectrum_append(out, components[0].wavelength_nm[i],
                               (components[0].value[i] + parts[0] * components[1].value[i] +
                                parts[1] * components[2].value[i]) /
                                   100,
                               temperature->place, err);
    for (int i = 0; i < 3; i++)
        spectrum_free(&components[i]);
    return done;
}
