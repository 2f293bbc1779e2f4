/* SPDX-License-Identifier: MIT */
/* Only the files of the room "files" include this. */
#ifndef DATA_FILES_INSIDE_H
#define DATA_FILES_INSIDE_H

#include "data/files/files.h"

/* output.c: syncs the folder of a path, so that its new name outlives a crash of the machine. The
 * file is whole in any case, so a failure is none of the output. */
void folder_sync(const char *path);

/* temporary.c: fills out->descriptor, temporary and named with a new file in the folder of a path.
 * Where the file system can, the file has no name, so that nothing stays behind if the program is
 * killed. Otherwise its name is .NAME.PID.N.tmp, which guard_remove knows. Returns false with
 * errno.
 */
bool temporary_create(struct output *out, const char *path, mode_t mode);
/* Likewise with a file in memory, which can only be copied. Returns false, with errno as it
 * was, where the system has none. */
bool temporary_in_memory(struct output *out);
/* Gives the file the path's name, in place of any file of that name. Returns false with errno. */
bool temporary_name(struct output *out, const char *path);
void temporary_remove(struct output *out); /* its name; the descriptor stays open */

const char *temporary_folder(void); /* TMPDIR, or /tmp */

#endif
