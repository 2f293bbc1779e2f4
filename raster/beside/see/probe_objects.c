/* SPDX-License-Identifier: MIT */
/* The values of pixels of a stack: of a region, of one object, or of each object. They are mean and
 * standard deviation in each band; of objects also in XYZ and CIELAB, and in the channels of a
 * camera of any number of channels. Pixels at an edge of an object, where a neighbour shows another
 * one, are left out unless they are wanted. */
#include "raster/beside/see/inside.h"

/* Rows are read in chunks of so many samples, 64 MiB, or of those that are wanted. Large chunks are
 * better because a compressed page is unpacked as a whole. */
static const uint64_t chunk_samples = (uint64_t)1 << 24;

enum { LABEL = 512 }; /* bytes of an object's label; a longer name is cut */

/* An object's values. */
struct values {
    char label[LABEL];
    uint64_t pixels;
    double *mean, *spread; /* of each column; owned */
    double xyz[3], lab[3];
};
/* Pixels that are measured. */
struct measured {
    struct stack_rows rows;
    struct rectangle at;     /* their rows and columns */
    struct probe *region;    /* all of these are one region; NULL: objects are measured */
    int first, n_objects;    /* the objects, from 1; a region counts as one */
    bool edges;              /* of objects count, too */
    struct sight colours;    /* of objects, to an observer */
    struct sight camera;     /* measures objects, too; no channels: there is none */
    int n_columns;           /* bands, then channels */
    double *pixel;           /* its columns; owned */
    struct moments *moments; /* [object][column]; owned */
    struct values values;    /* of the object at hand */
    int *map[3];             /* of the row before, the row at hand and the row behind; owned */
};

/* ---- pixels ---- */

/* Returns whether all neighbours of a pixel show its object. Beyond the picture they do. */
static bool is_inside(const struct measured *of, int x)
{
    const int number = of->map[1][x], width = of->rows.cube.image.width;
    for (int row = 0; row < 3; row++)
        for (int column = x > 0 ? x - 1 : 0; column <= x + 1 && column < width; column++)
            if (of->map[row][column] != number)
                return false;
    return true;
}

/* Returns where a pixel of the row at hand is added up; NULL: nowhere. */
static struct moments *moments_at(const struct measured *of, int x)
{
    const int object = of->map[1][x] - of->first;
    if (of->region) {
        note_shown(of->region, of->map[1][x]);
        return of->moments;
    }
    return object >= 0 && object < of->n_objects && (of->edges || is_inside(of, x))
               ? of->moments + (size_t)object * (size_t)of->n_columns
               : NULL;
}

/* Adds the pixel of the chunk. */
static void add_pixel(struct measured *of, struct moments *moments, const float *samples)
{
    const int n_bands = of->rows.cube.image.n_pages;
    for (int band = 0; band < n_bands; band++)
        of->pixel[band] = (double)samples[(size_t)band * of->rows.stride];
    for (int i = n_bands; i < of->n_columns; i++) {
        const double *weights = of->camera.weights + (size_t)(i - n_bands) * (size_t)n_bands;
        of->pixel[i] = 0;
        for (int band = 0; band < n_bands; band++)
            of->pixel[i] += weights[band] * of->pixel[band];
    }
    for (int column = 0; column < of->n_columns; column++)
        moments_add(&moments[column], of->pixel[column]);
}

/* Reads the rows of the map around row y. The first and the last row repeat beyond the border. */
static bool read_map(struct measured *of, int y, struct error *err)
{
    const struct image *image = &of->rows.cube.image;
    for (int i = 0; i < 3; i++) {
        const int row = y + i - 1 < 0 ? 0 : y + i - 1 >= image->height ? y : y + i - 1;
        if (!cube_objects(&of->rows.cube, 0, row, image->width, of->map[i], err))
            return false;
    }
    return true;
}

static bool measure_rows(struct measured *of, struct error *err)
{
    const int width = of->rows.cube.image.width;
    for (int row = 0; row < of->rows.n; row++) {
        if (!read_map(of, of->rows.first + row, err))
            return false;
        for (int x = of->at.x; x < of->at.x + of->at.width; x++) {
            struct moments *moments = moments_at(of, x);
            if (moments)
                add_pixel(of, moments, of->rows.samples + (size_t)row * (size_t)width + x);
        }
    }
    return true;
}

