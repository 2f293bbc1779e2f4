/* SPDX-License-Identifier: MIT */
/* An interactive viewer in one HTML file: the page of data/viewer.html with what it works from.
 *
 * Local illumination is linear: whatever the lights are, a pixel's radiance is its weights, which
 * depend on geometry only, times spectra of light and material. The weights go into the page as
 * planes of 16 bits, the spectra as JSON; products are made there. What fluoresces depends on
 * wavelengths outside the picture: that is computed here for every illuminant on offer. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "spectral.h"

enum { LARGEST_SAMPLE = 65535 };

/* ---- the picture as planes ---- */

/* Planes of a value a pixel: constant term, then diffuse and specular of each light, then what
 * spectral textures show at their own wavelengths. Finishes share them: a pixel has one finish. */
struct planes {
    size_t n_pixels;
    int n_weights, n_pages; /* planes of weights, and of textures */
    uint16_t *surface;      /* from 1; 0: background */
    float *values;          /* [plane][pixel] */
    double *place[2];       /* in a spectral texture, in texels; NULL: there is none */
};

static void planes_free(struct planes *planes)
{
    free(planes->surface);
    free(planes->values);
    free(planes->place[0]);
    free(planes->place[1]);
    *planes = (struct planes){0};
}

static bool planes_allocate(const struct plan *plan, struct planes *out, struct error *err)
{
    *out = (struct planes){.n_pixels = (size_t)plan->scene->width * (size_t)plan->scene->height,
                           .n_weights = 1 + 2 * plan->n_lights};
    for (int i = 0; i < plan->n_textures; i++)
        if (plan->textures[i].spectral && plan->textures[i].image.n_pages > out->n_pages)
            out->n_pages = plan->textures[i].image.n_pages;
    out->surface = calloc(out->n_pixels, sizeof *out->surface);
    out->values =
        calloc(out->n_pixels * (size_t)(out->n_weights + out->n_pages), sizeof *out->values);
    for (int i = 0; i < 2 && out->n_pages > 0; i++)
        out->place[i] = calloc(out->n_pixels, sizeof *out->place[i]);
    return (out->surface && out->values &&
            (out->n_pages == 0 || (out->place[0] && out->place[1]))) ||
           error_memory(err);
}

static int plane_of(const struct term *term)
{
    return term->kind == TERM_CONSTANT ? 0 : 1 + 2 * term->light + (term->kind == TERM_SPECULAR);
}

/* A pixel `from` of a chunk is the picture's pixel `to`. */
static void put_pixel(const struct surface *surfaces, const struct chunk *chunk, size_t from,
                      struct planes *planes, size_t to)
{
    size_t stride = (size_t)chunk->rows.width * (size_t)chunk->rows.height;
    if (chunk->surface[from] < 0)
        return;
    const struct finish *finish = surfaces[chunk->surface[from]].finish;
    const double *weight = chunk->weights + from;
    planes->surface[to] = (uint16_t)(chunk->surface[from] + 1);
    for (int t = 0; t < finish->n_terms; t++, weight += stride)
        planes->values[(size_t)plane_of(&finish->terms[t]) * planes->n_pixels + to] =
            (float)*weight;
    for (int i = 0; i < 2 && finish->texture && finish->texture->spectral; i++, weight += stride)
        planes->place[i][to] = *weight;
}

static bool put_chunk(const struct plan *plan, const struct surface *surfaces,
                      const struct tile *tile, int index, struct planes *planes, struct error *err)
{
    struct chunk chunk = {.surface = NULL};
    bool done = chunk_rasterize(plan, surfaces, tile, index, &chunk, err);
    for (int y = 0; done && y < chunk.rows.height; y++)
        for (int x = 0; x < chunk.rows.width; x++)
            put_pixel(surfaces, &chunk, (size_t)y * (size_t)chunk.rows.width + (size_t)x, planes,
                      (size_t)(chunk.rows.y + y) * (size_t)plan->scene->width +
                          (size_t)(chunk.rows.x + x));
    chunk_free(&chunk);
    return done;
}

static bool put_tile(const struct plan *plan, const struct surface *surfaces,
                     const struct tile *tile, struct planes *planes, struct error *err)
{
    int n_chunks = (tile->height + CHUNK_ROWS - 1) / CHUNK_ROWS;
    bool failed = false;
#pragma omp parallel for schedule(dynamic) num_threads(plan->options.threads)
    for (int i = 0; i < n_chunks; i++) {
        struct error own = {.status = EXIT_AGREED};
        if (put_chunk(plan, surfaces, tile, i, planes, &own))
            continue;
#pragma omp critical
        {
            if (!failed)
                *err = own;
            failed = true;
        }
    }
    return !failed;
}

