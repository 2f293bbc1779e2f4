/* SPDX-License-Identifier: MIT */
/* Reports a render: as a table, as one line for the stack, and as one JSON object. */
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "data/method/method.h"
#include "data/sampling/sampling.h"
#include "data/scene/scene.h"
#include "data/text/text.h"
#include "raster/render/render.h"

static double rms(const struct check_samples *samples)
{
    return samples->n ? sqrt(samples->sum_of_squares / (double)samples->n) : 0;
}

static double mean_residual(const struct check_samples *samples)
{
    return samples->n ? samples->sum / (double)samples->n : 0;
}

/* Returns whether OpenGL's samples are off in one direction. Roundings go both ways, so their mean
 * stays below the rounding of the largest sample, 2^-25 of full scale. A mean of four times that is
 * not chance if it also exceeds the scatter; samples of a pixel count as one, since they share
 * their errors. A colour buffer of few steps may round all pixels of a plain surface alike, so its
 * whole rounding is allowed. */
static bool is_biased(const struct plan *plan, const struct check_verdict *verdict)
{
    double mean = fabs(mean_residual(&verdict->samples));
    return mean > 4 * 65535.0 / 33554432 + buffer_rounding(plan) &&
           mean * sqrt((double)verdict->pixels) > 5 * rms(&verdict->samples);
}

static double percent(uint64_t part, uint64_t whole)
{
    return whole ? 100 * (double)part / (double)whole : 0;
}

static bool is_phong(const struct plan *plan)
{
    return plan->scene->shading == SHADING_PHONG;
}

void report_verdict(const struct plan *plan, const struct check_verdict *verdict, char *out,
                    size_t capacity)
{
    const struct check_samples *samples = &verdict->samples;
    if (is_phong(plan))
        snprintf(out, capacity,
                 "pixels of the reference, not cross-checked: OpenGL has no phong shading");
    else if (plan->options.store_raster && verdict->unexplained == 0)
        snprintf(out, capacity,
                 "pixels of the reference"); /* the same words with and without a check */
    else if (!plan->options.check)
        snprintf(out, capacity, "not cross-checked");
    else
        snprintf(out, capacity,
                 "cross-check: %s; %llu samples, %llu exact, %llu within 1 count, largest "
                 "difference %.3g counts, %llu of %llu pixels unexplained, %llu unbounded",
                 verdict->unexplained ? "DIFFERENT" : "agreed", (unsigned long long)samples->n,
                 (unsigned long long)samples->exact, (unsigned long long)samples->within_1,
                 samples->largest, (unsigned long long)verdict->unexplained,
                 (unsigned long long)verdict->pixels, (unsigned long long)verdict->unbounded);
}

/* ---- in words ---- */

static void print_floor(const char *name, const struct check_floor *floor, FILE *to)
{
    fprintf(to, "%s %.3f counts (median), %.3f (99.9 %%), %.1f (worst) of %llu pixels\n", name,
            floor_quantile(floor, 0.5), floor_quantile(floor, 0.999), floor->worst,
            (unsigned long long)floor->n);
}

static void print_check(const struct plan *plan, const struct check_verdict *verdict, FILE *to)
{
    const struct check_samples *samples = &verdict->samples;
    fprintf(to, "samples           %llu\n", (unsigned long long)samples->n);
    fprintf(to, "exact             %llu (%.3f %%)\n", (unsigned long long)samples->exact,
            percent(samples->exact, samples->n));
    fprintf(to, "within 1 count    %llu (%.3f %%)\n", (unsigned long long)samples->within_1,
            percent(samples->within_1, samples->n));
    fprintf(to, "largest           %.4f counts (root mean square %.5f)\n", samples->largest,
            rms(samples));
    fprintf(to, "mean residual     %+.6f counts%s\n", mean_residual(samples),
            is_biased(plan, verdict) ? ": OpenGL is biased" : "");
    print_floor("floor            ", &verdict->floor, to);
    print_floor("  in one band    ", &verdict->band_floor, to);
    print_floor("  smooth interior", &verdict->smooth_floor, to);
    fprintf(to, "worst error/bound %.3f (one band %.3f, depth %.3f)\n", samples->worst_ratio,
            samples->worst_fit_ratio, verdict->worst_depth_ratio);
    fprintf(to, "pixels            %llu, %llu ambiguous, %llu unbounded\n",
            (unsigned long long)verdict->pixels, (unsigned long long)verdict->ambiguous,
            (unsigned long long)verdict->unbounded);
    if (verdict->unbounded > verdict->pixels / 100)
        fprintf(to, "                  %.0f %% of the pixels have no bound: they are not checked\n",
                percent(verdict->unbounded, verdict->pixels));
    if (verdict->edge_holes + verdict->edge_doubles > 0)
        fprintf(to, "edge holes        %llu, doubled %llu\n",
                (unsigned long long)verdict->edge_holes, (unsigned long long)verdict->edge_doubles);
    fprintf(to, "unexplained       %llu\n", (unsigned long long)verdict->unexplained);
}

