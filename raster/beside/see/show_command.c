/* SPDX-License-Identifier: MIT */
/* spectral show with --csv or --svg: the curves of lights, detectors, materials and tables, as
 * Figures 12 to 20, 27, 29 and 31 of the thesis have them. */
#include "raster/beside/see/inside.h"

struct show_own {
    bool csv, svg;
};

struct curves {
    struct column columns[1 + MOST_CURVES]; /* the wavelengths, then the curves; values are owned */
    struct spectrum spectra[MOST_CURVES];   /* of the curves; owned */
    int n, n_nm;
};

/* Takes a spectrum over. */
static bool add_curve(struct curves *curves, const char *name, const char *part,
                      struct spectrum *spectrum, struct error *err)
{
    if (curves->n == MOST_CURVES)
        return error_usage(err, "more than %d curves; expected at most so many", MOST_CURVES);
    curves->spectra[curves->n++] = *spectrum;
    *spectrum = (struct spectrum){0};
    struct column *column = &curves->columns[curves->n];
    snprintf(column->name, sizeof column->name, "%s%s%s", name, part[0] ? " " : "", part);
    return true;
}

static bool add_material(struct curves *curves, const char *name, const char *path,
                         struct error *err)
{
    static const char *const parts[] = {"reflectance", "specular reflectance", "excitation",
                                        "emission"};
    struct material material;
    if (!material_read(path, NOWHERE, &material, err))
        return false;
    struct spectrum *spectra[] = {&material.diffuse, &material.specular, &material.excitation,
                                  &material.emission};
    bool done = true;
    for (int i = 0; i < 4; i++)
        if (spectra[i]->kind != SPECTRUM_NONE)
            done = done && add_curve(curves, name, parts[i], spectra[i], err);
    material_free(&material);
    return done;
}

static bool add_detector(struct curves *curves, const char *name, struct error *err)
{
    struct detector detector;
    bool done = detector_read(name, &detector, err);
    for (int i = 0; done && i < 3; i++)
        done = add_curve(curves, name, detector.observer ? &"X\0Y\0Z"[2 * i] : &"R\0G\0B"[2 * i],
                         &detector.sensitivity[i], err);
    detector_free(&detector);
    return done;
}

static bool add_samples(struct curves *curves, const char *path, struct error *err)
{
    struct spectrum *samples;
    int n;
    struct text text;
    if (!text_open(&text, path, NOWHERE, TEXT_XML, err))
        return false;
    bool done = set_read(text, HUGE_VAL, &samples, &n, err);
    for (int i = 0; done && i < n; i++)
        done = add_curve(curves, samples[i].name, "", &samples[i], err);
    set_free(samples, n);
    text_free(&text);
    return done;
}

/* Tries a detector, the samples of a table and a material. */
static bool add_other(struct curves *curves, const char *name, const char *path)
{
    struct error first = {0}, second = {0}, third = {0};
    return add_detector(curves, name, &first) ||
           (!file_is_missing(path) &&
            (add_samples(curves, path, &second) || add_material(curves, name, path, &third)));
}

/* Adds the curves of a name: a built-in material, a spectrum, a detector; or the samples of a
 * table, or a material, of a file. If it is none of them, the error is that of a spectrum. */
static bool add_named(struct curves *curves, const char *name, struct error *err)
{
    const struct word word = {.start = name, .length = strlen(name)};
    struct spectrum spectrum = {0};
    char *path;
    if (!word_file(&word, FILE_MATERIAL, &path, err))
        return false;
    if (path_is_builtin(path)) {
        const bool done = add_material(curves, name, path, err);
        free(path);
        return done;
    }
    bool done = spectrum_read(&word, -HUGE_VAL, HUGE_VAL, &spectrum, err) &&
                add_curve(curves, name, "", &spectrum, err);
    spectrum_free(&spectrum);
    if (!done && err->status == EXIT_INPUT && add_other(curves, name, path)) {
        *err = (struct error){0};
        done = true;
    }
    free(path);
    return done;
}

static int compare_numbers(const void *a, const void *b)
{
    const double one = *(const double *)a, other = *(const double *)b;
    return (one > other) - (one < other);
}

