/* SPDX-License-Identifier: MIT */
/* Writes the spectral stack: a multi-page TIFF, one page a wavelength, all directories first and
 * then all pixels, page after page, uncompressed and without gaps. Every sample so has a place that
 * is known before the first one is rendered, and rectangles may be written in any order.
 *
 * libtiff writes the directories, through callbacks on our own descriptor. Where it would write a
 * page's pixels it is handed a stand-in that is never read: the callback only moves the end of the
 * file, so that libtiff records the right offset and no blank pixels are written or kept in memory.
 *
 * Tags: TIFF 6.0; OME-XML 2016-06 for tifffile and Bio-Formats; GDAL_METADATA as in the GTiff
 * driver; IJMetadata as ImageJ's TiffEncoder; 65000 and 65111 as in the ODSI-DB of retinal images.
 */
#include "spectral.h"

#include <assert.h>
#include <errno.h>
#include <float.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <tiffio.h>
#include <unistd.h>

#define RADIANCE_UNIT "W sr-1 m-2 nm-1 (relative)"
#define UNFINISHED "not finished"

enum {
    TAG_IMAGEJ_SIZES = 50838,
    TAG_IMAGEJ_TEXTS = 50839,
    TAG_WAVELENGTHS = 65000,
    TAG_VERDICT = 65111,
    MOST_PAGES = 65535, /* the SHORTs of tag PageNumber */
    PIXEL_ALIGNMENT = 4 /* a float page may be mapped into memory as it is */
};

/* TIFFFieldInfo takes char *, not const char *: hence no string literals. */
static char gdal_name[] = "GDALMetadata";
static char imagej_sizes_name[] = "IJMetadataByteCounts";
static char imagej_texts_name[] = "IJMetadata";
static char wavelengths_name[] = "Wavelengths";
static char verdict_name[] = "Verdict";
static const TIFFFieldInfo private_fields[] = {
    {TIFFTAG_GDAL_METADATA, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_ASCII, FIELD_CUSTOM, 1, 0,
     gdal_name},
    {TAG_IMAGEJ_SIZES, TIFF_VARIABLE2, TIFF_VARIABLE2, TIFF_LONG, FIELD_CUSTOM, 1, 1,
     imagej_sizes_name},
    {TAG_IMAGEJ_TEXTS, TIFF_VARIABLE2, TIFF_VARIABLE2, TIFF_BYTE, FIELD_CUSTOM, 1, 1,
     imagej_texts_name},
    {TAG_WAVELENGTHS, TIFF_VARIABLE2, TIFF_VARIABLE2, TIFF_FLOAT, FIELD_CUSTOM, 1, 1,
     wavelengths_name},
    {TAG_VERDICT, TIFF_VARIABLE, TIFF_VARIABLE, TIFF_ASCII, FIELD_CUSTOM, 1, 0, verdict_name},
};
enum { PRIVATE_FIELDS = sizeof private_fields / sizeof private_fields[0] };

/* ---- the file, as libtiff sees it ---- */

struct client {
    int descriptor;
    uint64_t position, end;
    uint64_t room;        /* where the verdict's text lies; 0: not written yet */
    char blank;           /* its address stands for the pixels of a whole page */
    int error_number;     /* errno of the first failed call; 0: none */
    char message[1024];   /* libtiff's first complaint */
};

/* A verdict fills its room with blanks, so that the file's size and bytes elsewhere do not depend
 * on it. What is no printable ASCII becomes '?'; what is too long loses its tail. */
static void fill_room(const char *verdict, char room[STACK_VERDICT])
{
    size_t length = 0;
    for (; verdict[length] != '\0' && length < STACK_VERDICT - 1; length++)
        room[length] = verdict[length] >= ' ' && verdict[length] <= '~' ? verdict[length] : '?';
    memset(room + length, ' ', STACK_VERDICT - 1 - length);
    room[STACK_VERDICT - 1] = '\0';
}

