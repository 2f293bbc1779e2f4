/* SPDX-License-Identifier: MIT */
/* Reads a command line by the rules of a table, and explains the options in it. */
#include <strings.h>
#include <sys/resource.h>
#include <unistd.h>

#include "data/text/text.h"

/* ---- options that many commands take ---- */

static const struct option common_rows[] = {
    {"--memory MIB", "MiB of memory that a command may take beyond a tile's 300 (default: 1024)",
     SHARED(COUNT, memory_mib), .lowest = 1, .highest = 1 << 24},
    {"-h, --help", "prints the help of this command; spectral -V, --version prints the versions",
     SHARED(FLAG, help)},
};
static const struct option threads_rows[] = {
    {"-j, --threads N", "threads to compute with (default: one per processor)",
     SHARED(COUNT, threads), .lowest = 1, .highest = 1024},
};
static const struct option json_rows[] = {
    {"--json FILE", "writes the results as JSON; - is standard output", SHARED(TEXT, json),
     .writes = true},
};
static const struct option quiet_rows[] = {
    {"-q, --quiet", "prints no table and no progress", SHARED(FLAG, quiet)},
};
static const struct option seeing_rows[] = {
    {"--detector, --observer NAME", "sees with it, an observer or a camera (default: cie1931)",
     SHARED(TEXT, detector)},
    {"--white LIGHT[*REFLECTANCE]|object:NAME",
     "what is white: under this light, or an object's mean (default: the stack's lights)",
     SHARED(TEXT, white)},
    {"--matrix FILE", "takes the detector's values to XYZ: three numbers a channel, a row each",
     SHARED(TEXT, matrix)},
};
const struct option_list common_options = OPTION_LIST(common_rows),
                         threads_option = OPTION_LIST(threads_rows),
                         json_option = OPTION_LIST(json_rows),
                         quiet_option = OPTION_LIST(quiet_rows),
                         seeing_options = OPTION_LIST(seeing_rows);

/* ---- values ---- */

bool option_number(const char *option, const char *value, double lowest, double highest,
                   double *out, struct error *err)
{
    const char *start = value + strspn(value, " ");
    const struct word word = {.start = start, .length = strlen(start), .place = VALUE_OF(option)};
    return word_number(&word, "value", lowest, highest, out, err);
}

bool option_count(const char *option, const char *value, double lowest, double highest, int *out,
                  struct error *err)
{
    double count;
    if (!option_number(option, value, lowest, highest, &count, err))
        return false;
    *out = (int)count;
    return count == *out ||
           error_at(err, VALUE_OF(option), "value must be a whole number, not '%s'", value);
}

/* ---- one option ---- */

const struct option *option_at(const struct command *command, int i)
{
    const struct option_list *list = &command->rows, *const *next = command->shared;
    for (; i >= list->n; list = *next ? *next++ : &common_options) {
        if (list == &common_options)
            return NULL;
        i -= list->n;
    }
    return &list->options[i];
}

/* Goes on to the next name that a usage begins with, and sets its length. NULL: there is none. */
static const char *next_name(const char *usage, size_t *length)
{
    usage += strspn(usage, ", ");
    *length = strcspn(usage, ", ");
    return *usage == '-' ? usage : NULL;
}

/* Returns whether the word is one of the names that the usage begins with. Case counts in names of
 * one letter. */
static bool names_option(const char *usage, const char *word, size_t length)
{
    size_t n;
    for (const char *name = usage; (name = next_name(name, &n)); name += n)
        if (n == length && (n == 2 ? strncmp : strncasecmp)(name, word, n) == 0)
            return true;
    return false;
}

/* The words of a command line, and what they may be. */
struct reading {
    const struct command *command;
    bool recorded; /* only options that a stack records */
    const char *const *words;
    int n_words, at; /* at: the word that is read */
};

static bool is_known(const struct reading *reading, const struct option *option)
{
    return option->recorded || !reading->recorded;
}

