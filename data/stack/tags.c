/* SPDX-License-Identifier: MIT */
/* Sets the tags that describe each page, for readers that look in different places: OME-XML
 * 2016-06 for tifffile and Bio-Formats, GDAL_METADATA as in the GTiff driver, IJMetadata as in
 * ImageJ's TiffEncoder, 65000 and 65111 as in the ODSI-DB of retinal images, the rest TIFF 6.0. */
#include <inttypes.h>
#include <tiffio.h>

#include "data/stack/inside.h"

#define OME_SCHEMA "http://www.openmicroscopy.org/Schemas/OME/2016-06"

enum {
    TAG_IMAGEJ_SIZES = 50838,
    TAG_IMAGEJ_TEXTS = 50839,
    TAG_WAVELENGTHS = 65000,
    TEXT_SIZE = 160, /* the lines of the scale are the longest text, of 85 bytes and a number */
    TEXT = TIFF_VARIABLE,
    ARRAY = TIFF_VARIABLE2
};

/* TIFFFieldInfo takes char *, not const char *: hence no string literals. */
static const TIFFFieldInfo private_fields[] = {
    {TIFFTAG_GDAL_METADATA, TEXT, TEXT, TIFF_ASCII, FIELD_CUSTOM, 1, 0, (char[]){"GDALMetadata"}},
    {TAG_IMAGEJ_SIZES, ARRAY, ARRAY, TIFF_LONG, FIELD_CUSTOM, 1, 1, (char[]){"IJMetadataSizes"}},
    {TAG_IMAGEJ_TEXTS, ARRAY, ARRAY, TIFF_BYTE, FIELD_CUSTOM, 1, 1, (char[]){"IJMetadata"}},
    {TAG_WAVELENGTHS, ARRAY, ARRAY, TIFF_FLOAT, FIELD_CUSTOM, 1, 1, (char[]){"Wavelengths"}},
    {TAG_VERDICT, TEXT, TEXT, TIFF_ASCII, FIELD_CUSTOM, 1, 0, (char[]){"Verdict"}},
};

static int largest_count(const struct stack_options *options)
{
    return options->bits == 8 ? 255 : 65535;
}

static bool has_wavelengths(const struct stack_options *options)
{
    return !options->components && !options->names;
}

/* Returns the unit of values; NULL: they have none. */
static const char *unit_of(const struct stack_options *options)
{
    return options->components               ? NULL
           : options->names || options->unit ? options->unit
                                             : RELATIVE_UNIT;
}

/* Writes how samples become radiances, components or raw values. */
static void scale_lines(const struct stack_options *options, char text[TEXT_SIZE])
{
    char value[40] = "sample";
    if (options->bits != 32)
        snprintf(value, sizeof value, "count x full_scale / %d", largest_count(options));
    snprintf(text, TEXT_SIZE, "full_scale: %.*g\nscale: %s = %s%s%s\n",
             exact_digits(options->full_scale), options->full_scale,
             options->components ? "component"
             : options->names    ? "raw value"
                                 : "radiance",
             value, unit_of(options) ? " " : "", unit_of(options) ? unit_of(options) : "");
}

/* Writes the name in a line, in ASCII, and without what XML would have to escape. */
static void name_label(const char *name, int line, char out[TEXT_SIZE])
{
    size_t n = 0;
    for (; line > 0; line--)
        name += strcspn(name, "\n") + 1;
    for (; *name && *name != '\n' && n < TEXT_SIZE / 2; name++)
        if (*name >= ' ' && *name <= '~')
            out[n++] = strchr("<>&\"'", *name) ? '_' : *name;
    out[n] = '\0';
}

static void page_label(const struct stack_options *options, int page, char out[TEXT_SIZE])
{
    if (options->components)
        sampling_label(options->components, page, out);
    else if (options->names)
        name_label(options->names, page, out);
    else
        snprintf(out, TEXT_SIZE, PAGE_LABEL, options->wavelengths_nm[page]);
}

static void put_channel(struct printed *stream, const struct stack_options *options, int page)
{
    char label[TEXT_SIZE];
    page_label(options, page, label);
    print(stream, "<Channel ID=\"Channel:0:%d\" Name=\"%s\" SamplesPerPixel=\"1\"", page, label);
    if (has_wavelengths(options))
        print(stream, " EmissionWavelength=\"%.10g\" EmissionWavelengthUnit=\"nm\"",
              options->wavelengths_nm[page]);
    print_text(stream, "/>\n");
}