static bool measure(struct measured *of, struct error *err)
{
    const struct image *image = &of->rows.cube.image;
    const uint64_t n = (uint64_t)of->at.height * (uint64_t)image->width * (uint64_t)image->n_pages;
    for (int i = 0; i < 3; i++)
        if (!MAKE_ARRAY(of->map[i], (size_t)image->width, err, "a row of %s", image->path))
            return false;
    if (!MAKE_ARRAY(of->moments, (size_t)of->n_objects * (size_t)of->n_columns, err,
                    "the values of %d objects", of->n_objects) ||
        !MAKE_ARRAY(of->pixel, of->n_columns, err, "%d columns", of->n_columns) ||
        !rows_allocate(&of->rows, n < chunk_samples ? n : chunk_samples, err))
        return false;
    of->rows.end = of->at.y + of->at.height;
    for (int y = of->at.y; y < of->rows.end; y += of->rows.n)
        if (!rows_read(&of->rows, y, err) || !measure_rows(of, err))
            return false;
    return true;
}

/* ---- before ---- */

static bool open_stack(struct measured *of, const char *path, struct error *err)
{
    return cube_or_raw_open(path, &of->rows.cube, err) &&
           cube_needs_radiance(&of->rows.cube, "a probe", err);
}

/* Makes all pixels those that are measured, by their objects. */
static bool open_map(struct measured *of, struct error *err)
{
    const struct image *image = &of->rows.cube.image;
    of->at = (struct rectangle){0, 0, image->width, image->height};
    return of->rows.cube.record.map_bytes > 0 ||
           error_usage(err, "%s has no map of objects; expected a stack of spectral render",
                       image->path);
}

static void measured_free(struct measured *of)
{
    rows_close(&of->rows);
    sight_free(&of->colours);
    sight_free(&of->camera);
    FREE_ALL(of->pixel, of->moments, of->values.mean, of->values.spread, of->map[0], of->map[1],
             of->map[2]);
}

/* ---- a region, or one object ---- */

/* Labels an object, from 0: its name. Objects of one name, as the two halves of a metameric pair,
 * are NAME#1, NAME#2, ... */
static void label_object(const struct texts *objects, int object, char out[LABEL])
{
    const char *name = objects->text[object];
    int n = 0, number = 0;
    for (int i = 0; i < objects->n; i++) {
        n += strcmp(objects->text[i], name) == 0;
        number = i == object ? n : number;
    }
    snprintf(out, LABEL, n > 1 ? "%.*s#%d" : "%.*s", LABEL - 16, name, number);
}

/* Returns the number of the object that has this label, or number, from 1; 0: there is none. */
static int find_named(const struct texts *objects, const char *wanted, struct error *err)
{
    struct error ignored = {.status = EXIT_AGREED};
    const struct word word = {.start = wanted, .length = strlen(wanted)};
    char label[LABEL];
    long number;
    for (int i = 0; i < objects->n; i++) {
        if (strncmp(wanted, objects->text[i], strlen(objects->text[i])) != 0)
            continue;
        label_object(objects, i, label);
        if (strcmp(label, wanted) == 0)
            return i + 1;
    }
    if (word_integer(&word, "it", 1, objects->n, &number, &ignored))
        return (int)number;
    error_usage(err,
                "there is no object '%.100s', or not one alone; --objects lists them, those of one "
                "name as NAME#1, NAME#2, ...",
                wanted);
    return 0;
}

/* Chooses the pixels of a probe, which has begun. */
static bool choose_pixels(struct measured *of, struct probe *probe, struct error *err)
{
    of->n_objects = 1;
    of->n_columns = probe->n;
    if (!probe->wanted) {
        of->region = probe;
        of->at = probe->at;
        return true;
    }
    if (!open_map(of, err))
        return false;
    of->first = find_named(&of->rows.cube.record.objects, probe->wanted, err);
    note_shown(probe, of->first);
    return of->first > 0;
}

bool probe_stack(struct probe *probe, struct error *err)
{
    struct measured of = {.edges = false};
    const struct cube *cube = &of.rows.cube;
    const char *path = probe->options->operand;
    bool done = open_stack(&of, path, err) && probe_begin(probe, cube, err) &&
                choose_pixels(&of, probe, err) && measure(&of, err);
    if (done && of.moments->n == 0)
        done =
            error_usage(err, "%s: no pixel shows '%.100s' but at its edges", path, probe->wanted);
    if (done && probe->shown >= 0)
        done = string_copy(probe->shown > 0 ? cube->record.objects.text[probe->shown - 1]
                                            : "background",
                           &probe->object, err);
    done = done && probe_end(probe, cube, of.moments, err);
    measured_free(&of);
    return done;
}

/* ---- out ---- */