/* Finds the option that the command takes; NULL: it takes none of that name. */
static const struct option *find_option(const struct reading *reading, const char *word,
                                        size_t length)
{
    const struct option *option;
    for (int i = 0; (option = option_at(reading->command, i)); i++)
        if (is_known(reading, option) && names_option(option->usage, word, length))
            return option;
    return NULL;
}

static bool refuse_option(const struct reading *reading, const char *word, size_t length,
                          struct error *err)
{
    const struct word typed = {.start = word, .length = length};
    const struct option *option;
    struct suggestion suggestion = {.distance = 0};
    size_t n;
    for (int i = 0; (option = option_at(reading->command, i)); i++)
        for (const char *name = option->usage;
             is_known(reading, option) && (name = next_name(name, &n)); name += n)
            suggestion_add(&suggestion, &typed, name, n);
    suggestion.known[0] = '\0'; /* a list of them all is too long */
    return error_usage(err, "%s has no option '%.*s'; %s", reading->command->name, (int)length,
                       word, suggestion_end(&suggestion, "--help lists its options"));
}

bool options_record(struct options *options, const char *name, const char *value, struct error *err)
{
    size_t length = strlen(name) + (value ? strlen(value) : 0) + sizeof "=";
    if (options->n_recorded == MOST_RECORDED)
        return error_usage(err, "%s: more than %d options of the picture", name, MOST_RECORDED);
    char *word;
    if (!MAKE_ARRAY(word, length, err, "the option %s", name))
        return false;
    snprintf(word, length, "%s%s%s", name, value ? "=" : "", value ? value : "");
    options->recorded[options->n_recorded++] = word;
    return true;
}

/* Checks a value, and stores it at its place in *options. `changes` has room, since each option
 * that changes the scene is RECORDED, and options_record refuses one too many. */
static bool store_value(struct options *options, const struct option *option, const char *name,
                        const char *value, struct error *err)
{
    char *at = (option->own ? (char *)options->own : (char *)options) + option->offset;
    const struct word word = {
        .start = value, .length = value ? strlen(value) : 0, .place = VALUE_OF(name)};
    int chosen;
    switch (option->kind) {
    case OPTION_TEXT:
        chosen = option->choices ? word_choose(&word, option->choices, "value", err) : 0;
        value = option->choices && chosen >= 0 ? option->choices[chosen] : value;
        memcpy(at, &value, sizeof value);
        return chosen >= 0 && (!option->accepts || option->accepts(name, value, err));
    case OPTION_NUMBER:
        return option_number(name, value, option->lowest, option->highest, (double *)at, err);
    case OPTION_COUNT:
        return option_count(name, value, option->lowest, option->highest, (int *)at, err);
    case OPTION_FLAG:
        *(bool *)at = true;
        return true;
    case OPTION_CHANGE:
        if (option->marks && !strpbrk(value, option->marks))
            return error_at(err, VALUE_OF(name), "expected %s (%s), not '%.100s'",
                            strchr(option->usage, ' ') + 1, option->help, value);
    }
    options->changes[options->n_changes++] = (struct option_change){option->change, value};
    return true;
}

/* A change without a value has a usage of one word. */
static bool takes_value(const struct option *option)
{
    return option->kind == OPTION_CHANGE ? strchr(option->usage, ' ') != NULL
                                         : option->kind != OPTION_FLAG;
}

/* Reads one option with its value: behind the name in the same word, as in "--size=4x4" and "-j4",
 * or the next word. */
static bool read_option(struct reading *reading, struct options *options, struct error *err)
{
    const char *word = reading->words[reading->at];
    const size_t length = word[1] == '-' ? strcspn(word, "=") : 2;
    const char *value = word[length] == '\0' ? NULL : word + length + (word[length] == '=');
    const struct option *option = find_option(reading, word, length);
    char name[32], first[32];
    if (!option)
        return refuse_option(reading, word, word[1] == '-' ? length : strcspn(word, "="), err);
    snprintf(name, sizeof name, "%.*s", (int)length, word);
    snprintf(first, sizeof first, "%.*s", (int)strcspn(option->usage, ", "), option->usage);
    if (!takes_value(option) && value)
        return error_usage(err, "%s takes no value", name);
    if (takes_value(option) && !value && reading->at + 1 == reading->n_words)
        return error_usage(err, "%s needs a value: %s", name, option->usage);
    if (takes_value(option) && !value)
        value = reading->words[++reading->at];
    return (!option->recorded || options_record(options, first, value, err)) &&
           store_value(options, option, name, value, err);
}

