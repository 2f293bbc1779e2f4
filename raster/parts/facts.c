/* SPDX-License-Identifier: MIT */
/* The facts of a part's file, as text. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster/parts/parts.h"

static const char *word_of(bool truth)
{
    return truth ? "yes" : "no";
}

/* Numbers are written in hexadecimal, which keeps all of their digits. The record stands before
 * what follows from it, so that a message names the cause of a difference. */
char *facts_text(const struct plan *plan, const struct part_facts *facts, const char *record)
{
    struct printed printed = {.text = NULL};
    print(&printed, "size: %d x %d, tiles of %d x %d, %d bands of %d bits, map of %d bytes\n",
          plan->scene->width, plan->scene->height, plan->tile_width, plan->tile_height,
          plan->n_bands, plan->options.bits, plan->map_bytes);
    print_text(&printed, record);
    print(&printed, "shared: %s\n", word_of(facts->shared));
    print(&printed, "radiance_of_full_scale: %a\nclips: %s\n", facts->full_scale,
          word_of(facts->clips));
    print(&printed, "check: %s\nstrict: %s\nunchecked: %a\n", word_of(facts->check),
          word_of(facts->strict), facts->unchecked);
    print(&printed, "measured: %s\ntriangles_checked: %s\ndepths_checked: %s\n",
          word_of(facts->measured), word_of(!facts->lacks.numbers), word_of(!facts->lacks.depths));
    print(&printed, "gl_library: %s\ngl_renderer: %s\ngl_version: %s\n", facts->names.library,
          facts->names.renderer, facts->names.version);
    return printed_end(&printed);
}

/* Finds the value of a line "KEY: VALUE". Returns its length; *out is NULL where there is none. */
static size_t find_value(const char *text, const char *key, const char **out)
{
    const size_t length = strlen(key);
    const char *line = text;
    for (*out = NULL; line && !*out; line = strchr(line, '\n')) {
        line += *line == '\n';
        if (strncmp(line, key, length) == 0 && strncmp(line + length, ": ", 2) == 0)
            *out = line + length + 2;
    }
    return *out ? strcspn(*out, "\n") : 0;
}

static bool read_text(const char *text, const char *key, char *out, size_t capacity)
{
    const char *value;
    const size_t length = find_value(text, key, &value);
    if (!value || length >= capacity)
        return false;
    memcpy(out, value, length);
    out[length] = '\0';
    return true;
}

static bool read_truth(const char *text, const char *key, bool *out)
{
    char word[8];
    if (!read_text(text, key, word, sizeof word))
        return false;
    *out = strcmp(word, "yes") == 0;
    return *out || strcmp(word, "no") == 0;
}

static bool read_number(const char *text, const char *key, double *out)
{
    char word[64], *end = word;
    if (!read_text(text, key, word, sizeof word))
        return false;
    *out = strtod(word, &end);
    return end != word && *end == '\0';
}

bool facts_read(const char *text, struct part_facts *out)
{
    struct renderer_names *names = &out->names;
    bool numbers, depths;
    *out = (struct part_facts){.check = false};
    const bool done =
        read_number(text, "radiance_of_full_scale", &out->full_scale) &&
        read_truth(text, "clips", &out->clips) && read_truth(text, "check", &out->check) &&
        read_truth(text, "strict", &out->strict) && read_truth(text, "shared", &out->shared) &&
        read_number(text, "unchecked", &out->unchecked) &&
        read_truth(text, "measured", &out->measured) &&
        read_truth(text, "triangles_checked", &numbers) &&
        read_truth(text, "depths_checked", &depths) &&
        read_text(text, "gl_library", names->library, sizeof names->library) &&
        read_text(text, "gl_renderer", names->renderer, sizeof names->renderer) &&
        read_text(text, "gl_version", names->version, sizeof names->version);
    if (done)
        out->lacks = (struct renderer_lacks){!numbers, !depths};
    return done;
}

bool facts_differ(const char *a, const char *b, char line_a[FACT_LINE], char line_b[FACT_LINE])
{
    while (*a && *b) {
        const size_t length_a = strcspn(a, "\n"), length_b = strcspn(b, "\n");
        if (length_a != length_b || memcmp(a, b, length_a) != 0)
            break;
        a += length_a + (a[length_a] == '\n');
        b += length_b + (b[length_b] == '\n');
    }
    snprintf(line_a, FACT_LINE, "%.*s", (int)strcspn(a, "\n"), a);
    snprintf(line_b, FACT_LINE, "%.*s", (int)strcspn(b, "\n"), b);
    return *a || *b;
}