/* The values of one texture at its own wavelengths, where it is seen. */
static bool put_texture(const struct plan *plan, struct texture *texture, struct planes *planes,
                        struct error *err)
{
    for (int page = 0; page < texture->image.n_pages; page++) {
        float *plane = planes->values + (size_t)(planes->n_weights + page) * planes->n_pixels;
        if (!texture_load(texture, texture->image.wavelengths_nm + page, 1, err))
            return false;
        for (size_t i = 0; i < planes->n_pixels; i++) {
            int surface = planes->surface[i] - 1;
            struct texel_point at = {planes->place[0][i], planes->place[1][i], 0, 0};
            if (surface >= 0 && plan->finishes[plan->bodies[surface].finish].texture == texture)
                plane[i] = (float)texel_value(texture, 0, at, NULL);
        }
    }
    return true;
}

static bool put_picture(const struct plan *plan, const struct surface *surfaces,
                        struct planes *planes, struct error *err)
{
    int width = plan->scene->width, height = plan->scene->height;
    for (int y = 0; y < height; y += plan->tile_height)
        for (int x = 0; x < width; x += plan->tile_width) {
            struct tile tile = {x, y, width - x, height - y};
            if (tile.width > plan->tile_width)
                tile.width = plan->tile_width;
            if (tile.height > plan->tile_height)
                tile.height = plan->tile_height;
            if (!put_tile(plan, surfaces, &tile, planes, err))
                return false;
        }
    for (int i = 0; i < plan->n_textures; i++)
        if (plan->textures[i].spectral && !put_texture(plan, &plan->textures[i], planes, err))
            return false;
    return true;
}

static bool planes_rasterize(const struct plan *plan, struct planes *out, struct error *err)
{
    struct surface *surfaces = NULL;
    struct light_work work;
    if (plan->n_bodies > LARGEST_SAMPLE)
        return error_usage(err, "a page shows at most %d objects and parts; this scene has %d",
                           LARGEST_SAMPLE, plan->n_bodies);
    bool done = planes_allocate(plan, out, err) &&
                surfaces_light(plan, driver_of(NULL), &surfaces, &work, err) &&
                put_picture(plan, surfaces, out, err);
    surfaces_free(plan, surfaces);
    return done;
}

/* ---- planes as text ---- */

/* The value of sample 1: the largest is 65535. */
static double plane_scale(const struct planes *planes, int plane)
{
    const float *values = planes->values + (size_t)plane * planes->n_pixels;
    double largest = 0;
    for (size_t i = 0; i < planes->n_pixels; i++)
        if ((double)values[i] > largest)
            largest = (double)values[i];
    return largest / LARGEST_SAMPLE;
}

/* Differences between neighbours, which are small and alike, as bytes, all lower ones first. */
static void put_differences(const uint16_t *samples, size_t n, unsigned char *out)
{
    for (size_t i = 0; i < n; i++) {
        unsigned difference = samples[i] - (i > 0 ? (unsigned)samples[i - 1] : 0);
        out[i] = difference & 0xff;
        out[n + i] = difference >> 8 & 0xff;
    }
}

/* All planes, that of the surfaces first; allocated, NULL: no memory. */
static unsigned char *planes_bytes(const struct planes *planes, const double *scale, size_t *length)
{
    size_t n = planes->n_pixels, n_values = (size_t)(planes->n_weights + planes->n_pages);
    unsigned char *bytes = malloc(2 * n * (1 + n_values));
    uint16_t *samples = malloc(n * sizeof *samples);
    for (size_t plane = 0; bytes && samples && plane < n_values; plane++) {
        const float *values = planes->values + plane * n;
        for (size_t i = 0; i < n; i++)
            samples[i] =
                (uint16_t)(scale[plane] > 0 ? fmax(0, floor((double)values[i] / scale[plane] + 0.5))
                                            : 0);
        put_differences(samples, n, bytes + 2 * n * (1 + plane));
    }
    if (bytes)
        put_differences(planes->surface, n, bytes);
    if (!samples) {
        free(bytes);
        bytes = NULL;
    }
    free(samples);
    *length = 2 * n * (1 + n_values);
    return bytes;
}

