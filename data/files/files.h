/* SPDX-License-Identifier: MIT */
/* The room "files": files in, whole, and those that are built in; files out, which appear whole or
 * not at all and replace no input; the names of both; SHA-256 (FIPS 180-4). */
#ifndef DATA_FILES_FILES_H
#define DATA_FILES_FILES_H

#include <dirent.h>

#include "data/base/base.h"

/* ---- file.c: whole reads, compiled-in files, files that appear whole or not at all ---- */

/* A file that is compiled into the program. Its path is "builtin:" and its name, e.g.
 * builtin:tables/d65.csv. */
struct builtin_file {
    const char *name; /* relative to data/builtin/ */
    const unsigned char *bytes;
    size_t length;
};
/* Made by build.sh; sorted by name. The program may hold them in one packed piece. */
extern const struct builtin_file *const builtin_files;
extern const size_t builtin_file_count;
/* All of them as gzip packs them, with a NUL behind each; NULL: they are not packed. */
extern const unsigned char *const builtin_packed;
extern const size_t builtin_packed_length;
extern unsigned char *const builtin_unpacked; /* room for them, to which the files point already */
extern const size_t builtin_unpacked_length;
/* Unpacks them, if they are packed. Call it once, before anything else of this room. */
bool builtin_unpack(struct error *err);

#define BUILTIN_PREFIX "builtin:"
enum { BUILTIN_NAME = 256 };
/* Writes the part of a file's name between a folder and an ending. Returns false if the name does
 * not begin and end so. */
bool builtin_name(const struct builtin_file *file, const char *folder, const char *ending,
                  char out[BUILTIN_NAME]);

extern const char standard_input[]; /* "<stdin>", as messages and stacks call it */
/* Reads a whole text file, or a "builtin:..." file, into an allocated string; NULL after an error.
 * Refuses with EXIT_INPUT a folder, a missing or unreadable file and a file that contains a NUL
 * byte, but at the end of a line, where it becomes a blank. The message names `from`, the place
 * that names the file; its path is NULL when the command line names it. Waits for a pipe only then.
 * Where the path is standard_input itself, reads standard input to its end. */
char *file_read(const char *path, struct place from, struct error *err);

/* Opens a regular file for reading, or finds a "builtin:..." file, which has no descriptor (-1).
 * Refuses what file_read refuses, but accepts NUL bytes. */
bool file_open(const char *path, struct place from, int *descriptor,
               const struct builtin_file **builtin, struct error *err);

/* ---- paths.c: how one file names another, and what a path names ---- */

bool path_is_builtin(const char *path);  /* begins with BUILTIN_PREFIX */
const char *path_name(const char *path); /* points behind the last '/' */
/* Removes "." and "a/.." in place. The folder above the first one is the first one. Returns false
 * if the path is absolute, or leaves the folder where it begins. */
bool path_fold(char *path);
/* Returns the path of `name` as seen from the file `base`: an absolute or "builtin:" name stays,
 * any other name is relative to the folder of base. path_fold folds builtin paths. The
 * result is allocated; NULL: no memory. */
char *file_relative(const char *base, const char *name);

/* Find whether the name is that of a regular file, or of a link to one, and not "-"; whether two
 * names are those of one file. Fail only where the system does. */
bool file_is_regular(const char *path, bool *out, struct error *err);
bool file_is_same(const char *a, const char *b, bool *out, struct error *err);
bool file_is_missing(const char *path); /* no file has the name, which is not "builtin:..." */
/* format.c: finds a format by the first bytes: "TIFF", "PNG", "XML", ...; "text": they have no NUL;
 * "": another one. */
const char *format_of(const void *bytes, size_t length);
bool format_is_picture(const char *format);
/* Finds the format of a regular file; "": also of no such file; "ENVI": of an ENVI header, or of
 * raw samples with a header beside them. Fails only where the system does. */
bool file_format(const char *path, const char **out, struct error *err);
/* Returns the name of the raw samples of such a header, otherwise the path itself; allocated. NULL:
 * no memory. */
char *envi_data(const char *path);

/* ---- digest.c: SHA-256, and digests of the files that this process has read ---- */

struct digest {
    uint32_t hash[8];
    unsigned char block[64]; /* bytes that do not fill a block yet */
    uint64_t total;          /* bytes */
};
void digest_start(struct digest *out);
void digest_add(struct digest *digest, const void *bytes, size_t length);
void digest_end(struct digest *digest, char out[65]); /* 64 hexadecimal digits and a NUL */
void digest_bytes(const void *bytes, size_t length, char out[65]);

