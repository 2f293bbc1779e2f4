/* SPDX-License-Identifier: MIT */
/* A drawn scene for a page: the weights of its pixels, and the description of all that they weigh.
 * A still page contains both, packed. A live page has the program make them anew after a change. */
#include <stdlib.h>
#include <string.h>

#include "data/text/text.h"
#include "raster/view/view.h"

/* Returns the shape of planes as JSON, allocated; NULL: no memory. */
static char *planes_json(const struct plan *plan, const struct planes *planes, const double *scale)
{
    const struct scene *scene = plan->scene;
    struct json json;
    json_begin(&json);
    json_open(&json, NULL, '{');
    json_count(&json, "width", (uint64_t)scene->width);
    json_count(&json, "height", (uint64_t)scene->height);
    json_count(&json, "positions", (uint64_t)scene->positions); /* a side of each pixel */
    json_numbers(&json, "weight_scales", scale, planes->n_weights);
    json_numbers(&json, "texture_scales", scale + planes->n_weights, planes->n_pages);
    json_close(&json, '}');
    return json_end(&json);
}

/* Allocates the values of count 1 in all planes: of planes in counts, or in floats. */
static double *scales_of(const struct planes *planes, bool counts)
{
    const int n = planes->n_weights + planes->n_pages;
    double *scale = calloc((size_t)n, sizeof *scale);
    for (int i = 0; scale && i < n; i++)
        scale[i] = counts ? plane_scale(planes, i) : 1;
    return scale;
}

/* ---- in a page ---- */

struct still_page {
    struct page page; /* the first member */
    const struct plan *plan;
    const struct planes *planes;
    struct viewer_result *result;
};

static bool put_planes(struct still_page *still, struct error *err)
{
    struct printed *to = &still->page.text;
    double *scale = scales_of(still->planes, true);
    char *shape = scale ? planes_json(still->plan, still->planes, scale) : NULL;
    size_t length;
    char *text = shape ? planes_text(still->planes, scale, &length) : NULL;
    const bool done = text != NULL;
    if (done) {
        put_json(to, "shape", shape);
        put_base64(to, "planes", text, length);
    }
    free(shape);
    free(scale);
    free(text);
    return done || error_memory(err);
}

static bool put_still(struct page *page, struct error *err)
{
    struct still_page *still = (struct still_page *)page;
    char *json = description_make(still->plan, still->result, err);
    if (!json)
        return false;
    put_json(&page->text, "scene", json);
    free(json);
    return put_planes(still, err);
}

bool viewer_write(const struct plan *plan, const char *path, struct viewer_result *out,
                  struct notes *notes, struct outputs *outputs, struct error *err)
{
    struct planes planes = {.n_positions = 0};
    struct still_page still = {{.kind = PAGE_STILL, .put_data = put_still}, plan, &planes, out};
    *out = (struct viewer_result){.n_objects = plan->n_instances, .n_lights = plan->n_lights};
    const bool done = planes_rasterize(plan, &planes, notes, err) &&
                      page_write(&still.page, path, &out->bytes, outputs, err);
    planes_free(&planes);
    return done;
}

/* ---- in files, for a live page ---- */

bool description_write(const struct plan *plan, const char *path, struct outputs *outputs,
                       struct error *err)
{
    struct viewer_result result;
    char *json = description_make(plan, &result, err);
    const bool done = json && file_write(path, json, strlen(json), outputs, err);
    free(json);
    return done;
}

static bool write_parts(const struct planes *planes, const char *json, const struct output *out)
{
    char head[128];
    const size_t n_values = (size_t)(planes->n_weights + planes->n_pages) * planes->n_positions,
                 filled = (strlen(json) + 3) / 4 * 4;
    const int length = snprintf(head, sizeof head, "%11zu\n", filled);
    return write_all(out->descriptor, head, (size_t)length) &&
           write_all(out->descriptor, json, strlen(json)) &&
           write_all(out->descriptor, "   ", filled - strlen(json)) &&
           write_all(out->descriptor, planes->values, n_values * sizeof *planes->values) &&
           write_all(out->descriptor, planes->surface,
                     planes->n_positions * sizeof *planes->surface);
}

static bool write_planes(const struct plan *plan, const struct planes *planes, const char *path,
                         struct outputs *outputs, struct error *err)
{
    struct output out;
    double *scale = scales_of(planes, false);
    char *json = scale ? planes_json(plan, planes, scale) : NULL;
    free(scale);
    if (!json)
        return error_memory(err);
    const bool opened = output_open(&out, path, err),
               done = opened &&
                      (write_parts(planes, json, &out) ||
                       error_system(err, "cannot write %s", path)) &&
                      output_sync(&out, err);
    free(json);
    if (done)
        return output_pass(&out, outputs, err);
    if (opened)
        output_discard(&out);
    return false;
}

bool weights_write(const struct plan *plan, const char *path, struct outputs *outputs,
                   struct error *err)
{
    struct planes planes = {.n_positions = 0};
    const bool done = planes_rasterize(plan, &planes, NULL, err) &&
                      write_planes(plan, &planes, path, outputs, err);
    planes_free(&planes);
    return done;
}
