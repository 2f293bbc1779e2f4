/* SPDX-License-Identifier: MIT */
/* The calls by which libtiff reads a file, or a compiled-in file, and writes one. libtiff takes a
 * read that fails for the end of the file, and lack of memory for a tag that is not there: it then
 * goes on with less. So each failure is remembered here, and no file is complete after one. */
#include <tiffio.h>

#include "data/images/inside.h"

/* Notes the first call that failed. */
static void note_failure(struct client *client, const char *what)
{
    if (client->cause != 0)
        return;
    client->cause = errno;
    client->failed = what;
}

ssize_t client_bytes(struct client *client, void *out, size_t length, uint64_t offset)
{
    const struct builtin_file *file = client->builtin;
    if (file) {
        const size_t left = offset < file->length ? file->length - (size_t)offset : 0;
        const size_t n = length < left ? length : left;
        if (n > 0)
            memcpy(out, file->bytes + offset, n);
        return (ssize_t)n;
    }
    const ssize_t got = read_at(client->descriptor, out, length, offset);
    if (got < 0)
        note_failure(client, "cannot be read");
    return got;
}

/* ---- libtiff's calls ---- */

static tmsize_t client_read(thandle_t handle, void *bytes, tmsize_t length)
{
    struct client *client = handle;
    const ssize_t got = client_bytes(client, bytes, (size_t)length, client->position);
    if (got > 0)
        client->position += (uint64_t)got;
    return got;
}

/* The address of the client stands for the pixels of a whole page. */
static tmsize_t client_write(thandle_t handle, void *bytes, tmsize_t length)
{
    struct client *client = handle;
    struct pages *pages = client->pages;
    if (bytes != client) {
        if (pages->room != NULL && (size_t)length == pages->room_bytes &&
            memcmp(bytes, pages->room, strlen(pages->room)) == 0)
            pages->room_offset = client->position;
        if (!bytes)
            errno = ENOMEM; /* libtiff had none for them, and goes on */
        if (!bytes || !write_at(client->descriptor, bytes, (size_t)length, client->position)) {
            note_failure(client, "cannot be written");
            return -1;
        }
    }
    client->position += (uint64_t)length;
    if (client->position > client->bytes)
        client->bytes = client->position;
    return length;
}

static toff_t client_seek(thandle_t handle, toff_t offset, int whence)
{
    struct client *client = handle;
    const uint64_t from = whence == SEEK_CUR   ? client->position
                          : whence == SEEK_END ? client->bytes
                                               : 0;
    client->position = from + offset;
    return client->position;
}

static int client_close(thandle_t handle)
{
    (void)handle; /* the descriptor belongs to the image or the output */
    return 0;
}

static toff_t client_size(thandle_t handle)
{
    const struct client *client = handle;
    return client->bytes;
}

/* Keeps the first error of libtiff, and prints nothing. Lack of memory is found by errno. */
static void PRINTF_LIKE(3, 0)
    keep_error(thandle_t handle, const char *module, const char *format, va_list arguments)
{
    struct client *client = handle;
    (void)module;
    if (client && client->message[0] == '\0' && errno != ENOMEM)
        vsnprintf(client->message, sizeof client->message, format, arguments);
}

/* Keeps a warning only while samples are decoded: others are about private tags. */
static void PRINTF_LIKE(3, 0)
    keep_warning(thandle_t handle, const char *module, const char *format, va_list arguments)
{
    const struct client *client = handle;
    if (client && client->decoding)
        keep_error(handle, module, format, arguments);
}

/* The handlers hold for the whole process, in which nothing else opens a TIFF file: before version
 * 4.5 libtiff has none for a single file. They get the client of the file. */
TIFF *client_open(struct client *client, const char *path, const char *mode)
{
    errno = 0;
    TIFFSetErrorHandler(NULL);
    TIFFSetWarningHandler(NULL);
    TIFFSetErrorHandlerExt(keep_error);
    TIFFSetWarningHandlerExt(keep_warning);
    return TIFFClientOpen(path, mode, client, client_read, client_write, client_seek, client_close,
                          client_size, NULL, NULL);
}
