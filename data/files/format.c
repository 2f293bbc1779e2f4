/* SPDX-License-Identifier: MIT */
/* The formats of files, by their first bytes, so that a message can say which file this is. */
#include <limits.h>
#include <strings.h>
#include <unistd.h>

#include "data/files/files.h"

/* A format and its first bytes; in `any`, a byte of 1 may have any value in the file. */
static const struct {
    const char *name;
    unsigned char bytes[12], any[12];
    size_t n;
} formats[] = {
    {"TIFF", {'I', 'I', 42, 0}, {0}, 4},
    {"TIFF", {'M', 'M', 0, 42}, {0}, 4},
    {"TIFF", {'I', 'I', 43, 0}, {0}, 4}, /* BigTIFF */
    {"TIFF", {'M', 'M', 0, 43}, {0}, 4},
    {"PNG", {0x89, 'P', 'N', 'G'}, {0}, 4},
    {"JPEG", {0xff, 0xd8, 0xff}, {0}, 3},
    {"GIF", {'G', 'I', 'F', '8'}, {0}, 4},
    {"BMP", {'B', 'M', 0, 0, 0, 0, 0, 0, 0, 0}, {0, 0, 1, 1, 1, 1}, 10},
    {"WebP", {'R', 'I', 'F', 'F', 0, 0, 0, 0, 'W', 'E', 'B', 'P'}, {0, 0, 0, 0, 1, 1, 1, 1}, 12},
    {"OpenEXR", {0x76, 0x2f, 0x31, 0x01}, {0}, 4},
    {"Radiance HDR", {'#', '?', 'R', 'A', 'D', 'I', 'A', 'N', 'C', 'E'}, {0}, 10},
    {"JPEG 2000", {0, 0, 0, 12, 'j', 'P'}, {0}, 6},
    {"HDF5", {0x89, 'H', 'D', 'F'}, {0}, 4},
    {"PDF", {'%', 'P', 'D', 'F'}, {0}, 4},
    {"ENVI", {'E', 'N', 'V', 'I'}, {0}, 4},
};

static bool begins(const unsigned char *start, size_t i)
{
    for (size_t k = 0; k < formats[i].n; k++)
        if (!formats[i].any[k] && start[k] != formats[i].bytes[k])
            return false;
    return true;
}

static const char *format_of(const unsigned char *start, size_t length)
{
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++)
        if (length >= formats[i].n && begins(start, i))
            return formats[i].name;
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
