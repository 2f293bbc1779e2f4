/* SPDX-License-Identifier: MIT */
/* Writes the ENVI header of a stack. The pages of a stack lie raw and without gaps, so that ENVI,
 * SPy, GDAL and MATLAB can map the TIFF file itself: the header says where its samples begin. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/invocation/invocation.h"
#include "data/method/method.h"
#include "data/stack/stack.h"
#include "data/text/text.h"

/* ---- the header ---- */

bool names_make(const struct cube *cube, page_name *text, const char **names, struct error *err)
{
    const struct image *image = &cube->image;
    struct sampling sampling = {.detector = NULL};
    if (cube->components &&
        !sampling_read(image->path, cube->record.sampling, &sampling.method, err))
        return false;
    for (int page = 0; page < image->n_pages; page++) {
        names[page] = text[page];
        if (cube->components)
            sampling_label(&sampling, page, text[page]);
        else
            snprintf(text[page], sizeof text[page], PAGE_LABEL, image->wavelengths_nm[page]);
    }
    return true;
}

/* Returns whether each page is lit by 1 all in all: then a radiance of 1 is a reflectance of 1. */
static bool is_lit_by_one(const struct record *record)
{
    bool one = record->white.n > 0 && record_illumination(record) == 1;
    for (int i = 0; i < record->white.n; i++)
        one = one && record->white.value[i] == 1;
    return one;
}

/* Returns the description, allocated; NULL: no memory. */
static char *describe(const struct cube *cube)
{
    const struct record *record = &cube->record;
    const char *slash = strrchr(cube->image.path, '/');
    struct printed printed = {.text = NULL};
    if (record->program)
        print(&printed, "%s, rendered by %s, %s; %s, full_scale = %s; %s", record->scene,
              record->renderer, record->program, record->scale, record->full_scale,
              cube->image.verdict);
    else
        print_text(&printed, slash ? slash + 1 : cube->image.path);
    return printed_end(&printed);
}

static char *header_of(const struct cube *cube, struct envi_sidecar *sidecar, struct error *err)
{
    const struct image *image = &cube->image;
    const size_t n = (size_t)image->n_pages;
    page_name *text = calloc(n, sizeof *text);
    const char **names = calloc(n, sizeof *names);
    double *fwhm_nm = calloc(n, sizeof *fwhm_nm);
    char *description = describe(cube), *header = NULL;
    if (!text || !names || !fwhm_nm || !description)
        error_memory(err);
    else if (names_make(cube, text, names, err)) {
        for (int page = 0; page < image->n_pages; page++)
            fwhm_nm[page] = page_width_nm(image->wavelengths_nm, image->n_pages, page);
        sidecar->description = description;
        sidecar->names = names;
        sidecar->wavelengths_nm = cube->components ? NULL : image->wavelengths_nm;
        sidecar->fwhm_nm = cube->components || n == 1 ? NULL : fwhm_nm;
        header = envi_header_text(sidecar);
        if (!header)
            error_memory(err);
    }
    free(description);
    free(fwhm_nm);
    free(names);
    free(text);
    return header;
}

/* Returns the header of the stack in a file, allocated; NULL: it cannot be described. */
static char *header_make(const char *stack, struct error *err)
{
    struct envi_sidecar sidecar = {.gain = 1};
    struct cube cube;
    char *header = NULL;
    if (!cube_open(stack, &cube, err))
        return NULL;
    if (image_describe(&cube.image, &sidecar.layout, err)) {
        if (sidecar.layout.type != ENVI_FLOAT)
            sidecar.gain = cube.image.scale / (sidecar.layout.type == ENVI_UINT8 ? 255 : 65535);
        sidecar.is_reflectance = is_lit_by_one(&cube.record);
        header = header_of(&cube, &sidecar, err);
    }
    cube_close(&cube);
    return header;
}

/* ---- files ---- */

char *sidecar_name(const char *stack)
{
    const size_t capacity = strlen(stack) + sizeof ".hdr";
    char *name = malloc(capacity);
    if (name)
        snprintf(name, capacity, "%s.hdr", stack);
    return name;
}

bool sidecar_can_open(const char *stack, struct error *err)
{
    if (!stack || output_is_stream(stack))
        return error_usage(err,
                           "--envi writes a header beside the stack; expected -o with the name of a"
                           " file, not %s",
                           stack ? stack : "/dev/null");
    char *name = sidecar_name(stack);
    const bool can = name ? output_can_open(name, err) : error_memory(err);
    free(name);
    return can;
}

bool stack_commit_envi(struct stack_writer *writer, const char *path, struct outputs *outputs,
                       struct error *err)
{
    struct output output = {.path = NULL};
    char *name = sidecar_name(path);
    char *header = name ? header_make(writer->pages.output.temporary, err) : NULL;
    bool done = name || error_memory(err);
    done = done && header && output_open(&output, name, err);
    errno = 0;
    if (done && !write_all(output.descriptor, header, strlen(header)))
        done = error_system(err, "cannot write %s", name);
    done = done && stack_commit(writer, outputs, err) && output_pass(&output, outputs, err);
    output_discard(&output);
    free(header);
    free(name);
    return done;
}

/* ---- the command ---- */

static bool write_header(const char *stack, const char *path, struct outputs *outputs,
                         struct error *err)
{
    char *header = header_make(stack, err);
    const bool done = header && file_write(path, header, strlen(header), outputs, err);
    free(header);
    return done;
}

bool command_envi(struct options *options, struct error *err)
{
    const char *stack = options->operand;
    if (!stack)
        return error_usage(err, "envi takes a STACK; see spectral envi --help");
    char *beside = sidecar_name(stack);
    if (!beside)
        return error_memory(err);
    const char *path = options->output ? options->output : beside;
    const bool done =
        scene_refuse(stack, err) && write_header(stack, path, &options->outputs, err);
    free(beside);
    return done;
}