/* RFC 4648; out has room for 4 characters for every 3 bytes begun, and is not terminated. */
static void base64(const unsigned char *bytes, size_t length, char *out)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < length; i += 3) {
        size_t left = length - i;
        unsigned group = (unsigned)bytes[i] << 16 | (left > 1 ? (unsigned)bytes[i + 1] << 8 : 0) |
                         (left > 2 ? bytes[i + 2] : 0);
        for (size_t j = 0; j < 4; j++)
            *out++ = j <= left ? digits[group >> (18 - 6 * j) & 63] : '=';
    }
}

/* Deflated (RFC 1950), in base64; allocated, NULL: no memory. */
static char *planes_text(const struct planes *planes, const double *scale, size_t *length)
{
    size_t raw_length;
    unsigned char *raw = planes_bytes(planes, scale, &raw_length);
    uLongf packed_length = compressBound((uLong)raw_length);
    unsigned char *packed = raw ? malloc(packed_length) : NULL;
    char *out = NULL;
    if (packed && compress2(packed, &packed_length, raw, (uLong)raw_length, 9) == Z_OK)
        out = malloc((packed_length + 2) / 3 * 4);
    if (out)
        base64(packed, packed_length, out);
    *length = (packed_length + 2) / 3 * 4;
    free(raw);
    free(packed);
    return out;
}

/* ---- what the page computes with, as JSON ---- */

struct page {
    const struct plan *plan;
    struct json json;
    struct spectrum *illuminants; /* on offer; the first ones are owned */
    int n_illuminants, n_owned;
    double *row; /* n_bands; owned */
    struct viewer_result *result;
};

static void json_numbers(struct json *json, const char *key, const double *values, int n)
{
    json_open(json, key, '[');
    for (int i = 0; i < n; i++)
        json_number(json, NULL, values[i]);
    json_close(json, ']');
}

static void json_matrix(struct json *json, const char *key, double matrix[3][3])
{
    json_open(json, key, '[');
    for (int i = 0; i < 3; i++)
        json_numbers(json, NULL, matrix[i], 3);
    json_close(json, ']');
}

/* At the picture's wavelengths; null for a spectrum that is absent. */
static void put_spectrum(struct page *page, const char *key, const struct spectrum *spectrum,
                         enum spectrum_ends ends)
{
    const struct plan *plan = page->plan;
    for (int i = 0; i < plan->n_bands; i++)
        page->row[i] = spectrum_at(spectrum, plan->scene->wavelengths_nm[i], ends);
    if (spectrum->kind == SPECTRUM_NONE)
        json_string(&page->json, key, NULL);
    else
        json_numbers(&page->json, key, page->row, plan->n_bands);
}

/* ---- illuminants ---- */

/* The name of a built-in table as the command line has it; false for another file. */
static bool table_name(const struct builtin_file *file, char *out, size_t capacity)
{
    static const char folder[] = "tables/";
    const char *name = file->name + strlen(folder);
    if (strncmp(file->name, folder, strlen(folder)) != 0)
        return false;
    snprintf(out, capacity, "%.*s", (int)strcspn(name, "."), name);
    return true;
}

static bool same_illuminant(const struct spectrum *a, const struct spectrum *b)
{
    size_t size = (size_t)a->count * sizeof *a->value;
    return strcmp(a->name, b->name) == 0 && a->kind == b->kind && a->count == b->count &&
           (size == 0 || (memcmp(a->value, b->value, size) == 0 &&
                          memcmp(a->wavelength_nm, b->wavelength_nm, size) == 0));
}

/* The number of an illuminant, which is added if it is new; -1 after an error. */
static int find_illuminant(struct page *page, const struct spectrum *spectrum, struct error *err)
{
    for (int i = 0; i < page->n_illuminants; i++)
        if (same_illuminant(&page->illuminants[i], spectrum))
            return i;
    struct spectrum *more = array_more(page->illuminants, page->n_illuminants, sizeof *more, err);
    if (!more)
        return -1;
    page->illuminants = more;
    more[page->n_illuminants] = *spectrum;
    return page->n_illuminants++;
}

static bool add_builtin(struct page *page, const char *name, struct error *err)
{
    struct word word = {.start = name, .length = strlen(name)};
    struct spectrum spectrum;
    if (!spectrum_read(&word, 0, HUGE_VAL, &spectrum, err))
        return false;
    if (find_illuminant(page, &spectrum, err) < 0) {
        spectrum_free(&spectrum);
        return false;
    }
    page->n_owned = page->n_illuminants;
    return true;
}

