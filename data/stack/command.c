/* SPDX-License-Identifier: MIT */
/* spectral info: how a stack was made. */
#include <stdio.h>
#include <unistd.h>

#include "data/invocation/invocation.h"
#include "data/stack/stack.h"
#include "data/text/text.h"

bool record_open(const char *path, struct image *image, struct record *out, struct error *err)
{
    const struct place nowhere = {0};
    return image_open(path, nowhere, image, err) && record_read(image, out, err);
}

static void print_scene(const struct record *record, struct printed *to)
{
    print_fact(to, "program", record->program);
    print_fact(to, "scene", record->scene);
    print_fact(to, "scene SHA-256", record->scene_sha256);
    for (int i = 0; i < record->files.n; i++)
        print_fact(to, "file", record->files.text[i]);
    for (int i = 0; i < record->n_options; i++)
        print_fact(to, "option", record->options[i]);
    print_fact(to, "renderer", record->renderer);
    for (int i = 0; i < record->lights.n; i++)
        print_fact(to, "light", record->lights.text[i]);
    for (int i = 0; i < record->ambients.n; i++)
        print_fact(to, "ambient light", record->ambients.text[i]);
    if (record->sampling) {
        print_fact(to, "sampling", record->sampling);
        print_fact(to, record->response.n > 0 ? "sampled only for" : "sampled for",
                   record->sampling_detector);
    }
}

static void print_pages(const struct image *image, const struct record *record, struct printed *to)
{
    if (record->map_bytes > 0)
        print(to, "objects           %d\n", record->objects.n);
    print(to, "pages             %d of %d x %d pixels\n", image->n_pages, image->width,
          image->height);
    if (image->wavelengths_nm)
        print(to, "wavelengths       %.10g to %.10g nm\n", image->wavelengths_nm[0],
              image->wavelengths_nm[image->n_pages - 1]);
    if (record->rows.n > 0)
        print(to, "part              of a picture, from row %.0f of %.0f\n", record->rows.value[0],
              record->rows.value[2]);
    if (record->components)
        print(to, "components        of %.10g to %.10g nm\n", record->range_nm.value[0] + 0.5,
              record->range_nm.value[1] - 0.5);
    print_fact(to, "full scale", record->full_scale);
    print_fact(to, "scale", record->scale);
    print_fact(to, "verdict", image->verdict);
}

static void json_texts(struct json *json, const char *key, const char *const *texts, int n)
{
    json_open(json, key, '[');
    for (int i = 0; i < n; i++)
        json_string(json, NULL, texts[i]);
    json_close(json, ']');
}

static void info_json(const struct image *image, const struct record *record, struct json *json)
{
    json_begin(json);
    json_string(json, "program", record->program);
    json_string(json, "scene", record->scene);
    json_string(json, "scene_sha256", record->scene_sha256);
    json_texts(json, "files", record->files.text, record->files.n);
    json_texts(json, "options", (const char *const *)record->options, record->n_options);
    json_string(json, "renderer", record->renderer);
    json_texts(json, "lights", record->lights.text, record->lights.n);
    json_texts(json, "ambient_lights", record->ambients.text, record->ambients.n);
    json_string(json, "sampling", record->sampling);
    json_string(json, "sampled_for", record->sampling_detector);
    json_texts(json, "objects", record->objects.text, record->objects.n);
    json_count(json, "width", (uint64_t)image->width);
    json_count(json, "height", (uint64_t)image->height);
    json_count(json, "pages", (uint64_t)image->n_pages);
    json_numbers(json, "wavelengths_nm", image->wavelengths_nm, image->n_pages);
    json_numbers(json, "white", record->white.n > 0 ? record->white.value : NULL, record->white.n);
    json_number(json, "radiance_of_full_count", image->scale);
    json_string(json, "verdict", image->verdict);
}

bool command_info(struct options *options, struct error *err)
{
    const struct place nowhere = {0};
    struct json json;
    struct printed table = {.text = NULL};
    struct image image = {.path = NULL};
    struct record record = {.text = NULL};
    if (!options->operand)
        return error_usage(err, "info takes a STACK; see spectral info --help");
    bool done = scene_refuse(options->operand, err) &&
                image_open(options->operand, nowhere, &image, err) &&
                record_read(&image, &record, err);
    if (done && options->json) {
        info_json(&image, &record, &json);
        done = json_write(&json, options->json, &options->outputs, err);
    } else if (done) {
        print_scene(&record, &table);
        print_pages(&image, &record, &table);
    }
    done = printed_show(&table, STDOUT_FILENO, err) && done;
    record_free(&record);
    image_close(&image);
    return done;
}
