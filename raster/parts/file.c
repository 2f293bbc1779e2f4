/* SPDX-License-Identifier: MIT */
/* The file of a part: a head of text, then one tile after the other. A tile begins with its mark,
 * and its samples and its sums follow. These reach the disk before the mark is written, so that a
 * tile with a mark is complete. */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "raster/parts/parts.h"

/* The head has whole blocks; behind its text there are zeros. */
enum { HEAD_BLOCK = 4096, LONGEST_HEAD = 1 << 28 };
static const char magic[] = "spectral part 1\n";

/* ---- names and sizes ---- */

char *part_name(const char *stack, const struct picture_part *part)
{
    const size_t length = strlen(stack) + 64;
    char *name = malloc(length);
    if (name)
        snprintf(name, length, "%s.%d-of-%d.part", stack, part->number, part->count);
    return name;
}

static uint64_t sample_bytes(const struct plan *plan, int tile)
{
    const struct rectangle picture = plan_picture(plan),
                           positions = plan_tile(plan, &picture, tile),
                           at = plan_pixels(plan, &positions);
    return (uint64_t)at.width * (uint64_t)at.height *
           ((uint64_t)plan->n_bands * (uint64_t)plan->options.bits / 8 + (uint64_t)plan->map_bytes);
}

/* Samples of a tile in the part's own file. */
static uint64_t own_bytes(const struct part_file *file, int tile)
{
    return file->stack ? 0 : sample_bytes(file->plan, tile);
}

static uint64_t head_bytes(const char *text)
{
    return (sizeof magic - 1 + strlen(text)) / HEAD_BLOCK * HEAD_BLOCK + HEAD_BLOCK;
}

static bool fail_write(const struct part_file *file, struct error *err)
{
    return error_cause(err, (struct place){NULL, 0, 0}, errno, "cannot write %s", file->path);
}

/* ---- marks ---- */

struct mark {
    uint32_t tile, samples_checksum, sums_checksum, checksum; /* the last one: of the others */
    uint64_t samples_length, sums_length;
};

static void write_mark(const struct mark *mark, unsigned char out[MARK_BYTES])
{
    memcpy(out, &mark->tile, 4);
    memcpy(out + 4, &mark->samples_checksum, 4);
    memcpy(out + 8, &mark->samples_length, 8);
    memcpy(out + 16, &mark->sums_length, 8);
    memcpy(out + 24, &mark->sums_checksum, 4);
    const uint32_t checksum = checksum_add(0, out, 28);
    memcpy(out + 28, &checksum, 4);
}

/* Returns whether these bytes are the mark of a tile of such a size. */
static bool read_mark(const unsigned char bytes[MARK_BYTES], int tile, uint64_t samples,
                      struct mark *out)
{
    memcpy(&out->tile, bytes, 4);
    memcpy(&out->samples_checksum, bytes + 4, 4);
    memcpy(&out->samples_length, bytes + 8, 8);
    memcpy(&out->sums_length, bytes + 16, 8);
    memcpy(&out->sums_checksum, bytes + 24, 4);
    memcpy(&out->checksum, bytes + 28, 4);
    return out->checksum == checksum_add(0, bytes, 28) && out->tile == (uint32_t)tile &&
           out->samples_length == samples && out->sums_length <= SIZE_MAX / 2;
}

/* ---- the head ---- */

/* Refuses a head that records other facts. A process that was killed may have left its beginning,
 * or zeros. */
static bool check_head(const struct part_file *file, const char *found, const char *wanted,
                       size_t length, struct error *err)
{
    const struct place place = {file->path, 0, 0};
    char own[FACT_LINE], other[FACT_LINE];
    size_t same = 0;
    while (same < length && found[same] == wanted[same])
        same++;
    const size_t head = same;
    while (same < length && found[same] == '\0')
        same++;
    if (same == length)
        return true;
    if (head < sizeof magic - 1)
        return error_at(err, place, "is no part of a picture, and would be lost; move it away");
    facts_differ(wanted, found, own, other);
    return error_at(err, place,
                    "was begun with '%s', and this is '%s'; remove it to begin this part again",
                    other, own);
}

/* Reads what there is of the head; *out ends with a NUL. */
static bool read_head(const struct part_file *file, size_t most, char **out, size_t *length,
                      struct error *err)
{
    *out = malloc(most + 1);
    if (!*out)
        return error_memory(err);
    const ssize_t got = read_at(file->output.descriptor, *out, most, 0);
    if (got < 0)
        return error_system(err, "%s: cannot be read", file->path);
    *length = (size_t)got;
    (*out)[got] = '\0';
    return true;
}

