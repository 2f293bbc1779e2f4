/* SPDX-License-Identifier: MIT */
/* spectral pack: a scene with all files that it names, for another machine. */
#include <stdlib.h>
#include <string.h>

#include "data/invocation/invocation.h"
#include "data/pack/pack.h"

static bool write_archive(const struct packing *packing, const char *top, struct options *options,
                          struct error *err)
{
    struct output out;
    bool done = output_open(&out, options->output, err);
    for (int i = 0; done && i < packing->n_files; i++) {
        const struct packed_file *file = &packing->files[i];
        struct printed name = {.text = NULL};
        print(&name, "%s/%s", top, file->name);
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
    struct packing packing;
    char *top = output_name(scene->files[0].path, "");
    const bool done = packing_make(scene, &packing, err) && (top || error_memory(err)) &&
                      write_archive(&packing, top, options, err);
    packing_free(&packing);
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
    char *marked = pack_marked_name(name);
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
