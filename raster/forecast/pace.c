/* SPDX-License-Identifier: MIT */
/* The pace of this machine, in a small file of the user's cache (XDG Base Directory Specification
 * 0.8). */
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "data/output/output.h"
#include "data/text/text.h"
#include "raster/forecast/forecast.h"

static const char *const names[FORECAST_KINDS] = {
    [FORECAST_CHECKED] = "checked", [FORECAST_REFERENCE] = "reference"};

enum { PATH_LENGTH = 4096 };

/* Writes the path of a folder and of what is in it. Returns false without a folder for caches. */
static bool path_of(const char *end, char out[PATH_LENGTH])
{
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    const bool is_given = cache && cache[0] == '/';
    if (!is_given && !(home && home[0] == '/'))
        return false;
    const int length = snprintf(out, PATH_LENGTH, "%s%s%s", is_given ? cache : home,
                                is_given ? "" : "/.cache", end);
    return length > 0 && length < PATH_LENGTH;
}

/* Reads a line: a name and a number. */
static bool read_line(struct text *text, double out[FORECAST_KINDS], struct error *err)
{
    struct word word;
    double pace;
    if (!text_expect(text, &word, "name", err) ||
        !text_number(text, "pace", 1e-3, 1e3, &pace, err) || !text_end(text, "pace", err))
        return false;
    for (int i = 0; i < FORECAST_KINDS; i++)
        if (word_is(&word, names[i]))
            out[i] = pace;
    return true;
}

void pace_read(double out[FORECAST_KINDS])
{
    const struct place nowhere = {NULL, 0, 0};
    struct error ignored = {.status = EXIT_AGREED};
    struct text text;
    char path[PATH_LENGTH];
    for (int i = 0; i < FORECAST_KINDS; i++)
        out[i] = 0;
    if (!path_of("/spectral/pace", path) || !text_open(&text, path, nowhere, &ignored))
        return;
    while (text_next_line(&text) && read_line(&text, out, &ignored))
        ;
    text_free(&text);
}

void pace_write(const double pace[FORECAST_KINDS])
{
    struct error ignored = {.status = EXIT_AGREED};
    struct printed printed = {.text = NULL};
    char path[PATH_LENGTH];
    if (!path_of("", path))
        return;
    mkdir(path, 0700); /* there already, or the next one fails */
    if (!path_of("/spectral", path) || (mkdir(path, 0700), !path_of("/spectral/pace", path)))
        return;
    for (int i = 0; i < FORECAST_KINDS; i++)
        if (pace[i] > 0)
            print(&printed, "%s %.4g\n", names[i], pace[i]);
    char *text = printed_end(&printed);
    if (text)
        file_write(path, text, printed.length, NULL, &ignored);
    free(text);
}
