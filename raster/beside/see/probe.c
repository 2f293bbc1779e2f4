/* SPDX-License-Identifier: MIT */
/* Reads the spectrum of a pixel or a region of a stack, computes its colour, and prints both. For a
 * scene inspect.c finds the spectrum. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/images/images.h"
#include "raster/beside/see/inside.h"

/* ---- any probe ---- */

bool probe_begin(struct probe *probe, const char *source, const struct image *image,
                 struct error *err)
{
    const int n = probe->n = image->n_pages;
    if (!string_copy(source, &probe->source, err))
        return false;
    if (probe->x > image->width - probe->width || probe->y > image->height - probe->height)
        return error_usage(
            err,
            "%s: the picture has %d x %d pixels; the region of %d x %d pixels from %d,%d "
            "reaches beyond it",
            source, image->width, image->height, probe->width, probe->height, probe->x, probe->y);
    if (!MAKE_ARRAY(probe->wavelengths_nm, n, err, "a spectrum of %d bands", n) ||
        !MAKE_ARRAY(probe->mean, n, err, "a spectrum of %d bands", n) ||
        !MAKE_ARRAY(probe->spread, n, err, "a spectrum of %d bands", n))
        return false;
    memcpy(probe->wavelengths_nm, image->wavelengths_nm, (size_t)n * sizeof(double));
    return true;
}

bool probe_colour(struct probe *probe, const struct cube *cube, struct error *err)
{
    const struct white_request white = {probe->white, false};
    struct sight sight = {.weights = NULL};
    const bool done = sight_make(cube, probe->observer, &white, &sight, err);
    if (done) {
        detector_response(sight.weights, probe->mean, probe->n, probe->xyz);
        memcpy(probe->of_white, sight.white, sizeof probe->of_white);
        probe->has_white = sight.has_white;
    }
    sight_free(&sight);
    return done;
}

void moments_add(struct moments *moments, const float *values, size_t n)
{
    if (moments->n == 0 && n > 0)
        moments->first = (double)values[0];
    for (size_t i = 0; i < n; i++) {
        const double difference = (double)values[i] - moments->first;
        moments->sum += difference;
        moments->sum_of_squares += difference * difference;
    }
    moments->n += n;
}

void moments_end(const struct moments *moments, double *mean, double *spread)
{
    const double n = (double)moments->n, off = moments->sum / n;
    *mean = moments->first + off;
    *spread = sqrt(fmax(0, moments->sum_of_squares / n - off * off));
}

/* ---- a stack ---- */

/* Rows are read in chunks of so many samples, at least a row. Large chunks are better because a
 * compressed page is unpacked as a whole. */
enum { CHUNK_SAMPLES = 1 << 22 };

static bool read_band(struct cube *cube, int page, int rows, float *samples, struct probe *probe,
                      struct error *err)
{
    const int width = cube->image.width, end = probe->y + probe->height;
    struct moments moments = {0};
    for (int y = probe->y; y < end; y += rows) {
        const int n = end - y < rows ? end - y : rows;
        if (!image_read(&cube->image, page, y, n, samples, err))
            return false;
        for (int row = 0; row < n; row++)
            moments_add(&moments, samples + (size_t)row * (size_t)width + probe->x,
                        (size_t)probe->width);
    }
    moments_end(&moments, &probe->mean[page], &probe->spread[page]);
    return true;
}

static bool read_bands(struct cube *cube, struct probe *probe, struct error *err)
{
    const int width = cube->image.width, fitting = CHUNK_SAMPLES / width;
    const int rows = fitting < 1 ? 1 : fitting < probe->height ? fitting : probe->height;
    float *samples;
    bool done = MAKE_ARRAY(samples, (size_t)rows * (size_t)width, err, "rows of %s", probe->source);
    for (int page = 0; done && page < probe->n; page++)
        done = read_band(cube, page, rows, samples, probe, err);
    free(samples);
    return done;
}

/* Finds the number of the object that all pixels of the region show; -1: they show several, or the
 * stack has no map of objects. `row` is room for one row of the region. */