static bool write_at(int descriptor, const void *bytes, size_t length, uint64_t offset)
{
    const char *at = bytes;
    while (length > 0) {
        ssize_t written = pwrite(descriptor, at, length, (off_t)offset);
        if (written < 0 && errno == EINTR)
            continue;
        if (written < 0)
            return false;
        if (written == 0) {
            errno = ENOSPC;
            return false;
        }
        at += written;
        length -= (size_t)written;
        offset += (uint64_t)written;
    }
    return true;
}

static tmsize_t client_failure(struct client *client)
{
    if (client->error_number == 0)
        client->error_number = errno;
    return -1;
}

static tmsize_t client_read(thandle_t handle, void *bytes, tmsize_t length)
{
    struct client *client = handle;
    tmsize_t done = 0;
    while (done < length) {
        ssize_t count = pread(client->descriptor, (char *)bytes + done, (size_t)(length - done),
                              (off_t)client->position);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            return client_failure(client);
        if (count == 0)
            break;
        done += count;
        client->position += (uint64_t)count;
    }
    return done;
}

static tmsize_t client_write(thandle_t handle, void *bytes, tmsize_t length)
{
    struct client *client = handle;
    if (bytes != &client->blank) {
        char room[STACK_VERDICT];
        fill_room(UNFINISHED, room);
        if (length == STACK_VERDICT && memcmp(bytes, room, STACK_VERDICT) == 0)
            client->room = client->position;
        if (!write_at(client->descriptor, bytes, (size_t)length, client->position))
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

static int PRINTF_LIKE(4, 0) client_error(TIFF *tiff, void *data, const char *module,
                                          const char *format, va_list arguments)
{
    struct client *client = data;
    (void)tiff;
    (void)module;
    if (client->message[0] == '\0')
        vsnprintf(client->message, sizeof client->message, format, arguments);
    return 1; /* said: nothing goes to standard error */
}

static int PRINTF_LIKE(4, 0) client_warning(TIFF *tiff, void *data, const char *module,
                                            const char *format, va_list arguments)
{
    (void)tiff;
    (void)data;
    (void)module;
    (void)format;
    (void)arguments;
    return 1; /* our own private tags are no news */
}

/* A libtiff call has failed: says why. */
static bool tiff_failure(const struct client *client, const char *path, struct error *err)
{
    errno = client->error_number;
    if (client->message[0] == '\0')
        return error_system(err, "%s: cannot write the stack", path);
    return error_system(err, "%s: libtiff: %s", path, client->message);
}

/* NULL on failure. */
static TIFF *open_tiff(struct client *client, const char *path, const char *mode,
                       struct error *err)
{
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (options == NULL) {
        error_memory(err);
        return NULL;
    }
    TIFFOpenOptionsSetErrorHandlerExtR(options, client_error, client);
    TIFFOpenOptionsSetWarningHandlerExtR(options, client_warning, client);
    TIFF *tiff = TIFFClientOpenExt(path, mode, client, client_read, client_write, client_seek,
                                   client_close, client_size, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    if (tiff == NULL)
        tiff_failure(client, path, err);
    return tiff;
}

/* ---- texts ---- */

/* A text that grows as it is printed into. */
struct memory {
    FILE *stream;
    char *bytes;
    size_t length;
};

static bool memory_open(struct memory *memory, struct error *err)
{
    *memory = (struct memory){0};
    memory->stream = open_memstream(&memory->bytes, &memory->length);
    return memory->stream != NULL || error_memory(err);
}

/* The bytes are the caller's from here on, also after a failure. */
static bool memory_close(struct memory *memory, struct error *err)
{
    bool good = !ferror(memory->stream);
    if (fclose(memory->stream) != 0)
        good = false;
    return good || error_memory(err);
}

enum {
    NAME_SIZE = 32, /* of a number: sign, 17 digits, point, e+308 */
    LINE_SIZE = 128 /* of a line with a number in it */
};

static void number_name(double number, char name[NAME_SIZE])
{
    snprintf(name, NAME_SIZE, "%.10g", number);
}

/* The shortest decimal that reads back as the same double. */
static void exact_name(double number, char name[NAME_SIZE])
{
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(name, NAME_SIZE, "%.*g", digits, number);
        if (strtod(name, NULL) == number)
            return;
    }
}

/* The bytes of the UTF-8 character at `at`, or 0 where there is none (Unicode, table 3-7). */
static int utf8_length(const unsigned char *at)
{
    int length = at[0] < 0x80 ? 1 : at[0] < 0xc2 ? 0 : at[0] < 0xe0 ? 2 : at[0] < 0xf0 ? 3
               : at[0] < 0xf5 ? 4 : 0;
    if ((at[0] == 0xe0 && at[1] < 0xa0) || (at[0] == 0xed && at[1] > 0x9f)
        || (at[0] == 0xf0 && at[1] < 0x90) || (at[0] == 0xf4 && at[1] > 0x8f))
        return 0;
    for (int i = 1; i < length; i++)
        if ((at[i] & 0xc0) != 0x80)
            return 0;
    return length;
}

/* What XML cannot hold (control characters, bytes that are no UTF-8) becomes '?'. */
static void put_escaped(FILE *stream, const char *text)
{
    const unsigned char *at = (const unsigned char *)text;
    while (*at != '\0') {
        int length = utf8_length(at);
        if (*at == '&')
            fputs("&amp;", stream);
        else if (*at == '<')
            fputs("&lt;", stream);
        else if (*at == '>')
            fputs("&gt;", stream);
        else if (*at == '"')
            fputs("&quot;", stream);
        else if (length == 0 || *at == 0x7f || (*at < ' ' && *at != '\n' && *at != '\t'))
            putc('?', stream);
        else
            fwrite(at, 1, (size_t)length, stream);
        at += length > 0 ? length : 1;
    }
}

/* How samples become radiances, in one line of ASCII. */
static void scale_line(const struct stack_options *options, char line[LINE_SIZE])
{
    char full_scale[NAME_SIZE];
    exact_name(options->full_scale, full_scale);
    if (options->floating)
        snprintf(line, LINE_SIZE, "radiance = sample " RADIANCE_UNIT);
    else
        snprintf(line, LINE_SIZE, "radiance = count x %s / 65535 " RADIANCE_UNIT, full_scale);
}

static void put_description(FILE *stream, const struct stack_options *options)
{
    char full_scale[NAME_SIZE], line[LINE_SIZE];
    exact_name(options->full_scale, full_scale);
    scale_line(options, line);
    fputs("program: spectral " SPECTRAL_VERSION "\n", stream);
    if (options->scene != NULL) {
        fputs("scene: ", stream);
        put_escaped(stream, options->scene);
        putc('\n', stream);
    }
    fprintf(stream, "full_scale: %s\nscale: %s\n", full_scale, line);
    if (options->provenance != NULL)
        put_escaped(stream, options->provenance);
}

/* Begins with < and ends with >: readers know OME-XML by that. */
static bool ome_text(const struct stack_options *options, char **text, struct error *err)
{
    struct memory memory;
    if (!memory_open(&memory, err))
        return false;
    FILE *stream = memory.stream;
    fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
          "<OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\""
          " xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\""
          " xsi:schemaLocation=\"http://www.openmicroscopy.org/Schemas/OME/2016-06"
          " http://www.openmicroscopy.org/Schemas/OME/2016-06/ome.xsd\">\n"
          "<Image ID=\"Image:0\" Name=\"", stream);
    put_escaped(stream, options->scene != NULL ? options->scene : "stack");
    fputs("\"><Description>", stream);
    put_description(stream, options);
    fprintf(stream, "</Description>\n<Pixels ID=\"Pixels:0\" DimensionOrder=\"XYCZT\" Type=\"%s\""
            " BigEndian=\"false\" SizeX=\"%d\" SizeY=\"%d\" SizeC=\"%d\" SizeZ=\"1\""
            " SizeT=\"1\">\n", options->floating ? "float" : "uint16", options->width,
            options->height, options->n_wavelengths);
    for (int page = 0; page < options->n_wavelengths; page++) {
        char name[NAME_SIZE];
        number_name(options->wavelengths_nm[page], name);
        fprintf(stream, "<Channel ID=\"Channel:0:%d\" Name=\"%s nm\" SamplesPerPixel=\"1\""
                " EmissionWavelength=\"%s\" EmissionWavelengthUnit=\"nm\"/>\n", page, name, name);
    }
    for (int page = 0; page < options->n_wavelengths; page++)
        fprintf(stream, "<TiffData FirstC=\"%d\" FirstZ=\"0\" FirstT=\"0\" IFD=\"%d\""
                " PlaneCount=\"1\"/>\n", page, page);
    fputs("</Pixels></Image></OME>", stream);
    bool good = memory_close(&memory, err);
    *text = memory.bytes;
    return good;
}

/* The local spacing: the mean of the distances to the neighbours. 0: there is none. */
static double spacing_nm(const struct stack_options *options, int page)
{
    int before = page > 0 ? page - 1 : page;
    int after = page + 1 < options->n_wavelengths ? page + 1 : page;
    if (after == before)
        return 0;
    return (options->wavelengths_nm[after] - options->wavelengths_nm[before]) / (after - before);
}

static bool gdal_text(const struct stack_options *options, int page, char **text,
                      struct error *err)
{
    struct memory memory;
    if (!memory_open(&memory, err))
        return false;
    FILE *stream = memory.stream;
    char name[NAME_SIZE], micrometres[NAME_SIZE], scale[NAME_SIZE];
    double spacing = spacing_nm(options, page);
    number_name(options->wavelengths_nm[page], name);
    number_name(options->wavelengths_nm[page] / 1000, micrometres);
    exact_name(options->floating ? 1 : options->full_scale / 65535, scale);
    fprintf(stream, "<GDALMetadata>\n<Item name=\"CENTRAL_WAVELENGTH_UM\" sample=\"0\""
            " domain=\"IMAGERY\">%s</Item>\n", micrometres);
    if (spacing > 0) {
        number_name(spacing / 1000, micrometres);
        fprintf(stream, "<Item name=\"FWHM_UM\" sample=\"0\" domain=\"IMAGERY\">%s</Item>\n",
                micrometres);
    }
    fprintf(stream, "<Item name=\"wavelength\" sample=\"0\">%s</Item>\n"
            "<Item name=\"wavelength_units\" sample=\"0\">Nanometers</Item>\n"
            "<Item name=\"DESCRIPTION\" sample=\"0\" role=\"description\">%s nm</Item>\n"
            "<Item name=\"OFFSET\" sample=\"0\" role=\"offset\">0</Item>\n"
            "<Item name=\"SCALE\" sample=\"0\" role=\"scale\">%s</Item>\n"
            "<Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">" RADIANCE_UNIT "</Item>\n"
            "</GDALMetadata>\n", name, name, scale);
    bool good = memory_close(&memory, err);
    *text = memory.bytes;
    return good;
}

static void put_long(FILE *stream, uint32_t number)
{
    for (int shift = 0; shift < 32; shift += 8)
        putc((int)(number >> shift & 0xff), stream);
}

/* The bytes that ASCII takes as UTF-16. */
static uint32_t put_utf16(FILE *stream, const char *ascii)
{
    uint32_t length = 0;
    for (; *ascii != '\0'; ascii++, length += 2) {
        putc(*ascii, stream);
        putc(0, stream);
    }
    return length;
}

/* ImageJ's IJMetadata: the magic number, a table of {type, count} pairs, then all strings, as
 * UTF-16 without terminators; and beside it the sizes in bytes of the table and of each string.
 * Numbers are little-endian like the file, which turns "IJIJ", "info" and "labl" around. */
static bool imagej_text(const struct stack_options *options, uint32_t *sizes,
                        struct memory *text, struct error *err)
{
    char line[LINE_SIZE];
    if (!memory_open(text, err))
        return false;
    fputs("JIJI" "ofni", text->stream);
    put_long(text->stream, 1);
    fputs("lbal", text->stream);
    put_long(text->stream, (uint32_t)options->n_wavelengths);
    sizes[0] = 20;
    scale_line(options, line);
    sizes[1] = put_utf16(text->stream, line);
    for (int page = 0; page < options->n_wavelengths; page++) {
        number_name(options->wavelengths_nm[page], line);
        sizes[page + 2] = put_utf16(text->stream, line) + put_utf16(text->stream, " nm");
    }
    return memory_close(text, err);
}

/* ---- tags ---- */

/* Sets a private tag that has a counted array. A later libtiff may know the tag itself; the check
 * makes sure that it takes its arguments as our own definition does. */
static bool set_array(TIFF *tiff, uint32_t tag, uint32_t count, const void *values)
{
    const TIFFField *field = TIFFFieldWithTag(tiff, tag);
    return field != NULL && TIFFFieldPassCount(field)
           && TIFFFieldWriteCount(field) == TIFF_VARIABLE2
           && TIFFSetField(tiff, tag, count, values);
}

static bool set_imagej(TIFF *tiff, const struct stack_options *options, struct error *err)
{
    size_t count = (size_t)options->n_wavelengths + 2;
    struct memory text = {0};
    uint32_t *sizes = malloc(count * sizeof *sizes);
    bool good = sizes != NULL || error_memory(err);
    good = good && imagej_text(options, sizes, &text, err);
    if (good && text.length > UINT32_MAX)
        good = error_system(err, "the names of %d pages are too long", options->n_wavelengths);
    good = good && set_array(tiff, TAG_IMAGEJ_SIZES, (uint32_t)count, sizes)
           && set_array(tiff, TAG_IMAGEJ_TEXTS, (uint32_t)text.length, text.bytes);
    free(sizes);
    free(text.bytes);
    return good;
}

static bool set_wavelengths(TIFF *tiff, const struct stack_options *options, struct error *err)
{
    size_t count = (size_t)options->n_wavelengths;
    float *wavelengths = malloc(count * sizeof *wavelengths);
    if (wavelengths == NULL)
        return error_memory(err);
    for (size_t page = 0; page < count; page++)
        wavelengths[page] = (float)options->wavelengths_nm[page];
    bool good = set_array(tiff, TAG_WAVELENGTHS, (uint32_t)count, wavelengths);
    free(wavelengths);
    return good;
}

/* The tags that only the first page has. */
static bool set_first_page(TIFF *tiff, const struct stack_options *options, struct error *err)
{
    char room[STACK_VERDICT];
    char *description = NULL;
    fill_room(UNFINISHED, room);
    bool good = ome_text(options, &description, err)
                && TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, description)
                && TIFFSetField(tiff, TIFFTAG_SOFTWARE, "spectral " SPECTRAL_VERSION)
                && set_imagej(tiff, options, err) && set_wavelengths(tiff, options, err)
                && TIFFSetField(tiff, TAG_VERDICT, room);
    free(description);
    return good;
}

