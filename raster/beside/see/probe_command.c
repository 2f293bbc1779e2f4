/* SPDX-License-Identifier: MIT */
/* spectral probe: prints the spectrum of a pixel or a region, of a stack or of a scene. The command
 * lies in raster/ because the reference draws the scene. */
#include "raster/beside/see/inside.h"

struct probe_own {
    bool csv, svg, objects, edges;
    const char *against;
};

/* ---- operands ---- */

/* Reads the words behind the stack or scene: X Y; X Y W H; "X,Y", as commands print it; or the name
 * or number of an object. */
static bool region_read(const struct options *options, struct probe *out, struct error *err)
{
    static const char *const names[] = {"X", "Y", "W", "H"};
    int *numbers[] = {&out->at.x, &out->at.y, &out->at.width, &out->at.height}, end = 0;
    const char *word = options->operands[1];
    char x[16], y[16];
    if (options->n_operands == 2) {
        if (sscanf(word, "%15[0-9],%15[0-9]%n", x, y, &end) == 2 && word[end] == '\0')
            return option_count("X", x, 0, INT32_MAX, &out->at.x, err) &&
                   option_count("Y", y, 0, INT32_MAX, &out->at.y, err);
        out->wanted = word;
        return true;
    }
    if (options->n_operands != 3 && options->n_operands != 5)
        return options_misused(options->command, "expected X Y, X Y W H or OBJECT behind",
                               options->operand, err);
    for (int i = 0; i + 1 < options->n_operands; i++)
        if (!option_count(names[i], options->operands[1 + i], i < 2 ? 0 : 1, INT32_MAX, numbers[i],
                          err))
            return false;
    return true;
}

bool stack_refuses_changes(const struct options *options, struct error *err)
{
    for (int i = 0; i < options->n_recorded; i++)
        if (strncmp(options->recorded[i], "--detector=", strlen("--detector=")) != 0 &&
            strncmp(options->recorded[i], "--display=", strlen("--display=")) != 0)
            return error_usage(err, "%s is a stack; %s needs a scene", options->operand,
                               options->recorded[i]);
    return true;
}

/* Reads --against X Y: its value is X, and Y the last operand, behind those of the first region. Or
 * the value is an object, as the operand behind the stack. */
static bool read_against(struct options *options, struct probe *first, struct probe *second,
                         struct error *err)
{
    const struct probe_own *own = options->own;
    int *y = &second->at.y;
    if (own->svg || options->json || options->white)
        return error_usage(err, "--against takes no --svg, --json or --white");
    if (own->csv && !stack_refuses_changes(options, err)) /* the table has no colours */
        return false;
    if (options->n_operands == 2) {
        first->wanted = options->operands[1];
        second->wanted = own->against;
        return true;
    }
    if (options->n_operands != 4 && options->n_operands != 6)
        return error_usage(err, "--against takes X and Y: probe STACK X Y --against X Y; or an "
                                "object: probe STACK OBJECT --against OBJECT");
    options->n_operands--;
    return option_count("--against", own->against, 0, INT32_MAX, &second->at.x, err) &&
           option_count("--against", options->operands[options->n_operands], 0, INT32_MAX, y,
                        err) &&
           region_read(options, first, err);
}

static bool probe_operand(const struct options *options, struct probe *probe, struct error *err)
{
    bool is_stack;
    if (!image_is(options->operand, &is_stack, err))
        return false;
    if (!is_stack)
        return probe->wanted
                   ? error_usage(err, "objects are found in stacks; a scene takes X and Y")
                   : probe_scene(probe, err);
    return stack_refuses_changes(options, err) && probe_stack(probe, err);
}

/* ---- out ---- */

static void print_colour(const struct probe *probe, struct printed *to)
{
    double xy[2];
    const double *xyz = probe->xyz, *lab = probe->lab, *white = probe->sight.white;
    const struct detector *camera = &probe->camera.detector;
    chromaticity(xyz, xy);
    for (int i = 0; i < camera->n; i++)
        print(to, "%-17s %.6g, stored to %.2g\n", camera->channel[i], probe->raw[i],
              probe->raw_bound[i]);
    if (probe->options->matrix)
        print_detector(to, &probe->sight, probe->options->matrix);
    else
        print_fact(to, "observer", probe->sight.detector.name);
    print(to, "XYZ               %.4f %.4f %.4f%s\n", xyz[0], xyz[1], xyz[2],
          probe->absolute ? ", Y in cd/m2" : "");
    print(to, "xy                %.5f %.5f\n", xy[0], xy[1]);
    if (!probe->sight.has_white) {
        print(to, "Lab               none: the white is unknown; --white SPECTRUM sets it\n");
        return;
    }
    print(to, "Lab               %.4f %.4f %.4f\n", lab[0], lab[1], lab[2]);
    print(to, "white XYZ         %.4f %.4f %.4f\n", white[0], white[1], white[2]);
}

