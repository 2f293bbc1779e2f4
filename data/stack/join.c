/* SPDX-License-Identifier: MIT */
/* spectral join: the stacks of parts become the stack of the whole picture. Each part has whole
 * rows of pixels, and its record says which. All else in the records must be the same. Parts are
 * opened one after the other, so that their number has no limit. */
#include "data/stack/inside.h"

enum { COPIED_BYTES = 1 << 22 };

struct join_options {
    bool keep;
};
struct joined {
    struct cube first; /* part; it stays open */
    char *record;      /* as common_lines returns it; owned */
    struct stack_verdict sums;
    bool has_sums; /* the parts' lines have numbers */
    struct stack_writer writer;
    unsigned char *has; /* of each row of the picture: a part had it; owned */
    char *bytes;        /* COPIED_BYTES; owned */
};

/* ---- records ---- */

static bool refuse_changed(const struct cube *part, struct error *err)
{
    return error_usage(err, "%s was cut or changed after it was rendered; render this part again",
                       part->image.path);
}

/* Returns the lines that all parts record alike, allocated; NULL: there are none, or no memory.
 * They lie between those of the scale and those of the part. */
static char *common_lines(const struct cube *part, struct error *err)
{
    struct printed lines = {.text = NULL};
    char *record = description_text(part->image.description, err);
    const char *from = record ? strstr(record, "program: ") : NULL,
               *end = from ? strstr(from, "\nrows: ") : NULL;
    if (end)
        print_bytes(&lines, from, (size_t)(end + 1 - from));
    else
        refuse_changed(part, err);
    free(record);
    return printed_take(&lines, err);
}

/* Refuses a part whose samples or object map do not lie where render puts them. */
static bool check_layout(const struct joined *joined, const struct cube *part,
                         const struct raw_samples *layout, struct error *err)
{
    const struct cube *first = &joined->first;
    const struct record *record = &part->record;
    const struct numbers *nm = &record->wavelengths; /* one a page, or none */
    return (part->image.width == first->image.width &&
            part->image.n_pages == first->image.n_pages &&
            layout->bits == joined->writer.pages.bits && !layout->by_pixels &&
            !layout->big_endian && record->rows.value[2] == first->record.rows.value[2] &&
            strcmp(record->full_scale, first->record.full_scale) == 0 &&
            (nm->n == 0 || memcmp(nm->value, first->record.wavelengths.value,
                                  (size_t)nm->n * sizeof *nm->value) == 0) &&
            record->map_bytes == first->record.map_bytes &&
            (record->map_bytes > 0) == (record->object_map != NULL)) ||
           refuse_changed(part, err);
}

/* Refuses a record that differs from that of the first part. Names the first line that does. */
static bool check_common(const struct joined *joined, const struct cube *part, struct error *err)
{
    char *common = common_lines(part, err);
    const char *a = joined->record, *b = common;
    if (!common)
        return false;
    while (*a && strncmp(a, b, strcspn(a, "\n") + 1) == 0) {
        a += strcspn(a, "\n") + 1;
        b += strcspn(b, "\n") + 1;
    }
    const bool same = *a == *b && !*a;
    if (!same)
        error_usage(err, "%s is a part of another render than %s: it records '%.*s', not '%.*s'",
                    part->image.path, joined->first.image.path, (int)strcspn(b, "\n"), b,
                    (int)strcspn(a, "\n"), a);
    free(common);
    return same;
}

/* ---- verdicts ---- */

/* Adds up the verdicts of parts. Those without numbers must be the same. */
static bool add_verdict(struct joined *joined, const struct cube *part, struct error *err)
{
    struct stack_verdict own, *sums = &joined->sums;
    const struct image *first = &joined->first.image;
    const bool counts = stack_verdict_read(part->image.verdict, &own);
    if (counts != joined->has_sums || (!counts && strcmp(part->image.verdict, first->verdict) != 0))
        return error_usage(err, "%s: its verdict is '%s', but that of %s is '%s'", part->image.path,
                           part->image.verdict, first->path, first->verdict);
    if (!counts)
        return true;
    if (strcmp(own.word, "differs") == 0 || !sums->word[0])
        memcpy(sums->word, own.word, sizeof sums->word);
    sums->samples += own.samples;
    sums->exact += own.exact;
    sums->within_1 += own.within_1;
    sums->largest = own.largest > sums->largest ? own.largest : sums->largest;
    sums->unexplained += own.unexplained;
    sums->pixels += own.pixels;
    sums->unchecked += own.unchecked;
    sums->objects += own.objects;
    sums->edges += own.edges;
    return true;
}

