/* SPDX-License-Identifier: MIT */
/* spectral list: the names that scenes and options can use. spectral show: a built-in file. */
#include <ctype.h>
#include <strings.h>
#include <unistd.h>

#include "data/scene/scene.h"

static void list_shapes(struct printed *to)
{
    for (enum shape_kind kind = SHAPE_SPHERE; kind < SHAPE_MESH; kind++) {
        print_text(to, "  ");
        shape_print_signature(kind, to);
        print_text(to, "\n");
    }
    print_text(to, "  mesh FILE.obj [unitize] [crease ANGLE]\n");
}

static void list_samplings(struct printed *to)
{
    print_text(
        to,
        "  box:N               N boxes of equal area under the detector's functions\n"
        "  riemann:STEP        a sample every STEP nm\n"
        "  gauss:N             Gaussian quadrature weighted by the detector's functions\n"
        "  gauss:N,open        by none: the detector is left open\n"
        "  gauss:N,xyz|lms|acc by tristimulus values, cones or opponent functions, each its own\n"
        "  adaptive:TOLERANCE  emission peaks, and quadrature between them\n"
        "  basis:K             K principal components of lights x reflectances: no spectra\n"
        "  rgb, xyz            three numbers a light and a material: no spectra, no "
        "fluorescence\n");
}

static const struct list {
    const char *name, *alias;          /* alias NULL: none */
    void (*print)(struct printed *to); /* NULL: the list has the names of built-in files */
    enum file_kind kind;               /* of these files */
} lists[] = {
    {"scenes", NULL, NULL, FILE_SCENE},
    {"hard", NULL, NULL, FILE_SCENE},
    {"materials", NULL, NULL, FILE_MATERIAL},
    {"illuminants", "lights", NULL, FILE_TABLE},
    {"detectors", "observers", NULL, FILE_TABLE},
    {"shapes", NULL, list_shapes, FILE_KINDS},
    {"models", "meshes", NULL, FILE_MODEL},
    {"lists", NULL, NULL, FILE_LIST},
    {"textures", NULL, NULL, FILE_TEXTURE},
    {"reliefs", NULL, NULL, FILE_RELIEF},
    {"samplings", NULL, list_samplings, FILE_KINDS},
};
enum { N_LISTS = sizeof lists / sizeof lists[0] };

/* Returns whether the list has this file. Scenes in folders are hard cases, or targets. The tables
 * are illuminants and detectors, and a material may stand for a spectrum. */
static bool holds(const struct list *list, const struct builtin_file *file, char name[BUILTIN_NAME])
{
    char material[BUILTIN_NAME];
    return builtin_is(file, list->kind, name) &&
           (list->kind != FILE_SCENE ||
            (strcmp(list->name, "hard") == 0 ? strncmp(name, "hard/", 5) == 0
                                             : !strchr(name, '/'))) &&
           (list->kind != FILE_TABLE ||
            (!builtin_is(file, FILE_MATERIAL, material) &&
             table_is_detector(file) == (strcmp(list->name, "detectors") == 0)));
}

/* Orders names as a reader does: numbers in them by their value, so that f2 comes before f10. The
 * number of more digits is the larger one: no name has a number with zeros before it. */
static int compare_names(const void *a, const void *b)
{
    static const char digits[] = "0123456789";
    const char *one = a, *other = b;
    bool within = false; /* both are within a number */
    for (; *one && *one == *other; one++, other++)
        within = isdigit((unsigned char)*one);
    const size_t n = strspn(one, digits), m = strspn(other, digits);
    if (n != m && (within || (n > 0 && m > 0)))
        return n < m ? -1 : 1;
    return (unsigned char)*one - (unsigned char)*other;
}

static bool print_list(const struct list *list, struct printed *to, struct error *err)
{
    char(*names)[BUILTIN_NAME];
    size_t n = 0;
    if (!MAKE_ARRAY(names, builtin_file_count, err, "the names of built-in files"))
        return false;
    print(to, "%s\n", list->name);
    for (size_t i = 0; i < builtin_file_count && !list->print; i++)
        n += holds(list, &builtin_files[i], names[n]);
    qsort(names, n, sizeof *names, compare_names);
    for (size_t i = 0; i < n; i++)
        print(to, "  %s\n", names[i]);
    if (n == 0 && !list->print)
        print_text(to, "  none in this program\n");
    free(names);
    if (list->print)
        list->print(to);
    return true;
}