/* Finds the values of an object, from 0. */
static void find_values(struct measured *of, int object)
{
    struct values *out = &of->values;
    const struct moments *moments = of->moments + (size_t)object * (size_t)of->n_columns;
    const int n_bands = of->rows.cube.image.n_pages;
    label_object(&of->rows.cube.record.objects, object, out->label);
    out->pixels = moments[0].n;
    for (int i = 0; i < of->n_columns; i++)
        moments_end(&moments[i], &out->mean[i], &out->spread[i]);
    detector_response(of->colours.weights, out->mean, n_bands, out->xyz);
    if (of->colours.has_white)
        cielab(out->xyz, of->colours.white, out->lab);
}

/* Names a band or a channel. */
static void column_label(const struct measured *of, int column, char out[96])
{
    const struct image *image = &of->rows.cube.image;
    if (column < image->n_pages)
        snprintf(out, 96, "%.10g nm", image->wavelengths_nm[column]);
    else
        snprintf(out, 96, "%s", of->camera.detector.channel[column - image->n_pages]);
}

static void print_csv_head(const struct measured *of, struct printed *to)
{
    char label[96];
    print_text(to, "\"object\",\"pixels\",\"X\",\"Y\",\"Z\",\"L\",\"a\",\"b\"");
    for (int part = 0; part < 2; part++)
        for (int i = 0; i < of->n_columns; i++) {
            column_label(of, i, label);
            print_text(to, ",\"");
            csv_text(label, to);
            print_text(to, part == 0 ? "\"" : " standard deviation\"");
        }
    print_text(to, "\n");
}

static void print_numbers(const double *values, int n, bool known, struct printed *to)
{
    for (int i = 0; i < n; i++)
        if (known)
            print(to, ",%.*g", exact_digits(values[i]), values[i]);
        else
            print_text(to, ",");
}

static void print_csv(const struct measured *of, const struct values *values, struct printed *to)
{
    print_text(to, "\"");
    csv_text(values->label, to);
    print(to, "\",%llu", (unsigned long long)values->pixels);
    print_numbers(values->xyz, 3, values->pixels > 0, to);
    print_numbers(values->lab, 3, values->pixels > 0 && of->colours.has_white, to);
    print_numbers(values->mean, of->n_columns, values->pixels > 0, to);
    print_numbers(values->spread, of->n_columns, values->pixels > 0, to);
    print_text(to, "\n");
}

static void print_line(const struct measured *of, const struct values *values, struct printed *to)
{
    const int n_bands = of->rows.cube.image.n_pages;
    const bool seen = values->pixels > 0;
    print_printable(to, values->label);
    print(to, "\n  pixels          %llu\n", (unsigned long long)values->pixels);
    if (seen)
        print(to, "  XYZ             %.4f %.4f %.4f%s\n", values->xyz[0], values->xyz[1],
              values->xyz[2], of->rows.cube.record.unit ? ", Y in cd/m2" : "");
    if (seen && of->colours.has_white)
        print(to, "  Lab             %.4f %.4f %.4f\n", values->lab[0], values->lab[1],
              values->lab[2]);
    for (int i = n_bands; seen && i < of->n_columns; i++)
        print(to, "  %-15s %.6g, standard deviation %.3g\n",
              of->camera.detector.channel[i - n_bands], values->mean[i], values->spread[i]);
}

static void put_json(const struct measured *of, const struct values *values, struct json *json)
{
    const int n_bands = of->rows.cube.image.n_pages;
    const bool seen = values->pixels > 0;
    json_open(json, NULL, '{');
    json_string(json, "name", values->label);
    json_count(json, "pixels", values->pixels);
    json_numbers(json, "XYZ", seen ? values->xyz : NULL, 3);
    json_numbers(json, "Lab", seen && of->colours.has_white ? values->lab : NULL, 3);
    json_numbers(json, "radiance", seen ? values->mean : NULL, n_bands);
    json_numbers(json, "standard_deviation", seen ? values->spread : NULL, n_bands);
    json_numbers(json, "channels", seen ? values->mean + n_bands : NULL, of->camera.detector.n);
    json_numbers(json, "channels_standard_deviation", seen ? values->spread + n_bands : NULL,
                 of->camera.detector.n);
    json_close(json, '}');
}

