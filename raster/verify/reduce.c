/* SPDX-License-Identifier: MIT */
/* Makes a scene that fails as small as it still fails: tries it without each half of its parts,
 * then without each quarter, and so on (Zeller and Hildebrandt, "Simplifying and isolating
 * failure-inducing input", IEEE Transactions on Software Engineering 28, 2002). Each try is written
 * as files and drawn in a process of its own, as a user would draw it. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/invocation/invocation.h"
#include "data/process/process.h"
#include "raster/verify/verify.h"

enum { MOST_TRIES = 4000 };

/* A failure on its way down. */
struct reduction {
    const struct options *options; /* of the command, without changes of the scene */
    const struct verify_driver *driver;
    struct verify_result failure; /* of what is kept now */
    struct reduced kept;
    struct folder folder; /* for tries */
    int tries;
};

/* ---- tries ---- */

/* Colours that are wrong in one band, or in all alike, are one kind of failure. */
static int kind_of(const struct verify_result *result)
{
    const enum failure_kind kind = result->check.first.kind;
    if (result->outcome != VERIFY_DIFFERS || !result->check.first.found)
        return -1;
    return kind == FAILURE_BANDS ? (int)FAILURE_RADIANCE : (int)kind;
}

static bool is_same_failure(const struct verify_result *a, const struct verify_result *b)
{
    return a->outcome == b->outcome && kind_of(a) == kind_of(b);
}

/* Writes and draws what is kept; *fails: as before. A scene that is wrong without a part does not.
 */
static bool try_in(struct reduction *of, const char *folder, bool *fails, struct error *err)
{
    char path[REDUCED_PATH];
    struct verify_result result;
    struct error own = {.status = EXIT_AGREED};
    struct verify_scene scene = {.path = path};
    *fails = false;
    if (is_interrupted())
        return error_system(err, "interrupted; nothing was written");
    if (of->tries++ >= MOST_TRIES)
        return true;
    snprintf(path, sizeof path, "%s/case.scene", folder);
    if (!reduced_write(&of->kept, folder, err))
        return false;
    if (!verify_run(of->options, of->driver, &scene, &result, &own))
        return own.status == EXIT_INPUT || (*err = own, false);
    *fails = is_same_failure(&result, &of->failure);
    if (*fails)
        of->failure = result;
    return true;
}

static bool try_kept(struct reduction *of, bool *fails, struct error *err)
{
    return try_in(of, of->folder.path, fails, err);
}

/* Some parts of a kind, by their numbers. */
struct listed {
    enum reduced_kind kind;
    const int *number;
    int n;
};

/* Drops the parts if it fails without them. */
static bool try_without(struct reduction *of, const struct listed *parts, bool *dropped,
                        struct error *err)
{
    bool *kept = of->kept.kept[parts->kind];
    for (int i = 0; i < parts->n; i++)
        kept[parts->number[i]] = false;
    if (!try_kept(of, dropped, err))
        return false;
    for (int i = 0; i < parts->n && !*dropped; i++)
        kept[parts->number[i]] = true;
    return true;
}

/* Lists the parts of a kind that are kept. Returns how many. */
static int list_kept(const struct reduced *of, enum reduced_kind kind, int *listed)
{
    int n = 0;
    for (int i = 0; i < of->n[kind]; i++)
        if (of->kept[kind][i])
            listed[n++] = i;
    return n;
}

/* The triangles of objects that are not kept are not kept either. */
static void drop_triangles(struct reduced *of)
{
    bool *at = of->kept[REDUCED_TRIANGLES];
    for (int i = 0; i < of->n_objects; at += of->objects[i++].mesh.n_triangles)
        if (!of->kept[REDUCED_OBJECTS][i])
            memset(at, false, (size_t)of->objects[i].mesh.n_triangles);
}