/* Equal energy, the built-in ones, and what the scene has. */
static bool find_illuminants(struct page *page, struct error *err)
{
    const struct scene *scene = page->plan->scene;
    char name[256];
    if (!add_builtin(page, "1", err))
        return false;
    for (size_t i = 0; i < builtin_file_count; i++)
        if (table_name(&builtin_files[i], name, sizeof name) &&
            !table_is_detector(&builtin_files[i]) && !add_builtin(page, name, err))
            return false;
    for (int i = 0; i < scene->n_ambients; i++)
        if (find_illuminant(page, &scene->ambients[i].spectrum, err) < 0)
            return false;
    for (int i = 0; i < scene->n_lights; i++)
        if (find_illuminant(page, &scene->lights[i].spectrum, err) < 0)
            return false;
    return true;
}

static void put_illuminants(struct page *page)
{
    json_open(&page->json, "illuminants", '[');
    for (int i = 0; i < page->n_illuminants; i++) {
        json_open(&page->json, NULL, '{');
        json_string(&page->json, "name", page->illuminants[i].name);
        put_spectrum(page, "radiance", &page->illuminants[i], SPECTRUM_ZERO);
        json_close(&page->json, '}');
    }
    json_close(&page->json, ']');
}

/* As the scene has it. */
static bool put_light(struct page *page, const struct spectrum *spectrum, double intensity,
                      struct error *err)
{
    int illuminant = find_illuminant(page, spectrum, err);
    if (illuminant < 0)
        return false;
    json_open(&page->json, NULL, '{');
    json_count(&page->json, "illuminant", (uint64_t)illuminant);
    json_number(&page->json, "intensity", intensity);
    json_close(&page->json, '}');
    return true;
}

/* A scene without ambient light has one that is off. */
static bool put_lights(struct page *page, struct error *err)
{
    const struct scene *scene = page->plan->scene;
    bool done = true;
    json_open(&page->json, "ambients", '[');
    for (int i = 0; done && i < scene->n_ambients; i++)
        done = put_light(page, &scene->ambients[i].spectrum, scene->ambients[i].intensity, err);
    if (scene->n_ambients == 0)
        done = put_light(page, &page->illuminants[0], 0, err);
    json_close(&page->json, ']');
    json_open(&page->json, "lights", '[');
    for (int i = 0; done && i < scene->n_lights; i++)
        done = put_light(page, &scene->lights[i].spectrum, scene->lights[i].intensity, err);
    json_close(&page->json, ']');
    return done;
}

/* ---- surfaces ---- */

/* What each illuminant makes a finish give out. */
static bool put_luminescence(struct page *page, const struct finish *finish, struct error *err)
{
    const struct material *material = finish->material;
    bool fluoresces = material->excitation.kind != SPECTRUM_NONE || material->donaldson;
    if (!fluoresces) {
        json_string(&page->json, "luminescence", NULL);
        return true;
    }
    json_open(&page->json, "luminescence", '[');
    for (int i = 0; i < page->n_illuminants; i++) {
        if (!finish_luminescence(page->plan, finish, &page->illuminants[i], page->row, err))
            return false;
        json_numbers(&page->json, NULL, page->row, page->plan->n_bands);
    }
    json_close(&page->json, ']');
    return true;
}

static bool put_finish(struct page *page, const struct finish *finish, struct error *err)
{
    static const struct spectrum plastic = {
        .kind = SPECTRUM_CONSTANT, .parameter = {1, 0}, .factor = 1};
    static const struct spectrum none = {.kind = SPECTRUM_NONE};
    const struct material *material = finish->material;
    const struct spectrum *specular =
        material->specular.kind != SPECTRUM_NONE ? &material->specular : &plastic;
    struct json *json = &page->json;
    json_open(json, NULL, '{');
    put_spectrum(page, "diffuse", &material->diffuse, SPECTRUM_HOLD);
    put_spectrum(page, "specular", material->gloss > 0 ? specular : &none, SPECTRUM_HOLD);
    put_spectrum(page, "glow", &material->glow, SPECTRUM_ZERO);
    put_spectrum(page, "excitation", &material->excitation, SPECTRUM_ZERO);
    put_spectrum(page, "emission", &material->emission, SPECTRUM_ZERO);
    if (finish->texture && finish->texture->spectral)
        json_numbers(json, "texture", finish->texture->image.wavelengths_nm,
                     finish->texture->image.n_pages);
    else
        json_string(json, "texture", NULL);
    bool done = put_luminescence(page, finish, err);
    json_close(json, '}');
    return done;
}

