/* SPDX-License-Identifier: MIT */
/* The room "text": strict words and numbers in; the files that words name, built-in ones by names
 * of their own, which `spectral list` prints; facts out, as JSON or in words; the options of a
 * command line. This room does not depend on the meaning of an option. Still it refuses a wrong
 * value at once, so that the user sees the first mistake: rows have bounds, choices, and functions
 * of other rooms. */
#ifndef DATA_TEXT_TEXT_H
#define DATA_TEXT_TEXT_H

#include "data/files/files.h"
#include "data/maths/maths.h"

struct scene;
struct tables;

/* ---- text.c: a text file, word by word ---- */

/* A text file that is being read. Lines end in \n or \r\n; if the text has no \n, in \r. A '#'
 * starts a comment where a word could begin: not in a quote, nor in the middle of a word. Blanks,
 * tabs and the characters in `separators` separate words. "..." is one word. */
struct text {
    char *path;  /* owned */
    char *bytes; /* owned */
    size_t length;
    const char *at, *line_start, *line_end; /* cursor, current line */
    int line;
    const char *separators; /* more separators, e.g. ",;"; never NULL after text_open */
    struct tables *tables;  /* of spectra that its words have named; NULL: none is kept */
};

/* A word is a slice of its text, not terminated. It is valid while the text is open. */
struct word {
    const char *start;
    size_t length;
    bool quoted;
    struct place place;
    struct tables *tables; /* those of its text */
};

/* Forms that a text may have beyond the usual: longer than 256 MiB, up to 2 GiB; XML. */
enum { TEXT_LARGE = 1, TEXT_XML = 2 };
/* Opens a file, or standard_input. `from` is the place that names it. No line is current yet.
 * Refuses a line of more than 64 MiB, UTF-16 and JSON; and what `may`, a sum of the words above,
 * does not allow. */
bool text_open(struct text *out, const char *path, struct place from, int may, struct error *err);
/* Opens a string as a text. `name` takes the place of the path in messages. Both are copied. */
bool text_open_string(struct text *out, const char *name, const char *string, struct error *err);
void text_free(struct text *text);

/* Goes to the next line, blank or not. Returns false at the end of the file. */
bool text_next_line(struct text *text);
/* Reads the next word of the current line. Returns false at its end. An unclosed quote yields the
 * rest of the line as a word with `quoted` set and start[length] != '"'; text_expect, text_end and
 * the functions for numbers refuse it. */
bool text_word(struct text *text, struct word *out);
/* Reads the word that text_word would read. The cursor of the caller's text stays. */
bool text_peek(struct text text, struct word *out);
/* Reads the rest of the line, up to a comment, as one word without the blanks at its ends. Returns
 * false at the end of the line. */
bool text_rest(struct text *text, struct word *out);
/* Like text_word, but refuses the end of the line: "expected WHAT". */
bool text_expect(struct text *text, struct word *out, const char *what, struct error *err);
/* Refuses a further word on this line: "WORD is too much: WHAT takes no more". */
bool text_end(struct text *text, const char *what, struct error *err);
/* Return the cursor as a place, as for "expected ..." at the end of a line, and the whole file. */
struct place text_place(const struct text *text);
struct place text_whole(const struct text *text);

/* Returns how many bytes of a word a message shows: the precision of %.*s. */
int word_shown(const struct word *word);
bool word_is(const struct word *word, const char *literal);    /* false for quoted words */
bool word_equals(const struct word *word, const char *string); /* quoted or not */
char *word_copy(const struct word *word, struct error *err);   /* allocated; NULL: no memory */
/* Read a whole number or refuse it: 1.5abc, 1e999, nan, inf and 0x10 are errors. `what` names the
 * number in messages. Ranges are inclusive; -HUGE_VAL and HUGE_VAL set no limit. */
bool word_number(const struct word *word, const char *what, double lowest, double highest,
                 double *out, struct error *err);
bool word_integer(const struct word *word, const char *what, long lowest, long highest, long *out,
                  struct error *err);
/* Reads a number likewise, without a message. */
bool word_is_number(const struct word *word, double lowest, double *out);
/* Read the next word likewise. */
bool text_number(struct text *text, const char *what, double lowest, double highest, double *out,
                 struct error *err);
bool text_integer(struct text *text, const char *what, long lowest, long highest, long *out,
                  struct error *err);

/* ---- words.c: "did you mean ...?" ---- */

