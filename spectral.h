/* SPDX-License-Identifier: MIT */
/* Shared by every file of spectral: version, exit status, errors, places in input files.
 *
 * The program is divided into rooms. A room is a folder with one public header, which is its
 * contract: data/text/text.h for data/text/. Declarations that only its own files share stand in
 * its inside.h. A file includes this header, the headers of its own room and public headers of
 * earlier rooms only; data/README.md and raster/README.md list the rooms in order. The core does
 * not know the rooms in raster/beside/: they enter through the tables there.
 *
 * Data flows one way: scene -> plan -> pixels -> verdict -> stack.
 *
 * Conventions. Wavelengths are in nm, angles in degrees, lengths in scene units, window coordinates
 * in pixels (x to the right, y downwards, pixel centres at half-integers). Radiance, irradiance and
 * light spectra are relative: a perfect diffuser facing a light of spectrum 1 has radiance 1.
 * A function that can fail takes a struct error last and returns false on failure, with the error
 * filled in and *out safe to free. Every xxx_free accepts a zeroed struct and leaves it zeroed.
 * "Owned" means that xxx_free of the struct frees the member. An allocated result belongs to the
 * caller, who frees it.
 *
 * OpenGL and the reference draw the same picture and are compared. They share readers, mesh builder
 * and spectra, which this comparison cannot check: test/ compares those with closed forms. */
#ifndef SPECTRAL_H
#define SPECTRAL_H

/* The headers of the C library that most files need. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SPECTRAL_VERSION "0.6.0"
#define PROGRAM "spectral " SPECTRAL_VERSION

#if defined(__GNUC__)
#define PRINTF_LIKE(text, first) __attribute__((format(printf, text, first)))
#else
#define PRINTF_LIKE(text, first)
#endif

/* A position in an input file. Line 0 stands for the whole file, path NULL for the command line.
 * The reader of the file owns the path, which outlives every place that points to it. */
struct place {
    const char *path;
    int line, column; /* from 1; a column counts bytes */
};

/* Limits: what lies beyond one is refused. test/program/limits.py tries each of them. */
enum {
    LONGEST_SIDE = 262144,      /* pixels of a picture, rendered or read: a float has 1/64 of one */
    LONGEST_TEXTURE = 16384,    /* texels a side: OpenGL has a limit, too */
    LARGEST_PAGE = 1 << 24,     /* pixels of a page: browsers refuse larger canvases */
    MOST_PAGE_OBJECTS = 65535,  /* of a page, whose maps of objects have 16 bits */
    MOST_POSITIONS = 16,        /* a side of each pixel: see --samples */
    MOST_WAVELENGTHS = 65535,   /* of a scene: a TIFF file counts its pages in 16 bits */
    LARGEST_QUADRATURE = 64,    /* nodes: rules of more are not found in double precision */
    MOST_SHADOWED = 32,         /* lights that throw shadows: a pixel has a bit for each */
    MOST_DIVISIONS = 4096,      /* of a built-in shape, each way */
    MOST_TEAPOT_DIVISIONS = 64, /* of each of its 32 patches, each way */
    LONGEST_FACE = 10000,       /* corners: cutting takes seconds at most */
    MOST_CHANNELS = 256,        /* of a detector */
    MOST_BANDS = 1 << 20,       /* of a CGATS table without names of fields */
    LARGEST_MATRIX = 4096,      /* rows, and columns, of a matrix of fluorescence */
    LONGEST_TEXT = 256 << 20,   /* bytes of a text; a mesh may have more */
    LONGEST_LINE = 64 << 20,    /* bytes: a face of a million corners has 24 MB */
    DEEPEST_INCLUDE = 32,       /* scenes that include one another */
    MOST_INCLUDES = 1000,       /* files in all: pairs of includes, so deep, would be 2^32 */
    MOST_CURVES = 64,           /* of a chart or a table of `show` */
    MOST_OPERANDS = 1024,       /* of a command line */
    MOST_RECORDED = 64          /* options of a command line that decide the picture */
};
/* Does not compile where a limit no longer fits what it counts in. */
typedef char limits_fit[MOST_SHADOWED <= 32 && MOST_WAVELENGTHS <= UINT16_MAX &&
                                MOST_PAGE_OBJECTS <= UINT16_MAX && LONGEST_SIDE <= 1 << 18
                            ? 1
                            : -1];

enum exit_status {
    EXIT_AGREED = 0,    /* done, and the pictures agree */
    EXIT_DIFFERENT = 1, /* cross-check or comparison found a difference */
    EXIT_INPUT = 2,     /* bad usage or bad input */
    EXIT_SYSTEM = 3     /* disk full, no memory, no OpenGL, ... */
};

/* Zero it before use. The first failure wins: later ones leave it as it is. */
struct error {
    enum exit_status status;
    bool unsupported; /* EXIT_SYSTEM: the system works, but cannot do this */
    char text[2048];  /* one line, without a newline */
};

/* In data/base/error.c. All of these return false, so that a caller can `return error_at(...)`. */
enum error_kind {
    ERROR_INPUT,       /* EXIT_INPUT */
    ERROR_DIFFERENT,   /* EXIT_DIFFERENT */
    ERROR_FAILED,      /* EXIT_SYSTEM, for a failure that errno does not describe */
    ERROR_UNSUPPORTED, /* EXIT_SYSTEM and `unsupported` */
    ERROR_SYSTEM, /* EXIT_SYSTEM; appends ": " and the description of errno, unless that is 0 */
    ERROR_CAUSE   /* likewise, but EXIT_INPUT where the path is at fault that the user gave, as
                     for ENOENT */
};
/* Sets what the kind says. Puts the place before the message. */
bool error_of(struct error *err, enum error_kind kind, struct place place, const char *format, ...)
    PRINTF_LIKE(4, 5);
#define NOWHERE ((struct place){NULL, 0, 0})
#define VALUE_OF(option) ((struct place){(option), 1, 1}) /* of the command line */
#define error_at(err, ...) error_of(err, ERROR_INPUT, __VA_ARGS__)
#define error_usage(err, ...) error_of(err, ERROR_INPUT, NOWHERE, __VA_ARGS__)
#define error_different(err, ...) error_of(err, ERROR_DIFFERENT, NOWHERE, __VA_ARGS__)
#define error_failed(err, ...) error_of(err, ERROR_FAILED, NOWHERE, __VA_ARGS__)
#define error_unsupported(err, ...) error_of(err, ERROR_UNSUPPORTED, NOWHERE, __VA_ARGS__)
#define error_system(err, ...) error_of(err, ERROR_SYSTEM, NOWHERE, __VA_ARGS__)
#define error_cause(err, ...) error_of(err, ERROR_CAUSE, __VA_ARGS__)
/* Returns the text without "error: ", to be quoted in another message. */
const char *error_words(const struct error *err);

#endif
