/* SPDX-License-Identifier: MIT */
/* spectral info: how a stack was made. */
#include <ctype.h>
#include <stdio.h>

#include "data/invocation/invocation.h"
#include "data/stack/stack.h"

bool record_open(const char *path, struct image *image, struct record *out, struct error *err)
{
    const struct place nowhere = {0};
    return image_open(path, nowhere, image, err) && record_read(image, out, err);
}

/* Prints one fact. A control character of a file could drive the terminal: it becomes '?'. */
static void print_fact(const char *name, const char *value)
{
    printf("%-17s ", name);
    for (; *value; value++)
        putchar(iscntrl((unsigned char)*value) ? '?' : *value);
    putchar('\n');
}

static void print_scene(const struct record *record)
{
    print_fact("program", record->program);
    print_fact("scene", record->scene);
    print_fact("scene SHA-256", record->scene_sha256);
    for (int i = 0; i < record->n_options; i++)
        print_fact("option", record->options[i]);
    print_fact("renderer", record->renderer);
    for (int i = 0; i < record->lights.n; i++)
        print_fact("light", record->lights.text[i]);
    for (int i = 0; i < record->ambients.n; i++)
        print_fact("ambient light", record->ambients.text[i]);
    if (record->sampling) {
        print_fact("sampling", record->sampling);
        print_fact(record->response.n > 0 ? "sampled only for" : "sampled for",
                   record->sampling_detector);
    }
}

static void print_pages(const struct image *image, const struct record *record)
{
    if (record->map_bytes > 0)
        printf("objects           %d\n", record->objects.n);
    printf("pages             %d of %d x %d pixels\n", image->n_pages, image->width, image->height);
    if (image->wavelengths_nm)
        printf("wavelengths       %.10g to %.10g nm\n", image->wavelengths_nm[0],
               image->wavelengths_nm[image->n_pages - 1]);
    if (record->components)
        printf("components        of %.10g to %.10g nm\n", record->range_nm.value[0] + 0.5,
               record->range_nm.value[1] - 0.5);
    print_fact("full scale", record->full_scale);
    print_fact("scale", record->scale);
    print_fact("verdict", image->verdict);
}

bool command_info(struct options *options, struct error *err)
{
    struct image image = {.path = NULL};
    struct record record = {.text = NULL};
    if (!options->operand)
        return error_usage(err, "info takes a STACK; try spectral --help");
    bool done =
        scene_refuse(options->operand, err) && record_open(options->operand, &image, &record, err);
    if (done) {
        print_scene(&record);
        print_pages(&image, &record);
    }
    record_free(&record);
    image_close(&image);
    return done;
}
