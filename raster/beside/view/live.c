/* SPDX-License-Identifier: MIT */
/* A live page: it holds this program, compiled for browsers, and the files of the scene. */
#include <unistd.h>

#include "raster/beside/view/inside.h"

/* ---- the files of the scene, with names as seen from its folder ---- */

/* A file that is not built in. */
struct page_file {
    char *name; /* relative to the scene's folder, without "." and ".."; owned */
    const char *path;
};
struct page_files {
    struct page_file *list; /* the first one is the scene's; owned */
    int n;
    struct inputs inputs; /* own the paths of files that are no texts of the scene */
    char *above;          /* how the paths of files in that folder begin: "" or "scenes/"; owned */
};

/* Finds the name of a file below the scene's folder; allocated. */
static char *name_below(const struct page_files *files, const char *path, struct error *err)
{
    const size_t above = strlen(files->above);
    const bool below = strncmp(path, files->above, above) == 0;
    char *name;
    if (string_copy(below ? path + above : path, &name, err) && !(below && path_fold(name))) {
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
    int place = 0;
    while (place < files->n && strcmp(files->list[place].name, file.name) != 0)
        place++;
    if (place == files->n && array_add(&files->list, &files->n, &file, sizeof file, err))
        return true;
    free(file.name);
    return place < files->n && is_same_file(files->list[place].path, path, err);
}

static void page_files_free(struct page_files *files)
{
    for (int i = 0; i < files->n; i++)
        free(files->list[i].name);
    free(files->list);
    free(files->above);
    inputs_free(&files->inputs);
}

char *marked_name(const char *scene, struct error *err)
{
    const char *base = path_name(scene);
    struct printed name = {.text = NULL};
    print(&name, "%.*s%s%s", (int)(base - scene), scene, scene[0] == '/' ? "./" : "", base);
    return printed_take(&name, err);
}

/* Lists the texts of a scene and the files that it names, and those of the options. The
 * scene must outlive *out. Refuses a file outside of the scene's folder. The caller frees *out,
 * zeroed before, also after a failure. */
static bool page_files_make(const struct scene *scene, const struct options *options,
                            struct page_files *out, struct error *err)
{
    const char *path = scene->files[0].path, *display = options->display;
    bool done = string_copy(path_is_builtin(path) ? "" : path, &out->above, err);
    if (done) /* a built-in scene has no folder: its options name files from the working folder */
        out->above[path_name(out->above) - out->above] = '\0';
    done = done && inputs_list(scene, options->detector, false, &out->inputs, err);
    for (int i = 0; done && i < scene->n_texts; i++)
        done = add(out, scene->files[i].path, err);
    for (int i = 0; done && i < out->inputs.n; i++)
        done = add(out, input_path(out->inputs.file[i]), err);
    return done && (!display || display_is_known(display) || add(out, display, err));
}

/* ---- their bytes ---- */

/* Adds the bytes of a file. Those of standard input are read already. */
static bool add_content(struct printed *to, const struct scene *scene, const char *path,
                        struct error *err)
{
    const struct builtin_file *builtin; /* none of these is in the list */
    char block[1 << 16];
    int descriptor;
    ssize_t got = 1;
    if (scene_is_input(path)) {
        print_bytes(to, scene->files[0].bytes, scene->files[0].length);
        return true;
    }
    if (!file_open(path, NOWHERE, &descriptor, &builtin, err))
        return false;
    for (uint64_t at = 0; got > 0 && !to->failed; at += (uint64_t)got) {
        got = read_at(descriptor, block, sizeof block, at);
        print_bytes(to, block, got > 0 ? (size_t)got : 0);
    }
    if (got < 0)
        error_system(err, "cannot read %s", path);
    close(descriptor);
    return err->status == EXIT_AGREED;
}

/* Returns the name of a file in the page, where the scene's folder is the working folder. */
static const char *page_name(const char *name)
{
    return scene_is_input(name) ? "scene.scene" : name;
}

/* Returns whether an option names the file. Its word is relative to the working folder. */
static bool is_in_options(const struct options *options, const char *path)
{
    for (int i = 0; i < options->n_recorded; i++)
        if (strstr(options->recorded[i], path))
            return true;
    return false;
}

static bool add_file(const struct options *options, const struct scene *scene,
                     const struct page_file *file, struct json *json, struct printed *bytes,
                     struct error *err)
{
    const size_t before = bytes->length;
    if (!add_content(bytes, scene, file->path, err))
        return false;
    json_open(json, NULL, '{');
    json_string(json, "name", page_name(file->name));
    json_count(json, "length", bytes->length - before);
    if (is_in_options(options, file->path))
        json_string(json, "also", file->path);
    json_close(json, '}');
    return true;
}

/* Puts a scene, its options and its files. The bytes of all files, one after the other, are added
 * to *bytes. */
static bool put_scene(const struct options *options, const struct scene *scene, struct json *json,
                      struct printed *bytes, struct error *err)
{
    struct page_files files = {.list = NULL};
    const bool builtin = path_is_builtin(scene->files[0].path); /* such a name may have a folder */
    json_string(json, "scene", builtin ? scene->path : page_name(path_name(scene->path)));
    json_strings(json, "options", (const char *const *)options->recorded, options->n_recorded);
    json_open(json, "files", '[');
    bool done = page_files_make(scene, options, &files, err);
    for (int i = 0; done && i < files.n; i++)
        done = add_file(options, scene, &files.list[i], json, bytes, err);
    page_files_free(&files);
    json_close(json, ']');
    return done;
}

/* ---- the pages ---- */

/* Frees *bytes. */
static bool write_page(struct page_parts *parts, struct json *start, struct printed *bytes,
                       struct options *options, size_t *size, struct error *err)
{
    put_json(&parts->data, "start", json_take(start, err));
    char *files = printed_take(bytes, err);
    if (files)
        put_packed(&parts->data, "files", files, bytes->length, err);
    free(files);
    return page_write(parts, options, size, err);
}

bool live_write(struct viewing *view, struct error *err)
{
    struct page_parts parts = {.kind = PAGE_LIVE};
    struct printed bytes = {.text = NULL};
    struct json json;
    json_begin(&json);
    json_string(&json, "program", PROGRAM);
    json_truth(&json, "gallery", ((const struct view_options *)view->options->own)->gallery);
    if (put_first(view, &parts, err))
        put_scene(view->options, view->plan->scene, &json, &bytes, err);
    return write_page(&parts, &json, &bytes, view->options, &view->bytes, err);
}

static bool put_verified(const struct options *options, const struct verified_scene *of,
                         struct json *json, struct printed *bytes, struct error *err)
{
    static const char *const kinds[] = {"built-in", "hard", "file"};
    struct options alone = *options;
    struct scene scene;
    char *marked = marked_name(of->path, err);
    alone.operand = alone.operands[0] = marked;
    alone.n_operands = 1;
    json_open(json, NULL, '{');
    json_string(json, "name", of->name);
    json_string(json, "kind", kinds[of->kind]);
    const bool done = marked && scene_read_options(&alone, &scene, err) &&
                      put_scene(&alone, &scene, json, bytes, err);
    json_close(json, '}');
    if (marked)
        scene_free(&scene);
    free(marked);
    return done;
}

bool verifier_write(struct options *options, const struct verified_scene *scenes, int n,
                    struct error *err)
{
    struct page_parts parts = {.kind = PAGE_VERIFIER};
    struct printed bytes = {.text = NULL};
    struct json json;
    size_t size;
    json_begin(&json);
    json_string(&json, "program", PROGRAM);
    json_open(&json, "scenes", '[');
    for (int i = 0; i < n; i++)
        if (!put_verified(options, &scenes[i], &json, &bytes, err))
            break;
    json_close(&json, ']');
    return write_page(&parts, &json, &bytes, options, &size, err);
}
