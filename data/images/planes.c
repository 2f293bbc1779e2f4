/* SPDX-License-Identifier: MIT */
/* Writes float pages with names. */
#include <tiffio.h>

#include "data/images/inside.h"

static bool set_tags(TIFF *tiff, const void *of, int page, struct error *err)
{
    const struct planes_options *options = of;
    (void)err; /* libtiff reports its failures */
    return TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, options->description) &&
           TIFFSetField(tiff, TIFFTAG_SOFTWARE, PROGRAM) &&
           TIFFSetField(tiff, TIFFTAG_PAGENAME, options->names[page]);
}

bool planes_open(struct pages *out, const char *path, const struct planes_options *options,
                 struct error *err)
{
    *out = (struct pages){.count = options->n,
                          .width = options->width,
                          .height = options->height,
                          .channels = 1,
                          .bits = 32};
    return pages_open(out, path, set_tags, options, err);
}

bool planes_write(const struct pages *pages, const struct plane_rectangle *to, const float *samples,
                  struct error *err)
{
    const size_t n = (size_t)to->width;
    const uint64_t pitch = pages_row_bytes(pages);
    for (int row = 0; row < to->height; row++)
        if (!pages_write(pages, to->page,
                         (uint64_t)(to->y + row) * pitch + (uint64_t)to->x * sizeof *samples,
                         samples + (size_t)row * n, n * sizeof *samples, err))
            return false;
    return true;
}

bool planes_finish(struct pages *pages, struct error *err)
{
    return pages_finish(pages, NULL, err);
}

bool planes_commit(struct pages *pages, struct outputs *outputs, struct error *err)
{
    return output_pass(&pages->output, outputs, err);
}

void planes_discard(struct pages *pages)
{
    output_discard(&pages->output);
    *pages = (struct pages){.count = 0};
}
