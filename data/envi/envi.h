/* SPDX-License-Identifier: MIT */
/* The room "envi": spectral cubes as ENVI stores them, a file of raw samples and a text file beside
 * it, its header. ENVI, SPy, GDAL, QGIS and MATLAB read and write such pairs. */
#ifndef ENVI_H
#define ENVI_H

#include "data/base/base.h"
#include "data/text/text.h"
#include "spectral.h"

/* ---- layout.c: how samples lie ---- */

enum envi_interleave { ENVI_BSQ, ENVI_BIL, ENVI_BIP }; /* by bands, by rows, by pixels */
/* ENVI's numbers of the types of samples. */
enum envi_type {
    ENVI_UINT8 = 1,
    ENVI_INT16,
    ENVI_INT32,
    ENVI_FLOAT,
    ENVI_DOUBLE,
    ENVI_UINT16 = 12,
    ENVI_UINT32,
    ENVI_INT64,
    ENVI_UINT64,
    ENVI_TYPES
};
struct envi_layout {
    int samples, lines, bands; /* columns, rows, bands: at least 1 */
    uint64_t offset;           /* of the first sample in the file */
    enum envi_type type;
    enum envi_interleave interleave;
    bool big_endian;
};
/* Returns the bytes of a sample; 0: ENVI has no such type, or its samples are complex. */
int envi_type_bytes(enum envi_type type);
/* Returns the type in words: "unsigned 16-bit". */
const char *envi_type_name(enum envi_type type);
const char *envi_interleave_name(enum envi_interleave interleave); /* "bsq" */

/* ---- header.c: headers in ---- */

/* A header as its file states it, with one value for each band that is not marked as bad. */
struct envi_header {
    struct envi_layout layout;
    int n;                  /* bands that are not bad, at least 1 */
    int *band;              /* the number of each in the file, from 0; owned */
    double *wavelengths_nm; /* increasing; NULL: the header has none; owned */
    double *gain, *offset;  /* value = gain x sample + offset; owned */
    double ignored;         /* a sample that stands for none; it is read as 0 */
    bool has_ignored;       /* a NaN may be ignored */
    char *description;      /* on one line; "": it has none; owned */
};
/* Reads a header. Refuses, at its place there, whatever is malformed or given twice, complex or
 * compressed samples, unknown units of wavelengths, and wavelengths that do not increase. Ignores
 * unknown keys. `from` is the place that names the file. */
bool envi_header_read(const char *path, struct place from, struct envi_header *out,
                      struct error *err);
void envi_header_free(struct envi_header *header);

/* ---- write.c: headers out ---- */

/* A header to be written. Texts lose what a header cannot hold: braces and control characters. */
struct envi_sidecar {
    struct envi_layout layout;
    const char *description;
    const char *const *names;     /* of the bands */
    const double *wavelengths_nm; /* of the bands; NULL: they have none */
    const double *fwhm_nm;        /* their widths; NULL: unknown */
    double gain;                  /* radiance = gain x sample */
    bool is_reflectance;          /* a radiance of 1 is a reflectance of 1 */
};
/* Returns the header as text, allocated; NULL: no memory. */
char *envi_header_text(const struct envi_sidecar *sidecar);

/* ---- cube.c: cubes in ---- */

/* A cube that is open for reading. Its pages are the bands that are not bad. */
struct envi {
    struct envi_header header;
    char *path; /* of the data file; owned */
    struct place from;
    int descriptor;
    uint64_t bytes; /* of the data file */
    struct envi_rows *kept;
};
/* Finds whether the path names an ENVI header (NAME.hdr), or a data file with a header beside it:
 * PATH.hdr, or for NAME.img, .dat, .raw, .bsq, .bil and .bip NAME.hdr. Fails only where the system
 * does. */
bool envi_is(const char *path, bool *out, struct error *err);
/* Opens such a cube and reads its header, but no samples. The data file of NAME.hdr is NAME, or
 * NAME with one of these endings. Refuses what envi_header_read refuses, and a data file that is
 * too short. */
bool envi_open(const char *path, struct place from, struct envi *out, struct error *err);
/* Reads rows y .. y + rows - 1 of a page, one value for each sample, the top row first. Refuses a
 * value that is negative, not finite or too large for a float. In a cube by pixels the bands lie
 * side by side: these rows of up to 256 MB of bands are kept, so read the same rows of one page
 * after the other. A read that fails is EXIT_SYSTEM. */
bool envi_read(struct envi *envi, int page, int y, int rows, float *out, struct error *err);
void envi_close(struct envi *envi);

/* ---- Inside this room ---- */

enum { ENVI_PATH = 4096 }; /* a longer path cannot be opened */
/* files.c. Finds the header and the data file of a path for which envi_is is true. Refuses a header
 * without a data file. */
bool envi_files(const char *path, struct place from, char header[ENVI_PATH], char data[ENVI_PATH],
                struct error *err);

#endif
