/* SPDX-License-Identifier: MIT */
/* Reads a list of renders, and writes its lines as commands. */
#include <stdlib.h>
#include <string.h>

#include "data/index/index.h"
#include "raster/batch/batch.h"
#include "raster/parts/parts.h"

/* ---- reading ---- */

static bool add_word(struct batch_line *line, const struct word *word, struct error *err)
{
    char *copy = word_copy(word, err);
    if (!copy)
        return error_memory(err);
    if (array_add(&line->words, &line->n_words, &copy, sizeof copy, err))
        return true;
    free(copy);
    return false;
}

/* Reads the words of the current line, which has some. */
static bool read_words(struct text *text, struct batch_line *out, struct error *err)
{
    struct word word;
    while (text_peek(*text, &word)) {
        if (!text_expect(text, &word, "a word", err) || !add_word(out, &word, err))
            return false;
        if (out->n_words == 1)
            out->place = word.place;
    }
    return true;
}

/* Refuses what makes no sense in a list. */
static bool check_line(const struct options *of, struct place place, struct error *err)
{
    const char *wrong = of->again                                            ? "--again"
                        : of->help                                           ? "--help"
                        : of->output && output_is_standard(of->output)       ? "-o -"
                        : of->json && output_is_standard(of->json)           ? "--json -"
                        : of->check_map && output_is_standard(of->check_map) ? "--check-map -"
                        : of->operand && output_is_standard(of->operand)     ? "-"
                                                                             : NULL;
    return !wrong || error_at(err, place, "a line of a batch takes no %s", wrong);
}

/* Finds the file that a line writes: a stack, or the file of a part. */
static bool find_output(struct options *of, char **out, struct error *err)
{
    struct picture_part part;
    if (!options_name_output(of, options_scene(of), ".tif", err) ||
        (of->part && !part_read("--part", of->part, &part, err)))
        return false;
    *out = of->part ? part_name(of->output, &part) : strdup(of->output);
    return *out || error_memory(err);
}

/* Puts the line's place before the message of an option, which has none. */
static bool fail_line(struct place place, struct error *err)
{
    struct error at = {.status = EXIT_AGREED};
    if (err->status != EXIT_INPUT)
        return false;
    error_at(&at, place, "%s", error_words(err));
    *err = at;
    return false;
}

static bool complete_line(const struct options *options, struct batch_line *line, struct error *err)
{
    const struct option_rules rules = {"render", options->table, FOR_RENDER, 1};
    struct options of;
    bool done = options_read(&rules, line->words, line->n_words, &of, err);
    done = done ? check_line(&of, line->place, err) &&
                      (find_output(&of, &line->output, err) || fail_line(line->place, err))
                : fail_line(line->place, err);
    options_free(&of);
    return done;
}

/* Refuses the output of an earlier line: each would draw over the other. */
static bool check_output(const struct batch *batch, struct index *outputs, int i, struct error *err)
{
    const struct batch_line *line = &batch->lines[i];
    const size_t length = strlen(line->output);
    const int earlier = index_find(outputs, line->output, length);
    if (strcmp(line->output, "/dev/null") == 0)
        return true;
    return earlier < 0 ? index_add(outputs, line->output, length, i, err)
                       : error_at(err, line->place, "line %d writes %s, too; expected another -o",
                                  batch->lines[earlier].place.line, line->output);
}

static bool read_lines(const struct options *options, struct batch *out, struct error *err)
{
    struct index outputs = {.slots = NULL};
    bool done = true;
    while (done && text_next_line(&out->text)) {
        struct word word;
        if (!text_peek(out->text, &word))
            continue;
        const int i = out->n_lines;
        done = array_add(&out->lines, &out->n_lines, NULL, sizeof *out->lines, err) &&
               read_words(&out->text, &out->lines[i], err) &&
               complete_line(options, &out->lines[i], err) && check_output(out, &outputs, i, err);
    }
    index_free(&outputs);
    return done;
}

bool batch_read(const struct options *options, struct batch *out, struct error *err)
{
    const char *list = options->operand;
    *out = (struct batch){.lines = NULL};
    if (!list)
        return error_usage(err, "batch needs LIST, a file with a render in each line");
    return (output_is_standard(list) ? text_open_input(&out->text, "<stdin>", err)
                                     : text_open(&out->text, list, (struct place){0}, err)) &&
           read_lines(options, out, err) &&
           (out->n_lines > 0 || error_at(err, text_whole(&out->text),
                                         "the list is empty; expected lines as "
                                         "'spheres --size 300x200 -o spheres.tif'"));
}

void batch_free(struct batch *batch)
{
    for (int i = 0; i < batch->n_lines; i++) {
        for (int j = 0; j < batch->lines[i].n_words; j++)
            free(batch->lines[i].words[j]);
        free(batch->lines[i].words);
        free(batch->lines[i].output);
    }
    free(batch->lines);
    text_free(&batch->text);
    *batch = (struct batch){.lines = NULL};
}

/* ---- commands ---- */

/* Prints a word as a shell reads it: between quotes, unless it has only characters that need none.
 */
static void print_word(const char *word, struct printed *to)
{
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789"
                                "%+,-./:=@_";
    if (word[0] != '\0' && word[strspn(word, plain)] == '\0') {
        print_text(to, word);
        return;
    }
    print_text(to, "'");
    for (; *word != '\0'; word++)
        if (*word == '\'')
            print_text(to, "'\\''");
        else
            print_bytes(to, word, 1);
    print_text(to, "'");
}

void batch_print_command(const char *program, const struct batch_line *line, struct printed *to)
{
    print_word(program, to);
    print_text(to, " render");
    for (int i = 0; i < line->n_words; i++) {
        print_text(to, " ");
        print_word(line->words[i], to);
    }
    print_text(to, "\n");
}