/* The first page describes the whole stack. Its text begins with < and ends with >, by which
 * readers recognize OME-XML. */
static void put_description(struct printed *stream, const struct stack_writer *writer, int page)
{
    const struct stack_options *options = &writer->options;
    char text[TEXT_SIZE];
    if (page > 0) {
        page_label(options, page, text);
        if (!has_wavelengths(options))
            print(stream, "%s=%s", options->names ? "channel" : "component", text);
        else
            print(stream, "wavelength_nm=%.10g", options->wavelengths_nm[page]);
        return;
    }
    scale_lines(options, text);
    print_text(stream, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OME xmlns=\"" OME_SCHEMA "\""
                       " xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\""
                       " xsi:schemaLocation=\"" OME_SCHEMA " " OME_SCHEMA "/ome.xsd\">\n"
                       "<Image ID=\"Image:0\" Name=\"");
    print_xml(stream, options->scene);
    print(stream, "\"><Description>%s", text);
    print_xml(stream, options->provenance);
    if (options->map_bytes > 0)
        print(stream, "object_map: %" PRIu64 " %d\n",
              pages_offset(&writer->pages, options->n_wavelengths), options->map_bytes);
    print(stream,
          "</Description>\n<Pixels ID=\"Pixels:0\" DimensionOrder=\"XYCZT\" Type=\"%s\""
          " BigEndian=\"false\" SizeX=\"%d\" SizeY=\"%d\" SizeC=\"%d\" SizeZ=\"1\""
          " SizeT=\"1\">\n",
          options->bits == 32  ? "float"
          : options->bits == 8 ? "uint8"
                               : "uint16",
          options->width, options->height, options->n_wavelengths);
    for (page = 0; page < options->n_wavelengths; page++)
        put_channel(stream, options, page);
    for (page = 0; page < options->n_wavelengths; page++)
        print(stream,
              "<TiffData FirstC=\"%d\" FirstZ=\"0\" FirstT=\"0\" IFD=\"%d\""
              " PlaneCount=\"1\"/>\n",
              page, page);
    print_text(stream, "</Pixels></Image></OME>");
}

double page_width_nm(const double *wavelengths_nm, int n, int page)
{
    const int before = page > 0 ? page - 1 : page, after = page + 1 < n ? page + 1 : page;
    return after > before ? (wavelengths_nm[after] - wavelengths_nm[before]) / (after - before) : 0;
}

static void put_gdal_wavelength(struct printed *stream, const struct stack_options *options,
                                int page)
{
    const double *nm = options->wavelengths_nm;
    const double width_nm = page_width_nm(nm, options->n_wavelengths, page);
    print(stream,
          "<Item name=\"CENTRAL_WAVELENGTH_UM\" sample=\"0\""
          " domain=\"IMAGERY\">%.10g</Item>\n",
          nm[page] / 1000);
    if (width_nm > 0)
        print(stream, "<Item name=\"FWHM_UM\" sample=\"0\" domain=\"IMAGERY\">%.10g</Item>\n",
              width_nm / 1000);
    print(stream,
          "<Item name=\"wavelength\" sample=\"0\">%.10g</Item>\n"
          "<Item name=\"wavelength_units\" sample=\"0\">Nanometers</Item>\n",
          nm[page]);
}

static void put_gdal(struct printed *stream, const struct stack_writer *writer, int page)
{
    const struct stack_options *options = &writer->options;
    const double scale = options->bits == 32 ? 1 : options->full_scale / largest_count(options);
    char label[TEXT_SIZE];
    page_label(options, page, label);
    print_text(stream, "<GDALMetadata>\n");
    if (has_wavelengths(options))
        put_gdal_wavelength(stream, options, page);
    print(stream,
          "<Item name=\"DESCRIPTION\" sample=\"0\" role=\"description\">%s</Item>\n"
          "<Item name=\"OFFSET\" sample=\"0\" role=\"offset\">0</Item>\n"
          "<Item name=\"SCALE\" sample=\"0\" role=\"scale\">%.*g</Item>\n",
          label, exact_digits(scale), scale);
    if (unit_of(options))
        print(stream, "<Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">%s</Item>\n",
              unit_of(options));
    print_text(stream, "</GDALMetadata>\n");
}