/* Prints the names of the samples of a user's table. */
static void print_samples(const char *path, struct printed *to, struct error *err)
{
    const struct word word = {.start = path, .length = strlen(path)};
    struct spectrum *samples;
    int n;
    struct text text;
    char *file;
    const bool done =
        word_file(&word, FILE_TABLE, &file, err) && text_open(&text, file, NOWHERE, TEXT_XML, err);
    free(file);
    if (!done)
        return;
    set_read(text, HUGE_VAL, &samples, &n, err);
    print(to, "%s\n", path);
    for (int i = 0; i < n; i++)
        print(to, "  %s\n", samples[i].name);
    set_free(samples, n);
    text_free(&text);
}

static bool run_list(struct options *options, struct error *err)
{
    const char *wanted = options->operand ? options->operand : "";
    const struct word typed = {.start = wanted, .length = strlen(wanted)};
    struct suggestion suggestion = {.distance = 0};
    struct printed printed = {.text = NULL};
    bool found = false, done = true;
    for (int i = 0; done && i < N_LISTS; i++) {
        const struct list *list = &lists[i];
        suggestion_add(&suggestion, &typed, list->name, strlen(list->name));
        const bool named = strcasecmp(wanted, list->name) == 0 ||
                           (list->alias && strcasecmp(wanted, list->alias) == 0);
        if (*wanted ? !named : strcmp(list->name, "hard") == 0) /* more than all others */
            continue;
        found = true;
        done = print_list(list, &printed, err);
    }
    if (done && !found && !file_is_missing(wanted))
        print_samples(wanted, &printed, err);
    else if (done && !found)
        error_usage(err, "there is no list or file '%s'; %s", wanted,
                    suggestion_end(&suggestion, "the lists are"));
    return printed_show(&printed, STDOUT_FILENO, err);
}

/* ---- spectral show ---- */

/* Finds the built-in file of that name or path, of the first kind that has it; NULL: there is none,
 * and the error proposes one. */
static const struct builtin_file *find_shown(const char *name, struct error *err)
{
    const char *path = name + (path_is_builtin(name) ? strlen(BUILTIN_PREFIX) : 0);
    const struct word typed = {.start = name, .length = strlen(name)};
    struct suggestion suggestion = {.distance = 0};
    char known[BUILTIN_NAME];
    for (enum file_kind kind = 0; kind < FILE_KINDS; kind++)
        for (size_t i = 0; i < builtin_file_count; i++) {
            if (!builtin_is(&builtin_files[i], kind, known))
                continue;
            if (strcasecmp(name, known) == 0 || strcmp(path, builtin_files[i].name) == 0)
                return &builtin_files[i];
            suggestion_add(&suggestion, &typed, known, strlen(known));
        }
    suggestion.known[0] = '\0'; /* a list of them all is too long */
    error_usage(err, "no built-in file '%.40s'; %s", name,
                suggestion_end(&suggestion, "spectral list prints the names"));
    return NULL;
}

bool show_file(struct options *options, struct error *err)
{
    const char *output = options->output ? options->output : "-";
    if (options->n_operands > 1)
        return error_usage(err, "show prints one file; add --csv or --svg for curves");
    const struct builtin_file *file = find_shown(options->operand, err);
    if (file && isatty(STDOUT_FILENO) && output_is_standard(output) &&
        memchr(file->bytes, '\0', file->length))
        return error_usage(err, "%s is no text; add -o FILE", options->operand);
    return file &&
           file_write(output, (const char *)file->bytes, file->length, &options->outputs, err);
}

const struct command list_command = {
    .name = "list",
    .operands = "[KIND | FILE]",
    .summary = "print the names of what is built in, or of a table's samples",
    .example = "list materials",
    .run = run_list,
    .n_operands = 1,
};

static const struct option show_options[] = {
    {"-o, --output FILE", "writes there (default: standard output)", SHARED(TEXT, output),
     .writes = true},
};
const struct command show_command = {
    .name = "show",
    .operands = "NAME [-o FILE]",
    .summary = "print a built-in file, to start one of your own with",
    .example = "show patches -o my.scene",
    .first = "copies a scene, to change it",
    .run = show_file,
    .rows = OPTION_LIST(show_options),
    .n_operands = 1,
};
