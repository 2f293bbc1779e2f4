/* SPDX-License-Identifier: MIT */
/* A record reads back from the file's XML unchanged, with any bytes in its names. A forged record
 * does no harm. */

#include "data/base/inside.h"
#include "data/images/images.h"
#include "data/spectra/spectra.h"
#include "data/stack/inside.h"
#include "data/text/text.h"
#include "spectral.h"
#include "test.h"

/* Bytes that have a meaning in XML, lines or UTF-8, and one that is not UTF-8. */
static char strange[] = "--light=1=a <b>&amp;\"c\"\n%41 \t\x7f\xff\xc3\xa4: d";

/* Prints the record of a scene and of three objects. */
static char *make_record(const struct recorded *made, struct error *err)
{
    struct printed lines = {.text = NULL};
    record_put_scene(&lines, made, err);
    record_put(&lines, "object", "");
    record_put(&lines, "object", strange);
    record_put(&lines, "object", "object_map: 1 1");
    return printed_take(&lines, err);
}

/* Writes a stack of one pixel with this record; the image stays open. */
static bool written(const char *path, const struct recorded *made, struct image *image,
                    struct error *err)
{
    const struct place nowhere = {0};
    const uint16_t count = 1;
    char *text = make_record(made, err);
    struct stack_writer writer;
    struct stack_options options = {.width = 1,
                                    .height = 1,
                                    .n_wavelengths = 1,
                                    .wavelengths_nm = (const double[]){500},
                                    .full_scale = 2.5,
                                    .scene = "full_scale: 50 of a name",
                                    .provenance = text};
    files_read_forget();
    bool done = text && stack_open(&writer, path, &options, err) &&
                pages_write(&writer.pages, &(struct page_rectangle){0, 0, 0, 1, 1}, &count, err) &&
                stack_finish(&writer, "a verdict", err) &&
                output_pass(&writer.pages.output, NULL, err) &&
                image_open(path, nowhere, tags_read, image, err);
    free(text);
    return done;
}

static void check_round_trip(const char *path)
{
    struct spectrum third = {.kind = SPECTRUM_CONSTANT, .parameter = {1.0 / 3}, .factor = 1};
    struct light lights[] = {{.spectrum = third, .intensity = 0.1},
                             {.spectrum = third, .intensity = 0.2}};
    struct light ambient = {.spectrum = third};
    lights[0].spectrum.name = (char[]){"d65"};
    lights[1].spectrum.name = strange;
    ambient.spectrum.name = (char[]){"0.5"};
    const struct scene scene = {.path = strange,
                                .sha256 = "01ab",
                                .wavelengths_nm = (double[]){500},
                                .n_wavelengths = 1,
                                .lights = lights,
                                .n_lights = 2,
                                .ambients = &ambient,
                                .n_ambients = 1};
    const struct options options = {.recorded = {(char[]){"--a"}, strange}, .n_recorded = 2};
    const struct recorded made = {.scene = &scene, .renderer = "<none>", .options = &options};
    const struct spectral_pages pages = scene_pages(&scene);
    double white;
    struct record read;
    struct image image;
    struct error err = {0};
    if (!CHECK(written(path, &made, &image, &err) && record_read(&image, &read, &err),
               "a record is written and read %s", err.text))
        return;
    CHECK_TEXT(read.program, PROGRAM, "the program");
    CHECK_TEXT(read.scene, strange, "a scene of strange bytes");
    CHECK_TEXT(read.scene_sha256, "01ab", "its SHA-256");
    CHECK_TEXT(read.renderer, made.renderer, "the renderer");
    CHECK_TEXT(read.full_scale, "2.5", "the full scale");
    CHECK(read.options.n == 2, "all options: %d", read.options.n);
    CHECK_TEXT(read.options.text[1], strange, "the last option");
    CHECK(read.lights.n == 2 && read.ambients.n == 1 && read.objects.n == 3,
          "lights, ambient lights and objects");
    CHECK_TEXT(read.lights.text[0], "d65*0.1", "the first light");
    CHECK(strncmp(read.lights.text[1], strange, strlen(strange)) == 0 &&
              strcmp(read.lights.text[1] + strlen(strange), "*0.2") == 0,
          "the second light: %s", read.lights.text[1]);
    CHECK_TEXT(read.ambients.text[0], "0.5*0", "the ambient light");
    CHECK_TEXT(read.objects.text[0], "", "an object without a name");
    CHECK_TEXT(read.objects.text[1], strange, "an object with a strange name");
    CHECK_TEXT(read.objects.text[2], "object_map: 1 1",
               "an object whose name looks like a line of the record");
    CHECK(read.map_bytes == 0, "that name is not read as a line of the record");
    CHECK(record_illumination(&read) == 0.1 + 0.2 && /* takes 17 digits */
              record_illumination(&read) == scene_white(&scene, &pages, &white),
          "the illumination, to the bit");
    CHECK(read.white.n == 1 && read.white.value[0] == white, "the white, to the bit");
    CHECK_TEXT(image.verdict, "a verdict", "the verdict, without blanks");
    CHECK_NEAR(image.scale, 2.5, 0, "no name is read as the scale");
    record_free(&read);
    record_free(&read);
    image_close(&image);
}

