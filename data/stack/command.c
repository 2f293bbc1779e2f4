/* SPDX-License-Identifier: MIT */
/* spectral info: how a stack was made, as JSON or in words. */
#include "data/stack/inside.h"

/* Puts what words have beside the facts. */
static void print_meaning(const struct record *record, struct printed *to)
{
    if (record->rows.n > 0)
        print(to, "part              of a picture, from row %.0f of %.0f\n", record->rows.value[0],
              record->rows.value[2]);
    if (record->response.n > 0)
        print_fact(to, "sampled only for", record->sampling_detector);
    if (record->components)
        print(to, "components        of %.10g to %.10g nm\n", record->range_nm.value[0] + 0.5,
              record->range_nm.value[1] - 0.5);
    print_fact(to, "full scale", record->full_scale);
    print_fact(to, "scale", record->scale);
}

static void put_facts(struct json *json, const struct image *image, const struct record *record)
{
    json_string(json, "program", record->program);
    json_string(json, "scene", record->scene);
    json_string(json, "scene_sha256", record->scene_sha256);
    json_strings(json, "files", record->files.text, record->files.n);
    json_strings(json, "options", record->options.text, record->options.n);
    json_string(json, "renderer", record->renderer);
    json_string(json, "mipmaps", record->mipmaps);
    json_strings(json, "lights", record->lights.text, record->lights.n);
    json_strings(json, "ambient_lights", record->ambients.text, record->ambients.n);
    json_string(json, "sampling", record->sampling);
    json_string(json, "sampled_for", record->sampling_detector);
    if (json->words && record->map_bytes > 0)
        json_count(json, "objects", (uint64_t)record->objects.n);
    else if (!json->words)
        json_strings(json, "objects", record->objects.text, record->objects.n);
    json_count(json, "width", (uint64_t)image->width);
    json_count(json, "height", (uint64_t)image->height);
    json_count(json, "pages", (uint64_t)image->n_pages);
    json_numbers(json, "wavelengths_nm", image->wavelengths_nm, image->n_pages);
    if (json->words)
        print_meaning(record, &json->printed);
    else {
        json_string(json, "unit",
                    record->components ? NULL
                    : record->unit     ? record->unit
                                       : RELATIVE_UNIT);
        json_numbers(json, "white", record->white.n > 0 ? record->white.value : NULL,
                     record->white.n);
    }
    json_number(json, "radiance_of_full_count", image->scale);
    json_string(json, "verdict", image->verdict[0] ? image->verdict : NULL);
}

/* Puts the facts of a stack of another program, or of a picture or raw values: no record, but a
 * description. */
static void put_foreign(struct json *json, const struct image *image, struct error *err)
{
    char *own = description_text(image->description, err);
    const char *description = own ? own : image->description[0] != '<' ? image->description : "";
    json_string(json, "record", json->words ? "none: no render of spectral 0.2.0 or later" : NULL);
    json_count(json, "width", (uint64_t)image->width);
    json_count(json, "height", (uint64_t)image->height);
    json_count(json, "pages", (uint64_t)image->n_pages);
    json_numbers(json, "wavelengths_nm", image->wavelengths_nm, image->n_pages);
    if (json->words && !image->wavelengths_nm)
        json_string(json, "wavelengths", image->no_wavelengths);
    if (!json->words)
        json_string(json, "description", description);
    else if (description[0] != '\0')
        print(&json->printed, "description:\n%s\n", description);
    free(own);
}

static bool run_info(struct options *options, struct error *err)
{
    struct json json;
    struct image image = {.path = NULL};
    struct record record = {.text = NULL};
    bool done = scene_refuse(options->operand, err) &&
                image_open(options->operand, NOWHERE, tags_read, &image, err);
    const bool foreign = done && !record_is_there(&image);
    done = done && (foreign || record_read(&image, &record, err));
    (options->json ? json_begin : words_begin)(&json);
    if (done && foreign)
        put_foreign(&json, &image, err);
    else if (done)
        put_facts(&json, &image, &record);
    done = json_write(&json, options->json, &options->outputs, err);
    record_free(&record);
    image_close(&image);
    return done;
}

const struct command info_command = {
    .name = "info",
    .operands = "STACK",
    .summary = "print how a stack was made",
    .example = "info colorchecker.tif",
    .first = "prints how a stack was made",
    .run = run_info,
    .shared = {&json_option},
    .n_operands = 1,
};