/* Drops as many parts of a kind as it fails without; *any: some. */
static bool reduce_kind(struct reduction *of, enum reduced_kind kind, bool *any, struct error *err)
{
    const bool may_be_empty = kind == REDUCED_LIGHTS || kind == REDUCED_AMBIENTS;
    int *listed = malloc(((size_t)of->kept.n[kind] + 1) * sizeof *listed), n;
    bool done = listed != NULL || error_memory(err);
    if (!done)
        return false;
    n = list_kept(&of->kept, kind, listed);
    for (int step = may_be_empty ? n : n / 2; step > 0 && done; step /= 2)
        for (int from = 0; from < n && done;) {
            const int to = from + step < n ? from + step : n;
            bool dropped = false;
            if (to - from < n || may_be_empty)
                done = try_without(of, &(struct listed){kind, listed + from, to - from}, &dropped,
                                   err);
            n = list_kept(&of->kept, kind, listed);
            from = dropped ? from : to;
            *any = *any || dropped;
        }
    free(listed);
    if (kind == REDUCED_OBJECTS)
        drop_triangles(&of->kept);
    return done;
}

/* Halves the width, the height, or both, as long as it fails. */
static bool reduce_size(struct reduction *of, bool *any, struct error *err)
{
    static const int halves[3][2] = {{2, 2}, {2, 1}, {1, 2}};
    for (int i = 0; i < 3;) {
        const int width = of->kept.width, height = of->kept.height;
        bool fails = false;
        of->kept.width = (width + halves[i][0] - 1) / halves[i][0];
        of->kept.height = (height + halves[i][1] - 1) / halves[i][1];
        if ((of->kept.width < width || of->kept.height < height) && !try_kept(of, &fails, err))
            return false;
        if (!fails) {
            of->kept.width = width;
            of->kept.height = height;
            i++;
        }
        *any = *any || fails;
    }
    return true;
}

/* ---- the reduction ---- */

static bool reduce_all(struct reduction *of, struct error *err)
{
    static const enum reduced_kind order[REDUCED_KINDS] = {
        REDUCED_OBJECTS, REDUCED_BANDS, REDUCED_TRIANGLES, REDUCED_LIGHTS, REDUCED_AMBIENTS};
    bool fails, any = true;
    if (!try_kept(of, &fails, err))
        return false;
    if (!fails)
        return error_different(err, "the scene cannot be reduced: drawn from meshes and tables, it "
                                    "does not fail in the same way");
    while (any) { /* a small facet may be lost in a small picture: the size goes before triangles */
        any = false;
        for (int i = 0; i < REDUCED_KINDS; i++)
            if ((order[i] == REDUCED_TRIANGLES && !reduce_size(of, &any, err)) ||
                !reduce_kind(of, order[i], &any, err))
                return false;
    }
    return true;
}

static int count_kept(const struct reduced *of, enum reduced_kind kind)
{
    int n = 0;
    for (int i = 0; i < of->n[kind]; i++)
        n += of->kept[kind][i];
    return n;
}

static void print_size(const struct reduced *of, struct printed *to)
{
    print(to, "%d x %d pixels, objects %d, triangles %d, lights %d, wavelengths %d", of->width,
          of->height, count_kept(of, REDUCED_OBJECTS), count_kept(of, REDUCED_TRIANGLES),
          count_kept(of, REDUCED_LIGHTS) + count_kept(of, REDUCED_AMBIENTS),
          count_kept(of, REDUCED_BANDS));
}

/* ---- the case ---- */

/* Says why a failure is none of single precision. */
static void print_reason(const struct check_failure *first, struct printed *to)
{
    const double off = first->seen - first->expected;
    print_text(to, "\nWhy no rounding explains it\n\n");
    if (!first->found)
        print_text(to, "No single pixel fails: see the message.\n");
    else if (first->kind == FAILURE_TRIANGLE)
        print_text(to,
                   "The triangles that OpenGL may show at this pixel are all whose edges, moved "
                   "by as much as\nroundings and the driver's grid can move them, reach its "
                   "centre, and whose depth reaches the\nnearest one. OpenGL shows none of "
                   "them.\n");
    else if (first->kind == FAILURE_FRAGMENTS)
        print_text(to, "Fragments are counted by the stencil. Edges, moved by as much as roundings "
                       "and the driver's\ngrid can move them, leave no other number.\n");
    else
        print(to,
              "OpenGL's value is off by %.6g, and the bound is %.3g%s. The bound adds up the "
              "largest error that\neach operation of single precision may make, in any order, with "
              "or without fused multiply-add,\nfrom the vertex to the pixel, for each triangle "
              "that may be shown there.\n",
              off, first->bound, first->kind == FAILURE_DEPTH ? "" : " counts of 65535");
}

