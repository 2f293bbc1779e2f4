/* SPDX-License-Identifier: MIT */
/* The room "base": growing arrays, files, texts, memory. */
#ifndef BASE_H
#define BASE_H

#include <errno.h>
#include <sys/types.h>

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
void print_printable(struct printed *to, const char *text); /* without unprintable characters */
/* Prints "NAME  VALUE" in a line of its own, without the value's unprintable characters. */
void print_fact(struct printed *to, const char *name, const char *value);
void print_bytes(struct printed *to, const void *bytes, size_t length);
/* Prints a blank and the word as a shell reads it: between quotes, unless it needs none. */
void print_shell(struct printed *to, const char *word);
/* Prints a text for XML, with '?' for bytes and characters that XML excludes; NULL: nothing. */
void print_xml(struct printed *to, const char *text);
/* Returns the whole text, which then belongs to the caller; NULL: no memory, or it was returned
 * already. Its length stays. */
char *printed_end(struct printed *printed);
char *printed_take(struct printed *printed, struct error *err); /* NULL: memory_lacks */
/* Writes the whole text, without unprintable characters, to a descriptor, and frees it. It is no
 * failure if the reader of a pipe has gone, or standard error takes nothing. */
bool printed_show(struct printed *printed, int to, struct error *err);

/* ---- printable.c: what may reach a terminal ---- */

/* Returns the length in bytes of the UTF-8 character at `at`, in a text that ends with a NUL; 0:
 * the character is not valid, or, for the second, has no picture. */
int utf8_length(const unsigned char *at);
int printable_length(const unsigned char *at);
/* Replaces each unprintable character by '?', in place, but for the control characters in `kept`.
 */
void hide_unprintable(char *text, const char *kept);

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

#define BUILTIN_PREFIX "builtin:"
enum { BUILTIN_NAME = 256 };
/* Writes the part of a file's name between a folder and an ending. Returns false if the name does
 * not begin and end so. */
bool builtin_name(const struct builtin_file *file, const char *folder, const char *ending,
                  char out[BUILTIN_NAME]);

/* Reads a whole file, or a "builtin:..." file. *bytes is allocated, with a NUL behind its *length
 * bytes. Refuses with EXIT_INPUT a folder, a missing or unreadable file and a file that contains a
 * NUL byte. The message names `from`, the place that names the file; its path is NULL when the
 * command line names it. Waits for a pipe only then. */
bool file_read(const char *path, struct place from, char **bytes, size_t *length,
               struct error *err);
/* Reads standard input likewise, to its end. Messages call it `name`. */
bool input_read(const char *name, char **bytes, size_t *length, struct error *err);

/* Opens a regular file for reading, or finds a "builtin:..." file, which has no descriptor (-1).
 * Refuses what file_read refuses, but accepts NUL bytes. */
bool file_open(const char *path, struct place from, int *descriptor,
               const struct builtin_file **builtin, struct error *err);

/* ---- was_read.c: the files that this process has opened for reading ---- */

struct file_identity {
    uint64_t device, inode;
};
/* Notes the regular file of a descriptor: pipes and devices are never replaced. Every opening for
 * reading comes through file.c, which calls this. Fails without memory. */
bool file_note_read(int descriptor, struct error *err);
bool file_was_read(const char *path); /* also under another name of the file */
/* For a process that reads in place of another: the files noted so far; and one more. */
const struct file_identity *files_read(int *n);
bool files_read_add(const struct file_identity *file, struct error *err);
void files_read_forget(void); /* for tests, which write and read one file again and again */

/* ---- descriptor.c: bytes of an open file ---- */

/* Repeats a call of the system that a signal has interrupted, e.g. UNTIL_DONE(got, read(...)). */
#define UNTIL_DONE(result, call)                                                                   \
    do                                                                                             \
        (result) = (call);                                                                         \
    while ((result) < 0 && errno == EINTR)

/* Reads `length` bytes, or fewer where the file ends. Returns their number; -1: see errno. */
ssize_t read_at(int descriptor, void *bytes, size_t length, uint64_t offset);
/* Write all bytes, at the descriptor's own place or at an offset. Return false with errno. */
bool write_all(int descriptor, const void *bytes, size_t length);
bool write_at(int descriptor, const void *bytes, size_t length, uint64_t offset);

/* ---- memory.c: the memory that a command may take ---- */

/* "out of memory: 1.2 MiB for WHAT", as the format names it: "the texels of %s". 0 bytes: a library
 * does not say how many. Sets EXIT_SYSTEM. */
bool memory_lacks(struct error *err, double bytes, const char *format, ...) PRINTF_LIKE(3, 4);
/* Stores an array of n zeroed items in a pointer, which `array` points to. Stores NULL, and returns
 * false, where memory lacks; the macro then says what for. It evaluates n twice. */
bool memory_make(void *array, size_t n, size_t size);
#define MAKE_ARRAY(array, n, err, ...)                                                             \
    (memory_make(&(array), (size_t)(n), sizeof *(array)) ||                                        \
     memory_lacks(err, (double)(n) * (double)sizeof *(array), __VA_ARGS__))
/* Frees all these pointers, e.g. FREE_ALL(a, b). NULL is none. */
#define FREE_ALL(...)                                                                              \
    memory_free((void *[]){__VA_ARGS__}, sizeof(void *[]){__VA_ARGS__} / sizeof(void *))
void memory_free(void *const *items, size_t n);
/* Gives an array room for n items, which may move it. Returns false, and changes nothing, where
 * memory lacks. */
bool memory_resize(void *array, size_t n, size_t size);

/* Limits this process and those that it starts to so many bytes more than it has now. A smaller
 * limit of the user stays. The second function adds the bytes for the stacks of threads, once: call
 * it before a thread starts. Until then nothing else can take these bytes. */
void memory_limit(uint64_t bytes, uint64_t stacks);
void memory_allow_stacks(void);
/* Refuses what would need more memory than the limit leaves, before it is tried. The format names
 * what needs it, e.g. "a mesh of %d triangles". */
bool memory_suffices(double bytes, struct place place, struct error *err, const char *format, ...)
    PRINTF_LIKE(4, 5);

/* ---- paths.c: how one file names another, and what a path names ---- */

bool path_is_builtin(const char *path);  /* begins with BUILTIN_PREFIX */
const char *path_name(const char *path); /* points behind the last '/' */
/* Returns the path of `name` as seen from the file `base`: an absolute or "builtin:" name stays,
 * any other name is relative to the folder of base. "a/../" is removed from builtin paths. The
 * result is allocated; NULL: no memory. */
char *file_relative(const char *base, const char *name);

/* Find whether the name is that of a regular file, or of a link to one, and not "-"; whether two
 * names are those of one file. Fail only where the system does. */
bool file_is_regular(const char *path, bool *out, struct error *err);
bool file_is_same(const char *a, const char *b, bool *out, struct error *err);
bool file_is_missing(const char *path); /* no file has the name, which is not "builtin:..." */
/* format.c: finds the format of a regular file by its first bytes: "TIFF", "PNG", ...; "text": they
 * have no NUL; "": another one, or no such file; "ENVI": an ENVI header, or raw samples with a
 * header beside them. Fails only where the system does. */
bool file_format(const char *path, const char **out, struct error *err);
/* Returns the name of the raw samples of such a header, otherwise the path itself; allocated. NULL:
 * no memory. */
char *envi_data(const char *path);

/* ---- progress.c: time, progress and memory of this process ---- */

double clock_seconds(void);     /* of a clock that only goes forward */
double processor_seconds(void); /* that this process has had so far, on all processors */

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
