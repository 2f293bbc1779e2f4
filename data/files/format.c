/* SPDX-License-Identifier: MIT */
/* The formats of files, by their first bytes, so that a message can say which file this is. */
#include <limits.h>
#include <strings.h>
#include <unistd.h>

#include "data/files/files.h"

/* A format and its first n bytes; '?' stands for any byte. */
struct format {
    const char *name;
    const char *bytes;
    size_t n;
};
static const struct format pictures[] = {
    {"TIFF", "II\x2a\0", 4},
    {"TIFF", "MM\0\x2a", 4},
    {"TIFF", "II\x2b\0", 4}, /* BigTIFF */
    {"TIFF", "MM\0\x2b", 4},
    {"PNG", "\x89PNG", 4},
    {"SGI", "\x01\xda", 2},
    {"JPEG", "\xff\xd8\xff", 3},
    {"GIF", "GIF8", 4},
    {"BMP", "BM????\0\0\0\0", 10},
    {"WebP", "RIFF????WEBP", 12},
    {"OpenEXR", "\x76\x2f\x31\x01", 4},
    {"Radiance HDR", "#?RADIANCE", 10},
    {"JPEG 2000", "\0\0\0\x0cjP", 6},
    {"ENVI", "ENVI\n", 5},
    {"ENVI", "ENVI\r", 5},
    {"PNM", "P1\n", 3},
    {"PNM", "P2\n", 3},
    {"PNM", "P3\n", 3},
    {"PNM", "P4\n", 3},
    {"PNM", "P5\n", 3},
    {"PNM", "P6\n", 3},
};
static const struct format others[] = {
    {"HDF5", "\x89HDF", 4},    {"MATLAB", "MATLAB", 6},
    {"NumPy", "\x93NUMPY", 6}, {"ZIP", "PK\x03\x04", 4}, /* spreadsheets, too */
    {"gzip", "\x1f\x8b", 2},   {"PDF", "%PDF", 4},
    {"XML", "<?xml", 5},       {"XML", "\xef\xbb\xbf<?xml", 8},
    {"JSON", "{", 1},          {"UTF-16", "\xff\xfe", 2},
    {"UTF-16", "\xfe\xff", 2}, {"JCAMP-DX", "##TITLE=", 8},
    {"PLY", "ply\n", 4},       {"PLY", "ply\r", 4},
    {"STL", "solid ", 6},      {"OFF", "OFF\n", 4},
    {"OFF", "OFF\r", 4},       {"glTF", "glTF", 4},
    {"IES", "IESNA", 5},       {"a pointer of Git LFS", "version https://git-lfs", 23},
};
enum { PICTURES = sizeof pictures / sizeof *pictures, OTHERS = sizeof others / sizeof *others };

bool format_is_picture(const char *format)
{
    bool found = false;
    for (int i = 0; i < PICTURES; i++)
        found = found || strcmp(pictures[i].name, format) == 0;
    return found;
}

const char *format_of(const void *bytes, size_t length)
{
    const char *start = bytes;
    for (int i = 0; i < PICTURES + OTHERS; i++) {
        const struct format *format = i < PICTURES ? &pictures[i] : &others[i - PICTURES];
        size_t n = 0; /* bytes that fit */
        while (n < format->n && n < length &&
               (format->bytes[n] == '?' || format->bytes[n] == start[n]))
            n++;
        if (n == format->n)
            return format->name;
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
static const char *const endings[] = {"", ".img", ".dat", ".raw", ".bin", ".bsq", ".bil", ".bip"};
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