static bool write_readme(const struct reduction *of, const char *scene, const char *folder,
                         struct error *err)
{
    struct printed text = {.text = NULL};
    char path[REDUCED_PATH], options[64];
    const struct verify_result *failure = &of->failure;
    driver_options(of->driver, options);
    print(&text,
          "A picture that this OpenGL draws wrong, made small by " PROGRAM ", verify --reduce.\n\n"
          "driver    %s, %s, by %s\nbounds    of %s\nscene     %s, made smaller: ",
          failure->names.renderer, failure->names.version, failure->names.library, failure->profile,
          scene);
    print_size(&of->kept, &text);
    print(&text,
          "\nverdict   %s\n          %s\nrepeat    spectral render case.scene -o /dev/null%s",
          verify_words[failure->outcome], failure->text, options);
    verify_print_options(of->options, false, &text);
    print_text(&text,
               "\n\nPixels count from 0,0 at the top left. A count is 1/65535 of the largest "
               "radiance.\n");
    if (failure->outcome != VERIFY_FAILED)
        print_reason(&failure->check.first, &text);
    char *bytes = printed_end(&text);
    snprintf(path, sizeof path, "%s/README.txt", folder);
    const bool done = bytes ? file_write(path, bytes, strlen(bytes), NULL, err) : error_memory(err);
    free(bytes);
    return done;
}

/* The last try is that of the case itself, so that the message names its files. */
static bool write_case(struct reduction *of, const char *scene, const char *folder,
                       struct error *err)
{
    bool fails;
    of->tries = 0;
    if (mkdir(folder, 0777) != 0)
        return error_cause(err, (struct place){folder, 0, 0}, errno, "cannot make the folder");
    if (!try_in(of, folder, &fails, err))
        return false;
    errno = 0;
    return fails ? write_readme(of, scene, folder, err)
                 : error_system(err, "%s does not fail again: the driver is not steady", folder);
}

/* ---- the command's part ---- */

/* Reads the scene as verify_run does, and reduces it. */
static bool reduce_scene(struct reduction *of, const struct verify_scene *scene,
                         const struct options *options, struct error *err)
{
    struct options own = *options;
    struct scene read = {.path = NULL};
    verify_place(&own, scene);
    of->options = &own;
    bool done = scene_read_options(&own, &read, err);
    own.n_changes = 0;
    done = done && reduced_open(&read, &of->kept, err) && folder_open(&of->folder, err) &&
           reduce_all(of, err) && write_case(of, scene->name, options->reduce, err);
    folder_close(&of->folder);
    of->options = options;
    scene_free(&read);
    return done;
}

bool verify_reduce(const struct verification *of, const struct options *options, struct printed *to,
                   struct error *err)
{
    const int n = of->n_drivers * of->n_scenes;
    struct reduction reduction = {.tries = 0};
    int failing = 0;
    while (failing < n && of->results[failing].outcome == VERIFY_AGREED)
        failing++;
    if (failing == n)
        return true;
    const struct verify_scene *scene = &of->scenes[failing % of->n_scenes];
    reduction.driver = &of->drivers[failing / of->n_scenes];
    reduction.failure = of->results[failing];
    const bool done = reduce_scene(&reduction, scene, options, err);
    if (done) {
        print(to, "\n%s was reduced to ", scene->name);
        print_size(&reduction.kept, to);
        print(to, ":\n  %s/case.scene, with README.txt\n", options->reduce);
    }
    reduced_free(&reduction.kept);
    return done;
}