void region_text(const struct probe *probe, char *out, size_t capacity)
{
    if (probe->wanted)
        snprintf(out, capacity, "object %.80s", probe->wanted);
    else if (probe->at.width == 1 && probe->at.height == 1)
        snprintf(out, capacity, "pixel %d,%d", probe->at.x, probe->at.y);
    else
        snprintf(out, capacity, "%d x %d pixels from %d,%d", probe->at.width, probe->at.height,
                 probe->at.x, probe->at.y);
}

static void probe_print(const struct probe *probe, struct printed *to)
{
    char text[COLUMN_HEADING], number[32];
    print_fact(to, "source", probe->source);
    region_text(probe, text, sizeof text);
    print(to, "region            %s\n", text);
    print_fact(to, "object", probe->object ? probe->object : "unknown, or several");
    if (!probe->raw_file)
        print_colour(probe, to);
    for (int column = 0; column < probe->n_columns; column++) {
        column_heading(&probe->columns[column], text);
        snprintf(number, sizeof number, "column %d", column + 1);
        print_fact(to, number, text);
    }
    columns_print(probe->columns, probe->n_columns, probe->n, to);
}

static void probe_json(const struct probe *probe, struct json *json)
{
    static const char *const names[] = {"wavelengths_nm", "radiance", "standard_deviation"};
    json_begin(json);
    json_string(json, "source", probe->source);
    if (!probe->wanted) {
        json_count(json, "x", (uint64_t)probe->at.x);
        json_count(json, "y", (uint64_t)probe->at.y);
        json_count(json, "width", (uint64_t)probe->at.width);
        json_count(json, "height", (uint64_t)probe->at.height);
    }
    json_string(json, "object", probe->object);
    json_string(json, "observer", probe->sight.detector.name);
    json_string(json, "matrix", probe->options->matrix);
    json_strings(json, "channels", (const char *const *)probe->camera.detector.channel,
                 probe->camera.detector.n);
    json_numbers(json, "raw", probe->raw, probe->camera.detector.n);
    json_numbers(json, "raw_bound", probe->raw_bound, probe->camera.detector.n);
    json_string(json, "unit",
                probe->raw_file   ? "raw"
                : probe->absolute ? ABSOLUTE_UNIT
                                  : RELATIVE_UNIT);
    json_numbers(json, "XYZ", probe->raw_file ? NULL : probe->xyz, 3);
    json_numbers(json, "white_XYZ", probe->sight.has_white ? probe->sight.white : NULL, 3);
    json_numbers(json, "Lab", probe->sight.has_white ? probe->lab : NULL, 3);
    for (int column = 0; column < CURVES; column++)
        json_numbers(json, names[column],
                     probe->raw_file && column == WAVELENGTH ? NULL : probe->columns[column].values,
                     probe->n);
    json_open(json, "curves", '[');
    for (int column = CURVES; column < probe->n_columns; column++) {
        json_open(json, NULL, '{');
        json_string(json, "name", probe->columns[column].name);
        json_numbers(json, "values", probe->columns[column].values, probe->n);
        json_close(json, '}');
    }
    json_close(json, ']');
}

/* Prints a chart. The radiances are its subject; bars are their standard deviations, and end at 0
 * where a radiance is 0 or more. A pixel has none. */
