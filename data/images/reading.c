/* SPDX-License-Identifier: MIT */
/* The calls by which libtiff reads a file, or a compiled-in file. libtiff takes a read that fails
 * for the end of the file, and lack of memory for a tag that is not there: it then goes on with
 * less. So each failure is remembered here, and no picture is returned after one. */
#include <string.h>
#include <sys/stat.h>
#include <tiffio.h>

#include "data/images/inside.h"

/* ---- bytes ---- */

static ssize_t builtin_read(const struct builtin_file *file, void *out, size_t length,
                            uint64_t offset)
{
    const size_t left = offset < file->length ? file->length - (size_t)offset : 0;
    if (length > left)
        length = left;
    if (length > 0)
        memcpy(out, file->bytes + offset, length);
    return (ssize_t)length;
}

/* Returns the number of bytes, fewer at the end of the file; -1: the system failed. */
static ssize_t bytes_read(struct image_file *file, void *out, size_t length, uint64_t offset)
{
    if (file->builtin)
        return builtin_read(file->builtin, out, length, offset);
    const ssize_t got = read_at(file->descriptor, out, length, offset);
    if (got < 0 && file->cause == 0)
        file->cause = errno;
    return got;
}

bool source_bytes(const struct image *image, uint64_t offset, size_t length, void *out)
{
    return bytes_read(image->file, out, length, offset) == (ssize_t)length;
}

/* ---- libtiff's calls ---- */

static tmsize_t source_read(thandle_t handle, void *bytes, tmsize_t length)
{
    struct image_file *file = handle;
    const ssize_t got = bytes_read(file, bytes, (size_t)length, file->position);
    if (got > 0)
        file->position += (uint64_t)got;
    return got;
}

static tmsize_t source_write(thandle_t handle, void *bytes, tmsize_t length)
{
    (void)handle;
    (void)bytes;
    (void)length;
    return -1;
}

static toff_t source_size(thandle_t handle)
{
    const struct image_file *file = handle;
    return file->bytes;
}

static toff_t source_seek(thandle_t handle, toff_t offset, int whence)
{
    struct image_file *file = handle;
    const uint64_t from = whence == SEEK_CUR   ? file->position
                          : whence == SEEK_END ? file->bytes
                                               : 0;
    file->position = from + offset;
    return file->position;
}

static int source_close(thandle_t handle)
{
    (void)handle; /* image_close closes the descriptor */
    return 0;
}

/* Keeps the first error of libtiff, and prints nothing. */
static int PRINTF_LIKE(4, 0)
    keep_error(TIFF *tiff, void *data, const char *module, const char *format, va_list arguments)
{
    struct image_file *file = data;
    (void)tiff;
    (void)module;
    if (file->message[0] == '\0')
        vsnprintf(file->message, sizeof file->message, format, arguments);
    return 1;
}

/* Keeps a warning only while samples are decoded: others are about private tags. */
static int PRINTF_LIKE(4, 0)
    keep_warning(TIFF *tiff, void *data, const char *module, const char *format, va_list arguments)
{
    const struct image_file *file = data;
    return file->decoding ? keep_error(tiff, data, module, format, arguments) : 1;
}

/* ---- the source ---- */

/* Opens the file, and finds its size. */
static bool source_find(struct image *image, struct error *err)
{
    struct image_file *file = image->file;
    struct stat status = {.st_size = 0};
    if (!file_open(image->path, file->from, &file->descriptor, &file->builtin, err))
        return false;
    if (!file->builtin && fstat(file->descriptor, &status) != 0)
        return error_cause(err, file->from, errno, "cannot read %s", image->path);
    file->bytes = file->builtin ? file->builtin->length : (uint64_t)status.st_size;
    return true;
}

/* "m": the file is not mapped into memory; a file that is cut while it is mapped would end the
 * program. "c": libtiff does not split a large strip into small ones. */
bool source_open(struct image *image, struct error *err)
{
    const tmsize_t most_bytes = 1 << 30; /* of one allocation; a broken file may ask for more */
    struct image_file *file = image->file;
    if (!source_find(image, err))
        return false;
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (options == NULL)
        return memory_lacks(err, 0, "libtiff, which reads %s", image->path);
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, most_bytes);
    TIFFOpenOptionsSetErrorHandlerExtR(options, keep_error, file);
    TIFFOpenOptionsSetWarningHandlerExtR(options, keep_warning, file);
    errno = 0;
    file->tiff = TIFFClientOpenExt(image->path, "rmc", file, source_read, source_write, source_seek,
                                   source_close, source_size, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    return source_is_sound(image, err) &&
           (file->tiff != NULL || image_refuse_broken(image, -1, err));
}

/* The C library sets errno where it has no memory. Nothing sets it to 0 again but this. */
bool source_is_sound(const struct image *image, struct error *err)
{
    struct image_file *file = image->file;
    if (file->cause == 0 && errno == ENOMEM)
        file->cause = ENOMEM;
    errno = file->cause;
    return file->cause == 0 ||
           (file->cause == ENOMEM ? memory_lacks(err, 0, "libtiff, which reads %s", image->path)
                                  : error_system(err, "cannot read %s", image->path));
}