enum { LIST_SIZE = 512 };
/* The known words beside an unknown one. Zero it before use. */
struct suggestion {
    char known[LIST_SIZE], nearest[64], text[LIST_SIZE + 64];
    int distance; /* of the nearest one from the typed word */
};
/* Adds a known word, and compares it with the typed one. A word of other programs may stand for it.
 */
void suggestion_add(struct suggestion *suggestion, const struct word *typed, const char *known,
                    size_t length);
/* Returns "did you mean NEAREST?" if a known word is near, or else the list behind the words
 * `otherwise`: "known are A, B". Valid as long as *suggestion. */
const char *suggestion_end(struct suggestion *suggestion, const char *otherwise);

/* ---- words.c: tools for statements of all kinds, so that all refuse a mistake alike ---- */

/* Returns the index of the word in `known`, which ends with NULL; -1: it is none, or quoted. */
int word_find(const struct word *word, const char *const *known);
/* Returns the index of the word in `known`, which ends with NULL; ignores case. Returns -1 for any
 * other word, with an error that proposes the nearest known one. `what` names the word in the
 * message. */
int word_choose(const struct word *word, const char *const *known, const char *what,
                struct error *err);
/* Finds the next word among the known ones. Without a word the error is "expected EXPECTED". */
int text_choose(struct text *text, const char *expected, const char *const *known, const char *what,
                struct error *err);
/* Finds the ending of a path likewise, among words as ".png", ".tif", NULL. *out is its index; -1:
 * the name has no ending, as "-" and /dev/stdout. */
bool path_ending(const char *path, const char *const *known, int *out, struct error *err);
/* Sets *first to `again` if it has no line yet. Otherwise refuses: "WHAT is given twice". */
bool place_once(struct place *first, struct place again, const char *what, struct error *err);
/* Like word_choose; then notes the place in given[index], and refuses a word that has one there. */
int word_choose_once(const struct word *word, const char *const *known, const char *what,
                     struct place *given, struct error *err);
/* Returns whether the word, which is not empty, begins with a digit, a sign or a point and has no
 * quotes. */
bool word_begins_number(const struct word *word);
/* Copies a string into an allocated one. A NULL stays NULL. */
bool string_copy(const char *from, char **out, struct error *err);
/* Returns the place of the next word, or of the line's end. */
struct place text_next_place(struct text text);
/* Reads three numbers; text_direction refuses 0 0 0. */
bool text_vector(struct text *text, const char *what, struct vector *out, struct error *err);
bool text_direction(struct text *text, const char *what, struct vector *out, struct error *err);

/* Prints a text within a quoted field of CSV (RFC 4180): doubles its quotation marks. */
void csv_text(const char *text, struct printed *to);

/* ---- json.c: facts out, as JSON (RFC 8259) or in words ---- */

/* A text that grows as it is written. */
struct json {
    struct printed printed;
    bool separated;   /* the next member needs a comma before it */
    bool words;       /* lines for a reader in place of JSON */
    int depth;        /* of words: objects around the next line */
    const char *list; /* of words: the key of the list whose entries are written; NULL: none */
    int n_row;        /* of words: 1 and the members of the entry so far; 0: no entry is open */
};
/* Begins a text, which is an object. When memory runs out, here or later, only json_take reports
 * it. */
void json_begin(struct json *json);
/* Begins a text in words: the member "scene_sha256" becomes a line "scene sha256   VALUE", and each
 * entry of the list "files" a line "file   VALUE". A value that is null gets no line. */
void words_begin(struct json *json);
/* Each writes one member of an object, or of an array, whose members have no key: key NULL.
 * Brackets are '{' or '[' to open, '}' or ']' to close. */
void json_open(struct json *json, const char *key, char bracket);
void json_close(struct json *json, char bracket);
void json_string(struct json *json, const char *key, const char *value); /* NULL: null */
/* Infinity and NaN become null: JSON has neither. */
void json_number(struct json *json, const char *key, double value);
void json_count(struct json *json, const char *key, uint64_t value);
void json_truth(struct json *json, const char *key, bool value);
/* An array; null where values is NULL. Words name the first and the last number. */
void json_numbers(struct json *json, const char *key, const double *values, int n);
void json_strings(struct json *json, const char *key, const char *const *values, int n);
/* Ends the object and the text, and returns it as printed_take does. */
char *json_take(struct json *json, struct error *err);
/* Ends both and writes the text to a file, as file_write; words appear on standard output. */
bool json_write(struct json *json, const char *path, struct outputs *outputs, struct error *err);
struct options;
/* Writes what a command reports, and ends both. The JSON goes where --json says. The text goes to
 * --output; where that is not given, it goes to standard output, unless the report is JSON. */