static bool set_later_page(TIFF *tiff, const char *wavelength)
{
    char line[LINE_SIZE];
    snprintf(line, sizeof line, "wavelength_nm=%s", wavelength);
    return TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, line);
}

/* No Orientation: ImageJ would ignore the number of images. */
static bool set_page(TIFF *tiff, const struct stack_options *options, int page, struct error *err)
{
    char wavelength[NAME_SIZE], name[NAME_SIZE + 3];
    char *gdal = NULL;
    number_name(options->wavelengths_nm[page], wavelength);
    snprintf(name, sizeof name, "%s nm", wavelength);
    bool good =
        TIFFMergeFieldInfo(tiff, private_fields, PRIVATE_FIELDS) == 0
        && TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, (uint32_t)FILETYPE_PAGE)
        && TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, (uint32_t)options->width)
        && TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, (uint32_t)options->height)
        && TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, options->floating ? 32 : 16)
        && TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE)
        && TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK)
        && TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1)
        && TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, (uint32_t)options->height)
        && TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG)
        && TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT,
                        options->floating ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT)
        && TIFFSetField(tiff, TIFFTAG_PAGENAME, name)
        && TIFFSetField(tiff, TIFFTAG_PAGENUMBER, page, options->n_wavelengths)
        && gdal_text(options, page, &gdal, err) && TIFFSetField(tiff, TIFFTAG_GDAL_METADATA, gdal)
        && (page == 0 ? set_first_page(tiff, options, err) : set_later_page(tiff, wavelength));
    free(gdal);
    return good;
}

