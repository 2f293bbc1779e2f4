/* SPDX-License-Identifier: MIT */
/* A drawn scene for a page: planes of the weights of its pixels, from the reference's picture, and
 * the description of all that they weigh. Weights depend on geometry only. A still page contains
 * both, packed, planes as counts. A live page has the program make them anew after a change. */
#include "raster/beside/view/inside.h"

/* ---- the picture as planes ---- */

/* Planes of one value a position, and a pixel may have several: the weight of the constant
 * term, then the diffuse and the specular weight of each light, then the values of spectral
 * textures at their own wavelengths. Materials share the planes: a position shows one material. */
struct planes {
    size_t width, n_positions;
    int n_weights, n_pages; /* planes of weights, and of textures */
    uint16_t *surface;      /* from 1; 0: background */
    float *values;          /* [plane][position] */
    double *scale;          /* the value of count 1 in each plane; this and all arrays are owned */
};

static void planes_free(struct planes *planes)
{
    FREE_ALL(planes->surface, planes->values, planes->scale);
}

static bool planes_allocate(const struct plan *plan, struct planes *out, struct error *err)
{
    *out = (struct planes){.width = (size_t)plan->view.width,
                           .n_positions = (size_t)plan->view.width * (size_t)plan->view.height,
                           .n_weights = weight_pages(plan),
                           .n_pages = texture_pages(plan, true)};
    /* of each value: a float, 2 bytes, and up to 2 when they are packed; 14 of each pixel */
    const double n_values = (double)out->n_weights + out->n_pages;
    const double n_positions = (double)plan->view.width * plan->view.height;
    if (!memory_suffices(n_positions * (8 * n_values + 14), (struct place){NULL, 0, 0}, err,
                         "a page of %dx%d pixels", plan->view.width, plan->view.height))
        return false;
    return MAKE_ARRAY(out->surface, out->n_positions, err, "the pixels of a page") &&
           MAKE_ARRAY(out->values, out->n_positions * (size_t)n_values, err,
                      "the pixels of a page") &&
           MAKE_ARRAY(out->scale, (size_t)n_values, err, "the scales of a page");
}

/* Copies the rows of a page into its plane, and with the first one the numbers of surfaces. */
static bool put_page(void *context, const struct picture *picture, int page, const float *values,
                     struct error *err)
{
    struct planes *planes = context;
    const struct rectangle *at = &picture->at;
    const size_t width = (size_t)at->width;
    (void)err;
    for (int y = 0; y < at->height; y++) {
        const size_t from = (size_t)y * width,
                     to = (size_t)(at->y + y) * planes->width + (size_t)at->x;
        memcpy(planes->values + (size_t)page * planes->n_positions + to, values + from,
               width * sizeof *values);
        for (size_t x = 0; page == 0 && x < width; x++)
            planes->surface[to + x] = (uint16_t)(picture->surface[from + x] + 1);
    }
    return true;
}

/* ---- planes in a page, and in files ---- */

/* Returns the shape of the planes as JSON, allocated; NULL: see err. */
static char *shape_of(const struct planes *planes, const struct scene *scene, struct error *err)
{
    struct json json;
    json_begin(&json);
    json_count(&json, "width", (uint64_t)scene->width);
    json_count(&json, "height", (uint64_t)scene->height);
    json_count(&json, "positions", (uint64_t)scene->positions); /* a side of each pixel */
    json_numbers(&json, "weight_scales", planes->scale, planes->n_weights);
    json_numbers(&json, "texture_scales", planes->scale + planes->n_weights, planes->n_pages);
    return json_take(&json, err);
}

/* Draws the planes of the lit scene by the reference. The caller frees *out, also after a failure.
 */
static bool planes_make(const struct viewing *view, struct planes *out, struct error *err)
{
    const struct decomposition of = {.own_wavelengths = true, .take = put_page, .context = out};
    return planes_allocate(view->plan, out, err) && decompose(&view->lit, &of, err);
}

void put_differences(const uint16_t *samples, size_t n, unsigned char *out)
{
    for (size_t i = 0; i < n; i++) {
        unsigned difference = samples[i] - (i > 0 ? (unsigned)samples[i - 1] : 0);
        out[i] = difference & 0xff;
        out[n + i] = difference >> 8 & 0xff;
    }
}