bool report_write(struct options *options, struct json *json, struct printed *text,
                  struct error *err);

/* ---- names.c ---- */

enum file_kind {
    FILE_SCENE,
    FILE_MATERIAL,
    FILE_LIST, /* of materials */
    FILE_TABLE,
    FILE_MODEL,
    FILE_MAP, /* of materials of a mesh */
    FILE_TEXTURE,
    FILE_RELIEF,
    FILE_KINDS /* none: no built-in file is of this kind */
};
/* Writes the name of a built-in file of this kind. Returns false if the file is of another kind. */
bool builtin_is(const struct builtin_file *file, enum file_kind kind, char out[BUILTIN_NAME]);
/* Finds the file that a word names: a built-in one by its name, or a file relative to the word's
 * own file; if that is missing, a built-in one whose name differs in case. *out is its path,
 * allocated. Refuses an empty word, but not a missing file. */
bool word_file(const struct word *word, enum file_kind kind, char **out, struct error *err);
/* Finds it likewise; where it is missing, in the working folder, as the program of the thesis did.
 */
bool word_file_or_here(const struct word *word, enum file_kind kind, char **out, struct error *err);
/* Adds the files in the folder of a missing one that end as it does, or as those of its kind. */
void suggestion_add_files(struct suggestion *suggestion, const char *path, enum file_kind kind);
/* Refuses a missing file, and proposes a built-in one of this kind. The place names the file. */
bool file_expected(const char *path, struct place from, enum file_kind kind, struct error *err);

enum option_kind {
    OPTION_TEXT,   /* const char *: kept as it is written */
    OPTION_NUMBER, /* double, from lowest to highest */
    OPTION_COUNT,  /* int: a whole number from lowest to highest */
    OPTION_FLAG,   /* bool: takes no value */
    OPTION_CHANGE /* changes the scene, by the function `change`; with a value, if the usage has one
                   */
};

/* An option. Rows of one command have names of their own. */
struct option {
    const char *usage; /* names with their dashes, then the value's: "-o, --output FILE" */
    const char *help;  /* for --help, which breaks its lines */
    enum option_kind kind;
    bool own;               /* the value is in the command's own options, not in struct options */
    size_t offset;          /* of the value there; unused by OPTION_CHANGE */
    double lowest, highest; /* of a number or a count */
    const char *const *choices; /* OPTION_TEXT: the words to choose from, then NULL; NULL: any */
    /* OPTION_TEXT: refuses a value that the command cannot use; NULL: any is good. */
    bool (*accepts)(const char *option, const char *value, struct error *err);
    bool (*change)(struct scene *scene, const char *value, struct error *err);
    const char *marks; /* OPTION_CHANGE: the value has one of them; NULL: it may have none */
    const char *needs; /* it has an effect beside this option only, as "--objects"; NULL: always */
    bool writes;       /* OPTION_TEXT: the value names a file that the command writes */
    bool made_again;   /* OPTION_TEXT: the value names a file that --output may name, too */
    bool recorded;     /* it decides the picture: a stack records it, and --again reads it there */
};
/* Where the value of an option is: in struct options, or in the own struct of the command. */
#define SHARED(KIND, field) .kind = OPTION_##KIND, .offset = offsetof(struct options, field)
#define OWN(KIND, type, field)                                                                     \
    .own = true, .kind = OPTION_##KIND, .offset = offsetof(struct type, field)
#define CHANGES(function) .kind = OPTION_CHANGE, .change = (function)

/* Options that stand together: those of one command, or some that several commands take. */
struct option_list {
    const struct option *options;
    int n;
};
#define OPTION_LIST(rows)                                                                          \
    {                                                                                              \
        (rows), (int)(sizeof(rows) / sizeof *(rows))                                               \
    }