static bool probe_svg(const struct probe *probe, struct printed *to, struct error *err)
{
    const struct column *columns = probe->columns;
    const bool is_region = probe->at.width > 1 || probe->at.height > 1 || probe->wanted;
    const size_t n_bars = 3 * (size_t)probe->n; /* both ends, and what separates them */
    struct chart_series *all = NULL;
    double *nm, *ends = NULL;
    char region[96], title[512];
    struct chart chart = {.title = title,
                          .x_label = "wavelength (nm)",
                          .y_label = probe->absolute ? "radiance (W sr⁻¹ m⁻² nm⁻¹)"
                                                     : "radiance (W sr⁻¹ m⁻² nm⁻¹, relative)"};
    bool done = MAKE_ARRAY(nm, n_bars, err, "a plot") && MAKE_ARRAY(ends, n_bars, err, "a plot");
    for (size_t i = 0; done && i < n_bars; i++) {
        const double mean = columns[MEAN].values[i / 3], spread = columns[SPREAD].values[i / 3];
        nm[i] = columns[WAVELENGTH].values[i / 3];
        ends[i] = i % 3 == 0   ? fmax(mean - spread, fmin(mean, 0))
                  : i % 3 == 1 ? mean + spread
                               : (double)NAN;
    }
    for (int i = MEAN; done && i < probe->n_columns; i++) {
        const bool is_bars = i == SPREAD;
        const struct chart_series series = {.name = columns[i].name,
                                            .kind = is_bars ? CHART_BARS : CHART_LINE,
                                            .n = is_bars ? (int)n_bars : probe->n,
                                            .x = is_bars ? nm : columns[WAVELENGTH].values,
                                            .y = is_bars ? ends : columns[i].values,
                                            .right = strcmp(columns[i].unit, "1") == 0};
        if (series.right)
            chart.right_label = "reflectance, excitation, emission";
        if (!is_bars || is_region)
            done = array_add(&all, &chart.n, &series, sizeof series, err);
    }
    chart.series = all;
    region_text(probe, region, sizeof region);
    snprintf(title, sizeof title, "%s%s%s: %s", probe->object ? probe->object : "",
             probe->object ? ", " : "", region, probe->source);
    if (done)
        chart_svg(&chart, to);
    FREE_ALL(nm, ends, all);
    return done;
}

/* ---- the command ---- */

static bool probe_write(struct options *options, const struct probe *probe, struct error *err)
{
    const struct probe_own *own = options->own;
    struct printed printed = {.text = NULL};
    struct json json;
    probe_json(probe, &json);
    if (own->csv)
        columns_print_csv(probe->columns, probe->n_columns, probe->n, &printed);
    else if (own->svg)
        probe_svg(probe, &printed, err); /* report_write ends all, also after a failure */
    else
        probe_print(probe, &printed);
    return report_write(options, &json, &printed, err);
}

/* Refuses forms of a report that would not be written. */
static bool check_forms(const struct options *options, struct error *err)
{
    const struct probe_own *own = options->own;
    if (own->objects && (options->n_operands != 1 || own->svg))
        return error_usage(err, "--objects takes a STACK alone, and no --svg");
    return own->csv + own->svg + (options->json && !options->output) < 2 ||
           error_usage(err,
                       "--csv, --svg and --json exclude each other; give one of them, or --json "
                       "with -o FILE");
}

static bool run_probe(struct options *options, struct error *err)
{
    const struct probe_own *own = options->own;
    struct probe probe = {.at = {0, 0, 1, 1}, .options = options};
    if (!check_forms(options, err))
        return false;
    if (own->objects)
        return scene_refuse(options->operand, err) && stack_refuses_changes(options, err) &&
               probe_objects(options, own->csv, own->edges, err);
    struct probe second = probe;
    if (own->against ? !read_against(options, &probe, &second, err)
                     : !region_read(options, &probe, err))
        return false;
    if (own->against) {
        second.at.width = probe.at.width;
        second.at.height = probe.at.height;
        return scene_refuse(options->operand, err) &&
               probe_against(options, &probe, &second, own->csv, err);
    }
    bool done = probe_operand(options, &probe, err) && probe_write(options, &probe, err);
    probe_free(&probe);
    return done;
}

static const struct option probe_rows[] = {
    {"-o, --output FILE", "writes there (default: standard output)", SHARED(TEXT, output),
     .writes = true},
    {"--csv", "writes a table instead of text", OWN(FLAG, probe_own, csv)},
    {"--svg", "writes a plot instead of text", OWN(FLAG, probe_own, svg)},
    {"--against X Y",
     "compares with another region or object of the stack, also under each --light",
     OWN(TEXT, probe_own, against)},
    {"--objects", "prints the mean of each object of a stack, and of a detector's channels",
     OWN(FLAG, probe_own, objects)},
    {"--edges", "--objects counts pixels beside another object, too", OWN(FLAG, probe_own, edges),
     .needs = "--objects"},
};
const struct command probe_command = {
    .name = "probe",
    .operands = "STACK|SCENE X Y [W H], or STACK OBJECT",
    .summary = "print the spectrum of a pixel, or the mean of a region",
    .example = "probe fluorescence 700 300",
    .first = "prints the spectrum of a pixel",
    .run = run_probe,
    .rows = OPTION_LIST(probe_rows),
    .shared = {&seeing_options, &scene_options, &shading_options, &accuracy_options,
               &threads_option, &json_option},
    .own_size = sizeof(struct probe_own),
    .n_operands = 6, /* with --against, whose Y comes last */
};
