/* SPDX-License-Identifier: MIT */
/* Reports a render: as a table, and all figures as facts. */
#include "raster/render/inside.h"

/* A figure that does not exist: words say none, JSON says null. */
static const double no_figure = (double)NAN;

/* A ratio of -1 stands for none. */
static double existing(double ratio)
{
    return ratio < 0 ? no_figure : ratio;
}

/* ---- the table ---- */

static void print_picture(const struct plan *plan, const struct render_result *result,
                          struct printed *to)
{
    const struct scene *scene = plan->scene;
    const double *nm = scene->wavelengths_nm;
    print(to, "picture           %s, %d x %d pixels, %d %s", scene->path, scene->width,
          scene->height, plan->n_bands, has_components(plan) ? "components" : "wavelengths");
    if (!has_components(plan))
        print(to, ", %.10g to %.10g nm", nm[0], nm[scene->n_wavelengths - 1]);
    print_text(to, "\n");
    if (result->rows.count > 0)
        print(to, "part              rows %d to %d, from 0\n", result->rows.first,
              result->rows.first + result->rows.count - 1);
    if (plan->sampling) {
        print_text(to, "sampling          ");
        sampling_print(plan->sampling, to);
    }
    if (plan->options.use_gl)
        print(to, "drawn by          %s, %s, by %s\n", result->names.renderer,
              result->names.version, result->names.library);
}

/* Names the parts of pixels that the renderer does not have. */
static void print_lacks(const struct renderer_lacks *lacks, struct printed *to)
{
    if (lacks->numbers || lacks->depths)
        print(to, "not checked       %s%s%s: there are none\n", lacks->numbers ? "triangles" : "",
              lacks->numbers && lacks->depths ? ", " : "",
              lacks->depths ? "depths and fragments" : "");
}

static void print_bounds(const struct driver *driver, struct printed *to)
{
    char words[DRIVER_WORDS];
    driver_print(driver, words);
    print(to, driver->is_measured ? "bounds            %s: %s\n" : "bounds            of %s\n",
          driver->name, words);
}

/* Says what is lost above full scale. */
static void print_clipped(const struct plan *plan, const struct render_result *result,
                          struct printed *to)
{
    const int bits = plan->options.bits;
    if (result->odd.clipped > 0)
        print(to, "clipped           %llu samples above full scale are stored as %s\n",
              (unsigned long long)result->odd.clipped,
              bits == 8    ? "255"
              : bits == 32 ? "full scale"
                           : "65535");
}

void report_print(const struct plan *plan, const struct render_result *result, struct printed *to)
{
    print_picture(plan, result, to);
    if (plan->options.check && !driver_is_known(&result->driver))
        print_bounds(&result->driver, to);
    print_verdict(plan, &result->check, to);
    if (result->notes && result->notes->shading)
        shading_judge->print(result->notes->shading, to);
    print_lacks(&result->check.lacks, to);
    print_clipped(plan, result, to);
    if (result->notes)
        notes_print(result->notes, to);
    print(to, "seconds           %.3f, of processors %.3f\n", result->seconds.total,
          result->seconds.processor);
}

/* ---- all figures ---- */

/* Opens an object; where it is not there, puts null, and returns false. */
static bool open_object(struct json *json, const char *name, bool is_there)
{
    if (is_there)
        json_open(json, name, '{');
    else
        json_string(json, name, NULL);
    return is_there;
}

static void json_picture(struct json *json, const struct plan *plan,
                         const struct render_result *result)
{
    const struct scene *scene = plan->scene;
    const bool use_gl = plan->options.use_gl;
    const double buffer_bits = buffer_steps(plan) > 0 ? plan->options.buffer_bits : 32;
    char sampling[SAMPLING_NAME];
    json_string(json, "program", "spectral");
    json_string(json, "version", SPECTRAL_VERSION);
    scene_put(plan, json);
    if (plan->sampling)
        sampling_name(&plan->sampling->method, sampling);
    json_string(json, "sampling", plan->sampling ? sampling : NULL);
    json_string(json, "shading", shading_words[scene->shading]);
    json_number(json, "tessellation", scene->tessellation);
    json_number(json, "buffer_bits", use_gl ? buffer_bits : no_figure);
    json_count(json, "bits", (uint64_t)plan->options.bits);
    json_number(json, "full_scale", result->full_scale);
    json_string(json, "renderer", plan->options.store_raster ? "raster" : "gl");
    json_string(json, "gl_library", use_gl ? result->names.library : NULL);
    json_string(json, "gl_renderer", use_gl ? result->names.renderer : NULL);
    json_string(json, "gl_version", use_gl ? result->names.version : NULL);
    json_string(json, "driver_profile", plan->options.check ? result->driver.name : NULL);
}

