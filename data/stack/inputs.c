/* SPDX-License-Identifier: MIT */
/* Lists the files that a scene is made of. A stack records them with their digests, so that a
 * picture of one machine can be compared with that of another. */
#include "data/stack/stack.h"

/* ---- finding ---- */

/* Adds a copy of the path, unless it is NULL, built in or missing. */
static bool add(struct inputs *to, const char *path, struct error *err)
{
    char *copy = NULL;
    if (!path || path_is_builtin(path) || file_is_missing(path))
        return true;
    if (!string_copy(path, &copy, err))
        return false;
    if (array_add(&to->path, &to->n, &copy, sizeof copy, err))
        return true;
    free(copy);
    return false;
}

/* A material that was not read has no diffuse reflectance. The partner in a material file has that
 * file's path. */
static bool add_material(struct inputs *to, const struct material *material, struct error *err)
{
    const struct material *partner = material->partner;
    const char *paths[] = {material->path,
                           material->diffuse.path,
                           material->specular.path,
                           material->excitation.path,
                           material->emission.path,
                           material->glow.path,
                           material->donaldson,
                           material->texture,
                           partner ? partner->texture : NULL};
    bool done = true;
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; i++)
        done = done && (material->diffuse.kind == SPECTRUM_NONE || add(to, paths[i], err));
    return done;
}

static bool add_detector(struct inputs *to, const char *name, struct error *err)
{
    const struct word word = {.start = name, .length = name ? strlen(name) : 0};
    char *path = NULL;
    const bool done = !name || (word_file(&word, FILE_TABLE, &path, err) && add(to, path, err));
    free(path);
    return done;
}

static bool add_all(struct inputs *to, const struct scene *scene, struct error *err)
{
    bool done = true;
    for (int i = 0; done && i < scene->n_lights + scene->n_ambients; i++)
        done = add(to, scene_light(scene, i)->spectrum.path, err);
    for (int i = 0; done && i < scene->n_materials; i++)
        done = add_material(to, &scene->materials[i], err);
    for (int i = 0; done && i < scene->n_objects; i++)
        done = add(to, scene->objects[i].shape.path, err);
    return done;
}

/* ---- the list ---- */

static int compare_paths(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static void sort(struct inputs *inputs)
{
    int n = 0;
    if (inputs->n > 0)
        qsort(inputs->path, (size_t)inputs->n, sizeof *inputs->path, compare_paths);
    for (int i = 0; i < inputs->n; i++)
        if (n > 0 && strcmp(inputs->path[n - 1], inputs->path[i]) == 0)
            free(inputs->path[i]);
        else
            inputs->path[n++] = inputs->path[i];
    inputs->n = n;
}

bool inputs_list(const struct scene *scene, const char *detector, bool texts, struct inputs *out,
                 struct error *err)
{
    *out = (struct inputs){.path = NULL};
    bool done = add_all(out, scene, err) && add_detector(out, detector, err), regular;
    for (int i = 0; texts && done && i < scene->n_texts; i++)
        done = file_is_regular(scene->files[i].path, &regular, err) &&
               (!regular || add(out, scene->files[i].path, err));
    sort(out);
    return done;
}

void inputs_free(struct inputs *inputs)
{
    for (int i = 0; i < inputs->n; i++)
        free(inputs->path[i]);
    free(inputs->path);
    *inputs = (struct inputs){.path = NULL};
}

bool inputs_digest(struct inputs *inputs, struct error *err)
{
    char sha256[65];
    for (int i = 0; i < inputs->n; i++) {
        char *path = inputs->path[i];
        struct printed line = {.text = NULL};
        if (!digest_was_read(path, sha256) && !digest_file(path, sha256, err))
            return false;
        print(&line, "%s %s", sha256, path);
        inputs->path[i] = printed_take(&line, err);
        free(path);
        if (!inputs->path[i])
            return false;
    }
    return true;
}
