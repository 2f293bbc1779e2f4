/* SPDX-License-Identifier: MIT */
/* Functions of POSIX that WebAssembly's C library lacks; each file sees this header first. */
#ifndef WASI_MISSING_H
#define WASI_MISSING_H

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

static inline uid_t geteuid(void)
{
    return 0;
}

/* Files in memory have no modes. */
static inline mode_t umask(mode_t mask)
{
    return mask;
}

static inline int fchmod(int descriptor, mode_t mode)
{
    (void)descriptor, (void)mode;
    return 0;
}

/* A program copies standard output only, which is never closed. */
static inline int dup(int descriptor)
{
    return descriptor;
}

/* There are no links: pages lack the function that this one would import. */
static inline int no_linkat(const char *from, const char *to)
{
    (void)from, (void)to;
    errno = ENOSYS;
    return -1;
}
#define linkat(from_folder, from, to_folder, to, flags) no_linkat(from, to)

static inline char *realpath(const char *path, char *out)
{
    return out ? strcpy(out, path) : strdup(path);
}

/* No other process takes the name. */
static inline char *mkdtemp(char *name)
{
    memset(name + strlen(name) - 6, '0', 6);
    return mkdir(name, 0700) == 0 ? name : NULL;
}

#endif