/* Writes the head. Another process may write the same one meanwhile. */
static bool write_head(struct part_file *file, struct error *err)
{
    const size_t length = (size_t)head_bytes(file->text);
    char *wanted = calloc(length, 1), *found = NULL;
    size_t n = 0;
    bool done = wanted || error_memory(err);
    if (done) {
        memcpy(wanted, magic, sizeof magic - 1);
        memcpy(wanted + sizeof magic - 1, file->text, strlen(file->text));
        done = read_head(file, length, &found, &n, err) &&
               check_head(file, found, wanted, n, err) &&
               (write_at(file->output.descriptor, wanted, length, 0) || fail_write(file, err)) &&
               output_sync(&file->output, err);
    }
    free(wanted);
    free(found);
    file->at = length;
    return done;
}

/* ---- appending ---- */

static bool append_samples(struct tile_sink *sink, const struct stack_rectangle *to,
                           const void *samples, struct error *err)
{
    struct part_file *file = (struct part_file *)sink;
    const struct plan *plan = file->plan;
    const size_t size = to->page == plan->n_bands ? (size_t)plan->map_bytes
                                                  : (size_t)plan->options.bits / 8,
                 length = size * (size_t)to->width * (size_t)to->height;
    file->checksum = checksum_add(file->checksum, samples, length);
    if (file->stack)
        return stack_write(file->stack, to, samples, err);
    if (!write_at(file->output.descriptor, samples, length, file->at + MARK_BYTES + file->length))
        return fail_write(file, err);
    file->length += length;
    return true;
}

/* Samples and sums reach the disk before their marks. After a failure these tiles get none: a
 * system may report lost samples only once, so that a second sync would seem to succeed. */
static bool write_marks(struct part_file *file, struct error *err)
{
    const int n = file->n_late;
    file->n_late = 0;
    if ((file->stack && !unfinished_sync(file->stack, err)) || !output_sync(&file->output, err))
        return false;
    for (int i = 0; i < n; i++)
        if (!write_at(file->output.descriptor, file->late[i].bytes, MARK_BYTES, file->late[i].at))
            return fail_write(file, err);
    file->synced = clock_seconds();
    return true;
}

/* A process that waited for the disk after each tile would draw a sixth longer. So it waits this
 * often, and loses no more if the machine loses its power. */
static const double sync_seconds = 0.5;

static bool append_sums(struct tile_sink *sink, const unsigned char *sums, size_t length,
                        struct error *err)
{
    struct part_file *file = (struct part_file *)sink;
    struct part_mark *late = &file->late[file->n_late++];
    const struct mark mark = {.tile = (uint32_t)file->tiles[file->n_complete],
                              .samples_length = file->length,
                              .samples_checksum = file->checksum,
                              .sums_length = length,
                              .sums_checksum = checksum_add(0, sums, length)};
    const uint64_t begin = file->at, end = begin + MARK_BYTES + file->length + length;
    write_mark(&mark, late->bytes);
    late->at = begin;
    if (!write_at(file->output.descriptor, sums, length, end - length)) {
        file->n_late--;
        return fail_write(file, err);
    }
    output_written(&file->output, begin, end - begin);
    file->at = end;
    file->length = file->checksum = 0;
    const bool last = ++file->n_complete == file->n_tiles,
               now = last || file->n_late == MOST_LATE ||
                     clock_seconds() - file->synced >= sync_seconds;
    return !now || (write_marks(file, err) && (!last || output_sync(&file->output, err)));
}

/* ---- opening ---- */

static bool open_file(struct part_file *file, int flags, struct error *err)
{
    const struct place nowhere = {NULL, 0, 0};
    struct stat status;
    UNTIL_DONE(file->output.descriptor, open(file->path, flags | O_CLOEXEC | O_NOCTTY, 0666));
    if (file->output.descriptor < 0 || fstat(file->output.descriptor, &status) != 0)
        return error_cause(err, nowhere, errno, "cannot open %s", file->path);
    file->output.path = file->path;
    file->synced = clock_seconds();
    return S_ISREG(status.st_mode) || error_usage(err, "%s: is no regular file", file->path);
}

/* Reserves room for the samples of the tiles that are not there yet. Refuses a disk without. */
static bool reserve(const struct part_file *file, struct error *err)
{
    struct stat status;
    uint64_t end = file->at;
    for (int i = 0; i < file->n_tiles; i++)
        end += MARK_BYTES + own_bytes(file, file->tiles[i]);
    if (fstat(file->output.descriptor, &status) != 0)
        return error_system(err, "%s: cannot be read", file->path);
    const uint64_t there = (uint64_t)status.st_size;
    if (end > there && !output_fits(file->output.descriptor, file->path, end - there, err))
        return false;
    errno = 0;
    return output_reserve(&file->output, end) || fail_write(file, err);
}

