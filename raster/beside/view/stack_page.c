/* SPDX-License-Identifier: MIT */
/* A stack for a page: its samples, and all that it takes to see them. The samples of a large stack
 * are means of factor x factor pixels, so that the page keeps to its budget. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/images/images.h"
#include "data/spectra/spectra.h"
#include "raster/beside/see/see.h"
#include "raster/beside/view/inside.h"

/* ---- samples ---- */

/* A stack as a page shows it. */
struct shown_stack {
    struct stack_rows rows; /* those of one row of the page at a time */
    struct cube *cube;      /* of these rows */
    int factor, width, height;
    bool counts; /* samples are 16-bit counts; otherwise floats */
    size_t n_pixels;
    unsigned char *samples; /* owned: [page][pixel], counts as differences: see put_differences */
    size_t n_bytes;
    uint16_t *objects; /* the object of each pixel, from 1; owned; NULL: none is recorded */
};

/* Text of a page for each byte of samples, before they are compressed (base64). */
static const double text_per_byte = 4.0 / 3;

static void find_size(struct shown_stack *out, double budget_bytes)
{
    const struct image *image = &out->cube->image;
    const double pixel = image->n_pages * (out->counts ? 2 : 4) * text_per_byte;
    do {
        out->factor++;
        out->width = (image->width + out->factor - 1) / out->factor;
        out->height = (image->height + out->factor - 1) / out->factor;
    } while (pixel * out->width * out->height > budget_bytes && out->width * out->height > 1);
    out->n_pixels = (size_t)out->width * (size_t)out->height;
    out->n_bytes = out->n_pixels * (size_t)image->n_pages * (out->counts ? 2 : 4);
}

/* Stores the means of the current rows of a page of the stack. `sums` is room for a row. */
static void store_row(const struct shown_stack *of, int page, double *sums, float *out)
{
    const int width = of->cube->image.width;
    const float *row = of->rows.samples + (size_t)page * of->rows.stride;
    memset(sums, 0, (size_t)of->width * sizeof *sums);
    for (int y = 0; y < of->rows.n; y++, row += width)
        for (int x = 0; x < width; x++)
            sums[x / of->factor] += (double)row[x];
    for (int x = 0; x < of->width; x++) {
        const int left = width - x * of->factor, columns = left < of->factor ? left : of->factor;
        out[x] = (float)(sums[x] / ((double)columns * of->rows.n));
    }
}

static bool read_pages(struct shown_stack *of, float *out, struct error *err)
{
    const int n_pages = of->cube->image.n_pages;
    const size_t width = (size_t)of->width,
                 most = (size_t)of->factor * (size_t)of->cube->image.width * (size_t)n_pages;
    double *sums;
    bool done =
        MAKE_ARRAY(sums, width, err, "a row of a page") && rows_allocate(&of->rows, most, err);
    for (int y = 0; done && y < of->height; y++) {
        done = rows_read(&of->rows, y * of->factor, err);
        for (int page = 0; done && page < n_pages; page++)
            store_row(of, page, sums, out + (size_t)page * of->n_pixels + (size_t)y * width);
    }
    free(sums);
    return done;
}

/* Turns floats into counts of scale / LARGEST_SAMPLE, page by page. */
static bool store_counts(struct shown_stack *of, const float *values, struct error *err)
{
    uint16_t *counts;
    if (!MAKE_ARRAY(counts, of->n_pixels, err, "the pixels of a page") ||
        !MAKE_ARRAY(of->samples, of->n_bytes, err, "the pixels of a page")) {
        free(counts);
        return false;
    }
    for (int page = 0; page < of->cube->image.n_pages; page++) {
        const float *from = values + (size_t)page * of->n_pixels;
        for (size_t i = 0; i < of->n_pixels; i++)
            counts[i] = (uint16_t)fmin(
                LARGEST_SAMPLE,
                floor((double)from[i] / of->cube->image.scale * LARGEST_SAMPLE + 0.5));
        put_differences(counts, of->n_pixels, of->samples + (size_t)page * 2 * of->n_pixels);
    }
    free(counts);
    return true;
}