/* Reports all objects, as JSON and as text or a table. */
static void put_objects(struct measured *of, bool csv, struct json *json, struct printed *to)
{
    json_begin(json);
    json_string(json, "source", of->rows.cube.image.path);
    json_string(json, "unit", of->rows.cube.unit);
    json_numbers(json, "wavelengths_nm", of->rows.cube.image.wavelengths_nm,
                 of->rows.cube.image.n_pages);
    json_strings(json, "channel_names", (const char *const *)of->camera.detector.channel,
                 of->camera.detector.n);
    json_open(json, "objects", '[');
    if (csv)
        print_csv_head(of, to);
    for (int object = 0; object < of->n_objects; object++) {
        find_values(of, object);
        put_json(of, &of->values, json);
        (csv ? print_csv : print_line)(of, &of->values, to);
    }
    json_close(json, ']');
}

/* Measures all objects of a stack, whose sights are found. */
static bool measure_objects(struct measured *of, struct error *err)
{
    of->first = 1;
    of->n_objects = of->rows.cube.record.objects.n;
    of->n_columns = of->rows.cube.image.n_pages + of->camera.detector.n;
    return MAKE_ARRAY(of->values.mean, of->n_columns, err, "the values of an object") &&
           MAKE_ARRAY(of->values.spread, of->n_columns, err, "the values of an object") &&
           measure(of, err);
}

bool probe_objects(struct options *options, bool csv, bool edges, struct error *err)
{
    struct measured of = {.edges = edges};
    struct printed printed = {.text = NULL};
    struct json json;
    bool done = open_stack(&of, options->operand, err) && open_map(&of, err) &&
                sights_make(&of.rows.cube, options, &of.camera, &of.colours, err) &&
                measure_objects(&of, err);
    if (done) {
        put_objects(&of, csv, &json, &printed);
        done = report_write(options, &json, &printed, err);
    }
    measured_free(&of);
    return done;
}

/* ---- the objects of two stacks ---- */

static bool see_objects(const char *path, const struct seeing *by, struct measured *of,
                        struct error *err)
{
    return open_stack(of, path, err) && open_map(of, err) &&
           sight_make(&of->rows.cube, SIGHT_OF_OBSERVER, by, &of->colours, err) &&
           measure_objects(of, err);
}

/* Compares an object, beside the white of A. Refuses another one. */
static bool compare_object(const struct values *a, const struct values *b, const double white[3],
                           double *out, struct error *err)
{
    double lab[3];
    cielab(b->xyz, white, lab);
    *out = ciede2000_difference(a->lab, lab);
    return strcmp(a->label, b->label) == 0 ||
           error_usage(err, "the stacks show other objects: '%.100s' and '%.100s'", a->label,
                       b->label);
}

bool objects_compare(struct comparison *of, struct json *json, struct printed *to,
                     struct error *err)
{
    const struct seeing by = comparison_seeing(of, false), other = comparison_seeing(of, true);
    const char *const *stack = of->options->operands;
    struct measured a = {.edges = false}, b = a;
    bool done = MAKE_ARRAY(of->bins, N_BINS, err, "a distribution of differences") &&
                see_objects(stack[0], &by, &a, err) && see_objects(stack[1], &other, &b, err) &&
                check_units(&a.rows.cube, &b.rows.cube, err);
    if (done && a.n_objects != b.n_objects)
        done = error_usage(err, "%s has %d objects, %s %d", stack[0], a.n_objects, stack[1],
                           b.n_objects);
    json_open(json, "objects", '[');
    for (int i = 0; done && i < a.n_objects; i++) {
        double difference;
        find_values(&a, i);
        find_values(&b, i);
        done = compare_object(&a.values, &b.values, a.colours.white, &difference, err);
        if (!done || a.values.pixels == 0 || b.values.pixels == 0)
            continue;
        measure_add(&of->pixels[CIEDE2000], of->bins, difference, i, 0);
        of->n_pixels++;
        print(to, "%-17.6g ", difference);
        print_printable(to, a.values.label);
        print_text(to, "\n");
        json_open(json, NULL, '{');
        json_string(json, "name", a.values.label);
        json_number(json, "dE00", difference);
        json_close(json, '}');
    }
    json_close(json, ']');
    if (done) {
        measure_end(&of->pixels[CIEDE2000], of->bins, of->n_pixels);
        print_white(to, a.colours.white, true, by.white ? by.white : "recorded");
    }
    measured_free(&a);
    measured_free(&b);
    return done;
}

bool object_radiance(const char *path, const char *wanted, double *out, struct error *err)
{
    const struct options options = {.operand = path};
    struct probe probe = {.options = &options, .wanted = wanted};
    const bool done = probe_stack(&probe, err);
    if (done)
        memcpy(out, probe.columns[MEAN].values, (size_t)probe.n * sizeof *out);
    probe_free(&probe);
    return done;
}