/* Stores the samples of a plane in units of its scale, by which its largest value is
 * LARGEST_SAMPLE. */
static void count_plane(struct planes *planes, size_t plane, uint16_t *samples)
{
    const float *values = planes->values + plane * planes->n_positions;
    double largest = 0;
    for (size_t i = 0; i < planes->n_positions; i++)
        if ((double)values[i] > largest)
            largest = (double)values[i];
    const double scale = planes->scale[plane] = largest / LARGEST_SAMPLE;
    for (size_t i = 0; i < planes->n_positions; i++)
        samples[i] = (uint16_t)(scale > 0 ? fmax(0, floor((double)values[i] / scale + 0.5)) : 0);
}

/* Puts the shape, and then the surfaces and all planes in units of their scales, as 16-bit samples:
 * see put_differences. */
static void put_planes(struct planes *planes, const struct scene *scene, struct printed *to,
                       struct error *err)
{
    const size_t n = planes->n_positions, n_values = (size_t)(planes->n_weights + planes->n_pages),
                 length = 2 * n * (1 + n_values);
    unsigned char *bytes;
    uint16_t *samples = NULL;
    if (MAKE_ARRAY(bytes, length, err, "the pixels of a page") &&
        MAKE_ARRAY(samples, n, err, "the pixels of a page")) {
        put_differences(planes->surface, n, bytes);
        for (size_t plane = 0; plane < n_values; plane++) {
            count_plane(planes, plane, samples);
            put_differences(samples, n, bytes + 2 * n * (1 + plane));
        }
        put_json(to, "shape", shape_of(planes, scene, err));
        put_packed(to, "planes", bytes, length, err);
    }
    FREE_ALL(bytes, samples);
}

/* ---- the picture that a page shows first ---- */

bool still_write(struct viewing *view, struct error *err)
{
    return develop_scene(&view->lit, view->options, NULL, &view->exposure, &view->out_of_gamut,
                         err);
}

bool put_first(struct viewing *view, struct page_parts *to, struct error *err)
{
    to->width = view->plan->scene->width;
    to->height = view->plan->scene->height;
    return develop_scene(&view->lit, view->options, &to->first, &view->exposure,
                         &view->out_of_gamut, err);
}

/* ---- the page, and its data alone ---- */

bool viewer_write(struct viewing *view, struct error *err)
{
    struct planes planes = {.surface = NULL};
    struct page_parts parts = {.kind = PAGE_STILL};
    if (planes_make(view, &planes, err) && put_first(view, &parts, err)) {
        put_json(&parts.data, "scene", description_make(view, err));
        put_planes(&planes, view->plan->scene, &parts.data, err);
    }
    planes_free(&planes);
    return page_write(&parts, view->options, &view->bytes, err);
}

bool description_write(struct viewing *view, struct error *err)
{
    char *json = description_make(view, err);
    const bool done =
        json && file_write(view->options->output, json, strlen(json), &view->options->outputs, err);
    free(json);
    return done;
}

void put_head(struct printed *to, char *json)
{
    const size_t length = json ? strlen(json) : 0, filled = (length + 3) / 4 * 4;
    print(to, "%11zu\n%s", filled, json ? json : "");
    print_bytes(to, "   ", filled - length);
    free(json);
}

bool weights_write(struct viewing *view, struct error *err)
{
    struct planes planes = {.surface = NULL};
    struct printed bytes = {.text = NULL};
    if (planes_make(view, &planes, err)) {
        const size_t n = (size_t)(planes.n_weights + planes.n_pages);
        for (size_t plane = 0; plane < n; plane++)
            planes.scale[plane] = 1; /* floats are values */
        put_head(&bytes, shape_of(&planes, view->plan->scene, err));
        print_stored(&bytes, planes.values, sizeof *planes.values,
                     n * planes.n_positions * sizeof *planes.values);
        print_stored(&bytes, planes.surface, sizeof *planes.surface,
                     planes.n_positions * sizeof *planes.surface);
    }
    planes_free(&planes);
    return printed_write(&bytes, view->options->output, &view->options->outputs, err);
}
