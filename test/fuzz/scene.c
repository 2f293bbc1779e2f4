/* SPDX-License-Identifier: MIT */
/* Fuzz targets: a scene, and a list of materials, from the file to the plan and its notes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/mesh/mesh.h"
#include "data/scene/inside.h"
#include "data/text/text.h"
#include "raster/bounds/bounds.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "raster/render/render.h"
#include "raster/renderers/renderers.h"
#include "test/fuzz/fuzz.h"

/* A sphere of 4096 x 4096 is good input, and takes seconds. */
static bool is_small(const struct scene *scene)
{
    double corners = 0;
    for (int i = 0; i < scene->n_objects; i++) {
        const struct shape *shape = &scene->objects[i].shape;
        double product = 1;
        for (int j = 0; shape->kind != SHAPE_MESH && j < 4; j++)
            product *= fmax(shape->parameter[j], 1);
        corners += product;
    }
    return corners * scene->tessellation * scene->tessellation <= 4096 && scene->n_objects <= 64 &&
           scene->n_wavelengths <= 500;
}

/* Does what spectral plan does. */
static bool plan_scene(const struct scene *scene, struct error *err)
{
    const struct plan_options options = {.threads = 1, .check = true, .use_gl = true};
    struct plan plan = {.scene = NULL};
    struct notes notes = {.n = 0};
    struct lit_scene lit = {0};
    struct json words, json;
    words_begin(&words);
    json_begin(&json);
    bool done = plan_make(scene, NULL, &options, &plan, err) &&
                lit_make(&plan, driver_of(NULL), &lit, err) && notes_make(&lit, 256, &notes, err);
    if (done) {
        plan_facts(&plan, &words);
        plan_facts(&plan, &json);
        done = json_write(&json, "/dev/null", NULL, err);
    }
    free(printed_end(&words.printed));
    free(printed_end(&json.printed));
    lit_free(&lit);
    notes_free(&notes);
    plan_free(&plan);
    return done;
}

static void check_scene(const struct scene *scene)
{
    fuzz_holds(scene->width >= 1 && scene->height >= 1 && scene->n_wavelengths >= 1,
               "a scene has pixels and bands");
    for (int i = 1; i < scene->n_wavelengths; i++)
        fuzz_holds(scene->wavelengths_nm[i - 1] < scene->wavelengths_nm[i], "wavelengths increase");
    for (int i = 0; i < scene->n_objects; i++)
        fuzz_holds(scene->objects[i].material >= -1 &&
                       scene->objects[i].material < scene->n_materials,
                   "an object has a material of the scene");
}

static void read_scene(const char *path)
{
    struct error err = {.status = EXIT_AGREED};
    struct scene scene;
    bool done = scene_read(path, &scene, &err);
    if (done) {
        check_scene(&scene);
        if (is_small(&scene))
            done = plan_scene(&scene, &err);
    }
    fuzz_ends(done, &err);
    scene_free(&scene);
}

void fuzz_scene(const struct fuzz_input *input)
{
    read_scene(input->path);
}

/* A map gives the parts of a mesh their materials. */
void fuzz_map(const struct fuzz_input *input)
{
    static const char format[] =
        "material a { diffuse 0.5 }\nmaterial b bricks.txt\nlight d65 1 direction 0 0 1\n"
        "object mesh chair materials %s\nobject mesh meshes/two.obj materials %s\n";
    char path[FUZZ_PATH], scene[sizeof format + 2 * FUZZ_PATH];
    snprintf(scene, sizeof scene, format, input->path, input->path);
    fuzz_write(".scene", scene, strlen(scene), path);
    read_scene(path);
}

void fuzz_list(const struct fuzz_input *input)
{
    static const char format[] = "light d65 1 direction 0 0 1\nchecker %s plane 5 5\n";
    char path[FUZZ_PATH], scene[sizeof format + FUZZ_PATH];
    snprintf(scene, sizeof scene, format, input->path);
    fuzz_write(".scene", scene, strlen(scene), path);
    read_scene(path);
}
