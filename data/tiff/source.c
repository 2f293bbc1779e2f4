/* SPDX-License-Identifier: MIT */
/* A picture is a TIFF file or an ENVI cube. Only this file asks which. */
#include <stdlib.h>
#include <string.h>

#include "data/tiff/tiff.h"

bool image_kind(const char *path, enum image_kind *out, struct error *err)
{
    const char *format;
    bool envi = false;
    if (!file_format(path, &format, err))
        return false;
    const bool tiff = strcmp(format, "TIFF") == 0;
    if (!tiff && !envi_is(path, &envi, err))
        return false;
    *out = tiff ? IMAGE_TIFF : envi ? IMAGE_ENVI : IMAGE_NONE;
    return true;
}

/* Fills what all pictures have from the header of the cube. */
static bool cube_image_open(struct image *image, struct place from, struct error *err)
{
    image->envi = calloc(1, sizeof *image->envi);
    if (!image->envi)
        return error_memory(err);
    if (!envi_open(image->path, from, image->envi, err))
        return false;
    const struct envi_header *header = &image->envi->header;
    image->width = header->layout.samples;
    image->height = header->layout.lines;
    image->n_pages = header->n;
    image->description = strdup("");
    image->verdict = strdup("");
    if (!image->description || !image->verdict)
        return error_memory(err);
    if (!header->wavelengths_nm) {
        snprintf(image->no_wavelengths, sizeof image->no_wavelengths, "records no wavelengths");
        return true;
    }
    const size_t bytes = (size_t)header->n * sizeof *header->wavelengths_nm;
    image->wavelengths_nm = malloc(bytes);
    if (!image->wavelengths_nm)
        return error_memory(err);
    memcpy(image->wavelengths_nm, header->wavelengths_nm, bytes);
    return true;
}

bool image_open(const char *path, struct place from, struct image *out, struct error *err)
{
    *out = (struct image){.scale = 1, .path = strdup(path)};
    if (!out->path)
        return error_memory(err);
    enum image_kind kind;
    const bool done =
        image_kind(path, &kind, err) &&
        (kind == IMAGE_ENVI ? cube_image_open(out, from, err) : tiff_open(out, from, err));
    if (!done)
        image_close(out);
    return done;
}

bool image_read(struct image *image, int page, int y, int rows, float *out, struct error *err)
{
    return image->envi ? envi_read(image->envi, page, y, rows, out, err)
                       : tiff_read(image, page, y, rows, out, err);
}

bool image_is_float(const struct image *image)
{
    bool done = image->file && !image->coloured;
    for (int i = 0; i < image->n_pages && done; i++)
        done = image->file->pages[i].bits == 32;
    return done;
}

void image_close(struct image *image)
{
    tiff_close(image->file);
    if (image->envi)
        envi_close(image->envi);
    free(image->envi);
    free(image->path);
    free(image->description);
    free(image->verdict);
    free(image->wavelengths_nm);
    *image = (struct image){0};
}