/* ---- the layout ---- */

static uint64_t page_bytes(const struct stack_options *options)
{
    return (uint64_t)options->width * (uint64_t)options->height * (options->floating ? 4 : 2);
}

static uint64_t stack_bytes(const struct stack_options *options)
{
    return page_bytes(options) * (uint64_t)options->n_wavelengths;
}

/* Every directory, without the places of the pixels. */
static bool write_directories(TIFF *tiff, const struct stack_options *options, struct error *err)
{
    for (int page = 0; page < options->n_wavelengths; page++)
        if (!set_page(tiff, options, page, err) || !TIFFDeferStrileArrayWriting(tiff)
            || !TIFFWriteCheck(tiff, 0, "stack") || !TIFFWriteDirectory(tiff))
            return false;
    return true;
}

/* Gives each page its place at the end of the file, and notes it in its directory. Goes on with
 * TIFFReadDirectory: TIFFSetDirectory would walk the chain from its start for each page. */
static bool place_pages(TIFF *tiff, struct client *client, struct stack_writer *writer)
{
    int n_pages = writer->options.n_wavelengths;
    tmsize_t size = (tmsize_t)page_bytes(&writer->options);
    if (!TIFFSetDirectory(tiff, 0))
        return false;
    for (int page = 0; page < n_pages; page++) {
        if ((page > 0 && !TIFFReadDirectory(tiff))
            || TIFFWriteRawStrip(tiff, 0, &client->blank, size) != size
            || !TIFFForceStrileArrayWriting(tiff))
            return false;
        writer->page_offset[page] = TIFFGetStrileOffset(tiff, 0);
    }
    return true;
}

