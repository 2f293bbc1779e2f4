/* SPDX-License-Identifier: MIT */
/* Reads scenes: finds the file of a scene, reads one statement a line, and reads the files that it
 * includes. Statements may come in any order; some of them may be given only once. */
#include "data/scene/inside.h"

/* ---- files ---- */

bool scene_keep(struct scene *scene, struct text *text, struct error *err)
{
    text->tables = &scene->tables;
    if (array_add(&scene->files, &scene->n_files, text, sizeof *text, err))
        return true;
    text_free(text);
    return false;
}

bool scene_open(struct scene *scene, const struct word *word, enum file_kind kind, struct text *out,
                struct error *err)
{
    char *path = NULL;
    bool done = word_file(word, kind, &path, err) && file_expected(path, word->place, kind, err) &&
                text_open(out, path, word->place, 0, err) && scene_keep(scene, out, err);
    free(path);
    return done;
}

/* ---- statements ---- */

static bool read_statements(struct scene_reader *reader, struct text *text, struct error *err);

static bool include_read(struct scene_reader *reader, struct error *err)
{
    struct word word;
    struct text text;
    if (!text_expect(reader->text, &word, "a scene file", err) ||
        !text_end(reader->text, "include", err))
        return false;
    if (reader->n_included++ == MOST_INCLUDES)
        return error_at(err, word.place, "a scene includes at most %d files in all", MOST_INCLUDES);
    if (!scene_open(reader->scene, &word, FILE_SCENE, &text, err))
        return false;
    if (reader->n_open == DEEPEST_INCLUDE)
        return error_at(err, word.place, "files include each other more than %d deep",
                        DEEPEST_INCLUDE);
    for (int i = 0; i < reader->n_open; i++) {
        bool same;
        if (!file_is_same(reader->open[i], text.path, &same, err))
            return false;
        if (same)
            return error_at(err, word.place, "%.200s would include itself", reader->open[i]);
    }
    return read_statements(reader, &text, err);
}

/* The first N_ONCE of them may be given only once. */
static const char *const statements[] = {"wavelengths", "size",    "camera", "viewer",   "shading",
                                         "background",  "ambient", "light",  "material", "object",
                                         "checker",     "include", NULL};
static bool (*const statement_readers[])(struct scene_reader *, struct error *) = {
    wavelengths_read, size_read,  camera_read,     viewer_read, shading_read, background_read,
    ambient_read,     light_read, definition_read, object_read, checker_read, include_read};

static bool read_statement(struct scene_reader *reader, const struct word *word, struct error *err)
{
    const int statement = word_choose(word, statements, "statement", err);
    if (statement < 0 || (statement < N_ONCE && !place_once(&reader->given[statement], word->place,
                                                            statements[statement], err)))
        return false;
    reader->place = word->place;
    return statement_readers[statement](reader, err);
}

/* Reads all statements from the cursor to the end of the file. */
static bool read_statements(struct scene_reader *reader, struct text *text, struct error *err)
{
    struct word word;
    reader->open[reader->n_open++] = text->path;
    while (text_next_line(text)) {
        reader->text = text;
        if (text_word(text, &word) && !read_statement(reader, &word, err))
            return false;
    }
    reader->n_open--;
    return true;
}

/* ---- scenes and lists ---- */

bool scene_is_input(const char *path)
{
    return strcmp(path, standard_input) == 0;
}

bool scene_is_missing(const char *name, bool *out, struct error *err)
{
    const struct word word = {.start = name, .length = strlen(name)};
    char *path;
    const bool done = word_file(&word, FILE_SCENE, &path, err);
    *out = done && file_is_missing(path);
    free(path);
    return done;
}

/* Sets *out if the file is a list of materials: its first line has one word, and that is no
 * statement; or a table of them. Refuses an empty file. */
static bool is_list(struct text text, bool *out, struct error *err)
{
    const struct text whole = text;
    struct word word, more;
    while (text_next_line(&text)) {
        if (!text_word(&text, &word))
            continue;
        *out = (!text_word(&text, &more) || set_is(whole)) && word_find(&word, statements) < 0;
        return true;
    }
    return error_at(err, text_whole(&text),
                    "the file is empty; expected a scene or a list of materials");
}

static void digest_files(struct scene *scene)
{
    struct digest digest;
    scene->n_texts = scene->n_files;
    digest_start(&digest);
    for (int i = 0; i < scene->n_files; i++)
        digest_add(&digest, scene->files[i].bytes, scene->files[i].length);
    digest_end(&digest, scene->sha256);
}

/* Opens SCENE, and keeps it. */
static bool open_named(struct scene *scene, const char *name, struct text *out, struct error *err)
{
    const struct word named = {.start = name, .length = strlen(name)};
    const bool input = strcmp(name, "-") == 0;
    return string_copy(input ? standard_input : name, &scene->path, err) &&
           (input ? text_open(out, standard_input, NOWHERE, 0, err) && scene_keep(scene, out, err)
                  : scene_open(scene, &named, FILE_SCENE, out, err));
}

/* Reads the scene of that name. If the file is a list, this is the built-in colorchecker with the
 * list in place of its own. */
static bool read_named(struct scene_reader *reader, const char *name, struct error *err)
{
    struct scene *scene = reader->scene;
    const struct word grid = {.start = "colorchecker", .length = strlen("colorchecker")};
    struct text text;
    bool list = false;
    if (!open_named(scene, name, &text, err) || !is_list(text, &list, err))
        return false;
    if (list) {
        reader->list = text;
        if (!scene_open(scene, &grid, FILE_SCENE, &text, err))
            return false;
    }
    return read_statements(reader, &text, err) && materials_resolve(reader, err) &&
           wavelengths_complete(scene, err);
}

bool scene_read(const char *name, struct scene *out, struct error *err)
{
    struct scene_reader reader = {.scene = out};
    bool done;
    *out = (struct scene){0};
    view_set_defaults(out);
    done = read_named(&reader, name, err);
    index_free(&reader.named);
    index_free(&reader.listed);
    for (int i = 0; i < reader.n_mtl; i++)
        mtl_free(&reader.mtl[i]);
    free(reader.mtl);
    tables_free(&out->tables);
    if (done)
        digest_files(out);
    else
        scene_free(out);
    return done;
}

const struct light *scene_light(const struct scene *scene, int i)
{
    return i < scene->n_lights ? &scene->lights[i] : &scene->ambients[i - scene->n_lights];
}

bool scene_is_absolute(const struct scene *scene)
{
    return scene->n_lights + scene->n_ambients > 0 && scene_light(scene, 0)->absolute;
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
        object_free(&scene->objects[i]);
    for (int i = 0; i < scene->n_files; i++)
        text_free(&scene->files[i]);
    tables_free(&scene->tables);
    FREE_ALL(scene->ambients, scene->lights, scene->materials, scene->objects, scene->files,
             scene->wavelengths_nm, scene->path);
    *scene = (struct scene){0};
}
