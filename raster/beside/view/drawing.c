/* SPDX-License-Identifier: MIT */
/* A drawn scene for a page: the weights of its pixels, and the description of all that they weigh.
 * A still page contains both, packed. A live page has the program make them anew after a change. */
#include <stdlib.h>
#include <string.h>

#include "raster/beside/view/inside.h"

/* Planes, and their shape as JSON. */
struct drawn {
    struct planes planes;
    double *scale; /* the value of count 1 in each plane; owned */
    char *shape;   /* owned */
};

/* Describes the shape of planes. */
static char *shape_json(const struct plan *plan, const struct drawn *of, struct error *err)
{
    const struct scene *scene = plan->scene;
    const struct planes *planes = &of->planes;
    struct json json;
    json_begin(&json);
    json_count(&json, "width", (uint64_t)scene->width);
    json_count(&json, "height", (uint64_t)scene->height);
    json_count(&json, "positions", (uint64_t)scene->positions); /* a side of each pixel */
    json_numbers(&json, "weight_scales", of->scale, planes->n_weights);
    json_numbers(&json, "texture_scales", of->scale + planes->n_weights, planes->n_pages);
    return json_take(&json, err);
}

/* Draws the planes of a plan. counts: as counts of 16 bits; otherwise as floats. notes NULL: makes
 * none. The caller frees *out, also after a failure. */
static bool draw(const struct plan *plan, bool counts, struct drawn *out, struct notes *notes,
                 struct error *err)
{
    if (!planes_rasterize(plan, &out->planes, notes, err))
        return false;
    const int n = out->planes.n_weights + out->planes.n_pages;
    if (!MAKE_ARRAY(out->scale, (size_t)n, err, "the scales of a page"))
        return false;
    for (int i = 0; i < n; i++)
        out->scale[i] = counts ? plane_scale(&out->planes, i) : 1;
    return (out->shape = shape_json(plan, out, err)) != NULL;
}

static void drawn_free(struct drawn *drawn)
{
    planes_free(&drawn->planes);
    free(drawn->scale);
    free(drawn->shape);
}

/* ---- in a page ---- */

static bool put_planes(const struct drawn *drawn, struct printed *to, struct error *err)
{
    size_t length;
    unsigned char *bytes = planes_bytes(&drawn->planes, drawn->scale, &length, err);
    put_json(to, "shape", drawn->shape);
    const bool done = bytes && put_packed(to, "planes", bytes, length, err);
    free(bytes);
    return done;
}

bool viewer_write(const struct plan *plan, const char *path, struct viewer_result *out,
                  struct notes *notes, struct outputs *outputs, struct error *err)
{
    struct drawn drawn = {.shape = NULL};
    struct printed data = {.text = NULL};
    *out = (struct viewer_result){.bytes = 0};
    char *scene = draw(plan, true, &drawn, notes, err) ? description_make(plan, out, err) : NULL;
    if (scene)
        put_json(&data, "scene", scene);
    const bool done = scene && put_planes(&drawn, &data, err) &&
                      page_write(PAGE_STILL, &data, path, &out->bytes, outputs, err);
    free(scene);
    free(printed_end(&data));
    drawn_free(&drawn);
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

static bool write_parts(const struct drawn *drawn, const struct output *out, struct error *err)
{
    const struct planes *planes = &drawn->planes;
    const size_t n_values = (size_t)(planes->n_weights + planes->n_pages) * planes->n_positions;
    struct printed printed = {.text = NULL};
    put_head(&printed, drawn->shape);
    char *head = printed_take(&printed, err);
    const bool done =
        head && ((write_all(out->descriptor, head, printed.length) &&
                  write_all(out->descriptor, planes->values, n_values * sizeof *planes->values) &&
                  write_all(out->descriptor, planes->surface,
                            planes->n_positions * sizeof *planes->surface)) ||
                 error_system(err, "cannot write %s", out->path));
    free(head);
    return done;
}

bool weights_write(const struct plan *plan, const char *path, struct outputs *outputs,
                   struct error *err)
{
    struct drawn drawn = {.shape = NULL};
    struct output out;
    const bool opened = draw(plan, false, &drawn, NULL, err) && output_open(&out, path, err);
    const bool written = opened && write_parts(&drawn, &out, err) && output_sync(&out, err);
    drawn_free(&drawn);
    if (written)
        return output_pass(&out, outputs, err);
    if (opened)
        output_discard(&out);
    return false;
}
