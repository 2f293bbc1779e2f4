/* SPDX-License-Identifier: MIT */
/* Only the files of the room "spectra" include this. */
#ifndef DATA_SPECTRA_INSIDE_H
#define DATA_SPECTRA_INSIDE_H

#include "data/spectra/spectra.h"

/* The columns that are wanted of a table. */
struct columns {
    struct word table;              /* a built-in name, or a file */
    int count;                      /* 1, or the 3 of a detector */
    long first;                     /* from 1; 0: the table has no others */
    double lowest, highest, factor; /* limits of a value times the factor */
    bool scaled;                    /* the factor was written */
};
/* Reads them into out[count], without the factor. *xyz: they are named x, y and z. On failure the
 * caller frees *out. spectra_read reads three columns without limits. */
bool table_read(const struct columns *columns, struct spectrum *out, bool *xyz, struct error *err);
bool spectra_read(const char *name, struct spectrum out[3], bool *xyz, struct error *err);
/* Returns whether a word has a digit, and else only such characters. */
bool word_is_numeric(const struct word *word, const char *characters);

#endif
