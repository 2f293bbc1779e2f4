/* SPDX-License-Identifier: MIT */
/* The room "base": errors, growing arrays, texts that grow in memory, an index of names, memory and
 * its limit, threads and processes. A thread that has nothing to do sleeps: it takes no processor
 * from OpenGL, from other programs or from its own process. (OpenMP's threads spin while they wait;
 * only the environment, before the program starts, could forbid it.) */
#ifndef DATA_BASE_BASE_H
#define DATA_BASE_BASE_H

#include <errno.h>
#include <pthread.h>
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
/* Prints numbers of `size` bytes, `length` bytes in all, as store_numbers stores them. */
void print_stored(struct printed *to, const void *numbers, size_t size, size_t length);
/* Prints a blank and the word as a shell reads it: between quotes, unless it needs none. */
void print_shell(struct printed *to, const char *word);
/* Prints a text for XML, with '?' for bytes and characters that XML excludes; NULL: nothing. */
void print_xml(struct printed *to, const char *text);
/* Returns the whole text, which then belongs to the caller; NULL: no memory, or it was returned
 * already. Its length stays. */
char *printed_end(struct printed *printed);
/* Does the same; NULL: memory_lacks, or *err has a failure already, after which the text need not
 * be whole. A difference (EXIT_DIFFERENT) is none. All that writes a text comes through here: so a
 * caller puts a text together, and need not ask whether that has failed. */
char *printed_take(struct printed *printed, struct error *err);
/* Writes the whole text, without unprintable characters, to a descriptor, and frees it. It is no
 * failure if the reader of a pipe has gone, or standard error takes nothing. */
bool printed_show(struct printed *printed, int to, struct error *err);

/* ---- printable.c: what may reach a terminal ---- */

/* Returns the length in bytes of the UTF-8 character at `at`, in a text that ends with a NUL; 0:
 * the character is not valid. */
int utf8_length(const unsigned char *at);
/* Replaces each unprintable character by '?', in place, but for the control characters in `kept`.
 */
void hide_unprintable(char *text, const char *kept);

/* ---- printed.c: numbers in files ---- */

/* Returns whether the highest byte of a number comes first in memory. */
bool machine_is_big_endian(void);
/* Copies numbers of 1, 2, 4 or 8 bytes, `length` bytes in all, with the lowest byte first. */
void store_numbers(void *out, const void *numbers, size_t size, size_t length);

/* ---- descriptor.c: bytes of open files, and which this process has read ---- */

/* Repeats a call of the system that a signal has interrupted, e.g. UNTIL_DONE(got, read(...)). */
#define UNTIL_DONE(result, call)                                                                   \
    do                                                                                             \
        (result) = (call);                                                                         \
    while ((result) < 0 && errno == EINTR)

/* An offset that stands for the descriptor's own place, as in a pipe. */
#define OWN_PLACE UINT64_MAX
/* Reads `length` bytes, or fewer where the file ends. Returns their number; -1: see errno. */
ssize_t read_at(int descriptor, void *bytes, size_t length, uint64_t offset);
/* Write all bytes, at the offset or at the descriptor's own place. Return false with errno. */
bool write_at(int descriptor, const void *bytes, size_t length, uint64_t offset);
bool write_all(int descriptor, const void *bytes, size_t length);

/* Notes the regular file of a descriptor: pipes and devices are never replaced. Every opening for
 * reading comes through file.c, which calls this. Fails without memory. */
bool file_note_read(int descriptor, struct error *err);
bool file_was_read(const char *path); /* also under another name of the file */

/* ---- memory.c: the memory that a command may take ---- */

/* "out of memory: 1.2 MiB for WHAT", as the format names it: "the texels of %s". 0 bytes: a library
 * does not say how many. Sets EXIT_SYSTEM. */
bool memory_lacks(struct error *err, double bytes, const char *format, ...) PRINTF_LIKE(3, 4);
/* Stores an array of n zeroed items in a pointer, which `array` points to. Stores NULL, and returns
 * false, where memory lacks; the macro then says what for. It evaluates n twice. A product of sizes
 * that a file gives may need 64 bits. */
