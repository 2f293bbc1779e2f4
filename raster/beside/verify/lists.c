/* SPDX-License-Identifier: MIT */
/* The drivers and the scenes that are verified. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster/beside/measure/measure.h"
#include "raster/beside/verify/inside.h"

/* ---- drivers ---- */

static bool add_driver(struct verification *to, const char *library, const char *renderer,
                       struct error *err)
{
    struct verify_driver driver = {.names = {.library = ""}};
    snprintf(driver.library, sizeof driver.library, "%s", library);
    snprintf(driver.renderer, sizeof driver.renderer, "%s", renderer ? renderer : "");
    return array_add(&to->drivers, &to->n_drivers, &driver, sizeof driver, err);
}

/* Returns whether an earlier driver of the list is the same one, by another option. */
static bool is_listed(const struct driver_list *drivers, int index)
{
    const struct listed_driver *listed = &drivers->list[index];
    const char *driver;
    for (int i = 0; i < index; i++) {
        const struct listed_driver *other = &drivers->list[i];
        if (other->is && strcmp(other->is->names.library, listed->is->names.library) == 0 &&
            strcmp(other->is->names.renderer, listed->is->names.renderer) == 0 &&
            strcmp(other->is->names.version, listed->is->names.version) == 0 &&
            driver_way(other->renderer, &driver) == driver_way(listed->renderer, &driver))
            return true;
    }
    return false;
}

static bool find_drivers(const struct options *options, struct verification *out, struct error *err)
{
    const struct verify_options *own = options->own;
    struct driver_list drivers = {.n = 0};
    if (own->render.gl || own->render.renderer)
        return add_driver(out, own->render.gl ? own->render.gl : "auto", own->render.renderer, err);
    bool done = drivers_list(&drivers, err);
    for (int i = 0; i < drivers.n && done; i++)
        if (drivers.list[i].is && !is_listed(&drivers, i))
            done = add_driver(out, drivers.list[i].library, drivers.list[i].renderer, err);
    drivers_free(&drivers);
    return done && (out->n_drivers > 0 ||
                    error_unsupported(err, "no OpenGL can draw here; spectral drivers prints why"));
}

/* ---- scenes ---- */

/* The list owns a copy of the path. */
static bool add_scene(struct verification *to, const struct verify_scene *scene, const char *path,
                      struct error *err)
{
    struct verify_scene kept = *scene;
    if (!string_copy(path, &kept.path, err))
        return false;
    if (array_add(&to->scenes, &to->n_scenes, &kept, sizeof kept, err))
        return true;
    free(kept.path);
    return false;
}

/* Adds a built-in file if it is a scene of that kind; NULL: any name will do. */
static bool add_file(struct verification *to, const struct builtin_file *file, bool hard,
                     const char *wanted, struct error *err)
{
    struct verify_scene scene = {.is_hard = hard, .is_large = !hard};
    char name[BUILTIN_NAME];
    if (!builtin_name(file, hard ? "hard/" : "scenes/", ".scene", name) ||
        (wanted && strcmp(name, wanted) != 0))
        return true;
    snprintf(scene.name, sizeof scene.name, "%s%.*s", hard ? "hard/" : "", BUILTIN_NAME - 6, name);
    char path[sizeof BUILTIN_PREFIX + BUILTIN_NAME];
    snprintf(path, sizeof path, "%s%s", BUILTIN_PREFIX, file->name);
    return add_scene(to, &scene, hard ? path : name, err);
}

static bool add_builtin(struct verification *to, bool hard, const char *wanted, struct error *err)
{
    for (size_t i = 0; i < builtin_file_count; i++)
        if (!add_file(to, &builtin_files[i], hard, wanted, err))
            return false;
    return true;
}

/* Adds the scenes that a word names: "hard", all of these cases; "hard/NAME", one of them; a
 * built-in scene; or a file. */
static bool add_named(struct verification *to, const char *word, struct error *err)
{
    const int before = to->n_scenes;
    const size_t length = strlen(word);
    struct verify_scene scene = {.is_hard = false};
    if (strcmp(word, "hard") == 0)
        return add_builtin(to, true, NULL, err);
    if (!add_builtin(to, false, word, err) ||
        (strncmp(word, "hard/", 5) == 0 && !add_builtin(to, true, word + 5, err)))
        return false;
    if (to->n_scenes > before)
        return true;
    snprintf(scene.name, sizeof scene.name, "%s",
             length < sizeof scene.name ? word : word + length - sizeof scene.name + 1);
    return add_scene(to, &scene, word, err);
}

static bool find_scenes(const struct options *options, struct verification *out, struct error *err)
{
    for (int i = 0; i < options->n_operands; i++)
        if (!add_named(out, options->operands[i], err))
            return false;
    return options->n_operands > 0 ||
           (add_builtin(out, false, NULL, err) && add_builtin(out, true, NULL, err));
}

bool verification_open(const struct options *options, struct verification *out, struct error *err)
{
    *out = (struct verification){.n_drivers = 0};
    if (!find_scenes(options, out, err) || !find_drivers(options, out, err))
        return false;
    const size_t n = (size_t)out->n_drivers * (size_t)out->n_scenes;
    return MAKE_ARRAY(out->results, n, err, "the results of %zu pictures", n);
}

void verification_free(struct verification *of)
{
    for (int i = 0; i < of->n_scenes; i++)
        free(of->scenes[i].path);
    FREE_ALL(of->drivers, of->scenes, of->results);
    *of = (struct verification){.n_drivers = 0};
}

const struct verify_result *result_of(const struct verification *of, int driver, int scene)
{
    return &of->results[(size_t)driver * (size_t)of->n_scenes + (size_t)scene];
}

struct totals totals_of(const struct verify_result *results, int n)
{
    struct totals totals = {.seconds = 0};
    for (int i = 0; i < n; i++) {
        totals.n[results[i].outcome]++;
        totals.seconds += results[i].seconds;
    }
    return totals;
}

void driver_options(const struct verify_driver *driver, char out[64])
{
    snprintf(out, 64, " --gl %s%s%s", driver->library, driver->renderer[0] ? " --renderer " : "",
             driver->renderer);
}
