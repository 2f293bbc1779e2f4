/* SPDX-License-Identifier: MIT */
/* A spectral stack to be read, with what it says of itself where it is one of our own. */
#include "spectral.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct place nowhere = {0};

/* The map is the last thing in the file, and every object has a name. A stack of which that is not
 * true was written by others, or cut. */
static bool map_is_whole(const struct cube *cube)
{
    const struct record *record = &cube->record;
    const uint64_t pixels = (uint64_t)cube->image.width * (uint64_t)cube->image.height;
    const uint64_t bytes = pixels * (uint64_t)record->map_bytes;
    return record->n_objects > 0 && bytes <= cube->image.bytes &&
           record->map_offset == cube->image.bytes - bytes;
}

bool cube_open(const char *path, struct cube *out, struct error *err)
{
    struct error foreign = {0};
    *out = (struct cube){.record = {.text = NULL}};
    if (!image_open(path, nowhere, &out->image, err))
        return false;
    if (out->image.coloured || out->image.wavelengths_nm == NULL) {
        error_usage(
            err,
            "%s: %s; expected a stack of grey pages, one page or one GDAL band a wavelength,"
            " that tell increasing ones as OME-XML, GDAL_METADATA or page names such as"
            " \"305 nm\"",
            path, out->image.coloured ? "its pages are RGB" : out->image.untold);
        cube_close(out);
        return false;
    }
    if (record_read(&out->image, &out->record, &foreign) && !map_is_whole(out))
        out->record.map_bytes = 0;
    return true;
}

/* ---- the white ---- */

/* The whole text is one word, blanks and all. */
static bool spectrum_of_option(const char *value, struct text *text, struct spectrum *out,
                               struct error *err)
{
    if (!text_open_string(text, "--white", value, err))
        return false;
    if (!text_next_line(text) || strchr(value, '\n') != NULL)
        return error_at(err, text_place(text), "expected one line, not '%s'", value);
    const struct word word = {
        .start = text->at, .length = strlen(value), .place = {text->path, text->line, 1}};
    return spectrum_read(&word, 0, HUGE_VAL, out, err);
}

static bool white_of_option(const struct cube *cube, const char *value, double *out,
                            struct error *err)
{
    struct text text = {.path = NULL};
    struct spectrum spectrum = {.kind = SPECTRUM_NONE};
    const bool good = spectrum_of_option(value, &text, &spectrum, err);
    for (int i = 0; good && i < cube->image.n_pages; i++)
        out[i] = spectrum_at(&spectrum, cube->image.wavelengths_nm[i], SPECTRUM_ZERO);
    spectrum_free(&spectrum);
    text_free(&text);
    return good;
}

bool cube_white(const struct cube *cube, const char *spectrum, double *out, struct error *err)
{
    bool shines = false;
    if (spectrum == NULL && cube->record.n_white == 0)
        return error_usage(err,
                           "%s: tells no white, as stacks of scenes with lights do since spectral"
                           " 0.3.0; expected --white SPECTRUM",
                           cube->image.path);
    if (spectrum == NULL)
        memcpy(out, cube->record.white, (size_t)cube->image.n_pages * sizeof *out);
    else if (!white_of_option(cube, spectrum, out, err))
        return false;
    for (int i = 0; i < cube->image.n_pages; i++)
        shines = shines || out[i] > 0;
    return shines || error_usage(err,
                                 "%s: the white is 0 at all of its wavelengths; expected one that"
                                 " shines at some",
                                 cube->image.path);
}

bool cube_white_response(const struct cube *cube, const char *spectrum, bool needed,
                         const double *weights, bool *found, double out[3], struct error *err)
{
    struct error ignored = {.status = EXIT_AGREED};
    double *radiance = calloc((size_t)cube->image.n_pages, sizeof *radiance);
    if (radiance == NULL)
        return error_memory(err);
    needed = needed || spectrum != NULL;
    *found = cube_white(cube, spectrum, radiance, needed ? err : &ignored);
    if (*found)
        detector_response(weights, radiance, cube->image.n_pages, out);
    free(radiance);
    return *found || !needed;
}

/* ---- the object map ---- */

bool cube_objects(const struct cube *cube, int x, int y, int n, int *out, struct error *err)
{
    const struct record *record = &cube->record;
    const uint64_t pixel = (uint64_t)y * (uint64_t)cube->image.width + (uint64_t)x;
    const size_t length = (size_t)record->map_bytes, count = (size_t)n;
    const unsigned char *bytes = (const unsigned char *)out;
    if (length > 0 && !image_read_bytes(&cube->image, record->map_offset + pixel * length,
                                        count * length, out, err))
        return false;
    for (size_t i = count; i-- > 0;) { /* from the end: a number takes more room than its bytes */
        int number = length > 0 ? bytes[i * length] : record->n_objects + 1;
        if (length > 1)
            number += 256 * bytes[i * length + 1];
        out[i] = number <= record->n_objects ? number : -1;
    }
    return true;
}

void cube_close(struct cube *cube)
{
    record_free(&cube->record);
    image_close(&cube->image);
}
