/* SPDX-License-Identifier: MIT */
/* The scale of colours in which pictures show floors and differences. */
#include "data/images/inside.h"

static const struct {
    uint8_t rgb[3];
    const char *name; /* NULL: scale_print leaves this step out */
} steps[] = {{{8, 29, 88}, "navy"},          {{34, 72, 155}, NULL},
             {{29, 120, 180}, NULL},         {{45, 160, 190}, NULL},
             {{110, 195, 188}, "turquoise"}, {{180, 222, 190}, NULL},
             {{225, 240, 190}, NULL},        {{250, 245, 180}, "pale yellow"},
             {{254, 217, 118}, NULL},        {{254, 178, 76}, NULL},
             {{253, 120, 50}, "orange"},     {{227, 50, 26}, NULL},
             {{160, 10, 30}, "dark red"},    {{90, 0, 40}, "maroon"}};
enum { STEPS = sizeof steps / sizeof steps[0] };

void scale_colour(double value, double least, uint8_t out[3])
{
    int step = 0;
    for (double most = least; step < STEPS - 1 && !(value <= most); most *= 2)
        step++;
    for (int channel = 0; channel < 3; channel++)
        out[channel] = value == 0 ? 0 : steps[step].rgb[channel];
}

void scale_print(double least, struct printed *to)
{
    print_text(to, "up to ");
    for (int step = 0; step < STEPS - 1; step++)
        if (steps[step].name) {
            const double power = ldexp(least, step);
            print(to, power < 1 ? "1/%.0f %s, " : "%.0f %s, ", power < 1 ? 1 / power : power,
                  steps[step].name);
        }
    print(to, "above %s", steps[STEPS - 1].name);
}
