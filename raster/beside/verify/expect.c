/* SPDX-License-Identifier: MIT */
/* An earlier report, whose outcomes are expected again. Of its JSON (RFC 8259) only the strings
 * count: each is a key, or the value of the key before. */
#include "raster/beside/verify/inside.h"

/* Returns the next string, without its escapes, and moves *at behind it; NULL: there is none. The
 * strings that count have escapes of one character only. */
static char *next_string(char **at, bool *is_key)
{
    char *start = strchr(*at, '"'), *to = start;
    if (!start)
        return NULL;
    char *from = start + 1;
    for (; *from && *from != '"'; from++) {
        from += *from == '\\' && from[1];
        *to++ = *from;
    }
    *at = from + (*from == '"');
    *is_key = (*at)[strspn(*at, " \t\r\n")] == ':';
    *to = '\0';
    return start;
}

/* Finds the driver of these options; -1: it is not verified again. */
static int find_driver(const struct verification *of, const char *library, const char *renderer)
{
    for (int d = 0; d < of->n_drivers; d++) {
        const char *by = of->drivers[d].renderer;
        if (strcmp(of->drivers[d].library, library) == 0 && strcmp(by ? by : "", renderer) == 0)
            return d;
    }
    return -1;
}

static void expect_outcome(struct verification *of, int driver, const char *scene,
                           const char *verdict)
{
    for (int s = 0; driver >= 0 && s < of->n_scenes; s++)
        for (int i = 0; i < VERIFY_OUTCOMES; i++)
            if (strcmp(of->scenes[s].name, scene) == 0 && strcmp(verify_words[i], verdict) == 0)
                result_of(of, driver, s)->expected = i;
}

/* Notes what has changed since the report. */
static void compare(struct verification *of, int driver, const char *key, const char *value)
{
    struct reported now[REPORTED + 1];
    const size_t used = strlen(of->differs);
    reported_of(of, driver, now);
    for (int i = 0; now[i].key; i++)
        if (strcmp(now[i].key, key) == 0 && strcmp(now[i].value, value) != 0)
            snprintf(of->differs + used, sizeof of->differs - used,
                     "then %s was '%.80s', now it is '%.80s'\n", key, value, now[i].value);
}

bool expect_read(const char *path, struct verification *of, struct error *err)
{
    const char *key = "", *library = "", *renderer = "", *scene = "";
    char *text = file_read(path, NOWHERE, err), *at = text;
    bool is_key, any = false;
    for (char *word; text && (word = next_string(&at, &is_key));) {
        const int driver = find_driver(of, library, renderer);
        if (is_key)
            key = word;
        else if (strcmp(key, "gl") == 0) {
            library = word;
            renderer = scene = "";
        } else if (strcmp(key, "renderer") == 0)
            renderer = word;
        else if (strcmp(key, "scene") == 0)
            scene = word;
        else if (strcmp(key, "verdict") == 0) {
            expect_outcome(of, driver, scene, word);
            any = true;
        } else if (driver >= 0 && scene[0] == '\0')
            compare(of, driver, key, word);
    }
    free(text);
    return text && (any || error_usage(err, "%s is no report of verify --json", path));
}
