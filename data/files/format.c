/* SPDX-License-Identifier: MIT */
/* The formats of files, by their first bytes, so that a message can say which file this is. */
#include <limits.h>
#include <strings.h>
#include <unistd.h>

#include "data/files/files.h"

/* A format and its first n bytes; '?' stands for any byte. */
static const struct {
    const char *name;
    const char *bytes;
    size_t n;
} formats[] = {
    {"TIFF", "II\x2a\0", 4},
    {"TIFF", "MM\0\x2a", 4},
    {"TIFF", "II\x2b\0", 4}, /* BigTIFF */
    {"TIFF", "MM\0\x2b", 4},
    {"PNG", "\x89PNG", 4},
    {"JPEG", "\xff\xd8\xff", 3},
    {"GIF", "GIF8", 4},
    {"BMP", "BM????\0\0\0\0", 10},
    {"WebP", "RIFF????WEBP", 12},
    {"OpenEXR", "\x76\x2f\x31\x01", 4},
    {"Radiance HDR", "#?RADIANCE", 10},
    {"JPEG 2000", "\0\0\0\x0cjP", 6},
    {"HDF5", "\x89HDF", 4},
    {"PDF", "%PDF", 4},
    {"ENVI", "ENVI", 4},
};

static const char *format_of(const void *bytes, size_t length)
{
    const char *start = bytes;
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++) {
        size_t n = 0; /* bytes that fit */
        while (n < formats[i].n && n < length &&
               (formats[i].bytes[n] == '?' || formats[i].bytes[n] == start[n]))
            n++;
        if (n == formats[i].n)
            return formats[i].name;
    }
    return length > 0 && !memchr(start, '\0', length) ? "text" : "";
}

/* Finds the format by the first bytes alone. Does not wait for a pipe. */
static bool format_find(const char *path, const char **out, struct error *err)
{
    struct error failure = {.status = EXIT_AGREED};
    const struct builtin_file *builtin;
    unsigned char start[512];
    int file;
    *out = "";
    if (!file_open(path, NOWHERE, &file, &builtin, &failure)) {
        if (failure.status == EXIT_SYSTEM)
            *err = failure;
        return failure.status != EXIT_SYSTEM;
    }
    if (builtin) {
        *out = format_of(builtin->bytes, builtin->length);
        return true;
    }
    const ssize_t got = read_at(file, start, sizeof start, 0);
    if (got < 0)
        error_cause(err, NOWHERE, "cannot read %s", path);
    else
        *out = format_of(start, (size_t)got);
    close(file);
    return got >= 0;
}

/* ---- ENVI cubes: raw samples, and a header beside them ---- */

/* The raw samples of NAME.hdr are NAME, or NAME with an ending. */
static const char *const endings[] = {"", ".img", ".dat", ".raw", ".bsq", ".bil", ".bip"};
enum { ENDINGS = sizeof endings / sizeof endings[0] };

/* Returns the length of the path without the ending; 0: it ends otherwise. */
static size_t length_without(const char *path, const char *ending)
{
    const size_t length = strlen(path), end = strlen(ending);
    return length > end && strcasecmp(path + length - end, ending) == 0 ? length - end : 0;
}

bool file_format(const char *path, const char **out, struct error *err)
{
    char header[PATH_MAX];
    const char *found;
    bool is_file = false;
    bool done = format_find(path, out, err);
    const bool unknown = done && (**out == '\0' || strcmp(*out, "text") == 0);
    for (size_t i = 0; done && unknown && i < ENDINGS; i++) {
        const size_t length = length_without(path, endings[i]);
        if (length == 0 ||
            snprintf(header, sizeof header, "%.*s.hdr", (int)length, path) >= PATH_MAX)
            continue;
        done = format_find(header, &found, err) && file_is_regular(path, &is_file, err);
        if (done && is_file && strcmp(found, "ENVI") == 0)
            *out = found;
    }
    return done;
}

char *envi_data(const char *path)
{
    const size_t length = length_without(path, ".hdr");
    for (size_t i = 0; length > 0 && i < ENDINGS; i++) {
        struct printed printed = {.text = NULL};
        print(&printed, "%.*s%s", (int)length, path, endings[i]);
        char *name = printed_end(&printed);
        if (!name || !file_is_missing(name))
            return name;
        free(name);
    }
    return strdup(path);
}
