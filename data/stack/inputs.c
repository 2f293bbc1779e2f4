/* SPDX-License-Identifier: MIT */
/* Lists the files that a scene is made of. A stack records them with their digests, so that a
 * picture of one machine can be compared with that of another. */
#include "data/stack/stack.h"

/* ---- finding ---- */

const char *input_path(const char *file)
{
    return strlen(file) > SHA256_DIGITS ? file + SHA256_DIGITS + 1 : "";
}

/* Adds the file with its digest, unless the path is NULL, or the file built in, missing or there
 * already. */
static bool add(struct inputs *to, const char *path, struct error *err)
{
    char sha256[SHA256_DIGITS + 1];
    struct printed file = {.text = NULL};
    if (!path || path_is_builtin(path) || file_is_missing(path) ||
        index_find(&to->paths, path, strlen(path)) >= 0)
        return true;
    if (!digest_file(path, sha256, err) || !index_add(&to->paths, path, strlen(path), to->n, err))
        return false;
    print(&file, "%s %s", sha256, path);
    char *text = printed_take(&file, err);
    if (text && array_add(&to->file, &to->n, &text, sizeof text, err))
        return true;
    free(text);
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

static bool add_all(struct inputs *to, const struct scene *scene, struct error *err)
{
    bool done = true;
    for (int i = 0; done && i < scene->n_lights + scene->n_ambients; i++)
        done = add(to, scene_light(scene, i)->spectrum.path, err);
    for (int i = 0; done && i < scene->n_materials; i++)
        done = add_material(to, &scene->materials[i], err);
    for (int i = 0; done && i < scene->n_objects; i++)
        done = add(to, scene->objects[i].shape.path, err) &&
               add(to, scene->objects[i].shape.relief, err);
    return done;
}

/* ---- the list ---- */

static int compare_paths(const void *a, const void *b)
{
    return strcmp(input_path(*(char *const *)a), input_path(*(char *const *)b));
}

bool inputs_list(const struct scene *scene, const char *detector, bool texts, struct inputs *out,
                 struct error *err)
{
    const struct word word = {.start = detector, .length = detector ? strlen(detector) : 0};
    char *path = NULL;
    *out = (struct inputs){.file = NULL};
    bool done = add_all(out, scene, err) &&
                (!detector || word_file(&word, FILE_TABLE, &path, err)) && add(out, path, err),
         regular;
    free(path);
    for (int i = 0; texts && done && i < scene->n_texts; i++)
        done = file_is_regular(scene->files[i].path, &regular, err) &&
               (!regular || add(out, scene->files[i].path, err));
    if (out->n > 0)
        qsort(out->file, (size_t)out->n, sizeof *out->file, compare_paths);
    return done;
}

void inputs_free(struct inputs *inputs)
{
    for (int i = 0; i < inputs->n; i++)
        free(inputs->file[i]);
    free(inputs->file);
    index_free(&inputs->paths);
    *inputs = (struct inputs){.file = NULL};
}
