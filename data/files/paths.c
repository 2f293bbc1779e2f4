/* SPDX-License-Identifier: MIT */
/* Paths: how one file names another, what a path names, and the names of files that a command
 * writes. */
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/files/files.h"

bool path_is_builtin(const char *path)
{
    return strncmp(path, BUILTIN_PREFIX, strlen(BUILTIN_PREFIX)) == 0;
}

const char *path_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

bool path_fold(char *path)
{
    char *to = path;
    bool below = *path != '/';
    for (const char *at = path; *at != '\0';) {
        const size_t length = strcspn(at, "/"), step = length + (at[length] == '/');
        const bool up = length == 2 && memcmp(at, "..", 2) == 0;
        below = below && !(up && to == path);
        if (up)
            for (to -= to > path; to > path && to[-1] != '/'; to--)
                ;
        else if (length > 0 && !(length == 1 && *at == '.')) {
            memmove(to, at, step);
            to += step;
        }
        at += step;
    }
    *to = '\0';
    return below;
}

char *file_relative(const char *base, const char *name)
{
    const bool whole = base == NULL || name[0] == '/' || path_is_builtin(name);
    size_t folder = whole ? 0 : (size_t)(path_name(base) - base);
    struct printed path = {.text = NULL};
    if (!whole && folder == 0 && path_is_builtin(base))
        folder = strlen(BUILTIN_PREFIX);
    print(&path, "%.*s%s", (int)folder, folder > 0 ? base : "", name);
    char *out = printed_end(&path);
    if (out != NULL && path_is_builtin(out))
        path_fold(out + strlen(BUILTIN_PREFIX));
    return out;
}

/* ---- what a path names ---- */

/* Fails only where the system does. Examines standard output by its descriptor. */
static bool examine(const char *path, bool *exists, struct stat *out, struct error *err)
{
    struct error failure = {.status = EXIT_AGREED};
    *exists = (output_is_standard(path) ? fstat(STDOUT_FILENO, out) : stat(path, out)) == 0;
    if (*exists)
        return true;
    error_cause(&failure, NOWHERE, "cannot examine %s", path);
    if (failure.status == EXIT_SYSTEM)
        *err = failure;
    return failure.status != EXIT_SYSTEM;
}

bool file_is_regular(const char *path, bool *out, struct error *err)
{
    struct stat status;
    bool exists = false;
    const bool done = strcmp(path, "-") == 0 || examine(path, &exists, &status, err);
    *out = exists && S_ISREG(status.st_mode);
    return done;
}

bool file_is_missing(const char *path)
{
    return !path_is_builtin(path) && access(path, F_OK) != 0 && errno == ENOENT;
}

static bool examine_folder(const char *path, bool *exists, struct stat *out, struct error *err)
{
    char folder[PATH_MAX];
    const int length = (int)(path_name(path) - path);
    *exists = false;
    return snprintf(folder, sizeof folder, "%.*s.", length, path) >= PATH_MAX ||
           examine(folder, exists, out, err);
}

/* Files that do not exist yet are one if they have one name in one folder. */
bool file_is_same(const char *a, const char *b, bool *out, struct error *err)
{
    struct stat one, other;
    bool a_is, b_is;
    *out = strcmp(a, b) == 0;
    if (*out)
        return true;
    if (!examine(a, &a_is, &one, err) || !examine(b, &b_is, &other, err))
        return false;
    if (!a_is && !b_is && strcmp(path_name(a), path_name(b)) == 0 &&
        (!examine_folder(a, &a_is, &one, err) || !examine_folder(b, &b_is, &other, err)))
        return false;
    *out = a_is && b_is && one.st_dev == other.st_dev && one.st_ino == other.st_ino;
    return true;
}

/* ---- the names of outputs ---- */

char *output_name(const char *path, const char *ending, struct error *err)
{
    const char *name = path_name(path), *dot = strrchr(name, '.');
    size_t length = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    struct printed printed = {.text = NULL};
    print(&printed, "%.*s%s", (int)length, name, ending);
    return printed_take(&printed, err);
}

bool output_is_standard(const char *path)
{
    static const char *const names[] = {"-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", NULL};
    int i = 0;
    while (names[i] && strcmp(path, names[i]) != 0)
        i++;
    return names[i] != NULL;
}

bool output_is_stream(const char *path)
{
    struct stat status;
    return output_is_standard(path) ||
           (stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode));
}