void report_print(const struct plan *plan, const struct render_result *result, FILE *to)
{
    const struct render_seconds *seconds = &result->seconds;
    const int bits = plan->options.bits;
    fprintf(to, "scene             %s, %d x %d pixels, %d %s\n", plan->scene->path,
            plan->scene->width, plan->scene->height, plan->n_bands,
            has_components(plan) ? "components" : "wavelengths");
    if (plan->sampling) {
        fprintf(to, "sampling          ");
        sampling_print(plan->sampling, to);
    }
    fprintf(to, "full scale        %.10g is count 65535%s\n", result->full_scale,
            bits == 8 ? ", stored as 255" : "");
    if (plan->options.use_gl)
        fprintf(to, "OpenGL            %s, %s\n", result->gl_renderer, result->gl_version);
    if (plan->options.check)
        fprintf(to, "bounds            of %s\n", result->driver->name);
    if (plan->options.check)
        print_check(plan, &result->check, to);
    else
        fprintf(to, "cross-check       not made%s\n",
                is_phong(plan)  ? ": OpenGL has no phong shading"
                : gl_is_built() ? ""
                                : ": this program was built without OpenGL");
    if (result->odd.clipped)
        fprintf(to, "clipped           %llu samples above full scale are stored as %s\n",
                (unsigned long long)result->odd.clipped,
                bits == 8    ? "255"
                : bits == 32 ? "full scale"
                             : "65535");
    fprintf(to,
            "seconds           %.3f (read %.3f, plan %.3f, gl %.3f, raster %.3f, check %.3f, "
            "write %.3f)\n",
            seconds->total, seconds->read, seconds->plan, seconds->gl, seconds->raster,
            seconds->check, seconds->write);
}

/* Describes a failure in words. */
static void failure_text(const struct plan *plan, const struct check_failure *failure, char *out,
                         size_t capacity)
{
    char page[BAND_NAME];
    switch (failure->kind) {
    case FAILURE_RADIANCE:
        band_name(plan, failure->band, page);
        snprintf(out, capacity, "at %s OpenGL %.6g, reference %.6g, bound %.3g counts", page,
                 failure->seen, failure->expected, failure->bound);
        break;
    case FAILURE_BANDS:
        band_name(plan, failure->band, page);
        snprintf(out, capacity,
                 "at %s OpenGL %.6g, where the other bands call for %.6g, bound %.3g counts", page,
                 failure->seen, failure->expected, failure->bound);
        break;
    case FAILURE_TRIANGLE:
        if (failure->shown.surface >= plan->n_instances)
            snprintf(out, capacity, "OpenGL drew a triangle number that does not exist");
        else if (failure->shown.surface < 0)
            snprintf(out, capacity, "OpenGL shows the background");
        else
            snprintf(out, capacity, "OpenGL shows triangle %d of %s, which cannot be visible there",
                     failure->shown.triangle + 1, object_name(plan, failure->shown.surface));
        break;
    case FAILURE_DEPTH:
        snprintf(out, capacity, "OpenGL's depth %.8g, reference %.8g, bound %.3g", failure->seen,
                 failure->expected, failure->bound);
        break;
    case FAILURE_FRAGMENTS:
        snprintf(out, capacity, "OpenGL draws %.0f fragments, reference %.0f (modulo 256)",
                 failure->seen, failure->expected);
        break;
    case FAILURE_UNBOUNDED:
        snprintf(out, capacity, "OpenGL's error has no bound there");
        break;
    }
}

bool report_difference(const struct plan *plan, const struct check_verdict *verdict,
                       const char *then, struct error *err)
{
    const struct check_failure *first = &verdict->first;
    struct place place = {NULL, 0, 0};
    char where[256] = "", what[256];
    if (first->surface >= 0)
        place = plan->instances[first->surface].object->place;
    if (place.path)
        snprintf(where, sizeof where, " (%s:%d)", place.path, place.line);
    failure_text(plan, first, what, sizeof what);
    return error_different(
        err, "the pictures differ at %llu of %llu pixels, first at %d,%d on %s%s: %s; %s",
        (unsigned long long)verdict->unexplained, (unsigned long long)verdict->pixels, first->x,
        first->y, object_name(plan, first->surface), where, what, then);
}

