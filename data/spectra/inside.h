/* SPDX-License-Identifier: MIT */
/* Only the files of the room "spectra" include this. */
#ifndef DATA_SPECTRA_INSIDE_H
#define DATA_SPECTRA_INSIDE_H

#include "data/spectra/spectra.h"

/* The samples that a caller wants of a table. */
struct wanted {
    struct word table;              /* a built-in name, or a file */
    int count;                      /* samples from the first on; 0: all, a detector's */
    long first;                     /* the number of a sample, from 1; 0: the only one */
    struct word sample;             /* its name, which goes before the number; length 0: none */
    double lowest, highest, factor; /* limits of a value times the factor */
    bool scaled;                    /* the factor was written */
};
/* Reads them into out[count], without the factor; or all of them, with their names, into the
 * channels of a detector. The caller frees *out or *detector, also after a failure. spectra_read
 * reads n samples without limits, or a detector. */
bool table_read(const struct wanted *wanted, struct spectrum *out, struct detector *detector,
                struct error *err);
bool spectra_read(const char *name, int n, struct spectrum *out, struct detector *detector,
                  struct error *err);

/* ---- heading.c: what a cell of a heading says ---- */

/* A cell names, as bits: wavelengths; a unit; names of samples; those, or numbers or places of
 * samples; values in percent. Then one quantity: reflectance or transmittance; radiance or counts;
 * neither, as absorbance, a density, K/S. */
enum { SAYS_WAVELENGTH = 1, SAYS_UNIT = 2, SAYS_NAME = 4, SAYS_LABEL = 8, SAYS_PERCENT = 16 };
enum { SAYS_REFLECTANCE = 32, SAYS_LIGHT = 64, SAYS_OTHER = 128, SAYS_QUANTITY = 224 };
struct meaning {
    unsigned says;
    double to_nm;       /* its numbers times this are in nm; 1 where no unit stands */
    const char *advice; /* its unit is none of wavelengths, which follow so; NULL: it is one */
    bool is_unit;       /* it is nothing but a unit */
};
void heading_read(const struct word *cell, struct meaning *out);
/* Returns the wavelength in nm that a cell is: a number, with a unit or without, and nothing else;
 * 0: none. `named`: letters may stand before it, as in the SPEC_400 of CGATS. */
double heading_nm(const struct word *cell, bool named);
/* Returns which of the letters a channel is named by, as x, X, xbar, x_bar_10, CIE x, or R and red;
 * NULL: none. */
const char *heading_channel(const struct word *cell, const char *letters);
/* Returns whether a word has a digit, and else only such characters. */
bool word_is_numeric(const struct word *word, const char *characters);

/* ---- table.c: a table that is being read, whole, before any of it is chosen ---- */

struct reading {
    double nm, value;
    int line, nm_column, column; /* where they stand */
};
struct sample {
    struct word name, says;  /* says: a cell that says percent or a quantity; length 0: none */
    struct reading *reading; /* by increasing or decreasing wavelengths; owned */
    int n;
};
struct label {
    struct word word; /* a name of a sample */
    int sample;
};
/* A field of each sample that is a row: a value at a wavelength, or, with 0 nm, something else. */
struct field {
    double nm;
    unsigned says; /* as struct meaning has it */
};
struct table {
    struct text text;
    char separator; /* of cells: a semicolon, a comma, a tab or a blank */
    char mark;      /* of decimals: a point or a comma; 0: none was seen */
    int mark_line;  /* where it was first seen */
    struct sample *sample;
    struct label *label;
    int n_samples, n_labels;
    struct field *field;      /* of rows; owned */
    int n_fields, name_field; /* name_field: names a sample best */
    double to_nm;             /* wavelengths of columns times this are in nm */
    double norm;              /* divides values */
    struct word above; /* a cell of a heading that says percent or a quantity of all samples */
};
/* Adds a sample; and a name to one: the first, or that with `own`, is its own. An empty name is
 * none. */
bool table_add_sample(struct table *table, struct error *err);
bool table_add_name(struct table *table, int sample, const struct word *name, bool own,
                    struct error *err);
/* Adds a value to a sample, at the wavelength of `at`. Refuses wavelengths that neither rise nor
 * fall. */
bool table_add(struct table *table, int sample, const struct reading *at, const struct word *value,
               struct error *err);
/* Reads a number, whose decimal comma becomes a point in the text. Refuses a comma where commas
 * separate, and two marks in one file: one of them may separate thousands. */
bool table_number(struct table *table, const struct word *word, const char *what, double *out,
                  struct error *err);

/* ---- cells.c ---- */

/* Chooses the separator of the current line. */
void line_begin(struct table *table);
/* Reads the next cell of the line without quotes, and without the blanks within. An unclosed quote
 * stays. Returns false behind the last cell. */
bool line_cell(struct table *table, struct word *out);

/* ---- columns.c: a wavelength a row; or a sample a row, with the wavelengths in the heading ----
 */

bool columns_read(struct table *table, struct error *err);
/* Returns whether a text, before its first line, has such a row or heading. */
bool columns_found(struct text text);

/* ---- sets.c: tables of samples ---- */

/* Read the samples of a table, each in a row, behind the heading that is the current line; as
 * CGATS.5; as IES TM-27. */
bool samples_read(struct table *table, struct error *err);
bool cgats_read(struct table *table, struct error *err);
bool spdx_read(struct table *table, struct error *err);

#endif
