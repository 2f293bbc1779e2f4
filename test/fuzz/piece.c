/* SPDX-License-Identifier: MIT */
/* Fuzz target: the file of a part, which may be another machine's: its facts, its marks and its
 * sums, for a picture that the seeds are parts of. */
#include <stdlib.h>

#include "raster/bounds/bounds.h"
#include "raster/parts/parts.h"
#include "test/fuzz/fuzz.h"

/* Reads all tiles that are complete. */
static void read_tiles(struct part_file *file, const struct check_scene *check)
{
    struct error err = {.status = EXIT_AGREED};
    struct tile_sums sums = {.odd = {0, 0}};
    struct collector collector;
    bool found = true, done = totals_open(check, &sums.totals, &err) &&
                              part_plan(file, check->lit->plan, &err) &&
                              collector_open(check->lit->plan, NULL, &sums, &collector, &err);
    if (fuzz_ends(done, &err)) {
        while (done && found)
            done = collector_take(&collector, file, &found, &err);
        fuzz_holds(file->n_complete <= file->n_tiles, "a part has no more tiles than its picture");
        fuzz_ends(done, &err);
        collector_close(&collector);
    }
    totals_free(&sums.totals);
}

static void read_part(struct part_file *file)
{
    const struct plan_options options = {.threads = 1, .check = true, .use_gl = true};
    struct error err = {.status = EXIT_AGREED};
    struct scene scene;
    struct plan plan = {.scene = NULL};
    struct lit_scene lit = {0};
    struct light_work work;
    if (fuzz_ends(scene_read("patches", &scene, &err) && scene_set_size(&scene, "16x12", &err) &&
                      scene_set_wavelengths(&scene, "500", &err) &&
                      plan_make(&scene, NULL, &options, &plan, &err) &&
                      lit_make(&plan, driver_of(NULL), &lit, &work, &err),
                  &err)) {
        const struct check_scene check = {.lit = &lit, .full_scale = 1};
        read_tiles(file, &check);
    }
    lit_free(&lit);
    plan_free(&plan);
    scene_free(&scene);
}

void fuzz_piece(const struct fuzz_input *input)
{
    const struct picture_part whole = {1, 1};
    struct error err = {.status = EXIT_AGREED};
    struct part_facts facts;
    struct record record = {.text = NULL};
    struct part_file file;
    char path[FUZZ_PATH];
    fuzz_write(".part", input->bytes, input->length, path);
    if (fuzz_ends(part_open(path, &whole, &file, &err), &err)) {
        facts_read(file.text, &facts);
        record_parse(file.text, &record, &err);
        record_free(&record);
        read_part(&file);
    }
    part_close(&file);
}