struct command {
    const char *name;
    const char *operands; /* for --help; begins with a capital letter where one is needed */
    const char *summary;  /* for --help, which breaks its lines */
    const char *example;  /* the words behind "spectral", of scenes that all programs have */
    const char *first; /* what the example does, for the answer to the program's name alone; NULL:
                          this is no command to begin with */
    bool (*run)(struct options *options, struct error *err);
    struct option_list rows;              /* options of its own */
    const struct option_list *shared[16]; /* others, then NULL; common_options come behind */
    size_t own_size;                      /* bytes of its own options; 0: it has none */
    int n_operands;                       /* the most; at most MOST_OPERANDS */
};

/* The commands of this program, then NULL: see raster/beside/commands.c. */
extern const struct command *const commands[];

/* Options that many commands take. */
extern const struct option_list common_options; /* that all take */
extern const struct option_list threads_option, json_option, quiet_option;
extern const struct option_list seeing_options; /* --detector and --white of a stack's picture */

/* A change of the scene, to be made after the scene is read. */
struct option_change {
    bool (*apply)(struct scene *scene, const char *value, struct error *err);
    const char *value;
};

/* A command line as it was read. Texts point into it. NULL, 0 or false means that an option was not
 * given. */
struct options {
    const struct command *command;
    const char *program; /* the name that the user started the program by */
    const char *operand; /* the first one: SCENE, STACK or KIND; NULL: none */
    const char *operands[MOST_OPERANDS];
    struct option_change changes[MOST_RECORDED]; /* in the order given */
    char *recorded[MOST_RECORDED]; /* "NAME=VALUE" of each option with `recorded`; owned */
    int n_operands, n_changes, n_recorded;
    char *named_output;     /* of options_name_output; owned */
    struct outputs outputs; /* complete; they appear when the command has ended well */
    void *own;              /* the own options of the command, zeroed before reading; owned */
    const char *output, *json, *sampling, *detector, *white, *matrix, *display, *exposure,
        *accuracy;
    int threads, memory_mib, max_triangles;
    bool quiet, verbose, help;
};

/* Reads the words behind the command's name: "--option value", "--option=value", flags and
 * operands; behind "--" all words are operands. Refuses an output that is a file of another word.
 * recorded: a stack has recorded the words, and no other options are known. The words must outlive
 * *out. Call options_free also after a failure. */
bool options_read(const struct command *command, bool recorded, const char *const *words,
                  int n_words, struct options *out, struct error *err);
void options_free(struct options *options);
/* Refuses outputs that would replace the file of another option, or a file that was read until now,
 * and those beside --output that cannot be opened. options_read has called it; a command
 * that works long calls it again when its inputs are read. */
bool options_check_outputs(const struct options *options, struct error *err);
/* Refuses the operands: says why, names the word that this is about, and shows the usage. */
bool options_misused(const struct command *command, const char *why, const char *word,
                     struct error *err);
/* Adds "NAME=VALUE", or the name of a flag (value NULL), to the words that the stack records. */
bool options_record(struct options *options, const char *name, const char *value,
                    struct error *err);

/* Names the output after the file `path`, with another ending, where the command line gives none;
 * after "scene" where the path is "-". Refuses the name of another option's file. options_free ends
 * it. */
bool options_name_output(struct options *options, const char *path, const char *ending,
                         struct error *err);
/* Limits the memory of the command: see memory_limit. */
void options_limit_memory(const struct options *options);
/* Returns SCENE, or the built-in colorchecker if none is given. */
const char *options_scene(const struct options *options);
/* Returns the detector or observer, or cie1931 if none is given. */
const char *options_detector(const struct options *options);

/* Returns the descriptor of a command's table: standard output, or standard error if the JSON or
 * the command's output (NULL: none) may go to standard output. */
int options_table(const struct options *options, const char *output);
/* Prints the kind and the name of what a command without another table has written, unless that is
 * standard output. */
bool options_show_output(const struct options *options, const char *kind, const char *output,
                         struct error *err);
/* Reads the one number of an option or operand, from lowest to highest. Messages name `option`. */
bool option_number(const char *option, const char *value, double lowest, double highest,
                   double *out, struct error *err);
bool option_count(const char *option, const char *value, double lowest, double highest, int *out,
                  struct error *err); /* a whole number, up to INT_MAX */

/* Returns an option of a command by its number from 0 on; NULL: there are fewer. */
const struct option *option_at(const struct command *command, int i);
/* Prints the words of a text from the cursor's column on. A new line begins at that column. */
void help_words(struct printed *to, const char *text, int column);
/* Explains the options of a command. */
void help_options(const struct command *command, struct printed *to);

#endif