static void check_refused(const char *description, const char *what)
{
    const bool is_there = strstr(description, "scene_sha256: ") != NULL;
    struct image image = {.path = (char[]){"forged.tif"}, .n_pages = 1};
    double at_450[] = {450};
    image.wavelengths_nm = strstr(description, "segments") != NULL ? at_450 : NULL;
    struct record record;
    struct error err = {0};
    char *copy = strdup(description);
    image.description = copy;
    CHECK(!record_read(&image, &record, &err) && err.status == EXIT_INPUT &&
              strstr(err.text, is_there ? "forged.tif: its record of how it was made is damaged"
                                        : "forged.tif: has no record of how it was made") &&
              !record.text,
          "%s is refused", what);
    free(copy);
}

#define WHOLE                                                                                      \
    "<Description>full_scale: 1\nscale: x\nprogram: p\nscene: s\nscene_sha256: 0\nrenderer: r\n"
#define SAMPLED "sampling: gauss:1,xyz\nsampling_detector: cie1931\n"
#define RESPONSE "response_range: 379.5 730.5\nresponse: 1 -2 3\n"

static void check_refusals(void)
{
    static const char *const lines[] = {
        "white: 1",
        "white: 1 2",
        "white: 1 x\nillumination: 1",
        "white: 1  2",
        "illumination: inf",
        "object_map: 1",
        "object_map: 1 3",
        "object_map: 1 1 1",
        "object_map: -1 1",
        "object_map:  1",
        "object_map: 9223372036854775808 1",
        "object_map: 1e3 1",
        "white: 1\nwhite: 2\nillumination: 1",
        "sampling: gauss:1",
        "sampling_detector: cie1931",
        "segments: 400 500",
        SAMPLED "segments: 400",
        SAMPLED "segments: 500 400",
        SAMPLED "segments: 400 400",
        SAMPLED "segments: 400 2e6",
        SAMPLED "segments: 400 500\nsegments: 400 500",
        SAMPLED "segments: 400 nan",
        "response_range: 1 2\nresponse: 1 2 3",
        SAMPLED "response: 1 2 3",
        SAMPLED "response_range: 1 2\nresponse: 1 2",
        SAMPLED "response_range: 1\nresponse: 1 2 3",
        SAMPLED "response_range: 2 1\nresponse: 1 2 3",
        SAMPLED "segments: 1 2\nresponse_range: 1 2\nresponse: 1 2 3",
        SAMPLED "components: yes",
        SAMPLED RESPONSE "components: no",
        SAMPLED RESPONSE "white_response: 1 2 3",
        SAMPLED RESPONSE "illumination: 1\nwhite_response: 1 2",
        SAMPLED "illumination: 1\nwhite_response: 1 2 3",
        SAMPLED RESPONSE "components: yes\nillumination: 1\nwhite: 1"};
    char text[4096];
    struct image image = {.path = (char[]){"whole.tif"}, .description = text, .n_pages = 1};
    struct record record;
    struct error err = {0};
    strcpy(text, WHOLE "no key\noption: --a\n</Description>");
    CHECK(record_read(&image, &record, &err) && record.options.n == 1,
          "other lines are left alone %s", err.text);
    record_free(&record);
    strcpy(text, WHOLE "object_map: 4294967297 2\n</Description>");
    CHECK(record_read(&image, &record, &err) && record.map_offset == UINT64_C(4294967297) &&
              record.map_bytes == 2,
          "an object map beyond 4 GiB %s", err.text);
    record_free(&record);
    strcpy(text, WHOLE SAMPLED RESPONSE "components: yes\n</Description>");
    CHECK(record_read(&image, &record, &err) && record.components,
          "a complete sampling is refused %s", err.text);
    record_free(&record);
    image.wavelengths_nm = (double[]){500};
    CHECK(!record_read(&image, &record, &err), "components at wavelengths are refused");
    check_refused("", "nothing");
    check_refused(WHOLE, "a description without end");
    check_refused(strchr(WHOLE "</Description>", '>') + 1, "a description without beginning");
    check_refused("<Description>program: p\nscene: s\n</Description>", "half a record");
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        snprintf(text, sizeof text, WHOLE "%s\n</Description>", lines[i]);
        check_refused(text, "a malformed line");
    }
}

