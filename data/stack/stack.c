/* SPDX-License-Identifier: MIT */
/* Writes the spectral stack: a multi-page TIFF, one page a wavelength or component. The object map
 * lies behind the last page. Only the record says where: a reader of TIFF never gets there. */
#include <float.h>
#include <inttypes.h>
#include <tiffio.h>
#include <unistd.h>

#include "data/stack/inside.h"

static bool check_options(const struct stack_options *options, struct error *err)
{
    const int most_pages = 65535; /* the SHORTs of tag PageNumber */
    int n_pages = options->n_wavelengths, width = options->width, height = options->height;
    if (n_pages < 1 || n_pages > most_pages || width < 1 || height < 1)
        return error_usage(err,
                           "a stack of %d wavelengths of %dx%d pixels cannot be written; expected"
                           " 1 to %d wavelengths of at least 1x1",
                           n_pages, width, height, most_pages);
    if (!(options->full_scale > 0 && options->full_scale <= DBL_MAX))
        return error_usage(err,
                           "a full scale of %g cannot be written; expected a positive radiance",
                           options->full_scale);
    for (int page = 0; !options->components && !options->names && page < n_pages; page++) {
        /* Tag 65000 takes floats. Labels have 10 digits: closer wavelengths could share one. */
        double nm = options->wavelengths_nm[page];
        double before = page > 0 ? options->wavelengths_nm[page - 1] : 0;
        if (!(nm > before * (1 + 1e-9) && nm <= (double)FLT_MAX))
            return error_usage(err,
                               "wavelength %.10g nm after %.10g nm: the wavelengths of a stack"
                               " are finite and rise from above 0",
                               nm, before);
    }
    return true;
}

bool stack_open(struct stack_writer *out, const char *path, const struct stack_options *options,
                struct error *err)
{
    *out = (struct stack_writer){.options = *options};
    out->options.bits = options->bits > 0 ? options->bits : 16;
    if (!check_options(options, err))
        return false;
    out->pages = (struct pages){.count = options->n_wavelengths,
                                .width = options->width,
                                .height = options->height,
                                .channels = 1,
                                .bits = out->options.bits,
                                .bytes_behind = options->map_bytes,
                                .room = STACK_UNFINISHED,
                                .room_bytes = STACK_VERDICT,
                                .room_tag = TAG_VERDICT};
    return pages_open(&out->pages, path, tags_set, out, err);
}

/* Blanks fill the room behind the verdict, so that the size of the file does not depend on it.
 * A verdict that is too long loses its tail. */
bool stack_finish(struct stack_writer *writer, const char *verdict, struct error *err)
{
    char room[STACK_VERDICT];
    snprintf(room, sizeof room, "%-*.*s", STACK_VERDICT - 1, STACK_VERDICT - 1, verdict);
    return pages_finish(&writer->pages, room, err);
}

/* ---- the verdict as one line, and the line as numbers ---- */

void stack_verdict_text(const struct stack_verdict *verdict, char out[STACK_VERDICT])
{
    snprintf(out, STACK_VERDICT,
             "%s; %" PRIu64 " samples, %" PRIu64 " exact, %" PRIu64
             " within 1 count, largest difference %.3g counts, %" PRIu64 " of %" PRIu64
             " pixels unexplained, %" PRIu64 " of %" PRIu64 " object pixels not checked, %" PRIu64
             " of them along edges",
             verdict->word, verdict->samples, verdict->exact, verdict->within_1, verdict->largest,
             verdict->unexplained, verdict->pixels, verdict->unchecked, verdict->objects,
             verdict->edges);
}

uint64_t stack_unchecked(const struct stack_verdict *verdict, double most)
{
    const bool many = (double)verdict->edges > EDGE_SHARES * most * (double)verdict->objects;
    return verdict->unchecked - (many ? 0 : verdict->edges);
}

/* A line counts as read if it is the text of its numbers. */
bool stack_verdict_read(const char *line, struct stack_verdict *out)
{
    char text[STACK_VERDICT];
    *out = (struct stack_verdict){.samples = 0};
    if (sscanf(line,
               "%15[a-z ]; %" SCNu64 " samples, %" SCNu64 " exact, %" SCNu64
               " within 1 count, largest difference %lf counts, %" SCNu64 " of %" SCNu64
               " pixels unexplained, %" SCNu64 " of %" SCNu64 " object pixels not checked, %" SCNu64
               " of them along edges",
               out->word, &out->samples, &out->exact, &out->within_1, &out->largest,
               &out->unexplained, &out->pixels, &out->unchecked, &out->objects, &out->edges) != 10)
        return false;
    stack_verdict_text(out, text);
    return strcmp(text, line) == 0;
}

/* ---- two stacks ---- */

/* Finds the offset of the first byte that differs; UINT64_MAX: none does. Returns false where a
 * file cannot be read: see errno. */
static bool first_difference(int one, int other, uint64_t *out)
{
    char a[65536], b[sizeof a];
    ssize_t n = 1;
    for (*out = 0; n > 0;) {
        const ssize_t n_a = read_at(one, a, sizeof a, *out);
        const ssize_t n_b = read_at(other, b, sizeof b, *out);
        if (n_a < 0 || n_b < 0)
            return false;
        ssize_t same = 0;
        n = n_a < n_b ? n_a : n_b;
        while (same < n && a[same] == b[same])
            same++;
        *out += (uint64_t)same;
        if (same < n || (n == 0 && n_a != n_b))
            return true;
    }
    *out = UINT64_MAX;
    return true;
}

bool stack_compare(const struct stack_writer *writer, const char *path,
                   struct stack_difference *out, struct error *err)
{
    const struct stack_options *options = &writer->options;
    const struct builtin_file *builtin;
    uint64_t offset;
    int other;
    if (!file_open(path, NOWHERE, &other, &builtin, err))
        return false;
    if (builtin != NULL)
        return error_usage(err, "%s: is compiled in; only a file is compared", path);
    bool good = first_difference(writer->pages.output.descriptor, other, &offset) ||
                error_system(err, "%s: cannot be compared", path);
    close(other);
    *out = (struct stack_difference){
        .compared = good, .found = good && offset != UINT64_MAX, .page = -1};
    if (out->found && offset >= pages_offset(&writer->pages, 0) &&
        offset < pages_end(&writer->pages)) {
        int page = 0;
        while (page < options->n_wavelengths && offset >= pages_offset(&writer->pages, page + 1))
            page++;
        const uint64_t pixel =
            (offset - pages_offset(&writer->pages, page)) / pages_pixel_bytes(&writer->pages, page);
        out->in_map = page == options->n_wavelengths;
        out->page = out->in_map ? -1 : page;
        out->x = (int)(pixel % (uint64_t)options->width);
        out->y = (int)(pixel / (uint64_t)options->width);
    }
    return good;
}

/* ---- the end ---- */

void stack_discard(struct stack_writer *writer)
{
    output_discard(&writer->pages.output);
    *writer = (struct stack_writer){0};
}

const char *stack_library(void)
{
    return TIFFGetVersion();
}