/* Finds the share of object pixels that may stay unchecked, by the options of the record. */
static bool find_share(const struct record *record, double *out, struct error *err)
{
    static const char unchecked[] = "--unchecked=";
    const size_t length = sizeof unchecked - 1;
    *out = USUAL_UNCHECKED;
    for (int i = 0; i < record->options.n; i++)
        if (strcmp(record->options.text[i], "--strict") == 0)
            *out = 0;
    for (int i = 0; i < record->options.n; i++)
        if (strncmp(record->options.text[i], unchecked, length) == 0 &&
            !option_number("--unchecked", record->options.text[i] + length, 0, 1, out, err))
            return false;
    return true;
}

/* Concludes from the sums as a check of the whole picture does, by the recorded options. Each part
 * agrees on average by itself. */
static bool conclude(struct joined *joined, struct error *err)
{
    struct stack_verdict *sums = &joined->sums;
    double most;
    if (!find_share(&joined->first.record, &most, err))
        return false;
    if (strcmp(sums->word, "differs") != 0)
        snprintf(sums->word, sizeof sums->word, "%s",
                 (double)stack_unchecked(sums, most) > most * (double)sums->objects ? "not verified"
                                                                                    : "agreed");
    return true;
}

/* ---- rows ---- */

/* Lays out the whole stack, which the first part describes. The lines of its scale and of its
 * object map are stack_open's. */
static bool open_whole(struct joined *joined, const char *path, struct error *err)
{
    const struct cube *part = &joined->first;
    struct raw_samples layout = {.bits = 0};
    struct sampling_method method;
    bool done = image_describe(&part->image, &layout, err) &&
                (joined->record = common_lines(part, err)) &&
                MAKE_ARRAY(joined->has, part->record.rows.value[2], err, "rows of %s", path) &&
                MAKE_ARRAY(joined->bytes, COPIED_BYTES, err, "rows of %s", path);
    if (done && part->components)
        done = sampling_read(part->image.path, part->record.sampling, &method, err);
    joined->has_sums = stack_verdict_read(part->image.verdict, &joined->sums);
    joined->sums = (struct stack_verdict){.samples = 0};
    const struct stack_options options = {.width = part->image.width,
                                          .height = (int)part->record.rows.value[2],
                                          .n_wavelengths = part->image.n_pages,
                                          .wavelengths_nm = part->record.wavelengths.value,
                                          .full_scale = strtod(part->record.full_scale, NULL),
                                          .bits = layout.bits,
                                          .scene = part->record.scene,
                                          .provenance = joined->record,
                                          .map_bytes = part->record.map_bytes,
                                          .unit = part->record.unit,
                                          .components = part->components ? &method : NULL};
    done = done && stack_open(&joined->writer, path, &options, err);
    joined->writer.pages.as_stored = true; /* copied from another stack */
    return done;
}

/* Marks the rows of a part. Refuses rows that another part had. */
static bool mark_rows(struct joined *joined, const struct cube *part, struct error *err)
{
    const int first = (int)part->record.rows.value[0];
    for (int y = first; y < first + part->image.height; y++)
        if (joined->has[y]++)
            return error_usage(err, "%s: another part has its row %d", part->image.path, y);
    return true;
}

/* Copies a page of a part, some rows at a time. The object map is the page after the last one. */
static bool copy_page(struct joined *joined, const struct cube *part, int page, uint64_t from,
                      size_t row_bytes, struct error *err)
{
    const struct image *image = &part->image;
    const int most = row_bytes < COPIED_BYTES ? (int)(COPIED_BYTES / row_bytes) : 1,
              first = (int)part->record.rows.value[0];
    for (int y = 0; y < image->height; y += most) {
        const int rows = image->height - y < most ? image->height - y : most;
        const struct page_rectangle to = {page, 0, first + y, image->width, rows};
        if (!image_read_bytes(image, from + (uint64_t)y * row_bytes, (size_t)rows * row_bytes,
                              joined->bytes, err) ||
            !pages_write(&joined->writer.pages, &to, joined->bytes, err))
            return false;
    }
    return true;
}