/* Notes the digest of a text as its bytes were read. A built-in file has none. */
bool digest_note(const char *path, const void *bytes, size_t length, struct error *err);
/* Finds the digest of a file as it was read, or else as it is now. */
bool digest_file(const char *path, char out[65], struct error *err);

/* ---- output.c: files that appear whole or not at all ---- */

/* A regular or new file is written beside its place, and gets its name at the end; anything else (a
 * pipe, a device, "-" for standard output) receives a copy of a temporary file. */
struct output {
    int descriptor;
    char *path; /* final name, links resolved */
    const char
        *holder; /* what a failed write names: path, or the folder of the file to be copied */
    char temporary[4096]; /* the path under which this process can read the file before it has its
                             final name; "": no file is open. Linux takes no longer one */
    bool named;           /* the temporary name stands in the folder, and must be removed */
    bool copied;          /* path is no regular file, or "-": copy at the end */
};
/* Creates the file. Refuses a path that cannot be written, standard output where it is a terminal,
 * and a file that this process has read: see file_was_read. */
bool output_open(struct output *out, const char *path, struct error *err);
void output_discard(struct output *out); /* safe after output_pass, and on a zeroed struct */

/* The outputs of a command: they appear together, when all that can fail is done. */
struct outputs {
    struct output *list; /* complete; they and the list are owned */
    int n;
};
/* Passes a complete output, which is zeroed, to a command's outputs. NULL: lets it appear at once,
 * in a folder that nobody keeps yet; the caller holds signals back. A copy is made at once in any
 * case. After a failure it is discarded, and no temporary file is left. */
bool output_pass(struct output *output, struct outputs *outputs, struct error *err);
/* Finds the name by which the output of a path can be read before it is committed; NULL: it is none
 * of the first n. Fails only where the system does. */
bool outputs_readable(const struct outputs *outputs, int n, const char *path, const char **out,
                      struct error *err);
/* Lets all outputs appear under their names. Refuses to replace a file that this process has read:
 * then none appears. */
bool outputs_commit(struct outputs *outputs, struct error *err);
void outputs_discard(struct outputs *outputs); /* safe after commit */
/* Writes a whole small file, which appears whole or not at all. "-" is standard output; if its
 * reader closes the pipe, that is no failure. outputs as output_pass takes them. */
bool file_write(const char *path, const char *bytes, size_t length, struct outputs *outputs,
                struct error *err);
/* Writes a whole text likewise, and frees it. */
bool printed_write(struct printed *printed, const char *path, struct outputs *outputs,
                   struct error *err);
/* Refuses an output that cannot be opened, before the work begins. Leaves no file. */
bool output_can_open(const char *path, struct error *err);

/* ---- temporary.c: room on the disk ---- */

/* Reserves the blocks of a large file, so that they lie together, and a full disk or quota shows
 * before hours of rendering are lost. Returns false with errno where the disk is too full; true,
 * too, where a file system cannot reserve, or a file is small. */
bool output_reserve(const struct output *output, uint64_t length);

/* ---- paths.c: the names of files that a command writes ---- */

/* Returns the default name of an output: that of a file without its folder, and with another
 * ending. Allocated; NULL: no memory. */
char *output_name(const char *path, const char *ending, struct error *err);
bool output_is_standard(const char *path); /* true of "-" and /dev/stdout, standard output */
bool output_is_stream(const char *path);   /* true of "-", a pipe and a device */

/* ---- temporary.c: a folder for files that nobody keeps ---- */

struct folder {
    char path[4096]; /* "": there is none */
    DIR *entries; /* open, so that the folder can be emptied without memory; NULL: there is none */
};
/* Makes a folder in TMPDIR, or /tmp, whose name the guard knows (guard_remove). The caller lets the
 * guard know the files in it. */
bool folder_open(struct folder *out, struct error *err);
/* Makes a folder beside the path, which must not exist, for files that the user keeps. The caller
 * holds signals back until folder_close: see guard_hold. */
bool folder_open_beside(const char *path, struct folder *out, struct error *err);
/* Gives the folder the name of that path, with all files in it. */
bool folder_keep(struct folder *folder, const char *path, struct error *err);
void folder_close(struct folder *folder); /* with all files in it, unless they are kept */

#endif