/* Writes all directories and places all pages, as BigTIFF or not. *fits is false where the file
 * would pass the 4 GiB of a classic TIFF. */
static bool lay_out(struct stack_writer *writer, struct client *client, bool *fits,
                    struct error *err)
{
    const char *path = writer->output.path;
    *client = (struct client){.descriptor = writer->output.descriptor};
    TIFF *tiff = open_tiff(client, path, writer->big ? "w8l" : "wl", err);
    if (tiff == NULL)
        return false;
    bool good = write_directories(tiff, &writer->options, err);
    client->end = (client->end + PIXEL_ALIGNMENT - 1) / PIXEL_ALIGNMENT * PIXEL_ALIGNMENT;
    *fits = writer->big || client->end + stack_bytes(&writer->options) <= UINT32_MAX;
    good = good && (!*fits || place_pages(tiff, client, writer));
    TIFFClose(tiff);
    if (!good || client->error_number != 0)
        return tiff_failure(client, path, err);
    if (client->room == 0)
        return error_system(err, "%s: libtiff has left no room for the verdict", path);
    return true;
}

/* Finds a full disk before hours of rendering do. Nothing is reserved: that takes as long as
 * writing where a file system cannot do it by itself. */
static bool check_free_space(const struct stack_writer *writer, uint64_t needed,
                             struct error *err)
{
    struct statvfs disk;
    if (fstatvfs(writer->output.descriptor, &disk) != 0 || disk.f_blocks == 0 || disk.f_frsize == 0)
        return true; /* it does not say */
    if (needed / disk.f_frsize <= disk.f_bavail)
        return true;
    errno = 0;
    return error_system(err, "%s: the stack takes %" PRIu64 " MB, the disk has %" PRIu64 " MB left",
                        writer->output.path, needed / 1000000,
                        (uint64_t)disk.f_bavail * disk.f_frsize / 1000000);
}

