/* SPDX-License-Identifier: MIT */
/* Writes the spectral stack: a multi-page TIFF, one page a wavelength, all directories first and
 * then all pixels, page after page, uncompressed and without gaps. Every sample so has a place that
 * is known before the first one is rendered, and rectangles may be written in any order. Behind the
 * last page lies the object map, of which only the record tells: a reader of TIFF never gets there.
 *
 * libtiff writes the directories, through callbacks on our own descriptor. Where it would write a
 * page's pixels it is handed a stand-in that is never read: the callback only moves the end of the
 * file, so that libtiff records the right offset and no blank pixels are written or kept. */
#include "stack.h"

#include <assert.h>
#include <errno.h>
#include <float.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "a stack is little-endian, and samples go into it as they lie in memory"
#endif

/* ---- the file, as libtiff sees it ---- */

/* Its address stands for the pixels of a whole page. */
struct client {
    struct stack_writer *writer;
    struct error *err;
    uint64_t position, end;
    bool failed; /* err says why */
};

/* A long write may be cut short: Linux ends it at 2 GiB, a full disk where it is full. */
static bool write_at(int descriptor, const void *bytes, size_t length, uint64_t offset)
{
    const char *at = bytes;
    while (length > 0) {
        ssize_t written = pwrite(descriptor, at, length, (off_t)offset);
        if (written < 0)
            return false;
        at += written;
        length -= (size_t)written;
        offset += (uint64_t)written;
    }
    return true;
}

static tmsize_t client_failure(struct client *client)
{
    client->failed = true;
    error_system(client->err, "%s: cannot write the stack", client->writer->output.path);
    return -1;
}

static tmsize_t client_read(thandle_t handle, void *bytes, tmsize_t length)
{
    struct client *client = handle;
    int descriptor = client->writer->output.descriptor;
    ssize_t count = pread(descriptor, bytes, (size_t)length, (off_t)client->position);
    if (count < 0)
        return client_failure(client);
    client->position += (uint64_t)count;
    return count;
}

static tmsize_t client_write(thandle_t handle, void *bytes, tmsize_t length)
{
    struct client *client = handle;
    struct stack_writer *writer = client->writer;
    if (bytes != client) {
        if (length == STACK_VERDICT && memcmp(bytes, UNFINISHED, strlen(UNFINISHED)) == 0)
            writer->verdict_offset = client->position;
        if (!write_at(writer->output.descriptor, bytes, (size_t)length, client->position))
            return client_failure(client);
    }
    client->position += (uint64_t)length;
    if (client->position > client->end)
        client->end = client->position;
    return length;
}

static toff_t client_seek(thandle_t handle, toff_t offset, int whence)
{
    struct client *client = handle;
    uint64_t base = whence == SEEK_CUR ? client->position : whence == SEEK_END ? client->end : 0;
    client->position = base + offset;
    return client->position;
}

static int client_close(thandle_t handle)
{
    (void)handle; /* the descriptor belongs to struct output */
    return 0;
}

static toff_t client_size(thandle_t handle)
{
    const struct client *client = handle;
    return client->end;
}

/* Warnings come without a client: our own private tags are no news. */
static int PRINTF_LIKE(4, 0) client_message(TIFF *tiff, void *data, const char *module,
                                            const char *format, va_list arguments)
{
    struct client *client = data;
    char message[1024];
    (void)tiff;
    (void)module;
    if (client != NULL) {
        client->failed = true;
        vsnprintf(message, sizeof message, format, arguments);
        errno = 0;
        error_system(client->err, "%s: libtiff: %s", client->writer->output.path, message);
    }
    return 1; /* said: nothing goes to standard error */
}

