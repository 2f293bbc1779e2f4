/* SPDX-License-Identifier: MIT */
/* Reads the wavelengths and the scale that the pages of a TIFF file record: as tags.c
 * writes them, as GDAL does, or as OME-XML. */
#include <float.h>
#include <strings.h>
#include <tiffio.h>

#include "data/stack/inside.h"

/* An item of GDAL_METADATA ends at a '<'. */
enum item { ITEM_WAVELENGTH, ITEM_UNIT, ITEM_MICROMETRES, ITEM_SCALE, ITEM_OFFSET, ITEMS };

/* Returns the number at `at`; NaN: there is none. */
static double number_at(const char *at)
{
    const struct word word = {.start = at, .length = strcspn(at, " \t\r\n<\"")};
    double number;
    return word_is_number(&word, 0, &number) ? number : (double)NAN;
}

/* Finds `mark` before `end` in a tag of XML, and returns the place behind it: with the mark "
 * NAME=\"" the value of an attribute. NULL: there is no mark. */
static const char *attribute(const char *at, const char *end, const char *mark)
{
    const size_t length = strlen(mark);
    for (; (size_t)(end - at) >= length; at++)
        if (memcmp(at, mark, length) == 0)
            return at + length;
    return NULL;
}

/* Returns the text of a private tag; NULL: there is none. libtiff does not know these tags, and
 * adds no NUL. */
static const char *private_text(TIFF *tiff, uint32_t tag)
{
    uint32_t length = 0;
    const char *text = NULL;
    return TIFFGetField(tiff, tag, &length, &text) && length > 0 &&
                   memchr(text, '\0', length) != NULL
               ? text
               : NULL;
}

/* Stores the items of the current directory in out[band * ITEMS + item]; NULL stays where there is
 * none. A directory of one band need not number it. */
static void find_items(TIFF *tiff, int n_bands, const char **out)
{
    static const char *const marks[ITEMS] = {" name=\"wavelength\"", " name=\"wavelength_units\"",
                                             " name=\"CENTRAL_WAVELENGTH_UM\"", " role=\"scale\"",
                                             " role=\"offset\""};
    const char *at = private_text(tiff, TIFFTAG_GDAL_METADATA), *end;
    for (; at != NULL && (at = strstr(at, "<Item ")) != NULL; at = end) {
        end = strchr(at, '>');
        if (end == NULL)
            return;
        const char *sample = attribute(at, end, " sample=\"");
        const long band = n_bands == 1 ? 0 : sample != NULL ? strtol(sample, NULL, 10) : -1;
        for (int item = 0; item < ITEMS && band >= 0 && band < n_bands; item++)
            if (out[band * ITEMS + item] == NULL && attribute(at, end, marks[item]) != NULL)
                out[band * ITEMS + item] = end + 1;
    }
}

/* Converts a number with a unit, in capitals or not, to nm. NaN: there is no number, or the unit,
 * which is then kept, is unknown. */
static double length_nm(struct page_record *out, const char *number, const char *unit)
{
    static const struct {
        const char *names; /* the micro sign also appears as the letter mu, in Latin-1, as entity */
        double nm, divisor;
    } units[] = {{"nm,nanometer,nanometers,nanometre,nanometres", 1, 1},
                 {"um,µm,\u03bcm,\xb5m,&#181;m,&#xB5;m,micron,microns,micrometer,micrometers,"
                  "micrometre,micrometres",
                  1000, 1},
                 {"Å,\xc5,&#197;,angstrom,angstroms,ångström,ångströms", 1, 10},
                 {"m", 1e9, 1}};
    const size_t length = strcspn(unit, "<\"");
    for (size_t i = 0; i < sizeof units / sizeof units[0]; i++)
        for (const char *at = units[i].names, *end; length > 0 && *at; at = end + (*end == ',')) {
            end = at + strcspn(at, ",");
            if ((size_t)(end - at) == length && strncasecmp(at, unit, length) == 0)
                return number_at(number) * units[i].nm / units[i].divisor;
        }
    snprintf(out->unit, sizeof out->unit, "%.*s", length < 31 ? (int)length : 31, unit);
    return (double)NAN;
}

/* Reads the next <Channel> of the OME-XML: it records the wavelength of the next page. Without a
 * unit it is in nm. */
static double channel_wavelength(struct image *image, struct page_record *out)
{
    static const char mark[] = "<Channel";
    const char *at = image->channels, *number, *unit, *end;
    do {
        at = strstr(at, mark);
        if (at == NULL) {
            image->channels = "";
            return (double)NAN;
        }
        at += strlen(mark);
    } while (strchr(" \t\r\n", *at) == NULL);
    end = at + strcspn(at, "<");
    image->channels = end;
    number = attribute(at, end, " EmissionWavelength=\"");
    unit = attribute(at, end, " EmissionWavelengthUnit=\"");
    return number == NULL ? (double)NAN : length_nm(out, number, unit != NULL ? unit : "nm\"");
}

