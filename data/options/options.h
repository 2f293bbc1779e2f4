/* SPDX-License-Identifier: MIT */
/* The room "options": reads the options of a command line by the rules of a table.
 * This room does not depend on the meaning of a value. Still it refuses a wrong one at once, so
 * that the user sees the first mistake: the table has bounds, choices, and functions of other
 * rooms. */
#ifndef DATA_OPTIONS_OPTIONS_H
#define DATA_OPTIONS_OPTIONS_H

#include <stddef.h>
#include <stdio.h>

#include "data/output/output.h"

struct error;
struct scene;
struct options;

/* The commands that take an option, and groups of them. An option that is RECORDED decides the
 * picture: a stack records it, and --again reads it from there. */
enum { FOR_RENDER = 1, FOR_PLAN = 1 << 1, FOR_PROBE = 1 << 2, FOR_COST = 1 << 3 };
enum { FOR_VIEW = 1 << 4, FOR_DEVELOP = 1 << 5, FOR_COMPARE = 1 << 6, FOR_SHOW = 1 << 7 };
enum { FOR_INFO = 1 << 8, FOR_ENVI = 1 << 9, FOR_DRIVERS = 1 << 10, FOR_VERIFY = 1 << 11 };
enum { FOR_EXPORT = 1 << 12, FOR_JUDGE = 1 << 13, FOR_JOIN = 1 << 14 };
enum { FOR_ALL = 1 << 15, RECORDED = 1 << 16 };
enum {
    /* cost chooses the shading by itself */
    FOR_EXCHANGE = FOR_EXPORT | FOR_JUDGE,
    FOR_SHADED = FOR_RENDER | FOR_PLAN | FOR_PROBE | FOR_VIEW | FOR_EXCHANGE,
    FOR_SCENES = FOR_SHADED | FOR_COST | FOR_VERIFY,
    FOR_STACKS = FOR_PROBE | FOR_DEVELOP | FOR_COMPARE
};

enum option_kind {
    OPTION_TEXT,   /* const char *: kept as it is written */
    OPTION_NUMBER, /* double, from lowest to highest */
    OPTION_COUNT,  /* int: a whole number from lowest to highest */
    OPTION_FLAG,   /* bool: takes no value */
    OPTION_CHANGE  /* changes the scene, by the function `change` */
};

/* A row of the table: an option, or the heading of the options that follow. Two rows may share a
 * name if no command takes both. */
struct option {
    const char *usage; /* names with their dashes, then the value's: "-o, --output FILE" */
    const char *help;  /* for --help, which breaks its lines */
    int commands;
    enum option_kind kind;
    size_t offset;              /* of the value in struct options; unused by OPTION_CHANGE */
    double lowest, highest;     /* of a number or a count */
    const char *const *choices; /* OPTION_TEXT: the words to choose from, then NULL; NULL: any */
    /* OPTION_TEXT: refuses a value that the command cannot use; NULL: any is good. */
    bool (*accepts)(const char *option, const char *value, struct error *err);
    bool (*change)(struct scene *scene, const char *value, struct error *err);
    const char *heading; /* for --help; NULL: the row is an option, otherwise all else is 0 */
    bool writes;         /* OPTION_TEXT: the value names a file that the command writes */
};
struct option_table {
    const struct option *options;
    int n;
};

/* A change of the scene, to be made after the scene is read. */
struct option_change {
    bool (*apply)(struct scene *scene, const char *value, struct error *err);
    const char *value;
};

enum { MAX_OPERANDS = 1024, MAX_RECORDED = 64 };

/* A command line as it was read. Texts point into it. NULL, 0 or false means that an option was not
 * given. */
struct options {
    const struct option_table *table; /* by which it was read */
    int commands;                     /* whose options it may hold: see struct option_rules */
    const char *program;              /* the name that the user started the program by */
    const char *operand;              /* the first one: SCENE, STACK or KIND; NULL: none */
    const char *operands[MAX_OPERANDS];
    struct option_change changes[MAX_RECORDED]; /* in the order given */
    char *recorded[MAX_RECORDED]; /* "NAME=VALUE" of each RECORDED option, its first name; owned */
    int n_operands, n_changes, n_recorded;
    char *named_output; /* of options_name_output; owned */
    const char *output, *json, *again, *map, *check_map, *csv_file, *svg_file, *junit;
    const char *renderer, *buffer, *depth, *bits, *gl, *driver; /* one of their choices */
    const char *sampling, *detector, *white, *adaptation, *display, *exposure;
    const char *tolerance, *budget, *unchecked, *accuracy, *part;
    double full_scale;
    int threads, runs, memory_mib, max_triangles;
    struct outputs outputs; /* complete; they appear when the command has ended well */
    bool xyz, lab, csv, svg, no_check, strict, trust, keep, envi, quiet, verbose, help, measure,
        still, gallery;
};

/* The options and operands that a command allows. */
struct option_rules {
    const char *command; /* its name, for messages */
    const struct option_table *table;
    int commands;   /* the options allowed: those with one of these bits, and those FOR_ALL */
    int n_operands; /* the most operands; at most MAX_OPERANDS */
};

/* Reads the words behind the command's name: "--option value", "--option=value", flags and
 * operands; behind "--" all words are operands. Refuses an output that is a file of another word.
 * The words must outlive *out. Call options_free also after a failure. */
bool options_read(const struct option_rules *rules, char *const *words, int n_words,
                  struct options *out, struct error *err);
void options_free(struct options *options);

/* Names the output after the file `path`, with another ending, where the command line gives none;
 * after "scene" where the path is "-". Refuses a name that the command line has, too. options_free
 * ends it. */
bool options_name_output(struct options *options, const char *path, const char *ending,
                         struct error *err);
/* Limits the memory of the command: see memory_limit. */
void options_limit_memory(const struct options *options);
/* Returns SCENE, or the built-in colorchecker if none is given. */
const char *options_scene(const struct options *options);
/* Finds the share of object pixels that may stay unchecked in a picture that agrees. */
bool options_unchecked(const struct options *options, double *out, struct error *err);
/* Returns the detector or observer, or cie1931 if none is given. */
const char *options_detector(const struct options *options);

/* Returns whether commands with one of these bits take the option. */
bool option_takes(const struct option *option, int commands);
/* Returns the descriptor of a command's table: standard output, or standard error if the JSON or
 * the command's output (NULL: none) may go to standard output. */
int options_table(const struct options *options, const char *output);
/* Reads the one number of an option or operand, from lowest to highest. Messages name `option`. */
bool option_number(const char *option, const char *value, double lowest, double highest,
                   double *out, struct error *err);
bool option_count(const char *option, const char *value, double lowest, double highest, int *out,
                  struct error *err); /* a whole number, up to INT_MAX */

/* ---- help.c: the explanations of --help ---- */

/* Prints the words of a text from the cursor's column on. A new line begins at that column. */
void help_words(struct printed *to, const char *text, int column);
/* Prints a command or an option as the user types it, and its explanation beside it, or below if
 * there is no room. */
void help_explain(struct printed *to, const char *typed, const char *explanation);
/* Explains all options of a table, and those that commands with one of these bits take. */
void help_options(const struct option_table *table, struct printed *to);
void help_command_options(const struct option_table *table, int commands, struct printed *to);

#endif