/* Returns whether a record of these segments is accepted for pages at 1, 2, ... nm. */
static bool is_taken(int n, const char *segments, int repeated)
{
    static double nm[100];
    char text[8192];
    struct image image = {.path = (char[]){"forged.tif"}, .description = text, .n_pages = n};
    struct record record;
    struct error err = {0};
    int at = snprintf(text, sizeof text, WHOLE SAMPLED "segments: %s", segments);
    for (int i = 0; i < n; i++)
        nm[i] = i + 1;
    for (int i = 0; i < repeated; i++)
        at += snprintf(text + at, sizeof text - (size_t)at, "%s0 100", i > 0 ? " " : "");
    snprintf(text + at, sizeof text - (size_t)at, "\n</Description>");
    image.wavelengths_nm = nm;
    const bool taken = record_read(&image, &record, &err);
    record_free(&record);
    return taken;
}

static void check_segments(void)
{
    CHECK(is_taken(3, "0 2.5 0 2.5 2.5 4", 0), "segments that follow each other are accepted");
    CHECK(is_taken(3, "0 1.5 1.7 2.5 2.5 1000001", 0),
          "gaps between segments are accepted, up to 1e6 nm");
    CHECK(!is_taken(3, "0 1.5 1.7 2.5 2.5 1000002", 0), "segments beyond 1e6 nm are refused");
    CHECK(!is_taken(3, "0 1.5 1.2 2.5 2.5 4", 0), "segments that overlap are refused");
    CHECK(!is_taken(3, "0 1.5 0 2.5 2.5 4", 0), "segments with the same beginning are refused");
    CHECK(!is_taken(3, "0 1.5 0 2.5 0 1.5", 0), "segments that return are refused");
    CHECK(!is_taken(3, "2 4 0.5 1 0 0.4", 0), "segments that decrease are refused");
    CHECK(!is_taken(3, "1.1 1.5 1.5 2.5 2.5 4", 0) && !is_taken(3, "0 1.5 1.5 2.5 2.5 2.9", 0),
          "a page outside its own segment is refused");
    CHECK(is_taken(LARGEST_QUADRATURE, "", LARGEST_QUADRATURE) &&
              !is_taken(LARGEST_QUADRATURE + 1, "", LARGEST_QUADRATURE + 1),
          "more pages in a segment than a quadrature has nodes are refused");
}

int main(void)
{
    test_enter();
    check_round_trip("record.tif");
    check_refusals();
    check_segments();
    unlink("record.tif");
    return test_end();
}
