/* SPDX-License-Identifier: MIT */
/* spectral render --again: makes a stack again from its own record. The new stack must be the same,
 * byte for byte. */
#include <ctype.h>
#include <limits.h>

#include "raster/render/inside.h"

/* ---- options that a stack records ---- */

/* Returns what stands behind the one of these words that an option begins with; NULL: it begins
 * with none of them. */
static const char *behind(const char *option, const char *const *words)
{
    for (; *words; words++)
        if (strncmp(option, *words, strlen(*words)) == 0)
            return option + strlen(*words);
    return NULL;
}

void options_forget_check(struct options *options)
{
    static const char *const of_check[] = {
        "--no-check", "--strict", "--unchecked=", "--gl=", "--buffer=", NULL};
    int n = 0;
    for (int i = 0; i < options->n_recorded; i++)
        if (behind(options->recorded[i], of_check))
            free(options->recorded[i]);
        else
            options->recorded[n++] = options->recorded[i];
    options->n_recorded = n;
}

/* Takes from the record all options that decide the picture, and the others from the command line.
 * The caller frees *out, also after a failure. */
static bool again_options(const struct options *options, const struct record *record,
                          struct options *out, struct error *err)
{
    const struct render_options *own = options->own;
    if (!options_read(&render_command, true, record->options.text, record->options.n, out, err))
        return false;
    if (out->operand)
        return error_usage(err, "%s records '%s', which is not an option", own->again,
                           out->operand);
    out->operand = record->scene;
    out->json = options->json;
    out->threads = options->threads;
    out->quiet = options->quiet;
    struct render_options *made = out->own;
    made->maps = own->maps;
    made->bounds = own->bounds;
    made->bounds_for = own->bounds_for;
    if (!made->renderer || strcmp(made->renderer, "raster") != 0)
        return !(own->no_check || own->strict || own->unchecked) ||
               error_usage(err,
                           "%s stores OpenGL's pixels and records whether to check them; "
                           "--again takes no %s",
                           own->again,
                           own->no_check ? "--no-check"
                           : own->strict ? "--strict"
                                         : "--unchecked");
    made->no_check = own->no_check;
    made->strict = own->strict;
    made->unchecked = own->unchecked;
    made->check_map = own->check_map;
    return true;
}

/* ---- trust ---- */

/* Finds whether a file lies below the working folder, all links followed. */
static bool find_below(const char *path, bool *below, struct error *err)
{
    char folder[PATH_MAX], file[PATH_MAX];
    if (!realpath(".", folder) || !realpath(path, file))
        return error_cause(err, NOWHERE, "cannot find the folder of %s", path);
    const size_t length = strcmp(folder, "/") == 0 ? 0 : strlen(folder);
    *below = strncmp(file, folder, length) == 0 && file[length] == '/';
    return true;
}

/* A stack of a stranger could name any file, whose words an error would then show, or a pipe that
 * nobody writes to. */
static bool is_trusted(const char *stack, const char *file, struct error *err)
{
    bool regular, below = false;
    if (path_is_builtin(file) || file_is_missing(file))
        return true;
    if (!file_is_regular(file, &regular, err) || (regular && !find_below(file, &below, err)))
        return false;
    return below ||
           error_usage(err,
                       "%s names %.500s, which is no file below this folder; --trust reads it "
                       "nevertheless",
                       stack, file);
}

/* Returns the spectrum or detector that a recorded option names, e.g. of "--light=1=FILE*3"; NULL:
 * it names none. */
static const char *named_by(const char *option)
{
    static const char *const naming[] = {
        "--light=", "--ambient=", "--detector=", "--observer=", NULL};
    const char *value = behind(option, naming);
    const size_t digits = value ? strspn(value, "0123456789") : 0;
    return digits > 0 && value[digits] == '=' ? value + digits + 1 : value;
}

