/* SPDX-License-Identifier: MIT */
/* Stands for the C library's sys/statvfs.h: files in memory are on no disk. */
#ifndef WASI_STATVFS_H
#define WASI_STATVFS_H

struct statvfs {
    unsigned long f_blocks, f_frsize, f_bavail;
};

static inline int fstatvfs(int descriptor, struct statvfs *out)
{
    (void)descriptor, (void)out;
    return -1;
}

#endif
