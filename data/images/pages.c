/* SPDX-License-Identifier: MIT */
/* Writes TIFF files of uncompressed pages: first all directories, then all pixels, page after page
 * and without gaps. The place of every sample is known from the start, so that samples can be
 * written in any order.
 *
 * libtiff writes the directories, through the calls of client.c. Instead of the pixels of a page it
 * gets a pointer that nobody reads. The call only moves the end of the file: libtiff
 * records the right offset, and no blank pixels are written or kept. */
#include <assert.h>
#include <inttypes.h>
#include <sys/stat.h>
#include <tiffio.h>
#include <unistd.h>

#include "data/images/inside.h"

/* ---- places ---- */

size_t pages_pixel_bytes(const struct pages *pages, int page)
{
    return page == pages->count ? (size_t)pages->bytes_behind
                                : (size_t)pages->channels * (size_t)pages->bits / 8;
}

static uint64_t row_bytes(const struct pages *pages)
{
    return (uint64_t)pages->width * pages_pixel_bytes(pages, 0);
}

static uint64_t page_bytes(const struct pages *pages)
{
    return row_bytes(pages) * (uint64_t)pages->height;
}

uint64_t pages_offset(const struct pages *pages, int page)
{
    return pages->first + (uint64_t)page * page_bytes(pages);
}

uint64_t pages_end(const struct pages *pages)
{
    return pages_offset(pages, pages->count) +
           (uint64_t)pages->width * (uint64_t)pages->height * (uint64_t)pages->bytes_behind;
}

/* ---- libtiff ---- */

static bool put(const struct pages *pages, const void *bytes, size_t length, uint64_t offset,
                struct error *err)
{
    return write_at(pages->output.descriptor, bytes, length, offset) ||
           error_system(err, "%s: cannot be written", pages->output.holder);
}

/* Writes samples with the lowest byte first, as all files have them. size: bytes of a sample. */
static bool put_samples(const struct pages *pages, const char *samples, size_t length, size_t size,
                        uint64_t offset, struct error *err)
{
    char stored[1 << 14];
    if (size == 1 || !machine_is_big_endian())
        return put(pages, samples, length, offset, err);
    for (size_t at = 0, n; at < length; at += n) {
        n = length - at < sizeof stored ? length - at : sizeof stored;
        store_numbers(stored, samples + at, size, n);
        if (!put(pages, stored, n, offset + at, err))
            return false;
    }
    return true;
}

/* Returns true if nothing has failed. Sets an error if libtiff has given none. tiff may be NULL.
 * For lack of memory libtiff may leave out a tag, and say nothing: the C library has set errno
 * then. */
static bool close_tiff(TIFF *tiff, const struct client *client, bool good, struct error *err)
{
    const char *path = client->pages->output.path;
    if (tiff != NULL)
        TIFFClose(tiff);
    if (client->failed != NULL) {
        errno = client->cause;
        return error_system(err, "%s: %s", client->pages->output.holder, client->failed);
    }
    if (client->message[0] != '\0')
        return error_failed(err, "%s: libtiff: %s", path, client->message);
    if (client->cause == ENOMEM || errno == ENOMEM)
        return memory_lacks(err, 0, "libtiff, which writes %s", path);
    return good || error_failed(err, "%s: the written file is not complete", path);
}

/* ---- the layout ---- */

static int sample_format(const struct pages *pages)
{
    return pages->bits == 32 ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT;
}

/* Sets no Orientation: ImageJ would then ignore the number of images. */
static bool set_format(TIFF *tiff, const struct pages *pages, int page)
{
    return TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_PAGE) &&
           TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, pages->width) &&
           TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, pages->height) &&
           TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, pages->bits) &&
           TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE) &&
           TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                        pages->channels == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK) &&
           TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, pages->channels) &&
           TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, pages->height) &&
           TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) &&
           TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, sample_format(pages)) &&
           TIFFSetField(tiff, TIFFTAG_PAGENUMBER, page, pages->count);
}

static bool write_directories(TIFF *tiff, const struct pages *pages, page_tags *set_tags,
                              const void *of, struct error *err)
{
    bool good = true;
    for (int page = 0; good && page < pages->count; page++)
        good = set_format(tiff, pages, page) && set_tags(tiff, of, page, err) &&
               TIFFDeferStrileArrayWriting(tiff) && TIFFWriteCheck(tiff, 0, PROGRAM) &&
               TIFFWriteDirectory(tiff);
    return good;
}

/* Lets libtiff append a page in pieces: on 32 bits tmsize_t ends at 2 GiB. */
static bool place_page(TIFF *tiff, struct client *client)
{
    const uint64_t most = 1 << 30;
    for (uint64_t left = page_bytes(client->pages), n; left > 0; left -= n) {
        n = left < most ? left : most;
        if (TIFFWriteRawStrip(tiff, 0, client, (tmsize_t)n) != (tmsize_t)n)
            return false;
    }
    return true;
}

/* Places each page at the end of the file, and records the offset in its directory. Calls
 * TIFFReadDirectory for the next page: TIFFSetDirectory would walk the chain from its start. */
static bool place_pages(TIFF *tiff, struct client *client)
{
    const struct pages *pages = client->pages;
    for (int page = 0; page < pages->count; page++)
        if (!(page == 0 ? TIFFSetDirectory(tiff, 0) : TIFFReadDirectory(tiff)) ||
            !place_page(tiff, client) || !TIFFForceStrileArrayWriting(tiff) ||
            TIFFGetStrileOffset(tiff, 0) != pages_offset(pages, page))
            return false;
    return true;
}

