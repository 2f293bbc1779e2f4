/* SPDX-License-Identifier: MIT */
/* Writes colour pictures. RGB is one page of three samples a pixel. Floats are three grey pages:
 * ImageJ and Pillow open no other floats. */
#include <assert.h>
#include <stdlib.h>
#include <tiffio.h>

#include "data/pages/pages.h"

static bool set_tags(TIFF *tiff, const void *of, int page, struct error *err)
{
    const struct picture_options *options = of;
    (void)err; /* libtiff reports its failures */
    return TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, options->description) &&
           TIFFSetField(tiff, TIFFTAG_SOFTWARE, PROGRAM) &&
           (options->samples != PICTURE_FLOAT ||
            TIFFSetField(tiff, TIFFTAG_PAGENAME, options->channels[page])) &&
           (options->profile == NULL ||
            TIFFSetField(tiff, TIFFTAG_ICCPROFILE, (uint32_t)options->profile_length,
                         options->profile));
}

bool picture_open(struct picture_writer *out, const char *path,
                  const struct picture_options *options, struct error *err)
{
    static const int bits[] = {[PICTURE_8] = 8, [PICTURE_16] = 16, [PICTURE_FLOAT] = 32};
    const bool floating = options->samples == PICTURE_FLOAT;
    assert(options->width > 0 && options->height > 0);
    *out = (struct picture_writer){.options = *options,
                                   .pages = {.count = floating ? 3 : 1,
                                             .width = options->width,
                                             .height = options->height,
                                             .channels = floating ? 1 : 3,
                                             .bits = bits[options->samples]}};
    return pages_open(&out->pages, path, set_tags, options, err);
}

/* Writes each channel of some rows into its page. */
static bool write_planes(const struct picture_writer *writer, const float *samples, int rows,
                         struct error *err)
{
    const uint64_t row_bytes = pages_row_bytes(&writer->pages);
    const size_t n = (size_t)rows * (size_t)writer->options.width;
    float *plane = malloc(n * sizeof *plane);
    bool done = plane != NULL || error_memory(err);
    for (int channel = 0; done && channel < 3; channel++) {
        for (size_t i = 0; i < n; i++)
            plane[i] = samples[3 * i + (size_t)channel];
        done = pages_write(&writer->pages, channel, (uint64_t)writer->row * row_bytes, plane,
                           n * sizeof *plane, err);
    }
    free(plane);
    return done;
}

bool picture_write(struct picture_writer *writer, const void *samples, int rows, struct error *err)
{
    const uint64_t row_bytes = pages_row_bytes(&writer->pages);
    assert(rows >= 0 && rows <= writer->options.height - writer->row);
    const bool done = writer->options.samples == PICTURE_FLOAT
                          ? write_planes(writer, samples, rows, err)
                          : pages_write(&writer->pages, 0, (uint64_t)writer->row * row_bytes,
                                        samples, (size_t)rows * (size_t)row_bytes, err);
    writer->row += rows;
    return done;
}

bool picture_commit(struct picture_writer *writer, struct error *err)
{
    assert(writer->row == writer->options.height);
    const bool done =
        pages_finish(&writer->pages, NULL, err) && output_commit(&writer->pages.output, err);
    picture_discard(writer);
    return done;
}

void picture_discard(struct picture_writer *writer)
{
    output_discard(&writer->pages.output);
    *writer = (struct picture_writer){.row = 0};
}
