/* SPDX-License-Identifier: MIT */
/* The files that another program wrote. */
#include <errno.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include "raster/beside/verify/inside.h"

/* ---- drawn.txt ---- */

/* Copies the rest of a line, as a driver's name has blanks and may have anything else. */
static void copy_rest(const struct text *text, char *out, size_t capacity)
{
    const char *at = text->at;
    size_t length = (size_t)(text->line_end - at);
    while (length > 0 && (*at == ' ' || *at == '\t')) {
        at++;
        length--;
    }
    snprintf(out, capacity, "%.*s", (int)(length < capacity ? length : capacity - 1), at);
    hide_unprintable(out, "");
}

enum drawn_word { DRAWN_ID, DRAWN_RENDERER, DRAWN_VERSION, DRAWN_WORDS };

static bool read_line(struct text *text, struct place given[DRAWN_WORDS], struct drawn_words *out,
                      struct error *err)
{
    static const char *const known[] = {"id", "renderer", "version", NULL};
    struct word word;
    if (!text_word(text, &word))
        return true;
    switch (word_choose_once(&word, known, "line of drawn.txt", given, err)) {
    case DRAWN_ID:
        if (!text_expect(text, &word, "the id of scene.txt", err))
            return false;
        snprintf(out->id, sizeof out->id, "%.*s", (int)(word.length < 64 ? word.length : 64),
                 word.start);
        out->place = word.place;
        return text_end(text, "id", err);
    case DRAWN_RENDERER:
        copy_rest(text, out->names.renderer, sizeof out->names.renderer);
        return true;
    case DRAWN_VERSION:
        copy_rest(text, out->names.version, sizeof out->names.version);
        return true;
    default:
        return false;
    }
}

bool drawn_read_words(const char *path, struct drawn_words *out, struct error *err)
{
    struct place given[DRAWN_WORDS] = {{NULL, 0, 0}};
    struct text text;
    *out = (struct drawn_words){.place = {path, 0, 0}};
    if (!text_open(&text, path, out->place, err))
        return false;
    bool done = true;
    while (done && text_next_line(&text))
        done = read_line(&text, given, out, err);
    out->place.path = path;
    text_free(&text);
    return done && (out->id[0] || error_at(err, (struct place){path, 0, 0},
                                           "expected a line \"id\" with the id of scene.txt"));
}

/* ---- numbers ---- */

static bool read_whole(const char *path, int descriptor, size_t length, void *out,
                       struct error *err)
{
    const struct place place = {path, 0, 0};
    struct stat status;
    if (fstat(descriptor, &status) != 0)
        return error_cause(err, place, errno, "cannot read");
    if ((uint64_t)status.st_size != length)
        return error_at(err, place, "expected a file of %zu bytes, found %lld", length,
                        (long long)status.st_size);
    errno = 0;
    return read_at(descriptor, out, length, 0) == (ssize_t)length ||
           error_cause(err, place, errno, "cannot read");
}

bool drawn_read_file(const char *folder, const char *name, size_t length, void *out, bool *found,
                     struct error *err)
{
    char path[4096 + FILE_NAME];
    const struct builtin_file *builtin;
    int descriptor;
    snprintf(path, sizeof path, "%.4095s/%s", folder, name);
    if (found && !(*found = !file_is_missing(path)))
        return true;
    if (!file_open(path, (struct place){path, 0, 0}, &descriptor, &builtin, err))
        return false;
    const bool done = read_whole(path, descriptor, length, out, err);
    close(descriptor);
    return done;
}
