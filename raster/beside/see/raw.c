/* SPDX-License-Identifier: MIT */
/* The file of a detector's raw values, and what is said of it. */
#include <stdlib.h>

#include "raster/beside/see/inside.h"

/* Returns the unit of the values. */
static const char *unit_of(const struct development *of)
{
    return !of->cube.record.unit         ? "W sr-1 m-2 (relative)"
           : of->sight.detector.observer ? "cd m-2"
                                         : "W sr-1 m-2";
}

bool raw_open(const struct development *of, const char *path, struct stack_writer *out,
              struct error *err)
{
    struct printed made = {.text = NULL};
    print(&made, "program: " PROGRAM "\nraw values of: ");
    print_printable(&made, of->cube.image.path);
    print_text(&made, "\ndetector: ");
    print_printable(&made, of->sight.detector.name);
    print(&made, "\nexposure: %.*g\nunit: %s\n", exact_digits(of->exposure), of->exposure,
          unit_of(of));
    char *text = printed_take(&made, err);
    const struct stack_options options = {.width = of->cube.image.width,
                                          .height = of->cube.image.height,
                                          .n_wavelengths = of->sight.detector.n,
                                          .names = (const char *const *)of->sight.detector.channel,
                                          .unit = unit_of(of),
                                          .full_scale = of->full_scale,
                                          .bits = of->bits,
                                          .scene = of->cube.image.path,
                                          .provenance = text};
    const bool done = text && stack_open(out, path, &options, err);
    free(text);
    return done;
}

bool raw_write(const struct development *of, int y, struct stack_writer *writer, struct error *err)
{
    const int width = of->cube.image.width;
    struct page_rectangle to = {0, 0, y, width, (int)of->n / width};
    const size_t page = of->n * (size_t)of->bits / 8;
    for (; to.page < of->sight.detector.n; to.page++)
        if (!pages_write(&writer->pages, &to, (char *)of->samples + (size_t)to.page * page, err))
            return false;
    return true;
}

void raw_print(const struct development *of, const char *output, struct printed *to)
{
    const struct detector *detector = &of->sight.detector;
    print(to, "detector          %s (%d channel%s)\n", detector->name, detector->n,
          detector->n == 1 ? "" : "s");
    print(to, "values            raw, %s, %s\n", of->bits == 32 ? "float" : "16-bit counts",
          unit_of(of));
    if (of->bits == 16)
        print(to, "full scale        %.10g\n", of->full_scale);
    print(to, "exposure          %.10g%s\n", of->exposure, of->automatic ? " (auto)" : "");
    for (int i = 0; i < detector->n; i++)
        print(to, "channel %-9d %s: %.4g %% of its sensitivity lies outside\n", i + 1,
              detector->channel[i], 100 * of->sight.lost[i]);
    if (of->clipped.n > 0)
        print(to, "below 0           %llu values%s\n", (unsigned long long)of->clipped.n,
              of->bits == 32 ? "" : ", which become 0");
    print_fact(to, "picture", output);
}