/* Samples go to the file as they lie in memory. */
static bool is_little_endian(void)
{
    const uint16_t one = 1;
    return *(const unsigned char *)&one == 1;
}

/* Two wavelengths with the same name would be one to some readers. Tag 65000 takes floats. */
static bool check_wavelengths(const struct stack_options *options, struct error *err)
{
    double before = 0;
    for (int page = 0; page < options->n_wavelengths; page++) {
        double wavelength = options->wavelengths_nm[page];
        char name[NAME_SIZE], name_before[NAME_SIZE];
        number_name(wavelength, name);
        number_name(before, name_before);
        if (!(wavelength > before && wavelength <= (double)FLT_MAX)
            || strcmp(name, name_before) == 0)
            return error_usage(err, "wavelength %s nm after %s nm: the wavelengths of a stack are"
                               " finite and rise from above 0", name, name_before);
        before = wavelength;
    }
    return true;
}

static bool check_options(const struct stack_options *options, struct error *err)
{
    /* Room for directories in 63 bits; a page in tmsize_t, which is as wide as ptrdiff_t. */
    const uint64_t most_bytes = UINT64_C(1) << 62;
    if (options->n_wavelengths < 1 || options->n_wavelengths > MOST_PAGES)
        return error_usage(err, "a stack of %d wavelengths is impossible; TIFF numbers 1 to %d"
                           " pages", options->n_wavelengths, MOST_PAGES);
    if (options->width < 1 || options->height < 1)
        return error_usage(err, "a page of %dx%d pixels is empty; it takes at least 1x1",
                           options->width, options->height);
    if (page_bytes(options) > PTRDIFF_MAX
        || page_bytes(options) > most_bytes / (uint64_t)options->n_wavelengths)
        return error_usage(err, "%d pages of %dx%d pixels are too many for one file",
                           options->n_wavelengths, options->width, options->height);
    if (!(options->full_scale > 0 && options->full_scale <= DBL_MAX))
        return error_usage(err, "a full scale of %g is impossible; it is a positive radiance",
                           options->full_scale);
    if (!check_wavelengths(options, err))
        return false;
    errno = 0;
    if (!is_little_endian())
        return error_system(err, "a stack is little-endian, and so must the machine be");
    return true;
}

