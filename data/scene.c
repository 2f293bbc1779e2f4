/* SPDX-License-Identifier: MIT */
/* Scenes: which file it is, its statements one a line, and files that it includes. Statements come
 * in any order; one that can hold only once is refused the second time. */
#include "scene.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- files ---- */

bool scene_keep(struct scene *scene, const struct text *text, struct error *err)
{
    struct text *grown = array_more(scene->files, scene->n_files, sizeof *grown, err);
    struct text lost = *text;
    if (grown == NULL) {
        text_free(&lost);
        return false;
    }
    scene->files = grown;
    grown[scene->n_files++] = *text;
    return true;
}

static bool same_file(const char *a, const char *b)
{
    struct stat one, other;
    return strcmp(a, b) == 0 || (stat(a, &one) == 0 && stat(b, &other) == 0 &&
                                 one.st_dev == other.st_dev && one.st_ino == other.st_ino);
}

/* ---- statements ---- */

static bool read_statements(struct scene_reader *reader, struct text *text, struct error *err);

static bool include_open(struct scene_reader *reader, const char *path, struct place from,
                         struct error *err)
{
    struct text text;
    if (reader->n_open == DEEPEST_INCLUDE)
        return error_at(err, from, "files include each other more than %d deep", DEEPEST_INCLUDE);
    for (int i = 0; i < reader->n_open; i++)
        if (same_file(reader->open[i], path))
            return error_at(err, from, "%.200s would include itself", reader->open[i]);
    return text_open(&text, path, from, err) && scene_keep(reader->scene, &text, err) &&
           read_statements(reader, &text, err);
}

static bool include_read(struct scene_reader *reader, struct text *text, struct place place,
                         struct error *err)
{
    struct word word;
    char *path;
    bool done;
    (void)place;
    if (!text_expect(text, &word, "a scene file", err) || !text_end(text, "include", err))
        return false;
    path = word_path(&word, err);
    if (path == NULL)
        return false;
    done = include_open(reader, path, word.place, err);
    free(path);
    return done;
}

static const char *const statements[] = {"wavelengths", "size",    "camera",  "viewer",
                                         "shading",     "ambient", "light",   "material",
                                         "object",      "checker", "include", NULL};
static bool (*const statement_readers[])(struct scene_reader *, struct text *, struct place,
                                         struct error *) = {
    wavelengths_read, size_read,       camera_read, viewer_read,  shading_read, ambient_read,
    light_read,       definition_read, object_read, checker_read, include_read};

/* From the cursor to the file's end. */
static bool read_statements(struct scene_reader *reader, struct text *text, struct error *err)
{
    struct word word;
    reader->open[reader->n_open++] = text->path;
    while (text_next_line(text)) {
        int statement;
        if (!text_word(text, &word))
            continue;
        statement = word_choose(&word, statements, "statement", err);
        if (statement < 0 || !statement_readers[statement](reader, text, word.place, err))
            return false;
    }
    reader->n_open--;
    return true;
}

/* ---- scenes and lists ---- */

static bool refuse_missing(const char *name, struct error *err)
{
    static const char folder[] = "scenes/", ending[] = ".scene";
    char list[512] = "";
    size_t used = 0;
    for (size_t i = 0; i < builtin_file_count && used < sizeof list; i++) {
        const char *file = builtin_files[i].name, *end = strrchr(file, '.');
        if (strncmp(file, folder, strlen(folder)) == 0 && end != NULL && strcmp(end, ending) == 0)
            used +=
                (size_t)snprintf(list + used, sizeof list - used, "%s%.*s", used > 0 ? ", " : "",
                                 (int)(end - file - (long)strlen(folder)), file + strlen(folder));
    }
    return error_usage(err, "no built-in scene and no file '%.500s'; built-in: %s", name, list);
}

static bool open_scene(struct scene *scene, const char *name, struct text *out, struct error *err)
{
    const struct place nowhere = {0};
    char builtin[256];
    if (builtin_path("scenes/", name, ".scene", builtin, sizeof builtin))
        name = builtin;
    else if (strncmp(name, "builtin:", 8) != 0 && access(name, F_OK) != 0 && errno == ENOENT)
        return refuse_missing(name, err);
    return text_open(out, name, nowhere, err) && scene_keep(scene, out, err);
}

/* A list of materials, rather than a scene, begins with a line of one word that is no statement. */
static bool is_list(struct text text, bool *out, struct error *err)
{
    struct word word, more;
    while (text_next_line(&text)) {
        if (!text_word(&text, &word))
            continue;
        *out = !text_word(&text, &more);
        for (int i = 0; statements[i] != NULL; i++)
            *out = *out && !word_is(&word, statements[i]);
        return true;
    }
    return error_at(err, text_whole(&text), "empty; neither a scene nor a list of materials");
}

/* A list is shown as the built-in colorchecker, with the list in place of the one it names. */
static bool read_list(struct scene_reader *reader, const struct text *list, struct error *err)
{
    struct text text;
    reader->list = list;
    return open_scene(reader->scene, "colorchecker", &text, err) &&
           read_statements(reader, &text, err);
}

static bool read_named(struct scene_reader *reader, const char *name, struct error *err)
{
    struct scene *scene = reader->scene;
    struct text text;
    bool list = false;
    scene->path = strdup(name);
    if (scene->path == NULL)
        return error_memory(err);
    if (!open_scene(scene, name, &text, err) || !is_list(text, &list, err))
        return false;
    return (list ? read_list(reader, &text, err) : read_statements(reader, &text, err)) &&
           uses_resolve(reader, err) && settings_complete(scene, err);
}

bool scene_read(const char *name, struct scene *out, struct error *err)
{
    struct scene_reader reader = {.scene = out};
    bool done;
    *out = (struct scene){0};
    done = read_named(&reader, name, err);
    free(reader.uses);
    if (!done)
        scene_free(out);
    return done;
}

void scene_free(struct scene *scene)
{
    for (int i = 0; i < scene->n_ambients; i++)
        spectrum_free(&scene->ambients[i].spectrum);
    for (int i = 0; i < scene->n_lights; i++)
        spectrum_free(&scene->lights[i].spectrum);
    for (int i = 0; i < scene->n_materials; i++)
        material_free(&scene->materials[i]);
    for (int i = 0; i < scene->n_objects; i++)
        shape_free(&scene->objects[i].shape);
    for (int i = 0; i < scene->n_files; i++)
        text_free(&scene->files[i]);
    free(scene->ambients);
    free(scene->lights);
    free(scene->materials);
    free(scene->objects);
    free(scene->files);
    free(scene->wavelengths_nm);
    free(scene->path);
    *scene = (struct scene){0};
}