/* ---- outputs ---- */

/* Returns the text that an option was given; NULL: none. */
static const char *given_text(const struct options *options, const struct option *row)
{
    const char *value = NULL;
    if (row->kind == OPTION_TEXT)
        memcpy(&value, (const char *)(row->own ? options->own : options) + row->offset,
               sizeof value);
    return value;
}

/* Refuses an output that is the file of another option. */
static bool spares_option(const struct options *options, const struct option *writes,
                          const struct option *row, struct error *err)
{
    const char *written = given_text(options, writes), *named = given_text(options, row);
    bool is_file = row->writes, same = false;
    if (row == writes || !named || (row->made_again && written == options->output))
        return true;
    if ((!is_file && !file_is_regular(named, &is_file, err)) ||
        (is_file && !file_is_same(written, named, &same, err)))
        return false;
    return !same || error_usage(err, "%.*s and %.*s name the same file; expected two files",
                                (int)strcspn(writes->usage, ", "), writes->usage,
                                (int)strcspn(row->usage, ", "), row->usage);
}

/* Returns whether an option was given, of any kind but those that change the scene. */
static bool is_given(const struct options *options, const struct option *row)
{
    static const char none[sizeof(double)] = {0};
    const char *at = (const char *)(row->own ? options->own : options) + row->offset;
    return memcmp(at, none,
                  row->kind == OPTION_FLAG     ? sizeof(bool)
                  : row->kind == OPTION_COUNT  ? sizeof(int)
                  : row->kind == OPTION_NUMBER ? sizeof(double)
                                               : sizeof(char *)) != 0;
}

/* Refuses an option that has an effect only beside another, which was not given. */
static bool check_needs(const struct options *options, struct error *err)
{
    const struct reading all = {.command = options->command};
    const struct option *row;
    for (int i = 0; (row = option_at(options->command, i)); i++)
        if (row->needs && is_given(options, row) &&
            !is_given(options, find_option(&all, row->needs, strlen(row->needs))))
            return error_usage(err, "%.*s has an effect beside %s only",
                               (int)strcspn(row->usage, ", "), row->usage, row->needs);
    return true;
}

/* --output is opened before the work begins, or is a folder. output_open spares what was read. */
bool options_check_outputs(const struct options *options, struct error *err)
{
    const struct option *writes, *other;
    for (int i = 0; (writes = option_at(options->command, i)); i++) {
        const char *written = writes->writes ? given_text(options, writes) : NULL;
        if (!written || strcmp(written, "/dev/null") == 0)
            continue;
        if (written != options->output && !output_can_open(written, err))
            return false;
        for (int k = 0; (other = option_at(options->command, k)); k++)
            if (!spares_option(options, writes, other, err))
                return false;
    }
    return true;
}

/* ---- the command line ---- */

bool options_misused(const struct command *command, const char *why, const char *word,
                     struct error *err)
{
    return error_usage(err, "%s '%s'; usage: spectral %s %s [OPTIONS]", why, word, command->name,
                       command->operands);
}

bool options_read(const struct command *command, bool recorded, const char *const *words,
                  int n_words, struct options *out, struct error *err)
{
    struct reading reading = {command, recorded, words, n_words, 0};
    bool only_operands = false;
    *out = (struct options){.command = command};
    if (command->own_size > 0 && !memory_make(&out->own, 1, command->own_size))
        return memory_lacks(err, (double)command->own_size, "the options of %s", command->name);
    for (; reading.at < reading.n_words; reading.at++) {
        const char *word = reading.words[reading.at];
        if (!only_operands && strcmp(word, "--") == 0) {
            only_operands = true;
        } else if (!only_operands && word[0] == '-' && word[1]) {
            if (!read_option(&reading, out, err))
                return false;
        } else if (out->n_operands == command->n_operands) {
            return options_misused(command, "unexpected operand", word, err);
        } else {
            out->operands[out->n_operands++] = word;
        }
    }
    out->operand = out->operands[0];
    if (!out->help && !out->operand && !strchr("[-", command->operands[0]))
        return options_misused(command, "an operand is missing behind", command->name, err);
    return check_needs(out, err) && options_check_outputs(out, err);
}