static bool read_samples(struct shown_stack *of, struct error *err)
{
    const struct image *image = &of->cube->image;
    const size_t n = of->n_pixels * (size_t)image->n_pages;
    float *values;
    if (!memory_suffices((double)n * 4 + 2.0 * (double)of->n_bytes, (struct place){NULL, 0, 0}, err,
                         "a page of %d bands of %dx%d pixels", image->n_pages, of->width,
                         of->height) ||
        !MAKE_ARRAY(values, n, err, "the pixels of a page"))
        return false;
    bool done = read_pages(of, values, err);
    if (done && !of->counts) {
        of->samples = (unsigned char *)values;
        return true;
    }
    done = done && store_counts(of, values, err);
    free(values);
    return done;
}

/* Reads the object at the middle of each shown pixel. */
static bool read_objects(struct shown_stack *of, struct error *err)
{
    const struct image *image = &of->cube->image;
    if (of->cube->record.objects.n == 0)
        return true;
    int *row;
    bool done = MAKE_ARRAY(row, (size_t)image->width, err, "a row of objects") &&
                MAKE_ARRAY(of->objects, of->n_pixels, err, "the objects of a page");
    for (int y = 0; done && y < of->height; y++) {
        const int at = y * of->factor + of->factor / 2;
        done = cube_objects(of->cube, 0, at < image->height ? at : image->height - 1, image->width,
                            row, err);
        for (int x = 0; done && x < of->width; x++) {
            const int from = x * of->factor + of->factor / 2,
                      object = row[from < image->width ? from : image->width - 1];
            of->objects[(size_t)y * (size_t)of->width + (size_t)x] =
                (uint16_t)(object > 0 ? object : 0);
        }
    }
    free(row);
    return done;
}

static void stack_free(struct shown_stack *stack)
{
    free(stack->samples);
    free(stack->objects);
    rows_close(&stack->rows);
}

/* ---- the description ---- */

/* Puts a detector: its weights, and its responses to the white and to a radiance of 1. Leaves out
 * one that cannot see the stack. */
static bool put_detector(const struct cube *cube, const char *name, double *row, struct json *json,
                         struct error *err)
{
    static const struct white_request request = {NULL, false};
    struct detector detector = {.name = NULL};
    struct error refused = {.status = EXIT_AGREED};
    double lost[3], equal[3], white[3];
    bool has_white;
    if (!detector_read(name, &detector, err))
        return false;
    if (cube_weights(cube, &detector, row, &refused) &&
        cube_equal_response(cube, &detector, row, equal, &refused) &&
        cube_white_response(cube, &request, row, &has_white, white, &refused)) {
        cube_lost(cube, &detector, lost);
        json_open(json, NULL, '{');
        json_string(json, "name", name);
        json_truth(json, "observer", detector.observer);
        json_rows(json, "weights", row, cube->image.n_pages);
        json_numbers(json, "lost", lost, 3);
        json_numbers(json, "equal", equal, 3);
        json_numbers(json, "of_white", white, has_white ? 3 : 0);
        json_close(json, '}');
    }
    detector_free(&detector);
    return refused.status != EXIT_SYSTEM || (*err = refused, false);
}

static bool put_detectors(const struct cube *cube, struct json *json, struct error *err)
{
    char name[BUILTIN_NAME];
    double *row;
    bool done = MAKE_ARRAY(row, 3 * (size_t)cube->image.n_pages, err, "the weights of a detector");
    json_open(json, "detectors", '[');
    for (size_t i = 0; done && i < builtin_file_count; i++)
        if (table_is_detector(&builtin_files[i]) &&
            builtin_name(&builtin_files[i], "tables/", ".csv", name))
            done = put_detector(cube, name, row, json, err);
    json_close(json, ']');
    free(row);
    return done;
}

/* Puts the white at each page's wavelength; none if the stack records none. */
static bool put_white(const struct cube *cube, struct json *json, struct error *err)
{
    struct error refused = {.status = EXIT_AGREED};
    double *white;
    if (!MAKE_ARRAY(white, (size_t)cube->image.n_pages, err, "the white of a page"))
        return false;
    if (!cube->components && cube_white(cube, NULL, white, &refused))
        json_numbers(json, "white", white, cube->image.n_pages);
    if (cube->record.illumination.n > 0)
        json_number(json, "illumination", cube->record.illumination.value[0]);
    free(white);
    return true;
}

