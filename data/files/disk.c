/* SPDX-License-Identifier: MIT */
/* Room on the disk: a full disk shows before the work begins. */
#define _GNU_SOURCE /* fallocate */
#include <fcntl.h>
#include <sys/statvfs.h>

#include "data/files/files.h"

/* Some file systems do not report their size. */
bool output_fits(int descriptor, const char *path, uint64_t needed, struct error *err)
{
    struct statvfs disk;
    if (fstatvfs(descriptor, &disk) != 0 || disk.f_blocks == 0 || disk.f_frsize == 0 ||
        needed / disk.f_frsize <= disk.f_bavail)
        return true;
    errno = 0;
    return error_system(err, "%s: needs %.4g MB, the disk has %.4g MB left", path,
                        1e-6 * (double)needed,
                        1e-6 * (double)disk.f_bavail * (double)disk.f_frsize);
}

/* C libraries make up for a file system that cannot reserve by writing every block: so this asks
 * Linux itself. */
bool output_reserve(const struct output *output, uint64_t length)
{
#ifdef __linux__
    const uint64_t large = (uint64_t)32 << 20;
    int got;
    if (length <= large)
        return true;
    UNTIL_DONE(got, fallocate(output->descriptor, 0, 0, (off_t)length));
    return got == 0 || errno == EOPNOTSUPP || errno == ENOSYS || errno == EINVAL;
#else
    (void)output, (void)length;
    return true;
#endif
}