static bool put_surfaces(struct page *page, struct error *err)
{
    const struct plan *plan = page->plan;
    struct json *json = &page->json;
    json_open(json, "finishes", '[');
    for (int i = 0; i < plan->n_finishes; i++)
        if (!put_finish(page, &plan->finishes[i], err))
            return false;
    json_close(json, ']');
    json_open(json, "objects", '[');
    for (int i = 0; i < plan->n_bodies; i++) {
        json_open(json, NULL, '{');
        json_string(json, "name", object_name(plan, i));
        json_string(json, "shape", shape_name(plan->bodies[i].object->shape.kind));
        json_count(json, "finish", (uint64_t)plan->bodies[i].finish);
        json_close(json, '}');
    }
    json_close(json, ']');
    return true;
}

/* ---- detectors, adaptations and displays ---- */

static bool put_detector(struct page *page, const char *name, struct error *err)
{
    const struct plan *plan = page->plan;
    const double *nm = plan->scene->wavelengths_nm;
    struct detector detector = {.name = NULL};
    struct json *json = &page->json;
    double lost[3], *weights = malloc(3 * (size_t)plan->n_bands * sizeof *weights);
    bool done = (weights || error_memory(err)) && detector_read(name, &detector, err);
    if (done) {
        detector_weights(&detector, nm, plan->n_bands, weights);
        detector_lost(&detector, nm, plan->n_bands, lost);
        json_open(json, NULL, '{');
        json_string(json, "name", name);
        json_truth(json, "observer", detector.observer);
        json_open(json, "weights", '[');
        for (int i = 0; i < 3; i++)
            json_numbers(json, NULL, weights + (size_t)i * (size_t)plan->n_bands, plan->n_bands);
        json_close(json, ']');
        json_numbers(json, "lost", lost, 3);
        json_close(json, '}');
        page->result->n_detectors++;
    }
    detector_free(&detector);
    free(weights);
    return done;
}

static bool put_detectors(struct page *page, struct error *err)
{
    char name[256];
    json_open(&page->json, "detectors", '[');
    for (size_t i = 0; i < builtin_file_count; i++)
        if (table_name(&builtin_files[i], name, sizeof name) &&
            table_is_detector(&builtin_files[i]) && !put_detector(page, name, err))
            return false;
    json_close(&page->json, ']');
    return true;
}

/* The cone responses in which each kind adapts, and the white to which a complete one leads. */
static void put_adaptations(struct json *json)
{
    json_numbers(json, "display_white", display_white, 3);
    json_open(json, "adaptations", '[');
    for (int i = ADAPTATION_NONE; i <= ADAPTATION_CAT16; i++) {
        enum adaptation_kind kind = (enum adaptation_kind)i;
        double cones[3][3], inverse[3][3];
        json_open(json, NULL, '{');
        json_string(json, "name", adaptation_name(kind));
        json_truth(json, "incomplete", kind == ADAPTATION_FAIRCHILD);
        if (kind != ADAPTATION_NONE) {
            adaptation_cones(kind, cones);
            colour_inverse(cones, inverse);
            json_matrix(json, "cones", cones);
            json_matrix(json, "inverse", inverse);
        }
        json_close(json, '}');
    }
    json_close(json, ']');
}

/* The least linear value that is shown as this 8-bit code. */
static double code_step(enum display_kind kind, int channel, int code)
{
    double below = 0, at = display_largest(kind, channel);
    for (double middle = at / 2; middle > below && middle < at; middle = below + (at - below) / 2)
        if (display_encode(kind, channel, middle) * 255 + 0.5 >= code)
            at = middle;
        else
            below = middle;
    return at;
}

/* A tone curve is what its 255 steps are. */
static void put_displays(struct json *json)
{
    json_open(json, "displays", '[');
    for (int i = DISPLAY_SRGB; i <= DISPLAY_MONITOR; i++) {
        enum display_kind kind = (enum display_kind)i;
        double matrix[3][3], largest[3], steps[255];
        display_matrix(kind, matrix);
        for (int c = 0; c < 3; c++)
            largest[c] = display_largest(kind, c);
        json_open(json, NULL, '{');
        json_string(json, "name", display_name(kind));
        json_matrix(json, "matrix", matrix);
        json_numbers(json, "largest", largest, 3);
        json_open(json, "steps", '[');
        for (int c = 0; c < 3; c++) {
            for (int code = 1; code <= 255; code++)
                steps[code - 1] = code_step(kind, c, code);
            json_numbers(json, NULL, steps, 255);
        }
        json_close(json, ']');
        json_close(json, '}');
    }
    json_close(json, ']');
}