static void put_size(const struct shown_stack *stack, struct json *json)
{
    const struct image *image = &stack->cube->image;
    json_count(json, "width", (uint64_t)stack->width);
    json_count(json, "height", (uint64_t)stack->height);
    json_count(json, "full_width", (uint64_t)image->width);
    json_count(json, "full_height", (uint64_t)image->height);
    json_count(json, "factor", (uint64_t)stack->factor);
    json_count(json, "bands", (uint64_t)image->n_pages);
    json_truth(json, "components", stack->cube->components);
    json_truth(json, "counts", stack->counts);
    json_number(json, "unit", stack->counts ? image->scale / LARGEST_SAMPLE : 1);
    json_truth(json, "has_objects", stack->objects != NULL);
    json_numbers(json, "wavelengths", image->wavelengths_nm, image->n_pages);
}

/* Returns the description as JSON, allocated. */
static char *describe(const struct shown_stack *stack, const char *name, struct error *err)
{
    const struct texts *objects = &stack->cube->record.objects;
    struct json json;
    json_begin(&json);
    json_string(&json, "program", PROGRAM);
    json_string(&json, "stack", path_name(name));
    json_string(&json, "scene", stack->cube->record.scene);
    put_size(stack, &json);
    json_open(&json, "objects", '[');
    for (int i = 0; i < objects->n; i++)
        json_string(&json, NULL, objects->text[i]);
    json_close(&json, ']');
    const bool done = put_white(stack->cube, &json, err) && put_detectors(stack->cube, &json, err);
    put_adaptations(&json);
    put_displays(&json);
    if (done)
        return json_take(&json, err);
    free(printed_end(&json.printed));
    return NULL;
}

/* ---- a page, or its data alone ---- */

/* Returns the data: the head, the samples, the objects. Allocated. */
static char *stack_bytes(const struct shown_stack *stack, const char *name, size_t *length,
                         struct error *err)
{
    struct printed bytes = {.text = NULL};
    char *json = describe(stack, name, err);
    if (!json)
        return NULL;
    put_head(&bytes, json);
    free(json);
    print_bytes(&bytes, stack->samples, stack->n_bytes);
    if (stack->objects)
        print_bytes(&bytes, stack->objects, stack->n_pixels * sizeof *stack->objects);
    char *text = printed_take(&bytes, err);
    *length = bytes.length;
    return text;
}

static bool write_page(const char *bytes, size_t length, const char *path, size_t *n_bytes,
                       struct outputs *outputs, struct error *err)
{
    const bool live = has_live_pages();
    struct printed data = {.text = NULL};
    bool done = put_packed(&data, "stack", bytes, length, err);
    if (done && live)
        put_module(&data);
    done = done && page_write(live ? PAGE_LIVE : PAGE_STACK, &data, path, n_bytes, outputs, err);
    free(printed_end(&data));
    return done;
}

bool stack_page_write(const char *stack, const char *path, const struct stack_page_options *options,
                      struct stack_result *out, struct outputs *outputs, struct error *err)
{
    struct shown_stack shown = {.factor = 0};
    char *bytes = NULL;
    shown.cube = &shown.rows.cube;
    *out = (struct stack_result){.bytes = 0};
    bool done = cube_open(stack, shown.cube, err);
    if (done) {
        const struct image *image = &shown.cube->image;
        shown.counts = !image_is_float(image);
        find_size(&shown, options->budget_bytes);
        *out = (struct stack_result){.width = image->width,
                                     .height = image->height,
                                     .n_bands = image->n_pages,
                                     .factor = shown.factor};
    }
    done = done && read_samples(&shown, err) && read_objects(&shown, err) &&
           (bytes = stack_bytes(&shown, stack, &out->bytes, err)) != NULL;
    if (options->alone)
        done = done && file_write(path, bytes, out->bytes, outputs, err);
    else
        done = done && write_page(bytes, out->bytes, path, &out->bytes, outputs, err);
    free(bytes);
    stack_free(&shown);
    return done;
}