/* Checks the file, with and without the factor behind it. */
static bool option_is_trusted(const char *stack, const char *option, struct error *err)
{
    const char *named = named_by(option);
    char *file;
    if (!named || !string_copy(named, &file, err))
        return !named;
    char *factor = strrchr(file, '*');
    bool trusted = is_trusted(stack, file, err);
    if (factor) {
        *factor = '\0';
        trusted = trusted && is_trusted(stack, file, err);
    }
    free(file);
    return trusted;
}

/* Refuses a record that names a file that is not below the working folder. */
static bool record_is_trusted(const char *stack, const struct record *record, struct error *err)
{
    bool trusted = is_trusted(stack, record->scene, err);
    for (int i = 0; trusted && i < record->options.n; i++)
        trusted = option_is_trusted(stack, record->options.text[i], err);
    return trusted;
}

/* Replaces the message about a place in an input: it may quote a word of the file. */
static void hide_message(const char *stack, struct error *err)
{
    static const char mark[] = ": error: ";
    char *message = strstr(err->text, mark);
    if (err->status != EXIT_INPUT || !message || !isdigit((unsigned char)message[-1]))
        return;
    message += sizeof mark - 1;
    snprintf(message, (size_t)(err->text + sizeof err->text - message),
             "this input is not what it was when %.500s was made; render its scene to see why",
             stack);
}

/* ---- making it again ---- */

/* Refuses a stack that cannot be the same, before anything is drawn. */
static bool can_be_same(const struct record *record, const struct render_output *output,
                        struct error *err)
{
    if (scene_is_input(record->scene))
        return error_usage(err,
                           "%s: its scene was read from standard input, and is not in the stack; "
                           "store the scene in a file, and render that",
                           output->again);
    if (strcmp(record->program, PROGRAM) != 0 && !output->keep)
        return error_different(err,
                               "%s was made by %.80s, but this is " PROGRAM
                               ", and each stack records its program; --keep stores the new "
                               "stack anyway",
                               output->again, record->program);
    if (record->rows.n > 0)
        return error_usage(err, "%s is a part of a picture; expected a whole stack, as join writes",
                           output->again);
    bool missing;
    return scene_is_missing(record->scene, &missing, err) &&
           (!missing ||
            error_usage(err,
                        "%s: its scene '%.500s' does not exist; a relative name starts from the "
                        "folder where the stack was made",
                        output->again, record->scene));
}

static bool render_recorded(const struct options *options, const struct render_output *output,
                            struct error *err)
{
    struct image image = {.path = NULL};
    struct record record = {.text = NULL};
    struct options made = {.operand = NULL};
    const struct render_options *own = options->own;
    bool done = image_open(own->again, NOWHERE, tags_read, &image, err) &&
                record_read(&image, &record, err) && again_options(options, &record, &made, err) &&
                (own->trust || record_is_trusted(own->again, &record, err)) &&
                can_be_same(&record, output, err) &&
                render_with_options(&made, output, &record, err);
    if (!done && !own->trust)
        hide_message(own->again, err);
    options_free(&made);
    record_free(&record);
    image_close(&image);
    return done;
}

bool render_again(struct options *options, struct error *err)
{
    const struct render_options *own = options->own;
    options_forget_check(options);
    if (options->operand || options->n_recorded > 0)
        return error_usage(err, "--again takes no %s: the stack records it",
                           options->operand ? "SCENE" : options->recorded[0]);
    if (own->part)
        return error_usage(err, "--again takes no --part: it makes a whole stack");
    /* With -o /dev/null, or with its own name, the stack is written under its default name,
     * compared, and then discarded. */
    bool discard = options->output && strcmp(options->output, "/dev/null") == 0;
    if (options->output && !discard && !file_is_same(options->output, own->again, &discard, err))
        return false;
    if (discard)
        options->output = NULL;
    if (!options_name_output(options, own->again, "-again.tif", err))
        return false;
    const struct render_output output = {.path = options->output,
                                         .check_map = own->check_map,
                                         .again = own->again,
                                         .keep = own->keep,
                                         .discard = discard,
                                         .outputs = &options->outputs};
    return render_recorded(options, &output, err);
}