static bool find_number(const struct cube *cube, const struct probe *probe, int *row, int *number,
                        struct error *err)
{
    for (int y = 0; y < probe->height && (y == 0 || *number >= 0); y++) {
        if (!cube_objects(cube, probe->x, probe->y + y, probe->width, row, err))
            return false;
        *number = y == 0 ? row[0] : *number;
        for (int x = 0; x < probe->width; x++)
            *number = row[x] == *number ? *number : -1;
    }
    return true;
}

static bool find_object(const struct cube *cube, struct probe *probe, struct error *err)
{
    int number = -1, *row;
    bool done = MAKE_ARRAY(row, probe->width, err, "a row of %s", probe->source) &&
                find_number(cube, probe, row, &number, err);
    free(row);
    if (!done || number < 0)
        return done;
    return string_copy(number > 0 ? cube->record.objects.text[number - 1] : "background",
                       &probe->object, err);
}

bool probe_stack(struct probe *probe, const char *path, struct error *err)
{
    struct cube cube;
    if (!cube_open(path, &cube, err))
        return false;
    const bool done = cube_needs_radiance(&cube, "a probe", err) &&
                      probe_begin(probe, path, &cube.image, err) && read_bands(&cube, probe, err) &&
                      find_object(&cube, probe, err) && probe_colour(probe, &cube, err);
    cube_close(&cube);
    return done;
}

/* ---- out ---- */

static const char unit[] = "W sr-1 m-2 nm-1, relative";

static void print_colour(const struct probe *probe, struct printed *to)
{
    double xy[2], lab[3], luv[3];
    const double *xyz = probe->xyz, *white = probe->of_white;
    chromaticity(xyz, xy);
    print_fact(to, "observer", probe->observer);
    print(to, "XYZ               %.4f %.4f %.4f\n", xyz[0], xyz[1], xyz[2]);
    print(to, "xy                %.5f %.5f\n", xy[0], xy[1]);
    if (!probe->has_white) {
        print(to, "Lab               none: the white is unknown; --white SPECTRUM sets it\n");
        return;
    }
    cielab(xyz, white, lab);
    cieluv(xyz, white, luv);
    print(to, "Lab               %.4f %.4f %.4f\n", lab[0], lab[1], lab[2]);
    print(to, "Luv               %.4f %.4f %.4f\n", luv[0], luv[1], luv[2]);
    print(to, "white XYZ         %.4f %.4f %.4f\n", white[0], white[1], white[2]);
}

/* Writes the pixel or region in words, e.g. "pixel 3,4". */
static void region_text(const struct probe *probe, char *out, size_t capacity)
{
    if (probe->width == 1 && probe->height == 1)
        snprintf(out, capacity, "pixel %d,%d", probe->x, probe->y);
    else
        snprintf(out, capacity, "%d x %d pixels from %d,%d", probe->width, probe->height, probe->x,
                 probe->y);
}

/* The first columns of the table. Those of the curves follow. */
enum { WAVELENGTH, MEAN, SPREAD, CURVES };

static double column_value(const struct probe *probe, int column, int i)
{
    return column == WAVELENGTH ? probe->wavelengths_nm[i]
           : column == MEAN     ? probe->mean[i]
           : column == SPREAD   ? probe->spread[i]
                                : probe->curves[column - CURVES].values[i];
}

static void column_name(const struct probe *probe, int column, char *out, size_t capacity)
{
    static const char *const names[] = {"wavelength", "radiance", "standard deviation of radiance"};
    const struct probe_curve *curve = column < CURVES ? NULL : &probe->curves[column - CURVES];
    const char *of = column == WAVELENGTH ? "nm" : curve && curve->relative ? "1" : unit;
    snprintf(out, capacity, "%s (%s)", curve ? curve->name : names[column], of);
}