static void json_effects(struct json *json, const struct plan *plan)
{
    json_open(json, "effects", '{');
    for (int i = 0; i < N_EFFECTS; i++)
        if (strcmp(plan->effects[i].name, "lights") == 0)
            json_count(json, "lights", (uint64_t)plan->n_lights);
        else
            json_truth(json, plan->effects[i].name, plan->effects[i].used > 0);
    json_close(json, '}');
}

static void json_work(struct json *json, const struct plan *plan,
                      const struct render_result *result)
{
    const bool use_gl = plan->options.use_gl;
    json_open(json, "work", '{');
    json_count(json, "gl_passes", (uint64_t)result->gl.passes);
    json_count(json, "draw_calls", (uint64_t)result->gl.draw_calls);
    json_count(json, "vertices_lit", (uint64_t)result->light.vertices_lit);
    json_count(json, "points_lit", (uint64_t)result->light.points_lit);
    json_count(json, "specular_vertices", (uint64_t)result->light.specular_vertices);
    json_count(json, "power_functions", (uint64_t)result->light.power_functions);
    json_count(json, "excitation_integrals", (uint64_t)plan->work.excitation_integrals);
    json_count(json, "textures_loaded", (uint64_t)plan->n_textures);
    json_count(json, "materials_loaded", (uint64_t)plan->n_materials);
    json_count(json, "terms", (uint64_t)plan->work.terms);
    json_count(json, "unseen_instances", (uint64_t)plan->work.unseen_instances);
    json_count(json, "idle_lights", (uint64_t)plan->work.idle_lights);
    json_count(json, "undrawn_textures", (uint64_t)plan->work.undrawn_textures);
    json_count(json, "dark_passes", use_gl ? (uint64_t)plan->passes.n_dark : 0);
    json_count(json, "repeated_passes", use_gl ? (uint64_t)plan->passes.n_repeated : 0);
    json_close(json, '}');
}

static void json_failure(struct json *json, const struct plan *plan,
                         const struct check_failure *first)
{
    static const char *const kinds[] = {"radiance", "bands", "triangle", "depth", "fragments"};
    const bool has_band = first->kind == FAILURE_RADIANCE || first->kind == FAILURE_BANDS;
    const bool has_nm = has_band && !has_components(plan);
    const int side = plan->scene->positions;
    char page[BAND_NAME];
    if (!open_object(json, "first_unexplained", first->found))
        return;
    json_count(json, "x", (uint64_t)(first->x / side));
    json_count(json, "y", (uint64_t)(first->y / side));
    json_string(json, "what", kinds[first->kind]);
    json_number(json, "wavelength_nm",
                has_nm ? plan->scene->wavelengths_nm[first->band] : no_figure);
    if (has_band)
        band_name(plan, first->band, page);
    json_string(json, "page", has_band ? page : NULL);
    json_string(json, "object", object_name(plan, first->surface));
    if (first->kind == FAILURE_TRIANGLE) { /* numbers as spectral export has them; 0: background */
        json_count(json, "shown_instance", (uint64_t)first->shown.surface + 1);
        json_number(json, "shown_triangle",
                    first->shown.surface < 0 ? no_figure : (double)first->shown.triangle);
    } else {
        json_number(json, "found", first->seen);
        json_number(json, "expected", first->expected);
        json_number(json, "bound", first->bound);
    }
    json_open(json, "wrong_bands", '[');
    for (int i = 0; i < first->n_odd; i++) {
        json_open(json, NULL, '{');
        json_count(json, "first_page", (uint64_t)first->odd[i].first);
        json_count(json, "last_page", (uint64_t)first->odd[i].last);
        json_number(json, "counts", first->odd[i].off);
        json_close(json, '}');
    }
    json_close(json, ']');
    json_close(json, '}');
}

/* Quantiles, the worst floor, and the pixels with a floor of at most 1, 8 and 256 counts. */
static void json_floor(struct json *json, const char *name, const struct check_floor *floor)
{
    static const struct {
        const char *name;
        double part;
    } quantiles[] = {{"median", 0.5}, {"99", 0.99}, {"999", 0.999}, {"worst", 1}};
    static const int levels[FLOOR_LEVELS] = {1, 8, CHECKED_COUNTS};
    char key[48];
    for (int i = 0; i < 4; i++) {
        snprintf(key, sizeof key, "%s_%s_counts", name, quantiles[i].name);
        json_number(json, key,
                    floor->n == 0           ? no_figure
                    : quantiles[i].part < 1 ? floor_quantile(floor, quantiles[i].part)
                                            : floor->worst);
    }
    for (int i = 0; i < FLOOR_LEVELS; i++) {
        snprintf(key, sizeof key, "%s_within_%d", name, levels[i]);
        json_count(json, key, floor->within[i]);
    }
}

