/* SPDX-License-Identifier: MIT */
/* A stack for a page: its samples, and all that it takes to see them. The samples of a large stack
 * are means of factor x factor pixels, so that the page keeps to its budget. */
#include "raster/beside/view/inside.h"

/* ---- samples ---- */

/* Text of a page for each byte of samples: base64. Samples that do not compress at all need all of
 * it; of those that compress by more than this, the least factor may be missed. */
static const double text_per_byte = 4.0 / 3, most_compressed = 4;

/* Finds the size of the page for the next factor that may fit, if the samples are compressed by so
 * much. */
static void find_size(struct stack_page *out, double compressed)
{
    const struct image *image = &out->rows.cube.image;
    out->counts = !image_is_float(image);
    do {
        out->factor++;
        out->width = (image->width + out->factor - 1) / out->factor;
        out->height = (image->height + out->factor - 1) / out->factor;
        out->n_pixels = (size_t)out->width * (size_t)out->height;
        out->n_bytes = (double)out->n_pixels * image->n_pages * (out->counts ? 2 : 4);
    } while (out->n_bytes * text_per_byte > compressed * out->budget_bytes && out->n_pixels > 1);
}

/* Stores a mean as a float, or as a count of scale / LARGEST_SAMPLE. */
static void store_sample(const struct stack_page *of, float mean, size_t at)
{
    const double value = (double)mean / of->rows.cube.image.scale;
    if (of->counts)
        ((uint16_t *)of->samples)[at] =
            (uint16_t)fmin(LARGEST_SAMPLE, floor(value * LARGEST_SAMPLE + 0.5));
    else
        ((float *)of->samples)[at] = mean;
}

/* Stores the means of the current rows of a page of the stack from sample `at` on. `sums` is room
 * for a row. */
static void store_row(const struct stack_page *of, int page, double *sums, size_t at)
{
    const int width = of->rows.cube.image.width;
    const float *row = of->rows.samples + (size_t)page * of->rows.stride;
    memset(sums, 0, (size_t)of->width * sizeof *sums);
    for (int y = 0; y < of->rows.n; y++, row += width)
        for (int x = 0; x < width; x++)
            sums[x / of->factor] += (double)row[x];
    for (int x = 0; x < of->width; x++) {
        const int left = width - x * of->factor, columns = left < of->factor ? left : of->factor;
        store_sample(of, (float)(sums[x] / ((double)columns * of->rows.n)), at + (size_t)x);
    }
}

static bool read_samples(struct stack_page *of, struct error *err)
{
    const struct image *image = &of->rows.cube.image;
    const size_t width = (size_t)of->width, n_pages = (size_t)image->n_pages;
    const uint64_t most = (uint64_t)of->factor * (uint64_t)image->width * n_pages;
    double *sums = NULL;
    bool done = memory_suffices(3.0 * of->n_bytes, (struct place){NULL, 0, 0}, err,
                                "a page of %d bands of %dx%d pixels", image->n_pages, of->width,
                                of->height) &&
                MAKE_ARRAY(sums, width, err, "a row of a page") &&
                rows_allocate(&of->rows, most, err) &&
                (memory_make(&of->samples, (uint64_t)of->n_bytes, 1) ||
                 memory_lacks(err, of->n_bytes, "the pixels of a page"));
    for (int y = 0; done && y < of->height; y++) {
        done = rows_read(&of->rows, y * of->factor, err);
        for (size_t page = 0; done && page < n_pages; page++)
            store_row(of, (int)page, sums, page * of->n_pixels + (size_t)y * width);
    }
    free(sums);
    return done;
}

