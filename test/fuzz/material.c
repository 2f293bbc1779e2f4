/* SPDX-License-Identifier: MIT */
/* Fuzz targets: a material file, an MTL file, a table of a spectrum or a detector, a Donaldson
 * matrix, a display. */
#include <math.h>
#include <string.h>

#include "data/scene/inside.h"
#include "data/spectra/spectra.h"
#include "data/text/text.h"
#include "raster/beside/colour/colour.h"
#include "test/fuzz/fuzz.h"

static const struct place nowhere = {0};

/* A value that is not finite would become a pixel without a word. */
static void check_spectrum(const struct spectrum *spectrum, double lowest)
{
    for (int i = 1; i < spectrum->count; i++)
        fuzz_holds(spectrum->wavelength_nm[i - 1] < spectrum->wavelength_nm[i],
                   "wavelengths increase");
    for (double nm = 100; nm < 2000 && spectrum->kind != SPECTRUM_NONE; nm += 33.3) {
        const double value = spectrum_at(spectrum, nm, SPECTRUM_HOLD);
        fuzz_holds(isfinite(value) && value >= lowest, "a spectrum is finite, and not too low");
    }
}

static void check_material(const struct material *material)
{
    check_spectrum(&material->diffuse, 0);
    check_spectrum(&material->specular, 0);
    check_spectrum(&material->excitation, 0);
    check_spectrum(&material->emission, 0);
    check_spectrum(&material->glow, 0);
    fuzz_holds(material->diffuse.kind != SPECTRUM_NONE, "a material has a diffuse reflectance");
    fuzz_holds(material->gloss >= 0 && material->gloss <= 128, "a gloss is from 0 to 128");
    if (material->partner != NULL)
        check_spectrum(&material->partner->diffuse, 0);
}

void fuzz_material(const struct fuzz_input *input)
{
    struct error err = {.status = EXIT_AGREED};
    struct material material = {.name = NULL};
    if (fuzz_ends(material_read(input->path, nowhere, &material, &err), &err))
        check_material(&material);
    material_free(&material);
}

/* Reads three entries; the seeds have the first. */
void fuzz_mtl(const struct fuzz_input *input)
{
    static const char *const names[] = {"a", "b c", ""};
    struct error err = {.status = EXIT_AGREED};
    struct mtl mtl = {0};
    const bool opened = fuzz_ends(mtl_open(input->path, nowhere, &mtl, &err), &err);
    for (size_t i = 0; opened && i < sizeof names / sizeof names[0]; i++) {
        const struct word name = {.start = names[i], .length = strlen(names[i])};
        struct material material = {.name = NULL};
        err = (struct error){.status = EXIT_AGREED};
        const struct mtl_entry *entry = mtl_find(&mtl, nowhere, &name, &err);
        material = (struct material){0};
        if (fuzz_ends(entry && mtl_read(entry, &material, &err), &err))
            check_material(&material);
        material_free(&material);
    }
    mtl_free(&mtl);
}

static void read_column(const char *path, const char *column, double highest)
{
    char name[FUZZ_PATH + 8];
    struct error err = {.status = EXIT_AGREED};
    struct spectrum spectrum = {.kind = SPECTRUM_NONE};
    snprintf(name, sizeof name, "%s%s", path, column);
    const struct word word = {.start = name, .length = strlen(name)};
    if (fuzz_ends(spectrum_read(&word, 0, highest, &spectrum, &err), &err))
        check_spectrum(&spectrum, 0);
    spectrum_free(&spectrum);
}

/* Reads the table as a reflectance, as a light, as the second column of several, and as a detector.
 */
void fuzz_table(const struct fuzz_input *input)
{
    struct error err = {.status = EXIT_AGREED};
    struct detector detector = {.name = NULL};
    double lost[3], nm[] = {400, 500, 600}, weights[9];
    read_column(input->path, "", 1);
    read_column(input->path, "*0.5", HUGE_VAL);
    read_column(input->path, ":2", HUGE_VAL);
    if (fuzz_ends(detector_read(input->path, &detector, &err), &err)) {
        for (int i = 0; i < 3; i++)
            check_spectrum(&detector.sensitivity[i], -HUGE_VAL);
        detector_weights(&detector, nm, 3, weights);
        detector_lost(&detector, nm, 3, lost);
        for (int i = 0; i < 3; i++)
            fuzz_holds(lost[i] >= 0 && lost[i] <= 1, "a part that is lost is from 0 to 1");
    }
    detector_free(&detector);
}

void fuzz_matrix(const struct fuzz_input *input)
{
    const struct spectrum light = {SPECTRUM_CONSTANT, {1, 0}, .factor = 1};
    struct spectrum black = {.kind = SPECTRUM_CONSTANT, .factor = 1};
    struct error err = {.status = EXIT_AGREED};
    struct donaldson matrix = {.share = NULL};
    struct spectrum emission = {.kind = SPECTRUM_NONE};
    if (fuzz_ends(donaldson_read(input->path, nowhere, false, &black, &matrix, &err), &err) &&
        fuzz_ends(donaldson_emission(&matrix, &light, &emission, &err), &err))
        check_spectrum(&emission, 0);
    spectrum_free(&emission);
    spectrum_free(&black);
    donaldson_free(&matrix);
}

void fuzz_display(const struct fuzz_input *input)
{
    struct error err = {.status = EXIT_AGREED};
    struct display display;
    if (!fuzz_ends(display_read(input->path, &display, &err), &err))
        return;
    for (int i = 0; i < 9; i++) {
        const double largest = display_largest(&display, i % 3);
        fuzz_holds(isfinite(display.matrix[i / 3][i % 3]), "the matrix is finite");
        fuzz_holds(largest > 0 && isfinite(largest), "a channel has a range");
        for (double part = 0; part <= 1; part += 0.125) {
            const double value = display_encode(&display, i % 3, part * largest);
            fuzz_holds(value >= 0 && value <= 1, "a value is from 0 to 1");
        }
    }
}