void options_free(struct options *options)
{
    for (int i = 0; i < options->n_recorded; i++)
        free(options->recorded[i]);
    FREE_ALL(options->named_output, options->own);
    outputs_discard(&options->outputs);
    *options = (struct options){.command = NULL};
}

bool options_name_output(struct options *options, const char *path, const char *ending,
                         struct error *err)
{
    if (options->output)
        return true;
    options->output = options->named_output =
        output_name(output_is_standard(path) ? "scene" : path, ending, err);
    return options->output && options_check_outputs(options, err);
}

/* A tile, with the program's and OpenGL's own memory, takes at most 300 MiB: the tests measure it.
 * Stacks of threads count although most of them stays unused: the program and OpenGL have a thread
 * for each processor. */
void options_limit_memory(const struct options *options)
{
    const uint64_t mib = 1048576, tile_mib = 300, usual_stack = 8 * mib;
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    const uint64_t threads =
        (uint64_t)(options->threads > processors ? options->threads : processors);
    struct rlimit stack;
    const bool known = getrlimit(RLIMIT_STACK, &stack) == 0 && stack.rlim_cur != RLIM_INFINITY;
    const int usual_mib = 1024;
    const uint64_t wanted = (uint64_t)(options->memory_mib > 0 ? options->memory_mib : usual_mib);
    memory_limit((wanted + tile_mib) * mib,
                 2 * threads * (known ? (uint64_t)stack.rlim_cur : usual_stack));
}

const char *options_scene(const struct options *options)
{
    return options->operand ? options->operand : "colorchecker";
}

int options_table(const struct options *options, const char *output)
{
    const bool json = options->json && output_is_standard(options->json);
    return json || (output && output_is_stream(output)) ? STDERR_FILENO : STDOUT_FILENO;
}

bool options_show_output(const struct options *options, const char *kind, const char *output,
                         struct error *err)
{
    struct printed words = {.text = NULL};
    if (output_is_standard(output))
        return true;
    print(&words, "%-18s%s\n", kind, output);
    return printed_show(&words, options_table(options, output), err);
}

const char *options_detector(const struct options *options)
{
    return options->detector ? options->detector : "cie1931";
}

/* ---- help, in lines of a terminal's width ---- */

enum { HELP_WIDTH = 80, HELP_COLUMN = 34 }; /* of a line; where an explanation begins */

void help_words(struct printed *to, const char *text, int column)
{
    const char *gap = "";
    for (int at = column, length; *(text += strspn(text, " \n")); text += length) {
        length = (int)strcspn(text, " \n");
        if (at + (int)strlen(gap) + length > HELP_WIDTH) {
            print(to, "\n%*s", column, "");
            at = column;
            gap = "";
        }
        print(to, "%s%.*s", gap, length, text);
        at += (int)strlen(gap) + length;
        gap = " ";
    }
    print_text(to, "\n");
}

/* An explanation stands beside its option, or below if there is no room. */
void help_options(const struct command *command, struct printed *to)
{
    const struct option *option;
    for (int i = 0; (option = option_at(command, i)); i++) {
        const int used = 2 + (int)strlen(option->usage);
        print(to, "  %s", option->usage);
        if (used + 2 > HELP_COLUMN)
            print_text(to, "\n");
        print(to, "%*s", used + 2 > HELP_COLUMN ? HELP_COLUMN : HELP_COLUMN - used, "");
        help_words(to, option->help, HELP_COLUMN);
    }
}
