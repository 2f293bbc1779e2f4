/* SPDX-License-Identifier: MIT */
/* The names of an ENVI cube's two files. Either names the other one. */
#include <string.h>
#include <strings.h>

#include "data/envi/envi.h"

static const char *const header_endings[] = {".hdr", ".HDR", NULL};
/* A data file with such an ending may have the header NAME.hdr. Any other header is FILE.hdr. */
static const char *const data_endings[] = {".img", ".dat", ".raw", ".bsq", ".bil", ".bip", NULL};

/* Returns the length of the path without its ending, if that is one of these in any case; 0: it has
 * another ending. */
static size_t length_without(const char *path, const char *const *endings)
{
    const size_t length = strlen(path);
    for (; *endings; endings++) {
        const size_t end = strlen(*endings);
        if (length > end && path[length - end - 1] != '/' &&
            strcasecmp(path + length - end, *endings) == 0)
            return length - end;
    }
    return 0;
}

/* Finds a file whose name is the first `length` bytes of the path, then one of the endings. "": no
 * file has such a name. */
static bool find_beside(const char *path, size_t length, const char *const *endings,
                        char out[ENVI_PATH], struct error *err)
{
    bool found = false;
    for (; !found && *endings; endings++)
        if (snprintf(out, ENVI_PATH, "%.*s%s", (int)length, path, *endings) < ENVI_PATH &&
            !file_is_regular(out, &found, err))
            return false;
    if (!found)
        out[0] = '\0';
    return true;
}

static bool find_header(const char *data, char out[ENVI_PATH], struct error *err)
{
    const size_t named = length_without(data, data_endings);
    return find_beside(data, strlen(data), header_endings, out, err) &&
           (out[0] != '\0' || named == 0 || find_beside(data, named, header_endings, out, err));
}

bool envi_is(const char *path, bool *out, struct error *err)
{
    char header[ENVI_PATH] = "";
    bool is_file;
    *out = length_without(path, header_endings) > 0;
    if (*out)
        return true;
    if (!file_is_regular(path, &is_file, err) || (is_file && !find_header(path, header, err)))
        return false;
    *out = header[0] != '\0';
    return true;
}

bool envi_files(const char *path, struct place from, char header[ENVI_PATH], char data[ENVI_PATH],
                struct error *err)
{
    static const char *const whole_name[] = {"", NULL};
    const size_t named = length_without(path, header_endings);
    bool is_file;
    if (named == 0) {
        snprintf(data, ENVI_PATH, "%s", path);
        return find_header(path, header, err) &&
               (header[0] != '\0' || error_at(err, from, "%s: its ENVI header has vanished", path));
    }
    snprintf(header, ENVI_PATH, "%s", path);
    if (!find_beside(path, named, whole_name, data, err) ||
        (data[0] == '\0' && !find_beside(path, named, data_endings, data, err)) ||
        !file_is_regular(path, &is_file, err))
        return false;
    if (data[0] != '\0' || !is_file) /* the reader of the header says why it is no file */
        return true;
    return error_at(err, from,
                    "%s: its data file is missing; expected %.*s, or this name with the ending"
                    " .img, .dat, .raw, .bsq, .bil or .bip; any other name may stand in place of"
                    " the header's",
                    path, (int)named, path);
}