void probe_print(const struct probe *probe, struct printed *to)
{
    char text[160], number[32];
    print_fact(to, "source", probe->source);
    region_text(probe, text, sizeof text);
    print(to, "region            %s\n", text);
    print_fact(to, "object", probe->object ? probe->object : "unknown, or several");
    print_colour(probe, to);
    for (int column = 0; column < CURVES + probe->n_curves; column++) {
        column_name(probe, column, text, sizeof text);
        snprintf(number, sizeof number, "column %d", column + 1);
        print_fact(to, number, text);
    }
    for (int i = 0; i < probe->n; i++) {
        print(to, "%-17.10g", probe->wavelengths_nm[i]);
        for (int column = MEAN; column < CURVES + probe->n_curves; column++)
            print(to, " %-12.6g", column_value(probe, column, i));
        print_text(to, "\n");
    }
}

void probe_print_csv(const struct probe *probe, struct printed *to)
{
    char name[160];
    const int last = CURVES + probe->n_curves - 1;
    for (int column = 0; column <= last; column++) {
        column_name(probe, column, name, sizeof name);
        print_text(to, "\"");
        csv_text(name, to);
        print_text(to, column < last ? "\"," : "\"\n");
    }
    for (int i = 0; i < probe->n; i++)
        for (int column = 0; column <= last; column++) {
            const double value = column_value(probe, column, i);
            print(to, "%.*g%c", exact_digits(value), value, column < last ? ',' : '\n');
        }
}

void probe_json(const struct probe *probe, struct json *json)
{
    double lab[3];
    json_begin(json);
    json_string(json, "source", probe->source);
    json_count(json, "x", (uint64_t)probe->x);
    json_count(json, "y", (uint64_t)probe->y);
    json_count(json, "width", (uint64_t)probe->width);
    json_count(json, "height", (uint64_t)probe->height);
    json_string(json, "object", probe->object);
    json_string(json, "observer", probe->observer);
    json_numbers(json, "XYZ", probe->xyz, 3);
    json_numbers(json, "white_XYZ", probe->has_white ? probe->of_white : NULL, 3);
    if (probe->has_white)
        cielab(probe->xyz, probe->of_white, lab);
    json_numbers(json, "Lab", probe->has_white ? lab : NULL, 3);
    json_numbers(json, "wavelengths_nm", probe->wavelengths_nm, probe->n);
    json_numbers(json, "radiance", probe->mean, probe->n);
    json_numbers(json, "standard_deviation", probe->spread, probe->n);
    json_open(json, "curves", '[');
    for (int i = 0; i < probe->n_curves; i++) {
        json_open(json, NULL, '{');
        json_string(json, "name", probe->curves[i].name);
        json_numbers(json, "values", probe->curves[i].values, probe->n);
        json_close(json, '}');
    }
    json_close(json, ']');
}

void probe_svg(const struct probe *probe, struct printed *to)
{
    struct chart_line lines[1 + MAX_PROBE_CURVES];
    char region[96], title[512];
    const bool single = probe->width == 1 && probe->height == 1;
    bool relative = false;
    lines[0] = (struct chart_line){single ? "radiance" : "radiance ± standard deviation",
                                   probe->n,
                                   probe->wavelengths_nm,
                                   probe->mean,
                                   single ? NULL : probe->spread,
                                   false};
    for (int c = 0; c < probe->n_curves; c++) {
        const struct probe_curve *curve = &probe->curves[c];
        relative = relative || curve->relative;
        lines[1 + c] = (struct chart_line){curve->name,   probe->n, probe->wavelengths_nm,
                                           curve->values, NULL,     curve->relative};
    }
    region_text(probe, region, sizeof region);
    snprintf(title, sizeof title, "%s%s%s: %s", probe->object ? probe->object : "",
             probe->object ? ", " : "", region, probe->source);
    const struct chart chart = {.title = title,
                                .x_label = "wavelength (nm)",
                                .y_label = "radiance (W sr⁻¹ m⁻² nm⁻¹, relative)",
                                .right_label =
                                    relative ? "reflectance, excitation, emission" : NULL,
                                .lines = lines,
                                .n_lines = 1 + probe->n_curves,
                                .wavelengths = true};
    chart_svg(&chart, to);
}

void probe_free(struct probe *probe)
{
    for (int c = 0; c < probe->n_curves; c++)
        free(probe->curves[c].values);
    FREE_ALL(probe->source, probe->wavelengths_nm, probe->mean, probe->spread, probe->object);
}