/* NULL on failure. */
static TIFF *open_tiff(struct client *client, const char *mode)
{
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (options == NULL) {
        error_memory(client->err);
        return NULL;
    }
    TIFFOpenOptionsSetErrorHandlerExtR(options, client_message, client);
    TIFFOpenOptionsSetWarningHandlerExtR(options, client_message, NULL);
    TIFF *tiff =
        TIFFClientOpenExt(client->writer->output.path, mode, client, client_read, client_write,
                          client_seek, client_close, client_size, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    return tiff;
}

/* True if all went well; says why not where libtiff has said nothing. tiff may be NULL. */
static bool close_tiff(TIFF *tiff, const struct client *client, bool good)
{
    if (tiff != NULL)
        TIFFClose(tiff);
    errno = 0;
    return (good && !client->failed) ||
           error_system(client->err, "%s: the stack is not whole", client->writer->output.path);
}

/* ---- the layout ---- */

/* Of a page, or behind the last one of the object map. */
static uint64_t sample_bytes(const struct stack_options *options, int page)
{
    if (page == options->n_wavelengths)
        return (uint64_t)options->map_bytes;
    return options->floating ? 4 : 2;
}

static uint64_t plane_bytes(const struct stack_options *options, int page)
{
    return (uint64_t)options->width * (uint64_t)options->height * sample_bytes(options, page);
}

static uint64_t page_bytes(const struct stack_options *options)
{
    return plane_bytes(options, 0);
}

/* What the description tells: how the stack was made, and where its object map lies. Allocated;
 * NULL: no memory. */
static char *told_lines(const struct stack_writer *writer)
{
    const char *provenance = writer->options.provenance != NULL ? writer->options.provenance : "";
    const size_t length = strlen(provenance), room = 64; /* for a key and two numbers */
    char *text = malloc(length + room);
    if (text == NULL)
        return NULL;
    memcpy(text, provenance, length + 1);
    if (writer->options.map_bytes > 0)
        snprintf(text + length, room, "object_map: %" PRIu64 " %d\n", writer->map_offset,
                 writer->options.map_bytes);
    return text;
}

static bool write_directories(TIFF *tiff, const struct stack_writer *writer, struct error *err)
{
    struct stack_options told = writer->options;
    char *lines = told_lines(writer);
    bool good = lines != NULL || error_memory(err);
    told.provenance = lines;
    for (int page = 0; good && page < told.n_wavelengths; page++)
        good = tags_set(tiff, &told, page, err) && TIFFDeferStrileArrayWriting(tiff) &&
               TIFFWriteCheck(tiff, 0, "stack") && TIFFWriteDirectory(tiff);
    free(lines);
    return good;
}

/* Gives each page its place at the end of the file, and notes it in its directory. Goes on with
 * TIFFReadDirectory: TIFFSetDirectory would walk the chain from its start for each page. */
static bool place_pages(TIFF *tiff, struct client *client)
{
    const struct stack_writer *writer = client->writer;
    tmsize_t size = (tmsize_t)page_bytes(&writer->options);
    for (int page = 0; page < writer->options.n_wavelengths; page++) {
        if (!(page == 0 ? TIFFSetDirectory(tiff, 0) : TIFFReadDirectory(tiff)) ||
            TIFFWriteRawStrip(tiff, 0, client, size) != size || !TIFFForceStrileArrayWriting(tiff))
            return false;
        writer->page_offset[page] = TIFFGetStrileOffset(tiff, 0);
    }
    return true;
}

/* Finds a full disk before hours of rendering do. Nothing is reserved: that takes as long as
 * writing where a file system cannot do it by itself. Some do not tell how large they are. */
static bool check_free_space(const struct stack_writer *writer, uint64_t needed, struct error *err)
{
    struct statvfs disk;
    if (fstatvfs(writer->output.descriptor, &disk) != 0 || disk.f_blocks == 0 ||
        disk.f_frsize == 0 || needed / disk.f_frsize <= disk.f_bavail)
        return true;
    errno = 0;
    return error_system(err, "%s: the stack takes %" PRIu64 " MB, the disk has %" PRIu64 " MB left",
                        writer->output.path, needed / 1000000,
                        (uint64_t)disk.f_bavail * disk.f_frsize / 1000000);
}

/* Writes all directories, then places all pages. What would pass the 4 GiB of a classic TIFF is
 * laid out once more, as BigTIFF; and so is what tells another place of its object map than turns
 * out. Its digits never become fewer: that ends. */
static bool lay_out(struct stack_writer *writer, struct error *err)
{
    const struct stack_options *options = &writer->options;
    struct client client = {.writer = writer, .err = err};
    TIFF *tiff = open_tiff(&client, writer->big ? "w8l" : "wl");
    bool good = tiff != NULL && write_directories(tiff, writer, err);
    client.end = (client.end + 3) / 4 * 4; /* a float page may be mapped into memory as it is */
    const int n_pages = options->n_wavelengths;
    const uint64_t map = client.end + page_bytes(options) * (uint64_t)n_pages;
    const uint64_t end = map + plane_bytes(options, n_pages);
    const bool fits = (writer->big || end <= UINT32_MAX) &&
                      (options->map_bytes == 0 || writer->map_offset == map);
    good = good && writer->verdict_offset != 0 && (!fits || place_pages(tiff, &client));
    if (!close_tiff(tiff, &client, good) || !check_free_space(writer, end, err))
        return false;
    if (ftruncate(writer->output.descriptor, fits ? (off_t)end : 0) != 0)
        return error_system(err, "%s: cannot hold %" PRIu64 " bytes", writer->output.path, end);
    writer->big = writer->big || end > UINT32_MAX;
    writer->map_offset = writer->page_offset[n_pages] = map;
    return fits || lay_out(writer, err);
}

static bool check_options(const struct stack_options *options, struct error *err)
{
    const int most_pages = 65535; /* the SHORTs of tag PageNumber */
    /* Room for directories in 63 bits; a page in tmsize_t, which is as wide as ptrdiff_t. */
    const uint64_t most_bytes = UINT64_C(1) << 62;
    int n_pages = options->n_wavelengths, width = options->width, height = options->height;
    if (n_pages < 1 || n_pages > most_pages || width < 1 || height < 1)
        return error_usage(err,
                           "a stack of %d wavelengths of %dx%d pixels is impossible; it has"
                           " 1 to %d of at least 1x1",
                           n_pages, width, height, most_pages);
    if (page_bytes(options) > PTRDIFF_MAX ||
        page_bytes(options) > most_bytes / ((uint64_t)n_pages + 1))
        return error_usage(err, "%d pages of %dx%d pixels are too many for one file", n_pages,
                           width, height);
    if (!(options->full_scale > 0 && options->full_scale <= DBL_MAX))
        return error_usage(err, "a full scale of %g is impossible; it is a positive radiance",
                           options->full_scale);
    for (int page = 0; page < n_pages; page++) {
        /* Tag 65000 takes floats. Labels have 10 digits: closer wavelengths could share one. */
        double nm = options->wavelengths_nm[page];
        double before = page > 0 ? options->wavelengths_nm[page - 1] : 0;
        if (!(nm > before * (1 + 1e-9) && nm <= (double)FLT_MAX))
            return error_usage(err,
                               "wavelength %.10g nm after %.10g nm: the wavelengths of a stack"
                               " are finite and rise from above 0",
                               nm, before);
    }
    return true;
}

bool stack_open(struct stack_writer *out, const char *path, const struct stack_options *options,
                struct error *err)
{
    *out = (struct stack_writer){.options = *options};
    if (!check_options(options, err) || !output_open(&out->output, path, err))
        return false;
    out->map_offset = page_bytes(options) * (uint64_t)options->n_wavelengths; /* nearly */
    out->page_offset = calloc((size_t)options->n_wavelengths + 1, sizeof *out->page_offset);
    if ((out->page_offset != NULL || error_memory(err)) && lay_out(out, err))
        return true;
    stack_discard(out);
    return false;
}

bool stack_write(struct stack_writer *writer, int page, int x, int y, int width, int height,
                 const void *samples, struct error *err)
{
    const struct stack_options *options = &writer->options;
    assert(page >= 0 && page < options->n_wavelengths + (options->map_bytes > 0) && x >= 0 &&
           y >= 0 && width >= 0 && height >= 0 && x <= options->width - width &&
           y <= options->height - height);
    size_t sample = (size_t)sample_bytes(options, page);
    bool together = width == options->width; /* whole rows lie together in the file too */
    size_t run = (size_t)width * sample * (together ? (size_t)height : 1);
    uint64_t pitch = (uint64_t)options->width * sample;
    uint64_t offset = writer->page_offset[page] + (uint64_t)y * pitch + (uint64_t)x * sample;
    for (int row = 0; row < (together ? 1 : height); row++)
        if (!write_at(writer->output.descriptor, (const char *)samples + (size_t)row * run, run,
                      offset + (uint64_t)row * pitch))
            return error_system(err, "%s: cannot write page %d", writer->output.path, page + 1);
    return true;
}

/* ---- the check at the end ---- */

/* The current directory describes this page and tells its place. */
static bool page_is_whole(TIFF *tiff, const struct stack_writer *writer, int page)
{
    const struct stack_options *options = &writer->options;
    uint16_t format = 0, compression = 0;
    TIFFGetField(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetField(tiff, TIFFTAG_COMPRESSION, &compression);
    return format == (options->floating ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT) &&
           compression == COMPRESSION_NONE && TIFFNumberOfStrips(tiff) == 1 &&
           TIFFScanlineSize64(tiff) == page_bytes(options) / (uint64_t)options->height &&
           TIFFStripSize64(tiff) == page_bytes(options) &&
           TIFFGetStrileByteCount(tiff, 0) == page_bytes(options) &&
           TIFFGetStrileOffset(tiff, 0) == writer->page_offset[page];
}

/* Reads every directory with libtiff, as another program would; "c" keeps it from showing a large
 * strip as many small ones. It does not know the verdict's tag: a counted array of characters. */
static bool check_file(struct stack_writer *writer, const char room[STACK_VERDICT],
                       struct error *err)
{
    int last = writer->options.n_wavelengths - 1;
    struct client client = {.writer = writer, .err = err};
    struct stat status;
    uint32_t count = 0;
    const char *text = NULL;
    if (fstat(writer->output.descriptor, &status) != 0)
        return error_system(err, "%s: cannot be examined", writer->output.path);
    client.end = (uint64_t)status.st_size;
    TIFF *tiff = open_tiff(&client, "rc");
    bool good = tiff != NULL && TIFFGetField(tiff, TAG_VERDICT, &count, &text) &&
                count == STACK_VERDICT && memcmp(text, room, STACK_VERDICT) == 0;
    for (int page = 0; good && page <= last; page++)
        good = page_is_whole(tiff, writer, page) && (page == last || TIFFReadDirectory(tiff));
    good = good && TIFFLastDirectory(tiff) &&
           writer->map_offset + plane_bytes(&writer->options, last + 1) == client.end;
    return close_tiff(tiff, &client, good);
}

/* A verdict fills its room with blanks, so that the size of the file does not depend on it. What is
 * no printable ASCII becomes '?'; what is too long loses its tail. */
bool stack_finish(struct stack_writer *writer, const char *verdict, struct error *err)
{
    char room[STACK_VERDICT];
    snprintf(room, sizeof room, "%-*.*s", STACK_VERDICT - 1, STACK_VERDICT - 1, verdict);
    for (char *at = room; *at != '\0'; at++)
        if (*at < ' ' || *at > '~')
            *at = '?';
    bool good = write_at(writer->output.descriptor, room, STACK_VERDICT, writer->verdict_offset) ||
                error_system(err, "%s: cannot write the verdict", writer->output.path);
    return good && check_file(writer, room, err);
}

/* ---- two stacks ---- */

/* Reads up to `capacity` bytes; less only at the end of the file. -1: see errno. */
static ssize_t read_at(int descriptor, char *bytes, size_t capacity, uint64_t offset)
{
    size_t length = 0;
    ssize_t got = 1;
    while (length < capacity && got > 0) {
        got = pread(descriptor, bytes + length, capacity - length, (off_t)(offset + length));
        if (got < 0)
            return -1;
        length += (size_t)got;
    }
    return (ssize_t)length;
}

/* The offset of the first byte that is not the same, UINT64_MAX where there is none. */
static bool first_difference(int one, int other, uint64_t *out)
{
    char a[65536], b[sizeof a];
    ssize_t n_a, n_b;
    *out = 0;
    do {
        n_a = read_at(one, a, sizeof a, *out);
        n_b = read_at(other, b, sizeof b, *out);
        if (n_a < 0 || n_b < 0)
            return false;
        ssize_t same = 0;
        while (same < n_a && same < n_b && a[same] == b[same])
            same++;
        *out += (uint64_t)same;
        if (same < n_a || same < n_b)
            return true;
    } while (n_a > 0);
    *out = UINT64_MAX;
    return true;
}

bool stack_compare(const struct stack_writer *writer, const char *path,
                   struct stack_difference *out, struct error *err)
{
    const struct place nowhere = {0};
    const struct stack_options *options = &writer->options;
    const struct builtin_file *builtin;
    uint64_t offset;
    int other;
    if (!file_open(path, nowhere, &other, &builtin, err))
        return false;
    if (builtin != NULL)
        return error_usage(err, "%s: is compiled in; only a file is compared", path);
    bool good = first_difference(writer->output.descriptor, other, &offset) ||
                error_system(err, "%s: cannot be compared", path);
    close(other);
    *out = (struct stack_difference){
        .compared = good, .found = good && offset != UINT64_MAX, .page = -1};
    for (int page = 0; out->found && page <= options->n_wavelengths; page++)
        if (offset >= writer->page_offset[page] &&
            offset - writer->page_offset[page] < plane_bytes(options, page)) {
            const uint64_t pixel =
                (offset - writer->page_offset[page]) / sample_bytes(options, page);
            out->in_map = page == options->n_wavelengths;
            out->page = out->in_map ? -1 : page;
            out->x = (int)(pixel % (uint64_t)options->width);
            out->y = (int)(pixel / (uint64_t)options->width);
        }
    return good;
}

/* ---- the end ---- */

bool stack_commit(struct stack_writer *writer, struct error *err)
{
    bool good = output_commit(&writer->output, err);
    stack_discard(writer);
    return good;
}

void stack_discard(struct stack_writer *writer)
{
    output_discard(&writer->output);
    free(writer->page_offset);
    *writer = (struct stack_writer){0};
}

const char *stack_library(void)
{
    return TIFFGetVersion();
}