bool memory_make(void *array, uint64_t n, size_t size);
#define MAKE_ARRAY(array, n, err, ...)                                                             \
    (memory_make(&(array), (uint64_t)(n), sizeof *(array)) ||                                      \
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
/* Shows that `done` of `all` steps are done. Removes the line after the last one. */
void progress_show(struct progress_line *line, long done, long all);
uint64_t peak_bytes(void); /* the largest memory of the process so far; 0: unknown */

/* ---- loop.c ---- */

/* Returns `wanted`, at most MOST_THREADS; 0 stands for the number of processors that this process
 * may run on. */
int threads_count(int wanted);
/* Calls work(context, i) once for each i below n, on n_threads threads, this one included in any
 * case, and returns after the last call. A thread takes the next i as soon as it is free. Where the
 * system starts fewer threads, those that there are do the work. */
void threads_each(int n_threads, int n, void (*work)(void *context, int i), void *context);

/* A number that several threads add to; COUNTER begins it. */
struct counter {
    pthread_mutex_t lock;
    uint64_t n;
};
#define COUNTER                                                                                    \
    {                                                                                              \
        PTHREAD_MUTEX_INITIALIZER, 0                                                               \
    }
uint64_t counter_add(struct counter *to, uint64_t n); /* returns the number before */

/* ---- pipeline.c: two stages that work side by side, one on what the other has made ---- */

/* Two stages over one context. Set the first members, and zero the others. */
struct pipeline {
    /* Makes the next thing. Returns false behind the last one, or on failure: then *err says so. */
    bool (*make)(void *context, struct error *err);
    bool (*take)(void *context, struct error *err); /* takes all; false: it failed, or `make` did */
    void *context;
    bool alone; /* one thread: `take` calls `make` where it waits */
    bool stopped;
    struct error err; /* of the stage that failed first */
    pthread_mutex_t lock;
    pthread_cond_t changed;
};
/* Runs `make` on this thread, until it has made all, and `take` on another, and returns when both
 * have ended. Where no thread starts, both run on this one. If one fails, the other stops where it
 * waits, and *err is the error of the first. */
bool pipeline_run(struct pipeline *pipeline, struct error *err);

/* Places that one stage fills, and another takes and frees. They say only what they hold, by
 * numbers above 0 that the stages choose; their contents belong to the stages. Zero it, but for the
 * first two members, before the pipeline runs. */
enum { MOST_PLACES = 8 };
struct places {
    struct pipeline *pipeline;
    int n;
    long holds[MOST_PLACES]; /* 0: the place is free */
};
/* Waits until a place holds this number (0: until one is free), and returns it; -1: the pipeline
 * has stopped. */
int places_wait(struct places *places, long number);
void places_set(struct places *places, int place, long number); /* 0: the place is free now */

/* ---- index.c: a hash table from keys to numbers ---- */

/* Numbers by their keys, strings of any bytes. The time to find a key does not grow with the number
 * of keys. Zeroed it is empty. It keeps copies of the keys. */
struct index {
    struct index_slot *slots; /* owned */
    size_t n_slots, n_keys;   /* n_slots: 0 or a power of two, above n_keys */
    struct printed keys;      /* one behind the other; owned */
    uint64_t seed;            /* another one in each index: no input can make all keys collide */
};
/* Returns the number of a key; -1: the index does not have it. */
int index_find(const struct index *index, const void *key, size_t length);
/* Adds a key that the index does not have, with its number, 0 or above. A failure, for lack of
 * memory, changes no other key; no further one can be added. */
bool index_add(struct index *index, const void *key, size_t length, int number, struct error *err);
void index_free(struct index *index);
/* Returns a number whose every bit depends on every bit of the argument. */
uint64_t hash_bits(uint64_t bits);

/* ---- guard.c: the end of this process ---- */

/* Call once, first of all. From then on:
 * - SIGINT, SIGTERM and SIGHUP end the process at once, unless it ignores them, and remove the
 * names that guard_remove knows.
 * - A crash, or an exit that is not by guard_exit, removes these names, prints one line and ends
 * the process with EXIT_SYSTEM: a library may end its process, as LLVM does without memory. */
void guard_begin(void);
/* Ends the process with the exit status of a command. Does not return. */
void guard_exit(int status);

/* Remembers the name of a file or of an empty folder that must not outlive the process; the latest
 * is removed first. Returns false where there is no room for it: the caller then makes no such
 * file. The name is absolute, or relative to a working folder that stays. guard_forget takes it
 * back. */
bool guard_remove(const char *path);
void guard_forget(const char *path);

/* Between these two calls the signals that end the process wait: outputs get their names, or a
 * folder holds files that have no guard. They nest. */
void guard_hold(void);
void guard_release(void);
bool is_interrupted(void); /* such a signal waits */

/* ---- process.c: a job, or this program again, in a process of its own ---- */

/* A job fills in `out`, of the size that process_run has. */
typedef bool process_job(void *context, void *out, struct error *err);
/* Runs a job in a copy of this process, and waits for it. Returns the job's `size` bytes at `out`.
 * limit_s: ends a job that takes more seconds; 0: none is too slow. What the job reads is no input
 * of this process, which must read it before, if no output may replace it: see file_was_read. No
 * other thread of this process runs now, and it starts no OpenGL: a copy of a process has none of
 * its threads, and OpenGL would wait for them. */
bool process_run(process_job *job, void *context, void *out, size_t size, unsigned limit_s,
                 struct error *err);

/* The seconds of a program from exec to exit: by the clock; and of the processor, for the user and
 * for the system, in all processes of the program. */
struct run_seconds {
    double wall, processor;
};
/* Runs this program with the words, which end with NULL; the first is the name that this program
 * was started by. Standard input and output are /dev/null. Returns false with the last line that
 * the program printed on standard error, and with its exit status. */
bool process_program(const char *const *words, struct run_seconds *out, struct error *err);

#endif