/* Reads the object at the middle of each shown pixel. */
static bool read_objects(struct stack_page *of, struct error *err)
{
    const struct image *image = &of->rows.cube.image;
    if (of->rows.cube.record.objects.n == 0)
        return true;
    int *row;
    bool done = MAKE_ARRAY(row, (size_t)image->width, err, "a row of objects") &&
                MAKE_ARRAY(of->objects, of->n_pixels, err, "the objects of a page");
    for (int y = 0; done && y < of->height; y++) {
        const int at = y * of->factor + of->factor / 2;
        done = cube_objects(&of->rows.cube, 0, at < image->height ? at : image->height - 1,
                            image->width, row, err);
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

/* ---- the description ---- */

/* Puts the white at each page's wavelength; none if the stack records none. */
static void put_white(const struct cube *cube, struct json *json, struct error *err)
{
    struct error refused = {.status = EXIT_AGREED};
    double *white;
    if (MAKE_ARRAY(white, (size_t)cube->image.n_pages, err, "the white of a page") &&
        !cube->components && cube_white(cube, NULL, white, &refused))
        json_numbers(json, "white", white, cube->image.n_pages);
    if (cube->record.illumination.n > 0)
        json_number(json, "illumination", cube->record.illumination.value[0]);
    free(white);
}

/* Returns the description as JSON, allocated. */
static char *describe(const struct stack_page *stack, const char *name, struct error *err)
{
    const struct cube *cube = &stack->rows.cube;
    const struct image *image = &cube->image;
    const struct texts *objects = &cube->record.objects;
    struct json json;
    json_begin(&json);
    json_string(&json, "program", PROGRAM);
    json_string(&json, "stack", path_name(name));
    json_string(&json, "scene", cube->record.scene);
    json_string(&json, "radiance_unit", cube->record.unit);
    json_count(&json, "width", (uint64_t)stack->width);
    json_count(&json, "height", (uint64_t)stack->height);
    json_count(&json, "full_width", (uint64_t)image->width);
    json_count(&json, "full_height", (uint64_t)image->height);
    json_count(&json, "factor", (uint64_t)stack->factor);
    json_count(&json, "bands", (uint64_t)image->n_pages);
    json_truth(&json, "components", cube->components);
    json_truth(&json, "counts", stack->counts);
    json_number(&json, "unit", stack->counts ? image->scale / LARGEST_SAMPLE : 1);
    json_truth(&json, "has_objects", stack->objects != NULL);
    json_numbers(&json, "wavelengths", image->wavelengths_nm, image->n_pages);
    json_strings(&json, "objects", objects->text, objects->n);
    put_white(cube, &json, err);
    put_eyes(cube, true, stack->options, &json, err);
    return json_take(&json, err);
}

/* ---- a page, or its data alone ---- */

/* Puts the data: the head, the samples, page by page, counts as differences, and the objects. */
static void put_stack(const struct stack_page *stack, const char *name, struct printed *to,
                      struct error *err)
{
    const size_t n = stack->n_pixels;
    unsigned char *differences;
    put_head(to, describe(stack, name, err));
    if (!stack->counts)
        print_stored(to, stack->samples, sizeof(float), (size_t)stack->n_bytes);
    else if (MAKE_ARRAY(differences, 2 * n, err, "the pixels of a page")) {
        for (int page = 0; page < stack->rows.cube.image.n_pages; page++) {
            put_differences((const uint16_t *)stack->samples + (size_t)page * n, n, differences);
            print_bytes(to, differences, 2 * n);
        }
        free(differences);
    }
    if (stack->objects)
        print_stored(to, stack->objects, sizeof *stack->objects,
                     stack->n_pixels * sizeof *stack->objects);
}

/* Prints the data for the next factor that may fit, if they are compressed by so much. */
static void put_next(struct stack_page *of, const char *stack, double compressed,
                     struct printed *to, struct error *err)
{
    find_size(of, compressed);
    FREE_ALL(of->samples, of->objects, of->rows.samples);
    of->samples = of->objects = NULL;
    of->rows.samples = NULL;
    if (read_samples(of, err) && read_objects(of, err))
        put_stack(of, stack, to, err);
}

/* Packs the data with the least factor that keeps to the budget. */
static void put_smallest(struct stack_page *of, const char *stack, struct printed *data,
                         struct error *err)
{
    do {
        struct printed bytes = {.text = NULL};
        free(printed_end(data));
        *data = (struct printed){.text = NULL};
        put_next(of, stack, most_compressed, &bytes, err);
        char *text = printed_take(&bytes, err);
        put_packed(data, "stack", text, text ? bytes.length : 0, err);
        free(text);
    } while (err->status == EXIT_AGREED && (double)data->length > of->budget_bytes &&
             of->n_pixels > 1);
}

bool stack_page_write(struct stack_page *of, struct options *options, bool alone, struct error *err)
{
    const char *stack = options->operand;
    struct page_parts parts = {.kind = has_live_pages() ? PAGE_LIVE : PAGE_STACK};
    struct printed bytes = {.text = NULL};
    if (!cube_open(stack, &of->rows.cube, err))
        return false;
    if (!alone) {
        put_smallest(of, stack, &parts.data, err); /* page_write ends them, also after a failure */
        return page_write(&parts, options, &of->bytes, err);
    }
    put_next(of, stack, 1, &bytes, err);
    of->bytes = bytes.length;
    return printed_write(&bytes, options->output, &options->outputs, err);
}

void stack_page_free(struct stack_page *of)
{
    FREE_ALL(of->samples, of->objects);
    rows_close(&of->rows);
}
