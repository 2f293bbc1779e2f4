/* SPDX-License-Identifier: MIT */
/* The files of a scene, as its live page holds them: with names relative to the scene's folder. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster/beside/view/inside.h"

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

/* Finds the name of a file below the scene's folder; allocated. */
static char *name_below(const struct page_files *files, const char *path, struct error *err)
{
    const size_t above = strlen(files->above);
    const bool below = strncmp(path, files->above, above) == 0;
    char *name;
    if (string_copy(below ? path + above : path, &name, err) && !(below && simplify(name))) {
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
           (same || error_usage(err, "%s and %s are two files, and one in the page; rename one",
                                known, path));
}

/* Adds a file, unless its name is there already. */
static bool add(struct page_files *files, const char *path, struct error *err)
{
    if (path_is_builtin(path))
        return true;
    struct page_file file = {name_below(files, path, err), path};
    if (!file.name)
        return false;
    const size_t length = strlen(file.name);
    const int place = index_find(&files->places, file.name, length);
    if (place < 0 && array_add(&files->list, &files->n, &file, sizeof file, err))
        return index_add(&files->places, file.name, length, files->n - 1, err);
    free(file.name);
    return place >= 0 && is_same_file(files->list[place].path, path, err);
}

void page_files_free(struct page_files *files)
{
    for (int i = 0; i < files->n; i++)
        free(files->list[i].name);
    free(files->list);
    free(files->above);
    index_free(&files->places);
    inputs_free(&files->inputs);
    *files = (struct page_files){.list = NULL};
}

char *marked_name(const char *scene)
{
    const char *base = path_name(scene);
    const size_t length = strlen(scene) + sizeof "./";
    char *name = malloc(length);
    if (name)
        snprintf(name, length, "%.*s%s%s", (int)(base - scene), scene, scene[0] == '/' ? "./" : "",
                 base);
    return name;
}

bool page_files_make(const struct scene *scene, struct page_files *out, struct error *err)
{
    const char *path = scene->files[0].path;
    *out = (struct page_files){.list = NULL};
    bool done = string_copy(path_is_builtin(path) ? "" : path, &out->above, err);
    if (done) /* a built-in scene has no folder: its options name files from the working folder */
        out->above[path_name(out->above) - out->above] = '\0';
    done = done && inputs_list(scene, NULL, false, &out->inputs, err);
    for (int i = 0; done && i < scene->n_texts; i++)
        done = add(out, scene->files[i].path, err);
    for (int i = 0; done && i < out->inputs.n; i++)
        done = add(out, out->inputs.path[i], err);
    return done;
}
