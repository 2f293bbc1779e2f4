/* SPDX-License-Identifier: MIT */
/* The spectrum of a pixel or a region, and its colour. Of a scene, the reference draws the region
 * as it draws the whole picture, and the spectra of the lights and of the material are listed
 * beside the region's radiance. */
#include "raster/beside/see/inside.h"

/* ---- columns ---- */

void column_heading(const struct column *column, char out[COLUMN_HEADING])
{
    const char *unit = column->unit;
    snprintf(out, COLUMN_HEADING, "%s%s%s%s", column->name, unit ? " (" : "", unit ? unit : "",
             unit ? ")" : "");
}

void columns_print(const struct column *columns, int n_columns, int n, struct printed *to)
{
    for (int i = 0; i < n; i++) {
        print(to, "%-17.10g", columns[0].values[i]);
        for (int column = 1; column < n_columns; column++)
            print(to, " %-12.6g", columns[column].values[i]);
        print_text(to, "\n");
    }
}

void columns_print_csv(const struct column *columns, int n_columns, int n, struct printed *to)
{
    char heading[COLUMN_HEADING];
    for (int column = 0; column < n_columns; column++) {
        column_heading(&columns[column], heading);
        print_text(to, column > 0 ? ",\"" : "\"");
        csv_text(heading, to);
        print_text(to, "\"");
    }
    for (int i = 0; i < n; i++)
        for (int column = 0; column < n_columns; column++) {
            const double value = columns[column].values[i];
            print_text(to, column > 0 ? "," : "\n");
            if (isfinite(value))
                print(to, "%.*g", exact_digits(value), value);
        }
    print_text(to, "\n");
}

/* ---- any probe ---- */

void moments_add(struct moments *moments, double value)
{
    if (moments->n++ == 0)
        moments->first = value;
    const double difference = value - moments->first;
    moments->sum += difference;
    moments->sum_of_squares += difference * difference;
}

void moments_end(const struct moments *moments, double *mean, double *spread)
{
    const double n = (double)moments->n, off = moments->sum / n;
    *mean = moments->first + off;
    *spread = sqrt(fmax(0, moments->sum_of_squares / n - off * off));
}

/* Adds a column of zeros; unit NULL: that of radiances. Returns it; NULL: no memory. */
static struct column *add_column(struct probe *probe, const char *name, const char *unit,
                                 struct error *err)
{
    if (!array_add(&probe->columns, &probe->n_columns, NULL, sizeof *probe->columns, err))
        return NULL;
    struct column *out = &probe->columns[probe->n_columns - 1];
    snprintf(out->name, sizeof out->name, "%s", name);
    out->unit = unit ? unit : probe->absolute ? ABSOLUTE_UNIT : ABSOLUTE_UNIT ", relative";
    return MAKE_ARRAY(out->values, (size_t)probe->n, err, "a spectrum of %d bands", probe->n)
               ? out
               : NULL;
}

void note_shown(struct probe *probe, int number)
{
    if (probe->shown == NO_PIXEL)
        probe->shown = number;
    else if (number != probe->shown)
        probe->shown = SEVERAL;
}

bool probe_begin(struct probe *probe, const struct cube *cube, struct error *err)
{
    const struct image *image = &cube->image;
    probe->absolute = cube->record.unit != NULL;
    probe->n = image->n_pages;
    probe->shown = NO_PIXEL;
    if (!string_copy(image->path, &probe->source, err))
        return false;
    if (cube->raw && (probe->options->detector || probe->options->matrix || probe->options->white))
        return error_usage(err,
                           "%s has raw values, which no eye sees; --detector, --matrix and "
                           "--white need a stack",
                           image->path);
    if (probe->at.x > image->width - probe->at.width ||
        probe->at.y > image->height - probe->at.height)
        return error_usage(
            err,
            "%s: the picture has %d x %d pixels; the region of %d x %d pixels from %d,%d "
            "reaches beyond it",
            image->path, image->width, image->height, probe->at.width, probe->at.height,
            probe->at.x, probe->at.y);
    probe->raw_file = cube->raw;
    if (!add_column(probe, cube->raw ? "channel" : "wavelength", cube->raw ? "number" : "nm",
                    err) ||
        !add_column(probe, cube->raw ? "raw value" : "radiance", cube->raw ? "raw" : NULL, err) ||
        !add_column(probe, cube->raw ? "standard deviation" : "standard deviation of radiance",
                    cube->raw ? "raw" : NULL, err))
        return false;
    memcpy(probe->columns[WAVELENGTH].values, image->wavelengths_nm,
           (size_t)probe->n * sizeof(double));
    return true;
}