/* Finds the wavelength of the next page. */
static void find_wavelength(struct image *image, const char *const items[ITEMS],
                            struct page_record *out)
{
    const char *name = "";
    const double channel = channel_wavelength(image, out);
    double nm = (double)NAN;
    TIFFGetField(image->tiff, TIFFTAG_PAGENAME, &name);
    if (strcmp(name + strcspn(name, " "), " nm") == 0)
        nm = number_at(name);
    if (isnan(nm) && items[ITEM_WAVELENGTH] != NULL && items[ITEM_UNIT] != NULL)
        nm = length_nm(out, items[ITEM_WAVELENGTH], items[ITEM_UNIT]);
    if (isnan(nm) && items[ITEM_MICROMETRES] != NULL)
        nm = 1000 * number_at(items[ITEM_MICROMETRES]);
    if (isnan(nm))
        nm = channel;
    out->wavelength_nm = nm > 0 && nm <= DBL_MAX ? nm : out->unit[0] != '\0' ? 0 : (double)NAN;
}

/* Refuses OME-XML whose TiffData give the channels the pages in another order, or in other files.
 */
static bool check_order(const struct image *image, struct error *err)
{
    const char *at = image->description, *end;
    while ((at = strstr(at, "<TiffData")) != NULL) {
        end = at + strcspn(at, ">");
        const char *channel = attribute(at, end, " FirstC=\""),
                   *page = attribute(at, end, " IFD=\"");
        if (channel && page && strtol(channel, NULL, 10) != strtol(page, NULL, 10))
            return image_refuse(image, -1, err,
                                "its OME-XML gives channel %ld page %ld; expected the order of the "
                                "channels, counted from 0",
                                strtol(channel, NULL, 10), strtol(page, NULL, 10));
        at = end;
    }
    return true;
}

/* Reads the description and the full scale in it, the verdict, and how many pages a stack of this
 * program records. */
static bool read_first(struct image *image, struct page_record *out, struct error *err)
{
    static const char full_scale[] = "full_scale: ";
    const char *text = "", *verdict = private_text(image->tiff, TAG_VERDICT);
    uint16_t page = 0, n_pages = 0;
    uint32_t count = 0;
    const char *any = NULL;
    if (TIFFGetField(image->tiff, TAG_VERDICT, &count, &any) &&
        TIFFGetField(image->tiff, TIFFTAG_PAGENUMBER, &page, &n_pages))
        image->n_recorded = n_pages;
    TIFFGetField(image->tiff, TIFFTAG_IMAGEDESCRIPTION, &text);
    if (!string_copy(text, &image->description, err) ||
        !string_copy(verdict != NULL ? verdict : "", &image->verdict, err))
        return false;
    image->channels = image->description;
    for (size_t n = strlen(image->verdict); n > 0 && image->verdict[n - 1] == ' ';)
        image->verdict[--n] = '\0';
    /* the names before the element are the user's */
    const char *element = strstr(image->description, "<Description>");
    const char *scale = strstr(element != NULL ? element : image->description, full_scale);
    out->full_scale = scale != NULL ? number_at(scale + strlen(full_scale)) : -1;
    return (strcmp(image->verdict, STACK_UNFINISHED) != 0 ||
            image_refuse(image, -1, err,
                         "it is not finished: its render goes on, or was killed")) &&
           check_order(image, err);
}

bool tags_read(struct image *image, int n, struct page_record *out, struct error *err)
{
    const char **items;
    if (image->n_pages == 0 && !read_first(image, out, err))
        return false;
    if (!MAKE_ARRAY(items, (size_t)n * ITEMS, err, "the bands of %s", image->path))
        return false;
    find_items(image->tiff, n, items);
    const char *nodata = private_text(image->tiff, TIFFTAG_GDAL_NODATA);
    for (int band = 0; band < n; band++) {
        const char *const *own = items + (size_t)band * ITEMS;
        find_wavelength(image, own, &out[band]);
        out[band].count_scale = own[ITEM_SCALE] != NULL ? number_at(own[ITEM_SCALE]) : -1;
        out[band].has_nodata = nodata != NULL;
        out[band].nodata = nodata ? strtod(nodata, NULL) : 0;
        out[band].offset = own[ITEM_OFFSET] != NULL ? number_at(own[ITEM_OFFSET]) : 0;
    }
    free(items);
    return true;
}
