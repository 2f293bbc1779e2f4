/* SPDX-License-Identifier: MIT */
/* Large files on their way to the disk. What the system has not written when the file is complete,
 * the end of the program waits for; and what it keeps in memory, other programs miss. */
#define _GNU_SOURCE /* fallocate */
#include <fcntl.h>
#include <sys/statvfs.h>

#include "data/output/output.h"

/* So many bytes of a file stay in memory until the end: a small file is likely to be read next. */
static const uint64_t kept_bytes = (uint64_t)32 << 20;

/* Linux begins to write what has changed there, and forgets what has been written. The advice
 * changes no byte, so that nothing is lost where it is not taken. */
static void advise(const struct output *output, const struct output_piece *piece)
{
    posix_fadvise(output->descriptor, (off_t)piece->at, (off_t)piece->length, POSIX_FADV_DONTNEED);
}

/* Some file systems do not report their size. */
bool output_fits(int descriptor, const char *path, uint64_t needed, struct error *err)
{
    struct statvfs disk;
    if (fstatvfs(descriptor, &disk) != 0 || disk.f_blocks == 0 || disk.f_frsize == 0 ||
        needed / disk.f_frsize <= disk.f_bavail)
        return true;
    return error_failed(err, "%s: needs %.4g MB, the disk has %.4g MB left", path,
                        1e-6 * (double)needed,
                        1e-6 * (double)disk.f_bavail * (double)disk.f_frsize);
}

/* C libraries make up for a file system that cannot reserve by writing every block: so this asks
 * Linux itself. */
bool output_reserve(const struct output *output, uint64_t length)
{
#ifdef __linux__
    int got;
    if (length <= kept_bytes)
        return true;
    UNTIL_DONE(got, fallocate(output->descriptor, 0, 0, (off_t)length));
    return got == 0 || errno == EOPNOTSUPP || errno == ENOSYS || errno == EINVAL;
#else
    (void)output, (void)length;
    return true;
#endif
}

void output_written(struct output *output, uint64_t at, uint64_t length)
{
    const struct output_piece new = {at, length};
    struct output_piece *piece = &output->pieces[output->n_pieces % LATE_PIECES];
    output->written += length;
    if (output->copied || output->written <= kept_bytes)
        return;
    if (output->n_pieces >= LATE_PIECES)
        advise(output, piece); /* is on the disk by now */
    *piece = new;
    output->n_pieces++;
    advise(output, &new);
}