static void json_check(struct json *json, const struct plan *plan,
                       const struct check_verdict *verdict)
{
    const struct check_samples *samples = &verdict->samples;
    if (!open_object(json, "check", plan->options.check))
        return;
    json_count(json, "samples", samples->n);
    json_count(json, "exact", samples->exact);
    json_count(json, "within_1", samples->within_1);
    json_number(json, "max_counts", samples->largest);
    json_number(json, "rms_counts",
                samples->n > 0 ? sqrt(samples->sum_of_squares / (double)samples->n) : no_figure);
    json_number(json, "mean_residual_counts", mean_residual(samples));
    json_number(json, "mean_residual_limit_counts", verdict->mean_limit);
    json_truth(json, "biased", is_biased(verdict));
    json_count(json, "pixels", verdict->pixels);
    json_count(json, "object_pixels", verdict->objects);
    json_count(json, "ambiguous_pixels", verdict->ambiguous);
    json_count(json, "edge_pixels", verdict->edges);
    json_count(json, "open_pixels", verdict->open);
    json_count(json, "open_edge_pixels", verdict->between);
    json_count(json, "unexplained_pixels", verdict->unexplained);
    json_count(json, "unchecked_pixels", verdict->unchecked);
    json_count(json, "unbounded_pixels", verdict->unbounded);
    json_count(json, "edge_holes", verdict->edge_holes);
    json_count(json, "edge_doubles", verdict->edge_doubles);
    json_truth(json, "triangles_checked", !verdict->lacks.numbers);
    json_truth(json, "depths_checked", !verdict->lacks.depths);
    json_number(json, "worst_error_over_bound", existing(samples->worst_ratio));
    json_number(json, "worst_band_error_over_bound", existing(samples->worst_fit_ratio));
    json_number(json, "worst_depth_error_over_bound", existing(verdict->worst_depth_ratio));
    json_floor(json, "floor", &verdict->floor);
    json_floor(json, "band_floor", &verdict->band_floor);
    json_count(json, "smooth_pixels", verdict->smooth_floor.n);
    json_floor(json, "smooth_floor", &verdict->smooth_floor);
    json_failure(json, plan, &verdict->first);
    json_close(json, '}');
}

static void json_again(struct json *json, const struct stack_difference *difference)
{
    if (!open_object(json, "again", difference->compared))
        return;
    json_truth(json, "same", !difference->found);
    if (difference->found && difference->page >= 0) {
        json_count(json, "page", (uint64_t)difference->page + 1);
        json_count(json, "x", (uint64_t)difference->x);
        json_count(json, "y", (uint64_t)difference->y);
    }
    json_close(json, '}');
}

static void json_part(struct json *json, const struct part_rows *rows)
{
    if (!open_object(json, "part", rows->count > 0))
        return;
    json_count(json, "first_row", (uint64_t)rows->first);
    json_count(json, "rows", (uint64_t)rows->count);
    json_close(json, '}');
}

static void json_seconds(struct json *json, const struct part_seconds *seconds)
{
    json_open(json, "seconds", '{');
    json_number(json, "read", seconds->read);
    json_number(json, "plan", seconds->plan);
    json_number(json, "gl", seconds->gl);
    json_number(json, "raster", seconds->raster);
    json_number(json, "check", seconds->check);
    json_number(json, "write", seconds->write);
    json_number(json, "total", seconds->total);
    json_number(json, "processor", seconds->processor);
    json_close(json, '}');
}

void report_put(const struct plan *plan, const struct render_result *result, struct json *json)
{
    if (!json->words) {
        json_picture(json, plan, result);
        json_effects(json, plan);
    } else {
        json_number(json, "full_scale", result->full_scale);
        if (plan->options.check && driver_is_known(&result->driver))
            print_bounds(&result->driver, &json->printed);
    }
    json_work(json, plan, result);
    if (!json->words)
        json_string(json, "verdict", verdict_word(plan, &result->check));
    json_check(json, plan, &result->check);
    if (result->notes && !json->words) {
        if (result->notes->shading)
            shading_judge->put(plan, result->notes->shading, json);
        notes_put(result->notes, json);
    }
    json_again(json, &result->difference);
    json_part(json, &result->rows);
    json_count(json, "clipped_samples", result->odd.clipped);
    json_seconds(json, &result->seconds);
}
