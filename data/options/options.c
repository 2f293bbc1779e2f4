/* SPDX-License-Identifier: MIT */
/* Reads a command line by the rules of a table. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "data/options/options.h"
#include "data/text/text.h"
#include "spectral.h"

/* ---- values ---- */

bool option_number(const char *option, const char *value, double lowest, double highest,
                   double *out, struct error *err)
{
    struct text text;
    bool done = text_open_string(&text, option, value, err) && text_next_line(&text) &&
                text_number(&text, "value", lowest, highest, out, err) &&
                text_end(&text, option, err);
    if (!done)
        error_usage(err, "%s takes a number", option);
    text_free(&text);
    return done;
}

static bool read_count(const char *option, const char *value, double lowest, int *out,
                       struct error *err)
{
    double count;
    if (!option_number(option, value, lowest, OPTION_COUNT_LIMIT, &count, err))
        return false;
    *out = (int)count;
    return count == *out || error_usage(err, "%s takes a whole number, not '%s'", option, value);
}

/* Refuses a value that is none of the choices; NULL: any value is good. */
static bool check_choice(const char *option, const char *const *choices, const char *value,
                         struct error *err)
{
    char list[LIST_SIZE] = "";
    for (; choices && *choices; choices++) {
        if (strcmp(value, *choices) == 0)
            return true;
        list_add(list, *choices, strlen(*choices));
    }
    return !choices || error_usage(err, "%s takes one of %s, not '%s'", option, list, value);
}

/* ---- one option ---- */

/* Returns whether the word is one of the names that the usage begins with. */
static bool names_option(const char *usage, const char *word, size_t length)
{
    while (*usage == '-') {
        const size_t n = strcspn(usage, ", ");
        if (n == length && strncmp(usage, word, length) == 0)
            return true;
        usage += n;
        usage += strspn(usage, ", ");
    }
    return false;
}

/* Finds the row of an option that the command takes; NULL: it takes none of that name. */
static const struct option *find_option(const struct option_rules *rules, const char *word,
                                        size_t length)
{
    for (int i = 0; i < rules->table->n; i++) {
        const struct option *option = &rules->table->options[i];
        if (option->commands & (rules->commands | FOR_ALL) &&
            names_option(option->usage, word, length))
            return option;
    }
    return NULL;
}

/* Adds "NAME=VALUE", or the name of a flag, to the words that the stack records. */
static bool record_option(struct options *options, const char *name, const char *value,
                          struct error *err)
{
    size_t length = strlen(name) + (value ? strlen(value) : 0) + sizeof "=";
    if (options->n_recorded == MAX_RECORDED)
        return error_usage(err, "%s: more than %d options of the picture", name, MAX_RECORDED);
    char *word = malloc(length);
    if (!word)
        return error_memory(err);
    snprintf(word, length, "%s%s%s", name, value ? "=" : "", value ? value : "");
    options->recorded[options->n_recorded++] = word;
    return true;
}

/* Checks a value, and stores it at its place in *options. `changes` has room, since each option
 * that changes the scene is RECORDED, and record_option refuses one too many. */
static bool store_value(struct options *options, const struct option *option, const char *name,
                        const char *value, struct error *err)
{
    char *at = (char *)options + option->offset;
    switch (option->kind) {
    case OPTION_TEXT:
        memcpy(at, &value, sizeof value);
        return check_choice(name, option->choices, value, err) &&
               (!option->accepts || option->accepts(name, value, err));
    case OPTION_NUMBER:
        return option_number(name, value, option->lowest, option->highest, (double *)at, err);
    case OPTION_COUNT:
        return read_count(name, value, option->lowest, (int *)at, err);
    case OPTION_FLAG:
        *(bool *)at = true;
        return true;
    case OPTION_CHANGE:
        break;
    }
    options->changes[options->n_changes++] = (struct option_change){option->change, value};
    return true;
}

/* Reads one option with its value, which may be the next word; *index moves on. */
static bool read_option(const struct option_rules *rules, char *const *words, int n_words,
                        int *index, struct options *options, struct error *err)
{
    const char *word = words[*index], *equals = strchr(word, '='), *value = NULL;
    const size_t length = equals ? (size_t)(equals - word) : strlen(word);
    const struct option *option = find_option(rules, word, length);
    char name[32];
    if (!option)
        return error_usage(err, "%s has no option '%.*s'; try spectral --help", rules->command,
                           (int)length, word);
    snprintf(name, sizeof name, "%.*s", (int)length, word);
    if (option->kind == OPTION_FLAG && equals)
        return error_usage(err, "%s takes no value", name);
    if (option->kind != OPTION_FLAG && !equals && *index + 1 == n_words)
        return error_usage(err, "%s needs a value; try spectral --help", name);
    if (option->kind != OPTION_FLAG)
        value = equals ? equals + 1 : words[++*index];
    return (!(option->commands & RECORDED) || record_option(options, name, value, err)) &&
           store_value(options, option, name, value, err);
}

/* ---- the command line ---- */

bool options_read(const struct option_rules *rules, char *const *words, int n_words,
                  struct options *out, struct error *err)
{
    bool only_operands = false;
    *out = (struct options){.table = rules->table};
    for (int i = 0; i < n_words; i++) {
        if (!only_operands && strcmp(words[i], "--") == 0) {
            only_operands = true;
        } else if (!only_operands && words[i][0] == '-' && words[i][1]) {
            if (!read_option(rules, words, n_words, &i, out, err))
                return false;
        } else if (out->n_operands == rules->n_operands) {
            return error_usage(err, "unexpected operand '%s'; try spectral --help", words[i]);
        } else {
            out->operands[out->n_operands++] = words[i];
        }
    }
    out->operand = out->operands[0];
    return true;
}

void options_free(struct options *options)
{
    for (int i = 0; i < options->n_recorded; i++)
        free(options->recorded[i]);
    options->n_recorded = 0;
    free(options->named_output);
    options->named_output = NULL;
}

bool options_name_output(struct options *options, const char *path, const char *ending,
                         struct error *err)
{
    if (options->output)
        return true;
    options->output = options->named_output = output_name(path, ending);
    return options->output || error_memory(err);
}

const char *options_scene(const struct options *options)
{
    return options->operand ? options->operand : "colorchecker";
}

const char *options_detector(const struct options *options)
{
    return options->detector ? options->detector : "cie1931";
}
