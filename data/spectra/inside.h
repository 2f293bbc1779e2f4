/* SPDX-License-Identifier: MIT */
/* Only the files of the room "spectra" include this. */
#ifndef DATA_SPECTRA_INSIDE_H
#define DATA_SPECTRA_INSIDE_H

#include "data/spectra/spectra.h"

/* The columns that are wanted of a table. */
struct columns {
    struct word table;              /* a built-in name, or a file */
    int count;                      /* of values that are kept; 0: all, a detector's */
    long first;                     /* the number of a column or sample, from 1; 0: the only one */
    struct word sample;             /* its name, which goes before the number; length 0: none */
    bool all;                       /* all samples are counted and named, and none is read */
    bool is_set;                    /* all are read, and are no detector's channels */
    double lowest, highest, factor; /* limits of a value times the factor */
    bool scaled;                    /* the factor was written */
};
/* Reads them into out[count], without the factor; or all of them, with their names, into the
 * channels of a detector. The caller frees *out or *detector, also after a failure. spectra_read
 * reads n columns without limits, or a detector. */
bool table_read(const struct columns *columns, struct spectrum *out, struct detector *detector,
                struct error *err);
bool spectra_read(const char *name, int n, struct spectrum *out, struct detector *detector,
                  struct error *err);

/* ---- table.c: a table that is being read ---- */

struct row {
    double nm;
    struct place place;
};

struct table {
    const struct columns *wanted;
    struct text text;
    char separator;  /* of columns: a semicolon, a comma, a tab or a blank */
    char mark;       /* of decimals: a point or a comma; 0: none was seen */
    int mark_line;   /* where it was first seen */
    long first;      /* the column or sample that is wanted; 0: the only one */
    long n_columns;  /* of values */
    bool decreasing; /* the first wavelength is the longest */
    bool of_rows;    /* each row is a sample, and the heading has the wavelengths */
    struct row *row; /* n_rows in the order of the file; owned */
    double *value;   /* n_values: those of a row, then those of the next; of samples, sample by
                        sample; owned */
    int n_rows, n_values;
    bool by_samples;
    struct set_names names; /* of all samples so far; owned */
    int n_named;            /* samples that have the wanted name */
};

enum { LABEL_SIZE = 96, LONGEST_NAME = 64 };
/* Writes the table as a scene names it, without a factor; a long name as FILE. */
const char *table_label(const struct table *table, char out[LABEL_SIZE]);
/* Reads a value, divided by norm, and refuses it if it leaves the limits with the factor. */
bool table_value(const struct table *table, const struct word *word, double norm, double *out,
                 struct error *err);

/* ---- columns.c: a row a wavelength ---- */

/* Reads the rows from the current line on. */
bool columns_read(struct table *table, struct error *err);
/* Returns whether a text, before its first line, has a line of wavelengths, or of a wavelength and
 * values. */
bool columns_found(struct text text);
/* Reads the next field of the line without quotes, and without the blanks within. An unclosed quote
 * stays. Returns false behind the last field. */
bool table_field(struct table *table, struct word *out);
/* Writes a point for a decimal comma into the text. Refuses a comma where commas separate, and two
 * marks in one file: one of them may separate thousands. */
bool table_mark(struct table *table, const struct word *word, struct error *err);

/* ---- sets.c: tables of samples ---- */

/* Read the samples of a table, each in a row, as CGATS.5 or as IES TM-27; keep the wanted one. */
bool samples_read(struct table *table, struct error *err); /* the heading is the current line */
bool cgats_read(struct table *table, struct error *err);
bool spdx_read(struct table *table, struct error *err);
/* Adds the name of the next sample; NULL: its number. */
bool names_add(struct table *table, const struct word *name, struct error *err);
bool is_sample(const struct table *table, const struct word *name); /* the wanted one */
/* Refuses a name that no sample has. */
bool sample_unknown(const struct table *table, struct error *err);

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