/* page_offset has one element more than there are pages: where the room for the verdict lies. */
static bool lay_out_whole(struct stack_writer *writer, struct error *err)
{
    struct client client;
    bool fits = true;
    writer->page_offset = calloc((size_t)writer->options.n_wavelengths + 1,
                                 sizeof *writer->page_offset);
    if (writer->page_offset == NULL)
        return error_memory(err);
    writer->big = stack_bytes(&writer->options) > UINT32_MAX;
    if (!lay_out(writer, &client, &fits, err))
        return false;
    if (!fits) {
        writer->big = true;
        if (ftruncate(writer->output.descriptor, 0) != 0)
            return error_system(err, "%s: cannot start anew", writer->output.path);
        if (!lay_out(writer, &client, &fits, err))
            return false;
    }
    writer->page_offset[writer->options.n_wavelengths] = client.room;
    if (!check_free_space(writer, client.end, err))
        return false;
    if (ftruncate(writer->output.descriptor, (off_t)client.end) != 0)
        return error_system(err, "%s: cannot hold %" PRIu64 " bytes", writer->output.path,
                            client.end);
    return true;
}

bool stack_open(struct stack_writer *out, const char *path, const struct stack_options *options,
                struct error *err)
{
    *out = (struct stack_writer){0};
    if (!check_options(options, err) || !output_open(&out->output, path, err))
        return false;
    out->options = *options;
    if (!lay_out_whole(out, err)) {
        stack_discard(out);
        return false;
    }
    out->options.scene = out->options.provenance = NULL; /* they need not live longer */
    return true;
}

/* ---- pixels ---- */

bool stack_write(struct stack_writer *writer, int page, int x, int y, int width, int height,
                 const void *samples, struct error *err)
{
    const struct stack_options *options = &writer->options;
    assert(page >= 0 && page < options->n_wavelengths && x >= 0 && y >= 0 && width >= 0
           && height >= 0 && x <= options->width - width && y <= options->height - height);
    size_t sample = options->floating ? 4 : 2;
    /* Whole rows lie together in the file too. */
    bool together = width == options->width;
    size_t run = (size_t)width * sample * (together ? (size_t)height : 1);
    uint64_t pitch = (uint64_t)options->width * sample;
    uint64_t offset = writer->page_offset[page] + (uint64_t)y * pitch + (uint64_t)x * sample;
    for (int row = 0; row < (together ? 1 : height); row++)
        if (!write_at(writer->output.descriptor, (const char *)samples + (size_t)row * run, run,
                      offset + (uint64_t)row * pitch))
            return error_system(err, "%s: cannot write page %d", writer->output.path, page + 1);
    return true;
}

