/* SPDX-License-Identifier: MIT */
/* The memory that a command may take. The kernel holds the limit (RLIMIT_DATA), so that libraries
 * keep it, too. Large needs are refused before they are tried, with their figure. Without
 * such a limit, as on other systems than Linux, all is allowed. */
#include <fcntl.h>
#include <stdarg.h>
#include <sys/resource.h>
#include <unistd.h>

#include "data/base/base.h"

static const double MiB = 1048576;

/* Returns the memory that counts against the limit; 0: unknown. It is the sixth number of statm, in
 * pages (proc(5)). */
static uint64_t used_bytes(void)
{
    char text[256] = "";
    int file;
    UNTIL_DONE(file, open("/proc/self/statm", O_RDONLY | O_CLOEXEC));
    if (file < 0)
        return 0;
    const ssize_t got = read_at(file, text, sizeof text - 1, 0);
    close(file);
    const char *at = text;
    for (int i = 0; got > 0 && i < 5; i++)
        at += strcspn(at, " ") + 1;
    return got > 0 ? strtoull(at, NULL, 10) * (uint64_t)sysconf(_SC_PAGESIZE) : 0;
}

static uint64_t for_stacks; /* bytes that the limit leaves out until threads start */

void memory_limit(uint64_t bytes, uint64_t stacks)
{
    struct rlimit limit;
    const uint64_t most = used_bytes() + bytes;
    if (getrlimit(RLIMIT_DATA, &limit) != 0 || (uint64_t)limit.rlim_cur <= most)
        return;
    const uint64_t above = (uint64_t)limit.rlim_cur - most; /* what the user's own limit leaves */
    limit.rlim_cur = (rlim_t)most;
    if (setrlimit(RLIMIT_DATA, &limit) == 0)
        for_stacks = stacks < above ? stacks : above;
}

void memory_allow_stacks(void)
{
    struct rlimit limit;
    if (for_stacks == 0 || getrlimit(RLIMIT_DATA, &limit) != 0)
        return;
    limit.rlim_cur += (rlim_t)for_stacks;
    setrlimit(RLIMIT_DATA, &limit);
    for_stacks = 0;
}

/* Returns the bytes that may still be allocated; UINT64_MAX: there is no limit. */
static uint64_t left_bytes(void)
{
    struct rlimit limit;
    if (getrlimit(RLIMIT_DATA, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
        return UINT64_MAX;
    const uint64_t used = used_bytes();
    return used < (uint64_t)limit.rlim_cur ? (uint64_t)limit.rlim_cur - used : 0;
}

/* ---- arrays ---- */

bool memory_lacks(struct error *err, double bytes, const char *format, ...)
{
    const bool large = bytes >= MiB / 10;
    char what[512], figure[40] = "";
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    if (bytes > 0)
        snprintf(figure, sizeof figure, large ? ": %.1f MiB" : ": %.0f bytes",
                 large ? bytes / MiB : bytes);
    return error_failed(err, "out of memory%s for %s; --memory sets the limit", figure, what);
}

/* All pointers to objects have one representation, by POSIX. */
bool memory_make(void *array, uint64_t n, size_t size)
{
    void *items = n > SIZE_MAX ? NULL : calloc(n > 0 ? (size_t)n : 1, size);
    memcpy(array, &items, sizeof items);
    return items != NULL;
}

void memory_free(void *const *items, size_t n)
{
    for (size_t i = 0; i < n; i++)
        free(items[i]);
}

bool memory_resize(void *array, size_t n, size_t size)
{
    void *items;
    memcpy(&items, array, sizeof items);
    items = n <= SIZE_MAX / size ? realloc(items, (n > 0 ? n : 1) * size) : NULL;
    if (items)
        memcpy(array, &items, sizeof items);
    return items != NULL;
}

bool memory_suffices(double bytes, struct place place, struct error *err, const char *format, ...)
{
    const double left = fmin((double)left_bytes(), (double)PTRDIFF_MAX); /* no array is longer */
    char what[512];
    va_list arguments;
    if (bytes <= left)
        return true;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return error_at(err, place,
                    "%s needs %.0f MiB of memory, and %.0f are left; --memory sets the limit", what,
                    bytes / MiB, left / MiB);
}
