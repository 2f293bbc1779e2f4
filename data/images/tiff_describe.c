/* SPDX-License-Identifier: MIT */
/* Describes a TIFF file whose samples lie raw and without gaps, so that a program that knows no
 * TIFF can read them. */
#include <inttypes.h>
#include <tiffio.h>

#include "data/images/images.h"

/* Refuses a page whose samples cannot be described by themselves. */
static bool page_is_raw(const struct image *image, int page, struct error *err)
{
    const struct sample_layout *layout = &image->file->pages[page];
    const char *why = layout->n_colours > 1      ? "is coloured"
                      : layout->inverted         ? "stores white as 0"
                      : layout->rows_offset == 0 ? "is compressed, in tiles, or in strips with gaps"
                      : layout->pixel_step > layout->n_bands ? "has an alpha"
                                                             : NULL;
    return !why || error_usage(err,
                               "%s: page %d %s; an ENVI header describes raw grey samples without"
                               " gaps, as spectral render writes them",
                               image->path, page + 1, why);
}

bool image_describe(const struct image *image, struct raw_samples *out, struct error *err)
{
    const struct sample_layout *first = image->file->pages;
    const bool by_pages = first->n_bands == 1;
    uint64_t expected = first->rows_offset;
    for (int page = 0; page < image->n_pages; page++) {
        const struct sample_layout *layout = &image->file->pages[page];
        if (!page_is_raw(image, page, err))
            return false;
        if (by_pages && layout->rows_offset != expected)
            return error_usage(err,
                               "%s: page %d begins at byte %" PRIu64 "; an ENVI header needs pages"
                               " without gaps, and so expects it at byte %" PRIu64,
                               image->path, page + 1, layout->rows_offset, expected);
        expected += (uint64_t)layout->row_bytes * layout->height;
    }
    *out = (struct raw_samples){first->rows_offset, first->bits, first->pixel_step > 1,
                                TIFFIsBigEndian(image->file->tiff) != 0};
    return true;
}
