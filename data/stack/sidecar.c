/* SPDX-License-Identifier: MIT */
/* Writes the ENVI header of a stack. The pages of a stack lie raw and without gaps, so that ENVI,
 * SPy, GDAL and MATLAB can map the TIFF file itself: the header says where its samples begin. */
#include <ctype.h>
#include <inttypes.h>

#include "data/stack/inside.h"

/* ---- the header ---- */

/* Returns what stands behind value i of a list of n: a new line begins behind each eighth. */
static const char *behind(int i, int n)
{
    return i == n - 1 ? "}\n" : i % 8 == 7 ? ",\n " : ", ";
}

/* Braces and control characters would end the value. */
static void put_description(struct printed *to, const struct cube *cube)
{
    const struct record *record = &cube->record;
    print_text(to, "ENVI\ndescription = {");
    const size_t start = to->length;
    if (record->program)
        print(to, "%s, rendered by %s, %s; %s, full_scale = %s; %s", record->scene,
              record->renderer, record->program, record->scale, record->full_scale,
              cube->image.verdict);
    else
        print_text(to, path_name(cube->image.path));
    for (size_t i = start; i < to->length; i++) {
        char *c = &to->text[i];
        *c = *c == '{' ? '(' : *c == '}' ? ')' : iscntrl((unsigned char)*c) ? '?' : *c;
    }
    print_text(to, "}\n");
}

/* ENVI's numbers of the types: 1 and 12 of 8 and 16 bits, unsigned, 4 of 32-bit floats. */
static void put_layout(struct printed *to, const struct image *image, const struct raw_samples *raw)
{
    print(to,
          "samples = %d\nlines = %d\nbands = %d\nheader offset = %" PRIu64 "\n"
          "file type = ENVI Standard\ndata type = %d\ninterleave = %s\nbyte order = %d\n",
          image->width, image->height, image->n_pages, raw->offset,
          raw->bits == 8    ? 1
          : raw->bits == 16 ? 12
                            : 4,
          raw->by_pixels ? "bip" : "bsq", raw->big_endian);
}

/* Prints the labels of pages, by which the tags name them as well, and their wavelengths. */
static void put_bands(struct printed *to, const struct cube *cube,
                      const struct sampling_method *method)
{
    const double *nm = cube->image.wavelengths_nm;
    const int n = cube->image.n_pages;
    char label[24];
    print_text(to, "band names = {\n ");
    for (int i = 0; i < n; i++) {
        snprintf(label, sizeof label, PAGE_LABEL, nm[i]);
        if (cube->components)
            sampling_label(method, i, label);
        print(to, "%s%s", label, behind(i, n));
    }
    if (cube->components)
        return;
    print_text(to, "wavelength units = Nanometers\nwavelength = {\n ");
    for (int i = 0; i < n; i++)
        print(to, "%.10g%s", nm[i], behind(i, n));
    if (n > 1)
        print_text(to, "fwhm = {\n ");
    for (int i = 0; i < n && n > 1; i++)
        print(to, "%.10g%s", page_width_nm(nm, n, i), behind(i, n));
}

/* Returns whether each page is lit by 1 all in all: then a radiance of 1 is a reflectance of 1. */
static bool is_lit_by_one(const struct record *record)
{
    bool one = record->white.n > 0 && record_illumination(record) == 1;
    for (int i = 0; i < record->white.n; i++)
        one = one && record->white.value[i] == 1;
    return one;
}

/* Prints how samples become radiances: radiance = gain x sample. */
static void put_scale(struct printed *to, const struct cube *cube, int bits)
{
    const int n = cube->image.n_pages;
    const double gain = bits == 32 ? 1 : cube->image.scale / (bits == 8 ? 255 : 65535);
    if (gain != 1)
        print_text(to, "data gain values = {\n ");
    for (int i = 0; i < n && gain != 1; i++)
        print(to, "%.17g%s", gain, behind(i, n));
    if (is_lit_by_one(&cube->record))
        print(to, "reflectance scale factor = %.17g\n", 1 / gain);
}

/* Prints the header of the stack in a file. */
static void print_header(const char *stack, struct printed *to, struct error *err)
{
    struct sampling_method method;
    struct raw_samples raw;
    struct cube cube;
    if (cube_open(stack, &cube, err) && image_describe(&cube.image, &raw, err) &&
        (!cube.components || sampling_read(stack, cube.record.sampling, &method, err))) {
        put_description(to, &cube);
        put_layout(to, &cube.image, &raw);
        put_bands(to, &cube, &method);
        put_scale(to, &cube, raw.bits);
    }
    cube_close(&cube);
}

/* ---- files ---- */

char *sidecar_name(const char *stack, struct error *err)
{
    struct printed printed = {.text = NULL};
    print(&printed, "%s.hdr", stack);
    return printed_take(&printed, err);
}

/* ---- the command ---- */

static bool run_envi(struct options *options, struct error *err)
{
    const char *stack = options->operand;
    char *beside = sidecar_name(stack, err);
    const char *path = options->output ? options->output : beside;
    struct printed header = {.text = NULL};
    if (beside && scene_refuse(stack, err))
        print_header(stack, &header, err);
    const bool done = printed_write(&header, path, &options->outputs, err) &&
                      options_show_output(options, "header", path, err);
    free(beside);
    return done;
}

static const struct option envi_options[] = {
    {"-o, --output FILE.hdr",
     "writes there; - is standard output (default: STACK's name + .hdr, beside it)",
     SHARED(TEXT, output), .writes = true},
};
const struct command envi_command = {
    .name = "envi",
    .operands = "STACK [-o FILE.hdr]",
    .summary = "write the header by which ENVI and GDAL map a stack",
    .example = "envi colorchecker.tif",
    .run = run_envi,
    .rows = OPTION_LIST(envi_options),
    .n_operands = 1,
};
