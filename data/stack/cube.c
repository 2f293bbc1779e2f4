/* SPDX-License-Identifier: MIT */
/* Reads a spectral stack, with its record if this program wrote it. */
#include "data/stack/inside.h"

/* Returns whether the object map ends where the file ends, and objects have names. If not, another
 * program changed the stack, or it was cut. */
static bool map_is_whole(const struct cube *cube)
{
    const struct record *record = &cube->record;
    const uint64_t pixels = (uint64_t)cube->image.width * (uint64_t)cube->image.height;
    const uint64_t bytes = pixels * (uint64_t)record->map_bytes;
    return record->objects.n > 0 && bytes <= cube->image.bytes &&
           record->map_offset == cube->image.bytes - bytes;
}

bool cube_open(const char *path, struct cube *out, struct error *err)
{
    return cube_or_raw_open(path, out, err) &&
           (!out->raw || error_usage(err,
                                     "%s has raw values of a detector's channels; expected "
                                     "the stack that they come from",
                                     path));
}

bool cube_or_raw_open(const char *path, struct cube *out, struct error *err)
{
    struct image *image = &out->image;
    *out = (struct cube){.record = {.text = NULL}};
    if (!image_open(path, NOWHERE, tags_read, image, err) ||
        (record_is_there(image) && !record_read(image, &out->record, err)))
        return false;
    out->unit = out->record.unit ? out->record.unit : RELATIVE_UNIT;
    out->raw = strstr(image->description, "\nraw values of: ") && !image->wavelengths_nm;
    out->components = out->record.components && !image->coloured;
    if (out->components || out->raw) { /* pages have numbers in place of wavelengths */
        if (!MAKE_ARRAY(image->wavelengths_nm, image->n_pages, err, "the pages of %s", path))
            return false;
        for (int i = 0; i < image->n_pages; i++)
            image->wavelengths_nm[i] = i + 1;
    }
    if (!map_is_whole(out))
        out->record.map_bytes = 0;
    return (!image->coloured && image->wavelengths_nm) ||
           error_usage(
               err,
               "%s: %s; expected a stack of grey pages, one page or one GDAL band a"
               " wavelength, that record increasing wavelengths as OME-XML, GDAL_METADATA or page"
               " names such as \"305 nm\"",
               path, image->coloured ? "its pages are RGB (a picture)" : image->no_wavelengths);
}

bool cube_needs_radiance(const struct cube *cube, const char *what, struct error *err)
{
    return !cube->components ||
           error_usage(err, "%s needs radiances at wavelengths; %s holds the components of %s",
                       what, cube->image.path, cube->record.sampling);
}

void cube_close(struct cube *cube)
{
    record_free(&cube->record);
    image_close(&cube->image);
}
