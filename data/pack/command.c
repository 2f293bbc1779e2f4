/* SPDX-License-Identifier: MIT */
/* spectral pack: a scene with all files that it names, for another machine. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "data/index/index.h"
#include "data/inputs/inputs.h"
#include "data/invocation/invocation.h"
#include "data/pack/pack.h"

/* ---- names in the archive ---- */

/* Removes "." and "FOLDER/.." from a relative path, in place. Returns false if it leaves its
 * folder, or is not relative. */
static bool simplify(char *path)
{
    char *to = path;
    for (const char *at = path; *at != '\0';) {
        const size_t length = strcspn(at, "/"), step = length + (at[length] == '/');
        const bool up = length == 2 && memcmp(at, "..", 2) == 0;
        if (length == 0 && at == path)
            return false;
        if (up && to == path)
            return false;
        if (up)
            for (to--; to > path && to[-1] != '/'; to--)
                ;
        else if (length > 0 && !(length == 1 && *at == '.')) {
            memmove(to, at, step);
            to += step;
        }
        at += step;
    }
    *to = '\0';
    return true;
}

/* The archive's files. */
struct packing {
    const char *top;   /* the folder in the archive */
    const char *above; /* how the paths of files in the scene's folder begin: "" or "scenes/" */
    struct packed_file {
        char *name; /* without the top folder; owned */
        const char *path;
    } * files; /* owned */
    int n_files;
    struct index places; /* in `files`, by name */
};

/* Finds the name of a file below the scene's folder; allocated. */
static char *name_below(const struct packing *packing, const char *path, struct error *err)
{
    const size_t above = strlen(packing->above);
    const bool below = strncmp(path, packing->above, above) == 0;
    char *name = strdup(below ? path + above : path);
    if (!name)
        error_memory(err);
    else if (!below || !simplify(name)) {
        error_usage(err,
                    "%s is not below the folder of the scene, and would not be found elsewhere; "
                    "copy it there, and name it by a relative path",
                    path);
        free(name);
        name = NULL;
    }
    return name;
}

/* Refuses two files that links give one name. */
static bool is_same_file(const char *known, const char *path, struct error *err)
{
    bool same;
    return file_is_same(known, path, &same, err) &&
           (same || error_usage(err, "%s and %s are two files, and one in the archive; rename one",
                                known, path));
}

/* Adds a file, unless its name is there already. */
static bool add(struct packing *packing, const char *path, struct error *err)
{
    if (path_is_builtin(path))
        return true;
    struct packed_file file = {name_below(packing, path, err), path};
    if (!file.name)
        return false;
    const size_t length = strlen(file.name);
    const int place = index_find(&packing->places, file.name, length);
    if (place < 0 && array_add(&packing->files, &packing->n_files, &file, sizeof file, err))
        return index_add(&packing->places, file.name, length, packing->n_files - 1, err);
    free(file.name);
    return place >= 0 && is_same_file(packing->files[place].path, path, err);
}

static void packing_free(struct packing *packing)
{
    for (int i = 0; i < packing->n_files; i++)
        free(packing->files[i].name);
    free(packing->files);
    index_free(&packing->places);
}

/* ---- the command ---- */

/* Returns the scene's name with a mark, so that the paths of all files that the scene names by
 * relative names begin in another way than a path from / on. Allocated; NULL: no memory. */
static char *marked_name(const char *scene)
{
    const char *base = path_name(scene);
    const size_t length = strlen(scene) + sizeof "./";
    char *name = malloc(length);
    if (name)
        snprintf(name, length, "%.*s%s%s", (int)(base - scene), scene, scene[0] == '/' ? "./" : "",
                 base);
    return name;
}

static bool write_archive(const struct packing *packing, struct options *options, struct error *err)
{
    struct output out;
    bool done = output_open(&out, options->output, err);
    for (int i = 0; done && i < packing->n_files; i++) {
        const struct packed_file *file = &packing->files[i];
        struct printed name = {.text = NULL};
        print(&name, "%s/%s", packing->top, file->name);
        char *text = printed_end(&name);
        done = text ? archive_add(&out, text, file->path, err) : error_memory(err);
        free(text);
    }
    done = done && archive_end(&out, err) && output_sync(&out, err);
    if (done)
        return output_pass(&out, &options->outputs, err);
    output_discard(&out);
    return false;
}

static bool pack_scene(const struct scene *scene, struct options *options, struct error *err)
{
    const char *path = scene->files[0].path;
    struct inputs inputs = {.path = NULL};
    struct packing packing = {.files = NULL};
    char *top = output_name(path, ""), *above = strdup(path);
    bool done = (top && above) || error_memory(err);
    if (done) {
        above[path_name(path) - path] = '\0';
        packing.top = top;
        packing.above = above;
    }
    done = done && inputs_list(scene, NULL, &inputs, err);
    for (int i = 0; done && i < scene->n_texts; i++)
        done = add(&packing, scene->files[i].path, err);
    for (int i = 0; done && i < inputs.n; i++)
        done = add(&packing, inputs.path[i], err);
    done = done && write_archive(&packing, options, err);
    packing_free(&packing);
    inputs_free(&inputs);
    free(above);
    free(top);
    return done;
}

bool command_pack(struct options *options, struct error *err)
{
    const char *name = options->operand;
    struct scene scene = {.path = NULL};
    if (!name)
        return error_usage(err, "pack needs SCENE, a scene file");
    if (output_is_standard(name))
        return error_usage(err, "pack reads no standard input; expected a scene file");
    char *marked = marked_name(name);
    options->operand = marked;
    bool done = marked ? scene_read_options(options, &scene, err) : error_memory(err);
    options->operand = name;
    if (done && path_is_builtin(scene.files[0].path))
        done = error_usage(
            err, "%s is built in: it needs no other file (spectral show %s prints it)", name, name);
    done = done && options_name_output(options, name, ".tar", err) &&
           scene_spared(options->output, &scene, err) && pack_scene(&scene, options, err);
    scene_free(&scene);
    free(marked);
    return done;
}
