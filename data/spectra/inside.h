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

/* ---- column_names.c: words of a heading ---- */

/* Returns whether a column is named as an observer's: x, X, xbar, x_bar_10, CIE x ... */
bool name_is_tristimulus(const struct word *word, char letter);
/* Refuses a column of wavelengths that names another unit than nm. */
bool name_check_unit(const struct word *word, struct error *err);
/* Returns whether a column is named as one of wavelengths. */
bool name_says_wavelength(const struct word *word);
/* Returns the wavelength that a name ends with, as in 400, nm400, R_400 or 400nm; 0: none. */
double name_wavelength(const struct word *word);
bool name_says_percent(const struct word *word);
/* Returns whether a word has a digit, and else only such characters. */
bool word_is_numeric(const struct word *word, const char *characters);
/* Returns whether a wavelength begins here: a digit, perhaps behind a sign or a point. */
bool word_begins_wavelength(const struct word *word);

#endif