/* Writes a string for ImageJ: the lines of the scale (page -1), or the label of a page. */
static size_t imagej_string(const struct stack_options *options, int page, char text[TEXT_SIZE])
{
    if (page < 0)
        scale_lines(options, text);
    else
        page_label(options, page, text);
    return strlen(text);
}

/* Writes the strings in UTF-16 without terminators, behind "IJIJ" and the numbers of strings of the
 * kinds "info" and "labl". libtiff takes all of it for bytes, whose order is that of the file. */
static void put_imagej_texts(struct printed *stream, const struct stack_writer *writer, int page)
{
    const struct stack_options *options = &writer->options;
    const uint32_t header[5] = {0x494a494a, 0x696e666f, 1, 0x6c61626c,
                                (uint32_t)options->n_wavelengths};
    char text[TEXT_SIZE];
    print_stored(stream, header, sizeof header[0], sizeof header);
    for (page = -1; page < options->n_wavelengths; page++) {
        size_t length = imagej_string(options, page, text);
        for (size_t i = 0; i < length; i++)
            print_bytes(stream, (char[2]){text[i], 0}, 2);
    }
}

/* Writes the sizes in bytes: of the header of five numbers, and of each string. */
static void put_imagej_sizes(struct printed *stream, const struct stack_writer *writer, int page)
{
    const struct stack_options *options = &writer->options;
    uint32_t size = 5 * sizeof size;
    char text[TEXT_SIZE];
    print_bytes(stream, &size, sizeof size);
    for (page = -1; page < options->n_wavelengths; page++) {
        size = 2 * (uint32_t)imagej_string(options, page, text);
        print_bytes(stream, &size, sizeof size);
    }
}

static void put_wavelengths(struct printed *stream, const struct stack_writer *writer, int page)
{
    const struct stack_options *options = &writer->options;
    for (page = 0; page < options->n_wavelengths; page++)
        print_bytes(stream, &(float){(float)options->wavelengths_nm[page]}, sizeof(float));
}

/* Sets a tag to the bytes that `put` prints. */
static bool set_printed(TIFF *tiff, uint32_t tag, const struct stack_writer *writer, int page,
                        void (*put)(struct printed *, const struct stack_writer *, int),
                        struct error *err)
{
    const TIFFField *field = TIFFFieldWithTag(tiff, tag);
    struct printed printed = {.text = NULL};
    put(&printed, writer, page);
    char *bytes = printed_take(&printed, err);
    if (bytes == NULL)
        return false;
    uint32_t count = (uint32_t)printed.length / (uint32_t)TIFFDataWidth(TIFFFieldDataType(field));
    const bool good = TIFFFieldPassCount(field) ? TIFFSetField(tiff, tag, count, bytes)
                                                : TIFFSetField(tiff, tag, bytes);
    free(bytes);
    return good;
}

static bool set_first_page(TIFF *tiff, const struct stack_writer *writer, struct error *err)
{
    char room[STACK_VERDICT];
    snprintf(room, sizeof room, "%-*s", STACK_VERDICT - 1, STACK_UNFINISHED);
    return set_printed(tiff, TAG_IMAGEJ_SIZES, writer, 0, put_imagej_sizes, err) &&
           set_printed(tiff, TAG_IMAGEJ_TEXTS, writer, 0, put_imagej_texts, err) &&
           (!has_wavelengths(&writer->options) ||
            set_printed(tiff, TAG_WAVELENGTHS, writer, 0, put_wavelengths, err)) &&
           TIFFSetField(tiff, TIFFTAG_SOFTWARE, PROGRAM) && TIFFSetField(tiff, TAG_VERDICT, room);
}

bool tags_set(TIFF *tiff, const void *stack, int page, struct error *err)
{
    const struct stack_writer *writer = stack;
    const uint32_t n_private = sizeof private_fields / sizeof private_fields[0];
    char label[TEXT_SIZE];
    page_label(&writer->options, page, label);
    return TIFFMergeFieldInfo(tiff, private_fields, n_private) == 0 &&
           TIFFSetField(tiff, TIFFTAG_PAGENAME, label) &&
           set_printed(tiff, TIFFTAG_IMAGEDESCRIPTION, writer, page, put_description, err) &&
           set_printed(tiff, TIFFTAG_GDAL_METADATA, writer, page, put_gdal, err) &&
           (page > 0 || set_first_page(tiff, writer, err));
}
