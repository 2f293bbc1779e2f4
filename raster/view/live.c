/* SPDX-License-Identifier: MIT */
/* A live page: it holds this program, compiled for browsers, and the files of the scene. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "data/text/text.h"
#include "raster/bounds/bounds.h"
#include "raster/driver/driver.h"
#include "raster/view/view.h"

struct live_page {
    struct page page; /* the first member */
    const struct options *options;
    const struct scene *scene;
};

/* ---- the program ---- */

static const struct builtin_file *find_module(void)
{
    const struct builtin_file *file;
    struct error missing;
    int descriptor;
    file_open(BUILTIN_PREFIX "viewer/spectral.wasm.gz", (struct place){NULL, 0, 0}, &descriptor,
              &file, &missing);
    return file;
}

bool has_live_pages(void)
{
    return find_module() != NULL;
}

bool put_module(struct page *page, struct error *err)
{
    const struct builtin_file *file = find_module();
    size_t length;
    char *text = base64_text(file->bytes, file->length, &length);
    if (!text)
        return error_memory(err);
    put_base64(&page->text, "module", text, length);
    free(text);
    return true;
}

/* ---- the files ---- */

static bool add_bytes(struct printed *to, int descriptor, const char *path, struct error *err)
{
    struct stat status;
    char *bytes = NULL;
    const struct place place = {path, 0, 0};
    if (fstat(descriptor, &status) != 0)
        return error_system(err, "cannot read %s", path);
    const size_t length = (size_t)status.st_size;
    if (!memory_suffices(3 * (double)status.st_size, place, err, "a page with %s", path))
        return false;
    bytes = malloc(length + 1);
    const ssize_t got = bytes ? read_at(descriptor, bytes, length, 0) : 0;
    const bool done =
        !bytes    ? error_memory(err)
        : got < 0 ? error_system(err, "cannot read %s", path)
                  : (size_t)got == length || error_system(err, "%s has become shorter", path);
    if (done)
        print_bytes(to, bytes, length);
    free(bytes);
    return done;
}

/* Adds the bytes of a file. Those of standard input are read already. */
static bool add_content(struct printed *to, const struct scene *scene, const char *path,
                        struct error *err)
{
    const struct builtin_file *builtin;
    int descriptor;
    if (scene_is_input(path)) {
        print_bytes(to, scene->files[0].bytes, scene->files[0].length);
        return true;
    }
    if (!file_open(path, (struct place){NULL, 0, 0}, &descriptor, &builtin, err))
        return false;
    const bool done = add_bytes(to, descriptor, path, err);
    close(descriptor);
    return done;
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

static bool add_file(const struct live_page *live, const struct page_file *file,
                     struct json *json, struct printed *bytes, struct error *err)
{
    const size_t before = bytes->length;
    if (!add_content(bytes, live->scene, file->path, err))
        return false;
    json_open(json, NULL, '{');
    json_string(json, "name", page_name(file->name));
    json_count(json, "length", bytes->length - before);
    if (is_in_options(live->options, file->path))
        json_string(json, "also", file->path);
    json_close(json, '}');
    return true;
}

static bool add_files(const struct live_page *live, struct json *json, struct printed *bytes,
                      struct error *err)
{
    const struct scene *scene = live->scene;
    struct page_files files = {.list = NULL};
    json_open(json, "files", '[');
    bool done = page_files_make(scene, &files, err);
    for (int i = 0; done && i < files.n; i++)
        done = add_file(live, &files.list[i], json, bytes, err);
    json_close(json, ']');
    page_files_free(&files);
    return done;
}

static bool put_files(struct live_page *live, struct error *err)
{
    struct page *page = &live->page;
    struct printed bytes = {.text = NULL};
    struct json json;
    size_t length = 0;
    json_begin(&json);
    json_open(&json, NULL, '{');
    json_string(&json, "program", PROGRAM);
    json_string(&json, "scene", page_name(path_name(live->scene->path)));
    json_truth(&json, "gallery", live->options->gallery);
    json_open(&json, "options", '[');
    for (int i = 0; i < live->options->n_recorded; i++)
        json_string(&json, NULL, live->options->recorded[i]);
    json_close(&json, ']');
    const bool listed = add_files(live, &json, &bytes, err);
    json_close(&json, '}');
    char *facts = json_end(&json), *all = printed_end(&bytes);
    char *text = facts && all && listed
                     ? packed_text((const unsigned char *)all, bytes.length, &length)
                     : NULL;
    const bool done = text != NULL;
    if (done) {
        put_json(&page->text, "start", facts);
        put_base64(&page->text, "files", text, length);
    }
    free(text);
    free(all);
    free(facts);
    return done || (listed && error_memory(err));
}

static bool put_live(struct page *page, struct error *err)
{
    struct live_page *live = (struct live_page *)page;
    return put_files(live, err) && put_module(page, err);
}

/* ---- the page ---- */

bool live_write(const struct plan *plan, struct options *options, struct viewer_result *out,
                struct notes *notes, struct error *err)
{
    struct live_page live = {{.kind = PAGE_LIVE, .put_data = put_live}, options, plan->scene};
    *out = (struct viewer_result){.bytes = 0};
    return page_allows(plan, err) && notes_of_plan(plan, SOME_PIXELS, notes, err) &&
           page_write(&live.page, options->output, &out->bytes, &options->outputs, err);
}
