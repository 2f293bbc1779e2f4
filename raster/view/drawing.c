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
    *out = (struct viewer_result){.bytes = 0};
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

void put_head(struct printed *to, const char *json)
{
    const size_t length = strlen(json), filled = (length + 3) / 4 * 4;
    print(to, "%11zu\n%s", filled, json);
    print_bytes(to, "   ", filled - length);
}

static bool write_parts(const struct planes *planes, const char *head, size_t length,
                        const struct output *out, struct error *err)
{
    const size_t n_values = (size_t)(planes->n_weights + planes->n_pages) * planes->n_positions;
    return (write_all(out->descriptor, head, length) &&
            write_all(out->descriptor, planes->values, n_values * sizeof *planes->values) &&
            write_all(out->descriptor, planes->surface,
                      planes->n_positions * sizeof *planes->surface)) ||
           error_system(err, "cannot write %s", out->path);
}

static bool write_planes(const struct plan *plan, const struct planes *planes, const char *path,
                         struct outputs *outputs, struct error *err)
{
    struct output out;
    struct printed printed = {.text = NULL};
    double *scale = scales_of(planes, false);
    char *json = scale ? planes_json(plan, planes, scale) : NULL;
    if (json)
        put_head(&printed, json);
    char *head = json ? printed_end(&printed) : NULL;
    const bool opened = head ? output_open(&out, path, err) : error_memory(err),
               done = opened && write_parts(planes, head, printed.length, &out, err) &&
                      output_sync(&out, err);
    free(scale);
    free(json);
    free(head);
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