/* There is no white if neither the probe names one nor the cube records one. Refuses a white that
 * the probe names if it cannot be used. */
bool probe_end(struct probe *probe, const struct cube *cube, const struct moments *moments,
               struct error *err)
{
    const int n = probe->n;
    const struct sight *sight = &probe->sight;
    const double *mean = probe->columns[MEAN].values;
    for (int band = 0; band < probe->n; band++)
        moments_end(&moments[band], &probe->columns[MEAN].values[band],
                    &probe->columns[SPREAD].values[band]);
    if (cube->raw)
        return true;
    if (!sights_make(cube, probe->options, &probe->camera, &probe->sight, err))
        return false;
    for (int i = 0; i < probe->camera.detector.n * n; i++) {
        const double weight = probe->camera.weights[i];
        probe->raw[i / n] += weight * mean[i % n];
        probe->raw_bound[i / n] += fabs(weight) * image_rounding(&cube->image, mean[i % n]);
    }
    detector_response(sight->weights, mean, probe->n, probe->xyz);
    if (sight->has_white)
        cielab(probe->xyz, sight->white, probe->lab);
    return true;
}

/* ---- a region of a scene ---- */

struct region {
    struct lit_scene lit;
    struct probe *probe;
    struct moments *moments; /* of each band; owned */
};

static void add_band(void *context, const struct drawn_band *drawn)
{
    struct region *region = context;
    const struct picture *picture = drawn->picture;
    const size_t n = (size_t)drawn->pixels.width * (size_t)drawn->pixels.height;
    for (size_t i = 0; i < n; i++)
        moments_add(&region->moments[drawn->band], (double)drawn->radiance[i]);
    for (int i = 0; drawn->band == 0 && i < picture->at.width * picture->at.height; i++)
        note_shown(region->probe, picture->surface[i]);
}

/* ---- curves of a scene ---- */

/* The subjects of curves. A reflectance continues beyond the ends of its spectrum, as data/terms
 * has it.
 */
enum curve_kind { LIGHT, REFLECTANCE, LUMINESCENCE };

/* Adds the curve factor x spectrum. */
static bool add_curve(struct probe *probe, const char *name, enum curve_kind kind, double factor,
                      const struct spectrum *spectrum, struct error *err)
{
    struct column *out = add_column(probe, name, kind == LIGHT ? NULL : "1", err);
    if (!out)
        return false;
    const enum spectrum_ends ends = kind == REFLECTANCE ? SPECTRUM_HOLD : SPECTRUM_ZERO;
    for (int i = 0; i < probe->n; i++)
        out->values[i] = factor * spectrum_at(spectrum, probe->columns[WAVELENGTH].values[i], ends);
    return true;
}