bool part_create(const char *stack, const struct plan *plan, const char *text,
                 struct part_file *file, struct error *err)
{
    file->sink = (struct tile_sink){append_samples, append_sums};
    file->output.descriptor = -1;
    file->path = part_name(stack, &file->part);
    file->text = strdup(text);
    if (!file->path || !file->text)
        return error_memory(err);
    return open_file(file, O_RDWR | O_CREAT, err) && write_head(file, err) &&
           part_plan(file, plan, err) && reserve(file, err);
}

bool part_open(const char *path, const struct picture_part *part, struct part_file *out,
               struct error *err)
{
    const struct place place = {path, 0, 0};
    char *head = NULL;
    size_t length = 0, most = HEAD_BLOCK;
    *out = (struct part_file){.part = *part, .path = strdup(path), .output = {.descriptor = -1}};
    if (!out->path)
        return error_memory(err);
    bool done = open_file(out, O_RDONLY, err);
    /* the text ends where the zeros begin */
    for (; done; most *= 2) {
        free(head);
        done = read_head(out, most, &head, &length, err);
        if (!done || length < most || strlen(head) < most || most >= LONGEST_HEAD)
            break;
    }
    if (done && (length < sizeof magic - 1 || memcmp(head, magic, sizeof magic - 1) != 0 ||
                 strlen(head) == length))
        done = error_at(err, place, "is no part of a picture, or not a whole one");
    if (done) {
        out->text = strdup(head + sizeof magic - 1);
        done = out->text || error_memory(err);
    }
    if (done)
        out->at = head_bytes(out->text);
    free(head);
    return done;
}

bool part_plan(struct part_file *file, const struct plan *plan, struct error *err)
{
    file->plan = plan;
    return part_deal(plan, &file->part, &file->tiles, &file->n_tiles, err);
}

/* ---- reading ---- */

bool part_samples(const struct part_file *file, uint64_t at, void *out, size_t length,
                  uint32_t *checksum, struct error *err)
{
    const ssize_t got = read_at(file->output.descriptor, out, length, at);
    if (got != (ssize_t)length)
        return error_at(err, (struct place){file->path, 0, 0}, "is truncated, or cannot be read");
    *checksum = checksum_add(*checksum, out, length);
    return true;
}

/* Reads the sums of a tile. Finds none where they are not those that the mark was made of. */
static bool read_sums(const struct part_file *file, const struct mark *mark, struct part_tile *out,
                      bool *found, struct error *err)
{
    const uint64_t at = out->samples + mark->samples_length;
    struct stat status;
    if (fstat(file->output.descriptor, &status) != 0)
        return error_system(err, "%s: cannot be read", file->path);
    if (at > (uint64_t)status.st_size || mark->sums_length > (uint64_t)status.st_size - at)
        return true;
    out->sums_length = (size_t)mark->sums_length;
    out->sums = malloc(out->sums_length + 1);
    if (!out->sums)
        return error_memory(err);
    uint32_t checksum = 0;
    if (!part_samples(file, at, out->sums, out->sums_length, &checksum, err))
        return false;
    *found = checksum == mark->sums_checksum;
    return true;
}

/* Reads the mark of the next tile. Returns false where there is none. */
static bool find_mark(const struct part_file *file, struct mark *out)
{
    unsigned char bytes[MARK_BYTES];
    if (file->n_complete == file->n_tiles)
        return false;
    const int tile = file->tiles[file->n_complete];
    return read_at(file->output.descriptor, bytes, MARK_BYTES, file->at) == MARK_BYTES &&
           read_mark(bytes, tile, own_bytes(file, tile), out);
}

bool part_begun(const struct part_file *file)
{
    struct mark ignored;
    return find_mark(file, &ignored);
}

bool part_next(struct part_file *file, bool *found, struct part_tile *out, struct error *err)
{
    struct mark mark;
    *found = false;
    *out = (struct part_tile){.samples = file->at + MARK_BYTES};
    errno = 0;
    if (!find_mark(file, &mark))
        return errno == 0 || error_system(err, "%s: cannot be read", file->path);
    if (!read_sums(file, &mark, out, found, err) || !*found) {
        free(out->sums);
        out->sums = NULL;
        return err->status == EXIT_AGREED;
    }
    out->checksum = mark.samples_checksum;
    file->at += MARK_BYTES + mark.samples_length + mark.sums_length;
    file->n_complete++;
    return true;
}

/* Tiles that are whole are kept if the process ends early. */
void part_close(struct part_file *file)
{
    struct error ignored = {.status = EXIT_AGREED};
    if (file->n_late > 0)
        write_marks(file, &ignored);
    if (file->path && file->output.descriptor >= 0)
        close(file->output.descriptor);
    free(file->path);
    free(file->text);
    free(file->tiles);
    *file = (struct part_file){.path = NULL};
}