/* Writes all directories, then places all pages. Starts again, as BigTIFF, if the file would pass
 * the 4 GiB of a classic TIFF. Starts again, too, if the tags record another offset than the pages
 * get: with the right offset they may be longer. Offsets only grow, so that this ends. */
static bool lay_out(struct pages *pages, page_tags *set_tags, const void *of, struct error *err)
{
    struct client client = {.pages = pages, .descriptor = pages->output.descriptor};
    TIFF *tiff = client_open(&client, pages->output.path, pages->big ? "w8l" : "wl");
    bool good = tiff != NULL && write_directories(tiff, pages, set_tags, of, err) &&
                (pages->room == NULL || pages->room_offset != 0);
    client.bytes = (client.bytes + 3) / 4 * 4; /* a program may map a page of floats into memory */
    const bool recorded = pages->bytes_behind == 0 || pages->first == client.bytes;
    pages->first = client.bytes;
    const uint64_t end = pages_end(pages);
    const bool fits = (pages->big || end <= UINT32_MAX) && recorded;
    good = good && (!fits || place_pages(tiff, &client));
    if (!close_tiff(tiff, &client, good, err))
        return false;
    int resized;
    UNTIL_DONE(resized, ftruncate(pages->output.descriptor, fits ? (off_t)end : 0));
    if (resized != 0 || (fits && !output_reserve(&pages->output, end)))
        return error_system(err, "%s: cannot hold %" PRIu64 " bytes", pages->output.holder, end);
    pages->big = pages->big || end > UINT32_MAX;
    return fits || lay_out(pages, set_tags, of, err);
}

/* 63 bits hold the directories, the pages and the bytes behind: 2^16 pages of 2^37 pixels of 2^4
 * bytes would need 2^57. */
bool pages_open(struct pages *pages, const char *path, page_tags *set_tags, const void *of,
                struct error *err)
{
    if (output_open(&pages->output, path, err) && lay_out(pages, set_tags, of, err))
        return true;
    output_discard(&pages->output);
    return false;
}

/* Whole rows of a page lie together in the file. */
bool pages_write(const struct pages *pages, const struct page_rectangle *to, const void *samples,
                 struct error *err)
{
    const size_t pixel = pages_pixel_bytes(pages, to->page);
    const bool together = to->width == pages->width;
    const size_t length = (size_t)to->width * pixel * (together ? (size_t)to->height : 1);
    const bool numbers = to->page < pages->count && !pages->as_stored;
    const char *from = samples;
    assert(to->page >= 0 && to->page < pages->count + (pages->bytes_behind > 0) && to->x >= 0 &&
           to->y >= 0 && to->width >= 0 && to->height >= 0 && to->x <= pages->width - to->width &&
           to->y <= pages->height - to->height);
    for (int y = to->y; y < to->y + (together ? 1 : to->height); y++, from += length) {
        const uint64_t first = (uint64_t)y * (uint64_t)pages->width + (uint64_t)to->x;
        if (!put_samples(pages, from, length, numbers ? (size_t)pages->bits / 8 : 1,
                         pages_offset(pages, to->page) + first * pixel, err))
            return false;
    }
    return true;
}

/* ---- the check at the end ---- */

/* Returns true if the current directory describes this page and has its offset. */
static bool page_is_whole(TIFF *tiff, const struct pages *pages, int page)
{
    uint16_t format = 0, compression = 0;
    TIFFGetField(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetField(tiff, TIFFTAG_COMPRESSION, &compression);
    return format == sample_format(pages) && compression == COMPRESSION_NONE &&
           TIFFNumberOfStrips(tiff) == 1 && TIFFScanlineSize64(tiff) == row_bytes(pages) &&
           TIFFStripSize64(tiff) == page_bytes(pages) &&
           TIFFGetStrileByteCount(tiff, 0) == page_bytes(pages) &&
           TIFFGetStrileOffset(tiff, 0) == pages_offset(pages, page);
}

/* Returns true if the room holds the text. libtiff does not know the room's tag: it returns a
 * counted array of characters. */
static bool room_is_filled(TIFF *tiff, const struct pages *pages, const char *room)
{
    uint32_t count = 0;
    const char *text = NULL;
    return TIFFGetField(tiff, pages->room_tag, &count, &text) && count == pages->room_bytes &&
           memcmp(text, room, count) == 0;
}

/* Reads every directory with libtiff, as another program would. */
bool pages_finish(struct pages *pages, const char *room, struct error *err)
{
    const int last = pages->count - 1;
    struct client client = {.pages = pages, .descriptor = pages->output.descriptor};
    struct stat status;
    if (room != NULL && !put(pages, room, pages->room_bytes, pages->room_offset, err))
        return false;
    if (fstat(pages->output.descriptor, &status) != 0)
        return error_system(err, "%s: cannot be examined", pages->output.path);
    client.bytes = (uint64_t)status.st_size;
    TIFF *tiff = client_open(&client, pages->output.path, "rc");
    bool good = tiff != NULL && (room == NULL || room_is_filled(tiff, pages, room));
    for (int page = 0; good && page <= last; page++)
        good = page_is_whole(tiff, pages, page) && (page == last || TIFFReadDirectory(tiff));
    good = good && TIFFLastDirectory(tiff) && pages_end(pages) == client.bytes;
    return close_tiff(tiff, &client, good, err);
}