/* Tries the reasons in the order of their certainty. */
bool report_not_again(const struct plan *plan, const struct render_result *result, const char *path,
                      const struct record *made, const char *then, struct error *err)
{
    const struct stack_difference *first = &result->difference;
    const char *renderer = render_stored(plan, result);
    static const char changed[] = "the stack, or a file that the scene names, has changed";
    char what[256], page[BAND_NAME];
    if (strcmp(made->program, PROGRAM) != 0)
        snprintf(what, sizeof what, "it was made by %.80s, this is " PROGRAM, made->program);
    else if (strcmp(made->renderer, renderer) != 0)
        snprintf(what, sizeof what, "it was drawn by %.80s, this one by %.80s", made->renderer,
                 renderer);
    else if (first->in_map)
        snprintf(what, sizeof what, "first at %d,%d of the object map; %s", first->x, first->y,
                 changed);
    else if (first->page < 0)
        snprintf(what, sizeof what, "in the tags of its pages; %s", changed);
    else {
        band_name(plan, first->page, page);
        snprintf(what, sizeof what, "first at %d,%d of page %d (%s); %s", first->x, first->y,
                 first->page + 1, page, changed);
    }
    return error_different(err, "the stack is not the same as %s: %s; %s", path, what, then);
}

/* ---- as JSON ---- */

/* json_number writes null for this value. */
static const double null_number = (double)NAN;

static void json_picture(struct json *json, const struct plan *plan,
                         const struct render_result *result)
{
    const struct scene *scene = plan->scene;
    const bool use_gl = plan->options.use_gl;
    const double buffer_bits = buffer_steps(plan) > 0 ? plan->options.buffer_bits : 32;
    char sampling[SAMPLING_NAME];
    json_string(json, "program", "spectral");
    json_string(json, "version", SPECTRAL_VERSION);
    json_string(json, "scene", scene->path);
    json_string(json, "scene_sha256", scene->sha256);
    json_count(json, "width", (uint64_t)scene->width);
    json_count(json, "height", (uint64_t)scene->height);
    json_numbers(json, "wavelengths_nm", has_components(plan) ? NULL : scene->wavelengths_nm,
                 scene->n_wavelengths);
    if (plan->sampling)
        sampling_name(&plan->sampling->method, sampling);
    json_string(json, "sampling", plan->sampling ? sampling : NULL);
    json_string(json, "shading", shading_words[scene->shading]);
    json_number(json, "tessellation", scene->tessellation);
    json_number(json, "buffer_bits", use_gl ? buffer_bits : null_number);
    json_count(json, "bits", (uint64_t)plan->options.bits);
    json_number(json, "full_scale", result->full_scale);
    json_string(json, "renderer", plan->options.store_raster ? "raster" : "gl");
    json_string(json, "gl_renderer", use_gl ? result->gl_renderer : NULL);
    json_string(json, "gl_version", use_gl ? result->gl_version : NULL);
    json_string(json, "driver_profile", plan->options.check ? result->driver->name : NULL);
}

static void json_effects(struct json *json, const struct plan *plan)
{
    json_open(json, "effects", '{');
    for (int i = 0; i < plan->n_effects; i++)
        if (strcmp(plan->effects[i].name, "lights") == 0)
            json_count(json, "lights", (uint64_t)plan->n_lights);
        else
            json_truth(json, plan->effects[i].name, plan->effects[i].used);
    json_close(json, '}');
}

static void json_work(struct json *json, const struct plan *plan,
                      const struct render_result *result)
{
    json_open(json, "work", '{');
    json_count(json, "gl_passes", (uint64_t)result->gl.passes);
    json_count(json, "draw_calls", (uint64_t)result->gl.draw_calls);
    json_count(json, "vertices_lit", (uint64_t)result->light.vertices_lit);
    json_count(json, "points_lit", (uint64_t)result->light.points_lit);
    json_count(json, "specular_vertices", (uint64_t)result->light.specular_vertices);
    json_count(json, "power_functions", (uint64_t)result->light.power_functions);
    json_count(json, "excitation_integrals", (uint64_t)plan->work.excitation_integrals);
    json_count(json, "textures_loaded", (uint64_t)plan->work.textures_loaded);
    json_count(json, "materials_loaded", (uint64_t)plan->work.materials_loaded);
    json_count(json, "terms", (uint64_t)plan->work.terms);
    json_close(json, '}');
}