/* from: the place of the first page. */
static bool copy_rows(struct joined *joined, const struct cube *part, uint64_t from,
                      struct error *err)
{
    const struct image *image = &part->image;
    const size_t row_bytes = (size_t)image->width * (size_t)joined->writer.pages.bits / 8;
    for (int page = 0; page < image->n_pages; page++, from += row_bytes * (uint64_t)image->height)
        if (!copy_page(joined, part, page, from, row_bytes, err))
            return false;
    return part->record.map_bytes == 0 ||
           copy_page(joined, part, image->n_pages, part->record.map_offset,
                     (size_t)image->width * (size_t)part->record.map_bytes, err);
}

/* ---- parts ---- */

static bool open_part(const char *path, struct cube *out, struct error *err)
{
    return cube_open(path, out, err) &&
           (out->record.rows.n > 0 ||
            error_usage(err, "%s is no part of a picture; expected stacks of render --part", path));
}

static bool add_part(struct joined *joined, const struct cube *part, struct error *err)
{
    struct raw_samples layout;
    return image_describe(&part->image, &layout, err) && check_common(joined, part, err) &&
           check_layout(joined, part, &layout, err) && mark_rows(joined, part, err) &&
           add_verdict(joined, part, err) && copy_rows(joined, part, layout.offset, err);
}

/* Refuses a picture that lacks rows. */
static bool check_rows(const struct joined *joined, struct error *err)
{
    const int height = (int)joined->first.record.rows.value[2];
    int first = 0, end;
    while (first < height && joined->has[first])
        first++;
    for (end = first; end < height && !joined->has[end];)
        end++;
    return first == height ||
           error_usage(err,
                       "rows %d to %d of the picture are missing; expected the parts with them",
                       first, end - 1);
}

/* Stores the stack if its verdict agrees, or if it is kept anyway. */
static bool finish(struct joined *joined, struct options *options, struct error *err)
{
    const struct join_options *own = options->own;
    char line[STACK_VERDICT];
    if (!check_rows(joined, err) || (joined->has_sums && !conclude(joined, err)))
        return false;
    snprintf(line, sizeof line, "%s", joined->first.image.verdict);
    if (joined->has_sums)
        stack_verdict_text(&joined->sums, line);
    const bool agreed = !joined->has_sums || strcmp(joined->sums.word, "agreed") == 0;
    bool done = stack_finish(&joined->writer, line, err);
    if (done && (agreed || own->keep))
        done = output_pass(&joined->writer.pages.output, &options->outputs, err);
    return done && (agreed ||
                    error_different(err, "the joined picture: %s; %s", line,
                                    own->keep ? "the stack was kept"
                                              : "no stack was written (--keep stores it anyway)"));
}

static bool report(const struct options *options, const struct joined *joined, struct error *err)
{
    struct printed printed = {.text = NULL};
    if (!options->quiet)
        print(&printed, "stack             %s, of %d parts\nverdict           %s\n",
              options->output, options->n_operands,
              joined->has_sums ? joined->sums.word : joined->first.image.verdict);
    return printed_show(&printed, options_table(options, options->output), err);
}

static bool run_join(struct options *options, struct error *err)
{
    struct joined joined = {.record = NULL};
    if (!options->output || !options->operand || picture_is_png(options->output))
        return error_usage(err, "join takes -o STACK.tif and the stacks of parts");
    bool done = open_part(options->operand, &joined.first, err) &&
                open_whole(&joined, options->output, err) && add_part(&joined, &joined.first, err);
    for (int i = 1; done && i < options->n_operands; i++) {
        struct cube part = {.components = false};
        done = open_part(options->operands[i], &part, err) && add_part(&joined, &part, err);
        cube_close(&part);
    }
    done = done && finish(&joined, options, err) && report(options, &joined, err);
    stack_discard(&joined.writer);
    cube_close(&joined.first);
    FREE_ALL(joined.record, joined.has, joined.bytes);
    return done;
}

static const struct option join_rows[] = {
    {"-o, --output STACK.tif", "writes there; - is standard output", SHARED(TEXT, output),
     .writes = true},
    {"--keep", "stores the stack even if the check fails", OWN(FLAG, join_options, keep)},
};
const struct command join_command = {
    .name = "join",
    .operands = "-o STACK PART...",
    .summary = "put together the parts that render --part drew",
    .example = "join -o colorchecker.tif colorchecker.*-of-2.tif",
    .run = run_join,
    .rows = OPTION_LIST(join_rows),
    .shared = {&quiet_option},
    .own_size = sizeof(struct join_options),
    .n_operands = MOST_OPERANDS,
};
