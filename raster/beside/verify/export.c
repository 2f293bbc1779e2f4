/* SPDX-License-Identifier: MIT */
/* Writes the files of a scene into a new folder. */

#include "raster/beside/verify/inside.h"
#include "raster/bounds/bounds.h"
#include "raster/counts/counts.h"
#include "raster/reference/reference.h"

static bool write_file(void *of, const char *name, const void *bytes, size_t length,
                       struct error *err)
{
    const struct folder *folder = of;
    if (is_interrupted())
        return error_failed(err, "interrupted; nothing was written");
    char path[sizeof folder->path + FILE_NAME + 1];
    snprintf(path, sizeof path, "%s/%s", folder->path, name);
    return file_write(path, bytes, length, NULL, err);
}

static bool find_scale(const struct plan *plan, double *out, struct error *err)
{
    struct lit_scene lit = {.plan = NULL};
    struct light_work work = {.vertices_lit = 0};
    bool clips;
    const bool done = lit_make(plan, driver_of(NULL), &lit, &work, err) &&
                      find_full_scale(&lit, out, &clips, err);
    lit_free(&lit);
    return done;
}

bool export_plan(const struct plan *plan, const char *path, struct error *err)
{
    struct folder folder;
    const struct file_taker taker = {write_file, &folder};
    char id[DIGEST_TEXT];
    double full_scale;
    if (!find_scale(plan, &full_scale, err))
        return false;
    guard_hold();
    const bool done = folder_open_beside(path, &folder, err) &&
                      scene_describe(plan, full_scale, &taker, id, err) &&
                      folder_keep(&folder, path, err);
    folder_close(&folder);
    guard_release();
    return done;
}