/* Adds each light, and the emission of a matrix under it at a right angle; shown NULL: none. */
static bool add_lights(struct probe *probe, const struct scene *scene, const struct material *shown,
                       struct error *err)
{
    bool done = true;
    for (int i = 0; done && i < scene->n_lights + scene->n_ambients; i++) {
        const struct light *light = scene_light(scene, i);
        const bool ambient = i >= scene->n_lights;
        struct spectrum emission = {.kind = SPECTRUM_NONE};
        char name[sizeof probe->columns[0].name], made[sizeof name];
        snprintf(name, sizeof name, "%s %d (%s)", ambient ? "ambient light" : "light",
                 1 + i - (ambient ? scene->n_lights : 0), light->spectrum.name);
        done = add_curve(probe, name, LIGHT, light->intensity, &light->spectrum, err);
        if (!shown || !shown->donaldson)
            continue;
        snprintf(made, sizeof made, "emission under %.80s", name);
        done = done && donaldson_emission(&shown->matrix, &light->spectrum, &emission, err) &&
               add_curve(probe, made, LIGHT, light->intensity, &emission, err);
        spectrum_free(&emission);
    }
    return done;
}

static bool add_material(struct probe *probe, const struct material *material, struct error *err)
{
    static const struct spectrum none = {.kind = SPECTRUM_NONE},
                                 one = {SPECTRUM_CONSTANT, .parameter = {1}, .factor = 1};
    const bool tinted = material->specular.kind != SPECTRUM_NONE;
    const struct {
        const char *name;
        enum curve_kind kind;
        const struct spectrum *spectrum;
    } curves[] = {{"reflectance", REFLECTANCE, &material->diffuse},
                  {"specular reflectance", REFLECTANCE,
                   !(material->gloss > 0) ? &none
                   : tinted               ? &material->specular
                                          : &one},
                  {"excitation", LUMINESCENCE, &material->excitation},
                  {"emission", LUMINESCENCE, &material->emission},
                  {"own light", LIGHT, &material->glow}};
    bool done = true;
    for (size_t i = 0; i < sizeof curves / sizeof curves[0]; i++)
        done =
            done && (curves[i].spectrum->kind == SPECTRUM_NONE ||
                     add_curve(probe, curves[i].name, curves[i].kind, 1, curves[i].spectrum, err));
    return done;
}

/* Adds the curves of the object first, since there may not be room for all lights. */
static bool add_curves(const struct region *region, struct error *err)
{
    struct probe *probe = region->probe;
    const int surface = probe->shown; /* -1: the background */
    const struct material *shown =
        surface < 0 ? NULL : region->lit.bounds[surface].shaded->material;
    return (surface == SEVERAL ||
            string_copy(object_name(region->lit.plan, surface), &probe->object, err)) &&
           (!shown || add_material(probe, shown, err)) &&
           add_lights(probe, region->lit.plan->scene, shown, err);
}

/* ---- a whole scene ---- */

bool probe_scene(struct probe *probe, struct error *err)
{
    const struct options *options = probe->options;
    struct render_job job = {
        .options = {.store_raster = true, .bits = 32, .threads = options->threads}};
    struct region region = {.lit = {.plan = &job.plan}, .probe = probe};
    struct radiances radiances = {1, add_band, &region}; /* sums have the order of pixels */
    struct cube cube = {.components = false};
    bool done = scene_read_options(options, &job.scene, err);
    if (job.scene.shading == SHADING_PHONG) /* which may have no largest radiance */
        job.options.full_scale = 1;
    done = done && job_plan(options, &job, err) && scene_cube(&job.scene, &cube, err) &&
           probe_begin(probe, &cube, err) &&
           MAKE_ARRAY(region.moments, probe->n, err, "the means of the region") &&
           lit_make(&job.plan, driver_of(NULL), &region.lit, err) &&
           find_full_scale(&region.lit, err) &&
           radiances_each(&region.lit, &probe->at, &radiances, err) && add_curves(&region, err) &&
           probe_end(probe, &cube, region.moments, err);
    FREE_ALL(cube.record.white.value, region.moments);
    lit_free(&region.lit);
    job_free(&job);
    return done;
}

void probe_free(struct probe *probe)
{
    for (int column = 0; column < probe->n_columns; column++)
        free(probe->columns[column].values);
    sight_free(&probe->sight);
    sight_free(&probe->camera);
    FREE_ALL(probe->columns, probe->source, probe->object);
}
