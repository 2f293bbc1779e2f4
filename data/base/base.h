/* SPDX-License-Identifier: MIT */
/* The room "base": growing arrays, files, threads, digests. */
#ifndef BASE_H
#define BASE_H

#include "spectral.h"

/* ---- error.c: arrays that grow ---- */

/* Adds a copy of the item, of `size` bytes, to an array of such items, and counts it; NULL: adds a
 * zeroed item. `array` is the address of the pointer to the array, which is NULL with *count 0. The
 * array may move. On failure array and *count stay. */
bool array_add(void *array, int *count, const void *item, size_t size, struct error *err);

/* ---- printed.c: a text that is printed into memory ---- */

/* Zero it before use. Nothing is printed behind what memory had no room for. */
struct printed {
    char *text;      /* owned until printed_end */
    size_t length;   /* without the NUL at the end */
    size_t capacity; /* of text */
    bool failed;     /* memory has run out */
};
void print(struct printed *to, const char *format, ...) PRINTF_LIKE(2, 3);
void print_text(struct printed *to, const char *text);
void print_bytes(struct printed *to, const void *bytes, size_t length);
/* Returns the whole text, which then belongs to the caller; NULL: no memory, or it was returned
 * already. Its length stays. */
char *printed_end(struct printed *printed);
/* Writes the whole text to a stream and frees it. Fails for lack of memory alone: main looks for
 * failed writes to standard output. */
bool printed_show(struct printed *printed, FILE *to, struct error *err);

/* ---- file.c: whole reads, compiled-in files, files that appear whole or not at all ---- */

/* A file that is compiled into the program. Its path is "builtin:" and its name, e.g.
 * builtin:tables/d65.csv. */
struct builtin_file {
    const char *name; /* relative to data/builtin/ */
    const unsigned char *bytes;
    size_t length;
};
extern const struct builtin_file builtin_files[]; /* made by build.sh; sorted by name */
extern const size_t builtin_file_count;

bool path_is_builtin(const char *path); /* begins with "builtin:" */
enum { BUILTIN_NAME = 256 };
/* Writes the part of a file's name between a folder and an ending. Returns false if the name does
 * not begin and end so. */
bool builtin_name(const struct builtin_file *file, const char *folder, const char *ending,
                  char out[BUILTIN_NAME]);

/* Reads a whole file, or a "builtin:..." file. *bytes is allocated, with a NUL behind its *length
 * bytes. Refuses with EXIT_INPUT a folder, a missing or unreadable file and a file that contains a
 * NUL byte. The message names `from`, the place that names the file; its path is NULL when the
 * command line names it. */
bool file_read(const char *path, struct place from, char **bytes, size_t *length,
               struct error *err);
/* Reads standard input likewise, to its end. Messages call it `name`. */
bool input_read(const char *name, char **bytes, size_t *length, struct error *err);

/* Opens a regular file for reading, or finds a "builtin:..." file, which has no descriptor (-1).
 * Refuses what file_read refuses, but accepts NUL bytes. */
bool file_open(const char *path, struct place from, int *descriptor,
               const struct builtin_file **builtin, struct error *err);

/* Returns the path of `name` as seen from the file `base`: an absolute or "builtin:" name stays,
 * any other name is relative to the folder of base. "a/../" is removed from builtin paths. The
 * result is allocated; NULL: no memory. */
char *file_relative(const char *base, const char *name);

/* Holds SIGINT, SIGTERM and SIGHUP back from this thread, and from threads that it starts, until
 * they are released. Returns what signals_release needs; NULL: no memory. Holds nest. */
void *signals_hold(void);
void signals_release(void *held); /* NULL is fine */

/* A file that appears whole or not at all. A regular or new file is written under a temporary name
 * beside it and renamed at the end; anything else (a pipe, a device, "-" for standard output)
 * receives a copy of a temporary file. Signals are held back while an output is open. */
struct output {
    int descriptor;
    char *path;      /* final name, links resolved */
    char *temporary; /* name being written; NULL when none is open */
    bool copied;     /* path is no regular file, or "-": copy instead of rename */
    void *held;      /* of signals_hold */
};
/* Creates the temporary file. Refuses a path that cannot be written, and a terminal. */
bool output_open(struct output *out, const char *path, struct error *err);
bool output_interrupted(void); /* true if a signal that is held back is pending */
/* Syncs, closes and renames (or copies). After a failure no temporary file is left. */
bool output_commit(struct output *out, struct error *err);
void output_discard(struct output *out); /* safe after commit, and on a zeroed struct */

bool write_all(int descriptor, const void *bytes, size_t length); /* false: see errno */
bool output_is_unread(void); /* standard output is a pipe that its reader has closed */
/* Writes a whole small file, which appears whole or not at all. "-" is standard output; if its
 * reader closes the pipe, that is no failure. */
bool file_write(const char *path, const char *bytes, size_t length, struct error *err);
/* Refuses an output that cannot be opened, before the work begins. Leaves no file. NULL: none. */
bool output_can_open(const char *path, struct error *err);

/* ---- threads.c ---- */

/* Starts `wanted` threads of OpenMP (0: as many as it offers), and returns their number. Signals
 * are held back from all but the first: another thread would end the program at once. */
int threads_start(int wanted);

/* ---- digest.c: SHA-256 (FIPS 180-4) ---- */

struct digest {
    uint32_t hash[8];
    unsigned char block[64]; /* bytes that do not fill a block yet */
    uint64_t total;          /* bytes */
};
void digest_start(struct digest *out);
void digest_add(struct digest *digest, const void *bytes, size_t length);
void digest_end(struct digest *digest, char out[65]); /* 64 hexadecimal digits and a NUL */
bool digest_file(const char *path, char out[65], struct error *err);

/* ---- outputs.c: the names of files that a command writes ---- */

/* Returns the default name of an output: that of a file without its folder, and with another
 * ending. Allocated; NULL: no memory. */
char *output_name(const char *path, const char *ending);
/* Finds the ending of a name in a list as ".png", ".tif", NULL, in capitals or small letters. *out
 * is its index; -1: the name has no ending, as "-" and /dev/stdout. Refuses any other ending. */
bool output_ending(const char *path, const char *const *endings, int *out, struct error *err);
/* Return true if the name is that of a regular file, or of a link to one, and not "-"; if two names
 * are those of one file; if no file has the name, which is not "builtin:...". */
bool file_is_regular(const char *path);
bool file_is_same(const char *a, const char *b);
bool file_is_missing(const char *path);
/* format.c: returns the format of a regular file by its first bytes: "TIFF", "PNG", ...; "text":
 * they have no NUL; "": another one, or it cannot be read. */
const char *file_format(const char *path);
bool output_is_standard(const char *path); /* true of "-", standard output */
/* Refuses an output that would replace the input. Either may be NULL. */
bool output_spares(const char *output, const char *input, struct error *err);

/* ---- progress.c: time, progress and memory of this process ---- */

double clock_seconds(void); /* of a clock that only goes forward */

/* A line of progress with the time left, on standard error. */
struct progress_line {
    double start, printed; /* in clock_seconds: the beginning, and the last time of printing */
};
/* Begins a line. Returns true if it is to be shown: standard error is a terminal, and `quiet` is
 * not set. */
bool progress_start(struct progress_line *out, bool quiet);
/* Shows that `done` of `all` steps are done. Removes the line after the last one. The context is a
 * struct progress_line. */
void progress_show(void *context, long done, long all);
uint64_t peak_bytes(void); /* the largest memory of the process so far; 0: unknown */

#endif
