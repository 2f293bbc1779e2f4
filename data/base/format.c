/* SPDX-License-Identifier: MIT */
/* The formats of files, by their first bytes, so that a message can say which file this is. */
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include "data/base/base.h"

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
};

static bool begins(const unsigned char *start, size_t i)
{
    for (size_t k = 0; k < formats[i].n; k++)
        if (!formats[i].any[k] && start[k] != formats[i].bytes[k])
            return false;
    return true;
}

const char *file_format(const char *path)
{
    unsigned char start[512] = {0};
    int file = -1;
    if (file_is_regular(path))
        UNTIL_DONE(file, open(path, O_RDONLY | O_CLOEXEC));
    const ssize_t got = file >= 0 ? read_at(file, start, sizeof start, 0) : -1;
    const size_t length = got > 0 ? (size_t)got : 0;
    if (file >= 0)
        close(file);
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++)
        if (length >= formats[i].n && begins(start, i))
            return formats[i].name;
    return length > 0 && !memchr(start, '\0', length) ? "text" : "";
}
