/* SPDX-License-Identifier: MIT */
/* Writes colour pictures, as TIFF or PNG. RGB is one page of three samples a pixel. Floats are
 * grey pages of a TIFF, one a channel: ImageJ and Pillow open no other floats. */
#include <tiffio.h>

#include "data/images/inside.h"
#include "data/text/text.h"

char *picture_text(char *text)
{
    for (char *at = text; at && *at != '\0'; at++)
        if ((*at < ' ' || *at > '~') && *at != '\n')
            *at = '?';
    return text;
}

static bool set_tags(TIFF *tiff, const void *of, int page, struct error *err)
{
    const struct picture_options *options = of;
    (void)err; /* libtiff reports its failures */
    return TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, options->description) &&
           TIFFSetField(tiff, TIFFTAG_SOFTWARE, PROGRAM) &&
           (options->bits != 32 || TIFFSetField(tiff, TIFFTAG_PAGENAME, options->channels[page])) &&
           (options->profile == NULL ||
            TIFFSetField(tiff, TIFFTAG_ICCPROFILE, (uint32_t)options->profile_length,
                         options->profile));
}

static const char *const endings[] = {".png", ".tif", ".tiff", NULL};

bool picture_accepts(const char *path, struct error *err)
{
    int ending;
    return path_ending(path, endings, &ending, err);
}

bool picture_is_png(const char *path)
{
    struct error ignored = {0};
    int ending;
    return path_ending(path, endings, &ending, &ignored) && ending == 0;
}

bool picture_open(struct picture_writer *out, const char *path,
                  const struct picture_options *options, struct error *err)
{
    const bool floating = options->bits == 32;
    int n_channels = 0;
    while (n_channels < MOST_PAGES_OF_FLOATS && options->channels[n_channels])
        n_channels++;
    *out = (struct picture_writer){.options = *options,
                                   .pages = {.count = floating ? n_channels : 1,
                                             .width = options->width,
                                             .height = options->height,
                                             .channels = floating ? 1 : 3,
                                             .bits = options->bits}};
    if (!options->memory && !picture_accepts(path, err))
        return false;
    return options->memory || picture_is_png(path)
               ? png_open(&out->png, &out->pages.output, path, options, err)
               : pages_open(&out->pages, path, set_tags, options, err);
}

bool picture_write(struct picture_writer *writer, const void *samples, int rows, struct error *err)
{
    const int width = writer->options.width;
    const size_t page_bytes = (size_t)rows * (size_t)width * pages_pixel_bytes(&writer->pages, 0);
    struct page_rectangle to = {0, 0, writer->row, width, rows};
    bool done = true;
    if (writer->png)
        done = png_write(writer->png, samples, rows, err);
    for (const char *from = samples; done && !writer->png && to.page < writer->pages.count;
         to.page++, from += page_bytes)
        done = pages_write(&writer->pages, &to, from, err);
    writer->row += rows;
    return done;
}

/* Makes room for the rows up to `end`. A strip whose rows are all written begins anew. */
static bool extend_strip(struct picture_writer *writer, int end, size_t row_bytes,
                         struct error *err)
{
    struct picture_strip *strip = &writer->strip;
    if (strip->end == writer->row)
        strip->first = writer->row;
    if (end <= strip->end)
        return true;
    const size_t n = (size_t)(end - strip->first);
    if (!memory_resize(&strip->samples, n, row_bytes))
        return memory_lacks(err, (double)n * (double)row_bytes, "rows of the picture");
    strip->end = end;
    return true;
}

bool picture_put(struct picture_writer *writer, const struct page_rectangle *at,
                 const void *samples, struct error *err)
{
    const size_t pixel = 3 * (size_t)writer->options.bits / 8;
    const size_t row_bytes = pixel * (size_t)writer->options.width, n = pixel * (size_t)at->width;
    const int end = at->y + at->height;
    if (!extend_strip(writer, end, row_bytes, err))
        return false;
    const int first = writer->strip.first;
    char *to = writer->strip.samples + (size_t)(at->y - first) * row_bytes + pixel * (size_t)at->x;
    for (int row = 0; row < at->height; row++)
        memcpy(to + (size_t)row * row_bytes, (const char *)samples + (size_t)row * n, n);
    const char *next = writer->strip.samples + (size_t)(writer->row - first) * row_bytes;
    return at->x + at->width < writer->options.width ||
           picture_write(writer, next, end - writer->row, err);
}

bool picture_finish(struct picture_writer *writer, struct error *err)
{
    return writer->png ? png_finish(writer->png, err) : pages_finish(&writer->pages, NULL, err);
}

bool picture_commit(struct picture_writer *writer, struct outputs *outputs, struct error *err)
{
    const bool done = picture_finish(writer, err) &&
                      (writer->options.memory || output_pass(&writer->pages.output, outputs, err));
    picture_discard(writer);
    return done;
}

void picture_discard(struct picture_writer *writer)
{
    png_free(writer->png);
    output_discard(&writer->pages.output);
    free(writer->strip.samples);
    *writer = (struct picture_writer){.row = 0};
}
