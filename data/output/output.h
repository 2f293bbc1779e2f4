/* SPDX-License-Identifier: MIT */
/* The room "output": files that appear whole or not at all, and the names of files that a command
 * writes. */
#ifndef OUTPUT_H
#define OUTPUT_H

#include <dirent.h>

#include "data/base/base.h"

/* ---- output.c: files that appear whole or not at all ---- */

/* A regular or new file is written beside its place, and gets its name at the end; anything else (a
 * pipe, a device, "-" for standard output) receives a copy of a temporary file. */
struct output {
    int descriptor;
    char *path;      /* final name, links resolved */
    char *temporary; /* the path under which this process can read the file before it has its final
                        name; NULL: no file is open */
    bool named;      /* the temporary name stands in the folder, and must be removed */
    bool copied;     /* path is no regular file, or "-": copy at the end */
};
/* Creates the file. Refuses a path that cannot be written, a terminal, and a file that this process
 * has read: see file_was_read. */
bool output_open(struct output *out, const char *path, struct error *err);
bool output_sync(const struct output *output, struct error *err); /* bytes are then on the disk */
void output_discard(struct output *out); /* safe after output_pass, and on a zeroed struct */

/* The outputs of a command: they appear together, when all that can fail is done. */
enum { MOST_OUTPUTS = 4 };
struct outputs {
    struct output list[MOST_OUTPUTS]; /* complete, and owned */
    int n;
};
/* Passes a complete output, which is zeroed, to a command's outputs. NULL: lets it appear at once.
 * A copy is made at once in any case. After a failure it is discarded, and no temporary file is
 * left. */
bool output_pass(struct output *output, struct outputs *outputs, struct error *err);
/* Finds the name by which the output of a path can be read before it is committed; NULL: it is none
 * of them. Fails only where the system does. */
bool outputs_readable(const struct outputs *outputs, const char *path, const char **out,
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
/* Refuses an output that cannot be opened, before the work begins. Leaves no file. NULL: none. */
bool output_can_open(const char *path, struct error *err);

/* ---- disk.c: room on the disk ---- */

/* Refuses a disk that has no room for so many bytes more, before hours of rendering are lost. */
bool output_fits(int descriptor, const char *path, uint64_t needed, struct error *err);
/* Reserves the blocks of a large file, so that they lie together, and a full disk shows before the
 * work begins. Returns false with errno where the disk is too full; true, too, where a file system
 * cannot reserve, or a file is small. */
bool output_reserve(const struct output *output, uint64_t length);

/* ---- paths.c: the names of files that a command writes ---- */

/* Returns the default name of an output: that of a file without its folder, and with another
 * ending. Allocated; NULL: no memory. */
char *output_name(const char *path, const char *ending, struct error *err);
/* Finds the ending of a name in a list as ".png", ".tif", NULL, in capitals or small letters. *out
 * is its index; -1: the name has no ending, as "-" and /dev/stdout. Refuses any other ending. */
bool output_ending(const char *path, const char *const *endings, int *out, struct error *err);
bool output_is_standard(const char *path); /* true of "-", standard output */
bool output_is_stream(const char *path);   /* true of "-", and of what exists and is no file */

/* ---- folder.c: a folder for files that nobody keeps ---- */

struct folder {
    char path[4096]; /* Linux takes no longer one; "": there is none */
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

/* ---- Inside this room ---- */

/* output.c: syncs the folder of a path, so that its new name outlives a crash of the machine. The
 * file is whole in any case, so a failure is none of the output. */
void folder_sync(const char *path);

/* temporary.c: fills out->descriptor, temporary and named with a new file in the folder of a path.
 * Where the file system can, the file has no name, so that nothing stays behind if the program is
 * killed. Otherwise its name is .NAME.PID.N.tmp, which guard_remove knows. Returns false with
 * errno.
 */
bool temporary_create(struct output *out, const char *path, mode_t mode);
/* Gives the file the path's name, in place of any file of that name. Returns false with errno. */
bool temporary_name(struct output *out, const char *path);
void temporary_remove(struct output *out); /* its name; the descriptor stays open */

#endif