/* ---- the end ---- */

static bool long_is(TIFF *tiff, uint32_t tag, uint32_t expected)
{
    uint32_t seen = 0;
    return TIFFGetField(tiff, tag, &seen) && seen == expected;
}

static bool short_is(TIFF *tiff, uint32_t tag, uint16_t expected)
{
    uint16_t seen = 0;
    return TIFFGetFieldDefaulted(tiff, tag, &seen) && seen == expected;
}

/* The current directory describes this page, and its pixels lie inside the file. */
static bool page_is_whole(TIFF *tiff, const struct stack_writer *writer, int page, uint64_t end)
{
    const struct stack_options *options = &writer->options;
    uint64_t offset = TIFFGetStrileOffset(tiff, 0), size = TIFFGetStrileByteCount(tiff, 0);
    return long_is(tiff, TIFFTAG_IMAGEWIDTH, (uint32_t)options->width)
           && long_is(tiff, TIFFTAG_IMAGELENGTH, (uint32_t)options->height)
           && short_is(tiff, TIFFTAG_BITSPERSAMPLE, options->floating ? 32 : 16)
           && short_is(tiff, TIFFTAG_SAMPLEFORMAT,
                       options->floating ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT)
           && short_is(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE)
           && TIFFNumberOfStrips(tiff) == 1 && offset == writer->page_offset[page]
           && size == page_bytes(options) && offset <= end && size <= end - offset;
}

/* The tag is unknown to libtiff while it reads: a counted array of characters. */
static bool verdict_is(TIFF *tiff, const char room[STACK_VERDICT])
{
    const TIFFField *field = TIFFFieldWithTag(tiff, TAG_VERDICT);
    uint32_t count = 0;
    const char *text = NULL;
    return field != NULL && TIFFFieldPassCount(field) && TIFFFieldReadCount(field) == TIFF_VARIABLE2
           && TIFFGetField(tiff, TAG_VERDICT, &count, &text) && count == STACK_VERDICT
           && memcmp(text, room, STACK_VERDICT) == 0;
}

/* Reads every directory with libtiff, as another program would; "c" keeps it from showing a large
 * strip as many small ones. */
static bool check_file(const struct stack_writer *writer, const char room[STACK_VERDICT],
                       struct error *err)
{
    const char *path = writer->output.path;
    int last = writer->options.n_wavelengths - 1;
    struct client client = {.descriptor = writer->output.descriptor};
    struct stat status;
    if (fstat(client.descriptor, &status) != 0)
        return error_system(err, "%s: cannot be examined", path);
    client.end = (uint64_t)status.st_size;
    TIFF *tiff = open_tiff(&client, path, "rc", err);
    if (tiff == NULL)
        return false;
    int page = 0;
    bool good = verdict_is(tiff, room);
    while (good && page_is_whole(tiff, writer, page, client.end) && page < last
           && TIFFReadDirectory(tiff))
        page++;
    good = good && page == last && page_is_whole(tiff, writer, page, client.end)
           && TIFFLastDirectory(tiff)
           && writer->page_offset[last] + page_bytes(&writer->options) == client.end;
    TIFFClose(tiff);
    if (good)
        return true;
    if (client.message[0] != '\0')
        return tiff_failure(&client, path, err);
    errno = 0;
    return error_system(err, "%s: page %d of the stack reads back wrong", path, page + 1);
}

bool stack_commit(struct stack_writer *writer, const char *verdict, struct error *err)
{
    char room[STACK_VERDICT];
    fill_room(verdict, room);
    uint64_t place = writer->page_offset[writer->options.n_wavelengths];
    bool good = write_at(writer->output.descriptor, room, STACK_VERDICT, place)
                || error_system(err, "%s: cannot write the verdict", writer->output.path);
    good = good && check_file(writer, room, err) && output_commit(&writer->output, err);
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