/* Finds the wavelengths of all tables; formulas have every 5 nm from 380 to 780 nm. */
static bool find_wavelengths(struct curves *curves, struct error *err)
{
    double **nm = &curves->columns[0].values;
    int kept = 0;
    bool done = true;
    for (int c = 0; c < curves->n; c++) {
        const struct spectrum *s = &curves->spectra[c];
        const bool sampled = s->kind == SPECTRUM_SAMPLED;
        for (int i = 0; done && i < (sampled ? s->count : 81); i++) {
            const double at = sampled ? s->wavelength_nm[i] : 380 + 5 * i;
            done = array_add(nm, &curves->n_nm, &at, sizeof at, err);
        }
    }
    if (curves->n_nm > 0)
        qsort(*nm, (size_t)curves->n_nm, sizeof **nm, compare_numbers);
    for (int i = 0; i < curves->n_nm; i++)
        if (kept == 0 || (*nm)[i] > (*nm)[kept - 1])
            (*nm)[kept++] = (*nm)[i];
    curves->n_nm = kept;
    return done;
}

/* Finds the values of the curves. Beyond a table they have none. */
static bool find_values(struct curves *curves, struct error *err)
{
    if (!find_wavelengths(curves, err))
        return false;
    for (int c = 0; c < curves->n; c++) {
        const struct spectrum *spectrum = &curves->spectra[c];
        double **values = &curves->columns[1 + c].values;
        if (!MAKE_ARRAY(*values, curves->n_nm, err, "a curve of %d wavelengths", curves->n_nm))
            return false;
        for (int i = 0; i < curves->n_nm; i++) {
            const double nm = curves->columns[0].values[i];
            (*values)[i] = spectrum_extrapolates(spectrum, nm)
                               ? (double)NAN
                               : spectrum_at(spectrum, nm, SPECTRUM_ZERO);
        }
    }
    return true;
}

static void curves_free(struct curves *curves)
{
    for (int i = 0; i < curves->n; i++)
        spectrum_free(&curves->spectra[i]);
    for (int i = 0; i <= curves->n; i++)
        free(curves->columns[i].values);
}

/* ---- out ---- */

static void print_svg(const struct curves *curves, const char *title, struct printed *to)
{
    struct chart_series series[MOST_CURVES];
    const struct chart chart = {.title = title,
                                .x_label = "wavelength (nm)",
                                .y_label = "value",
                                .series = series,
                                .n = curves->n};
    for (int c = 0; c < curves->n; c++)
        series[c] = (struct chart_series){.name = curves->columns[1 + c].name,
                                          .n = curves->n_nm,
                                          .x = curves->columns[0].values,
                                          .y = curves->columns[1 + c].values};
    chart_svg(&chart, to);
}

static bool run_show(struct options *options, struct error *err)
{
    const struct show_own *own = options->own;
    struct curves curves = {.columns = {{"wavelength", "nm", NULL}}};
    struct printed printed = {.text = NULL}, names = {.text = NULL};
    bool done = own->csv + own->svg < 2 || error_usage(err, "--csv and --svg exclude each other");
    if (done && !own->csv && !own->svg)
        return show_file(options, err);
    for (int i = 0; done && i < options->n_operands; i++) {
        done = add_named(&curves, options->operands[i], err);
        print(&names, "%s%s", i > 0 ? ", " : "", options->operands[i]);
    }
    char *title = printed_end(&names);
    done = done && find_values(&curves, err);
    if (done && own->csv)
        columns_print_csv(curves.columns, 1 + curves.n, curves.n_nm, &printed);
    else if (done)
        print_svg(&curves, title, &printed);
    done = done &&
           printed_write(&printed, options->output ? options->output : "-", &options->outputs, err);
    curves_free(&curves);
    free(title);
    return done;
}

static const struct option rows[] = {
    {"-o, --output FILE", "writes there (default: standard output)", SHARED(TEXT, output),
     .writes = true},
    {"--csv", "writes the curves of spectra, detectors, materials as a table",
     OWN(FLAG, show_own, csv)},
    {"--svg", "writes them as a plot", OWN(FLAG, show_own, svg)},
};
const struct command curves_command = {
    .name = "show",
    .operands = "NAME... [-o FILE]",
    .summary = "print a built-in file, to start one of your own with, or plot spectra",
    .example = "show patches -o my.scene",
    .first = "copies a scene, to change it",
    .run = run_show,
    .rows = OPTION_LIST(rows),
    .own_size = sizeof(struct show_own),
    .n_operands = MOST_CURVES,
};
