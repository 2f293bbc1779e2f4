/* SPDX-License-Identifier: MIT */
/* A drawn scene for a page: the weights of its pixels, and the description of all that they weigh.
 * A still page contains both, packed. A live page has the program make them anew after a change. */
#include <stdlib.h>
#include <string.h>

#include "raster/beside/view/inside.h"

/* ---- in a page ---- */

static bool put_planes(const struct planes *planes, struct printed *to, struct error *err)
{
    size_t length;
    unsigned char *bytes = planes_bytes(planes, &length, err);
    put_json(to, "shape", planes->shape);
    const bool done = bytes && put_packed(to, "planes", bytes, length, err);
    free(bytes);
    return done;
}

bool viewer_write(struct viewing *view, struct error *err)
{
    struct planes planes = {.shape = NULL};
    struct printed data = {.text = NULL};
    char *scene = planes_make(view->plan, true, &planes, &view->notes, err)
                      ? description_make(view, err)
                      : NULL;
    if (scene)
        put_json(&data, "scene", scene);
    const bool done = scene && put_planes(&planes, &data, err) &&
                      page_write(PAGE_STILL, &data, view->options->output, &view->bytes,
                                 &view->options->outputs, err);
    free(scene);
    free(printed_end(&data));
    planes_free(&planes);
    return done;
}

/* ---- in files, for a live page ---- */

bool description_write(struct viewing *view, struct error *err)
{
    char *json = description_make(view, err);
    const bool done =
        json && file_write(view->options->output, json, strlen(json), &view->options->outputs, err);
    free(json);
    return done;
}

void put_head(struct printed *to, const char *json)
{
    const size_t length = strlen(json), filled = (length + 3) / 4 * 4;
    print(to, "%11zu\n%s", filled, json);
    print_bytes(to, "   ", filled - length);
}

static bool write_parts(const struct planes *planes, const struct output *out, struct error *err)
{
    const size_t n_values = (size_t)(planes->n_weights + planes->n_pages) * planes->n_positions;
    struct printed printed = {.text = NULL};
    put_head(&printed, planes->shape);
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

bool weights_write(struct viewing *view, struct error *err)
{
    struct planes planes = {.shape = NULL};
    struct output out = {.path = NULL};
    const bool done = planes_make(view->plan, false, &planes, NULL, err) &&
                      output_open(&out, view->options->output, err) &&
                      write_parts(&planes, &out, err) && output_sync(&out, err) &&
                      output_pass(&out, &view->options->outputs, err);
    planes_free(&planes);
    output_discard(&out);
    return done;
}
