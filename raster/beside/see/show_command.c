/* SPDX-License-Identifier: MIT */
/* spectral show with --csv or --svg: the curves of lights, detectors, materials and tables, as
 * Figures 12 to 20, 27, 29 and 31 of the thesis have them. */
#include <stdlib.h>
#include <string.h>

#include "raster/beside/see/inside.h"

struct show_own {
    bool csv, svg;
};

struct curves {
    struct curve {
        char name[96];
        struct spectrum spectrum; /* owned */
    } curve[MOST_CURVES];
    int n;
};

/* Takes a spectrum over. */
static bool add_curve(struct curves *curves, const char *name, const char *part,
                      struct spectrum *spectrum, struct error *err)
{
    struct curve *curve = &curves->curve[curves->n];
    if (curves->n == MOST_CURVES)
        return error_usage(err, "more than %d curves; expected at most so many", MOST_CURVES);
    snprintf(curve->name, sizeof curve->name, "%s%s%s", name, part[0] ? " " : "", part);
    curve->spectrum = *spectrum;
    *spectrum = (struct spectrum){0};
    curves->n++;
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
    struct set_names names = {0};
    struct spectrum *samples = NULL;
    struct text text;
    if (!text_open(&text, path, NOWHERE, TEXT_XML, err))
        return false;
    bool done = set_read(text, HUGE_VAL, &samples, &names, err) && names.n > 0;
    for (int i = 0; done && i < names.n; i++)
        done = add_curve(curves, names.name[i], "", &samples[i], err);
    set_free(samples, &names);
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
static bool find_wavelengths(const struct curves *curves, struct probe *out, struct error *err)
{
    double *nm = NULL;
    int n = 0, kept = 0;
    bool done = true;
    for (int c = 0; c < curves->n; c++) {
        const struct spectrum *s = &curves->curve[c].spectrum;
        const bool sampled = s->kind == SPECTRUM_SAMPLED;
        for (int i = 0; done && i < (sampled ? s->count : 81); i++) {
            const double at = sampled ? s->wavelength_nm[i] : 380 + 5 * i;
            done = array_add(&nm, &n, &at, sizeof at, err);
        }
    }
    if (done)
        qsort(nm, (size_t)n, sizeof *nm, compare_numbers);
    for (int i = 0; done && i < n; i++)
        if (kept == 0 || nm[i] > nm[kept - 1])
            nm[kept++] = nm[i];
    out->columns[WAVELENGTH].values = nm;
    out->n = kept;
    return done;
}

/* Makes a probe of no region: its columns are the curves. Beyond a table they have no values. */
static bool fill_probe(const struct curves *curves, struct probe *out, struct error *err)
{
    if (!MAKE_ARRAY(out->columns, CURVES - 1 + curves->n, err, "a table of %d curves", curves->n))
        return false;
    out->n_columns = CURVES - 1 + curves->n;
    if (!find_wavelengths(curves, out, err))
        return false;
    snprintf(out->columns[WAVELENGTH].name, sizeof out->columns->name, "wavelength");
    for (int c = 0; c < curves->n; c++) {
        const struct curve *curve = &curves->curve[c];
        struct probe_column *column = &out->columns[c == 0 ? MEAN : SPREAD + c];
        snprintf(column->name, sizeof column->name, "%s", curve->name);
        if (!MAKE_ARRAY(column->values, out->n, err, "a curve of %d wavelengths", out->n))
            return false;
        for (int i = 0; i < out->n; i++) {
            const double nm = out->columns[WAVELENGTH].values[i];
            column->values[i] = spectrum_extrapolates(&curve->spectrum, nm)
                                    ? (double)NAN
                                    : spectrum_at(&curve->spectrum, nm, SPECTRUM_ZERO);
        }
    }
    return true;
}

static void print_csv(const struct probe *probe, struct printed *to)
{
    for (int column = 0; column < probe->n_columns; column++) {
        if (column == SPREAD)
            continue;
        print_text(to, column == WAVELENGTH ? "\"wavelength (nm)" : ",\"");
        csv_text(column == WAVELENGTH ? "" : probe->columns[column].name, to);
        print_text(to, "\"");
    }
    for (int i = 0; i < probe->n; i++)
        for (int column = 0; column < probe->n_columns; column++) {
            const double value = column == SPREAD ? 0 : probe->columns[column].values[i];
            if (column != SPREAD)
                print_text(to, column == WAVELENGTH ? "\n" : ",");
            if (column != SPREAD && isfinite(value))
                print(to, "%.*g", exact_digits(value), value);
        }
    print_text(to, "\n");
}

static bool run_show(struct options *options, struct error *err)
{
    const struct show_own *own = options->own;
    struct curves curves = {.n = 0};
    struct probe probe = {.n = 0};
    struct printed printed = {.text = NULL}, source = {.text = NULL};
    bool done = own->csv + own->svg < 2 || error_usage(err, "--csv and --svg exclude each other");
    if (done && !own->csv && !own->svg)
        return show_file(options, err);
    done = done && (options->n_operands > 0 || error_usage(err, "show takes one NAME or more"));
    for (int i = 0; done && i < options->n_operands; i++) {
        done = add_named(&curves, options->operands[i], err);
        print(&source, "%s%s", i > 0 ? ", " : "", options->operands[i]);
    }
    probe.source = printed_end(&source);
    done = done && fill_probe(&curves, &probe, err);
    if (done) {
        (own->svg ? probe_svg : print_csv)(&probe, &printed);
        done = printed_write(&printed, options->output ? options->output : "-", &options->outputs,
                             err);
    }
    probe_free(&probe);
    for (int i = 0; i < curves.n; i++)
        spectrum_free(&curves.curve[i].spectrum);
    return done;
}

static const struct option rows[] = {
    {"-o, --output FILE", "writes there (default: standard output)", SHARED(TEXT, output),
     .writes = true},
    {"--csv", "writes the curves of spectra, detectors, materials as a table",
     OWN(FLAG, show_own, csv)},
    {"--svg", "writes them as a plot", OWN(FLAG, show_own, svg)},
};
static const struct option_list list = OPTION_LIST(rows);
static const struct option_list *const lists[] = {&list, &common_options, NULL};
const struct command curves_command = {
    .name = "show",
    .operands = "NAME... [-o FILE]",
    .summary = "print a built-in file, to start one of your own with, or plot spectra",
    .example = "show d65 a --svg -o lights.svg",
    .run = run_show,
    .lists = lists,
    .own_size = sizeof(struct show_own),
    .n_operands = MOST_CURVES,
};