static void json_failure(struct json *json, const struct plan *plan,
                         const struct check_failure *first)
{
    static const char *const kinds[] = {"radiance", "bands",     "triangle",
                                        "depth",    "fragments", "unbounded"};
    const bool has_band = first->kind == FAILURE_RADIANCE || first->kind == FAILURE_BANDS;
    const bool has_nm = has_band && !has_components(plan);
    char page[BAND_NAME];
    if (!first->found) {
        json_string(json, "first_unexplained", NULL);
        return;
    }
    json_open(json, "first_unexplained", '{');
    json_count(json, "x", (uint64_t)first->x);
    json_count(json, "y", (uint64_t)first->y);
    json_string(json, "what", kinds[first->kind]);
    json_number(json, "wavelength_nm",
                has_nm ? plan->scene->wavelengths_nm[first->band] : null_number);
    if (has_band)
        band_name(plan, first->band, page);
    json_string(json, "page", has_band ? page : NULL);
    json_string(json, "object", object_name(plan, first->surface));
    json_close(json, '}');
}

static void json_check(struct json *json, const struct plan *plan,
                       const struct check_verdict *verdict)
{
    const struct check_samples *samples = &verdict->samples;
    json_open(json, "check", '{');
    json_count(json, "samples", samples->n);
    json_count(json, "exact", samples->exact);
    json_count(json, "within_1", samples->within_1);
    json_number(json, "max_counts", samples->largest);
    json_number(json, "rms_counts", rms(samples));
    json_number(json, "mean_residual_counts", mean_residual(samples));
    json_truth(json, "biased", is_biased(plan, verdict));
    json_count(json, "pixels", verdict->pixels);
    json_count(json, "ambiguous_pixels", verdict->ambiguous);
    json_count(json, "unexplained_pixels", verdict->unexplained);
    json_count(json, "unbounded_pixels", verdict->unbounded);
    json_count(json, "edge_holes", verdict->edge_holes);
    json_count(json, "edge_doubles", verdict->edge_doubles);
    json_number(json, "worst_error_over_bound", samples->worst_ratio);
    json_number(json, "worst_depth_error_over_bound", verdict->worst_depth_ratio);
    json_number(json, "floor_median_counts", floor_quantile(&verdict->floor, 0.5));
    json_number(json, "floor_worst_counts", verdict->floor.worst);
    json_number(json, "band_floor_median_counts", floor_quantile(&verdict->band_floor, 0.5));
    json_number(json, "band_floor_999_counts", floor_quantile(&verdict->band_floor, 0.999));
    json_number(json, "band_floor_worst_counts", verdict->band_floor.worst);
    json_count(json, "smooth_pixels", verdict->smooth_floor.n);
    json_number(json, "smooth_floor_median_counts", floor_quantile(&verdict->smooth_floor, 0.5));
    json_number(json, "smooth_floor_999_counts", floor_quantile(&verdict->smooth_floor, 0.999));
    json_number(json, "smooth_floor_worst_counts", verdict->smooth_floor.worst);
    json_failure(json, plan, &verdict->first);
    json_close(json, '}');
}

static void json_again(struct json *json, const struct stack_difference *difference)
{
    if (!difference->compared) {
        json_string(json, "again", NULL);
        return;
    }
    json_open(json, "again", '{');
    json_truth(json, "same", !difference->found);
    if (difference->found && difference->page >= 0) {
        json_count(json, "page", (uint64_t)difference->page + 1);
        json_count(json, "x", (uint64_t)difference->x);
        json_count(json, "y", (uint64_t)difference->y);
    }
    json_close(json, '}');
}

static void json_seconds(struct json *json, const struct render_seconds *seconds)
{
    json_open(json, "seconds", '{');
    json_number(json, "read", seconds->read);
    json_number(json, "plan", seconds->plan);
    json_number(json, "gl", seconds->gl);
    json_number(json, "raster", seconds->raster);
    json_number(json, "check", seconds->check);
    json_number(json, "write", seconds->write);
    json_number(json, "total", seconds->total);
    json_close(json, '}');
}

char *report_json(const struct plan *plan, const struct render_result *result, const char *output,
                  const char *sha256, uint64_t peak_bytes)
{
    struct json json;
    json_begin(&json);
    json_open(&json, NULL, '{');
    json_picture(&json, plan, result);
    json_effects(&json, plan);
    json_work(&json, plan, result);
    if (plan->options.check)
        json_check(&json, plan, &result->check);
    else
        json_string(&json, "check", NULL);
    json_again(&json, &result->difference);
    json_count(&json, "clipped_samples", result->odd.clipped);
    json_seconds(&json, &result->seconds);
    json_count(&json, "peak_bytes", peak_bytes);
    json_string(&json, "output", output);
    json_string(&json, "sha256", sha256);
    json_close(&json, '}');
    return json_end(&json);
}