/* ---- the page ---- */

static bool put_json(struct page *page, const struct planes *planes, const double *scale,
                     struct error *err)
{
    const struct scene *scene = page->plan->scene;
    struct json *json = &page->json;
    json_open(json, NULL, '{');
    json_string(json, "program", PROGRAM);
    json_string(json, "scene", scene->path);
    json_count(json, "width", (uint64_t)scene->width);
    json_count(json, "height", (uint64_t)scene->height);
    json_numbers(json, "wavelengths", scene->wavelengths_nm, scene->n_wavelengths);
    if (!find_illuminants(page, err) || !put_lights(page, err) || !put_surfaces(page, err) ||
        !put_detectors(page, err))
        return false;
    put_illuminants(page);
    put_adaptations(json);
    put_displays(json);
    json_numbers(json, "weight_scales", scale, planes->n_weights);
    json_numbers(json, "texture_scales", scale + planes->n_weights, planes->n_pages);
    json_close(json, '}');
    return true;
}

/* JSON inside of HTML: a "<", which only strings have, might end the script that holds it. */
static void write_json(const char *text, FILE *to)
{
    for (; *text; text++)
        if (*text == '<')
            fputs("\\u003c", to);
        else
            putc(*text, to);
}

/* The page's source with the data in the place of its mark. */
static bool write_page(const char *json, const char *planes, size_t planes_length, const char *path,
                       size_t *bytes, struct error *err)
{
    static const char mark[] = "<!-- scene -->\n";
    const struct place nowhere = {NULL, 0, 0};
    char *source = NULL, *text = NULL;
    size_t length;
    if (!file_read("builtin:viewer.html", nowhere, &source, &length, err))
        return false;
    const char *at = strstr(source, mark);
    FILE *to = open_memstream(&text, bytes);
    assert(at);
    if (to) {
        fwrite(source, 1, (size_t)(at - source), to);
        fputs("<script id=\"scene\" type=\"application/json\">", to);
        write_json(json, to);
        fputs("</script>\n<script id=\"planes\" type=\"text/plain\">", to);
        fwrite(planes, 1, planes_length, to);
        fputs("</script>\n", to);
        fputs(at + strlen(mark), to);
    }
    bool whole = to && !ferror(to);
    whole = (!to || fclose(to) == 0) && whole;
    bool done = whole ? file_write(path, text, *bytes, err) : error_memory(err);
    free(source);
    free(text);
    return done;
}

static void page_free(struct page *page)
{
    for (int i = 0; i < page->n_owned; i++)
        spectrum_free(&page->illuminants[i]);
    free(page->illuminants);
    free(page->row);
    free(page->json.text);
}

static bool make_page(struct page *page, const struct planes *planes, const char *path,
                      struct error *err)
{
    int n_planes = planes->n_weights + planes->n_pages;
    double *scale = calloc((size_t)n_planes, sizeof *scale);
    char *json = NULL, *text = NULL;
    size_t length;
    bool done = scale != NULL || error_memory(err);
    for (int i = 0; done && i < n_planes; i++)
        scale[i] = plane_scale(planes, i);
    if (done && put_json(page, planes, scale, err)) {
        json = json_end(&page->json);
        text = planes_text(planes, scale, &length);
        done = json && text ? write_page(json, text, length, path, &page->result->bytes, err)
                            : error_memory(err);
    } else
        done = false;
    free(scale);
    free(json);
    free(text);
    return done;
}

bool viewer_write(const struct plan *plan, const char *path, struct viewer_result *out,
                  struct error *err)
{
    struct page page = {.plan = plan, .result = out};
    struct planes planes = {.n_pixels = 0};
    *out = (struct viewer_result){.n_objects = plan->n_bodies, .n_lights = plan->n_lights};
    page.row = calloc((size_t)plan->n_bands, sizeof *page.row);
    bool done = (page.row || error_memory(err)) && planes_rasterize(plan, &planes, err) &&
                make_page(&page, &planes, path, err);
    out->n_illuminants = page.n_illuminants;
    page_free(&page);
    planes_free(&planes);
    return done;
}
