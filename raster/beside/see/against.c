/* SPDX-License-Identifier: MIT */
/* Two regions of a stack: the difference of their spectra, and CIEDE2000 under the light that the
 * stack records and under others. Another light multiplies the quotient of radiance and white,
 * which is a reflectance where nothing fluoresces or emits. The metamerism index is that of ISO
 * 18314-4 with CIEDE2000: the second region's XYZ under the other light are multiplied, as that
 * standard recommends, by the quotients of both regions' XYZ under the recorded light. */
#include "raster/beside/see/inside.h"

/* The colours of both regions under a light. */
struct match {
    double xyz[2][3], white[3], difference; /* CIEDE2000 */
};
struct pair {
    struct probe probes[2];
    struct cube cube;
    double *white, *light, *lit, *difference; /* of each page; the first owns all */
    int n;
};

/* ---- colours ---- */

static double difference(const double a[3], const double b[3], const double white[3])
{
    double lab[2][3];
    cielab(a, white, lab[0]);
    cielab(b, white, lab[1]);
    return ciede2000_difference(lab[0], lab[1]);
}

/* Finds the colours under a light, given by its value on each page. */
static void match_under(const struct pair *pair, const double *light, struct match *out)
{
    for (int k = 0; k < 2; k++) {
        const double *mean = pair->probes[k].columns[MEAN].values;
        for (int i = 0; i < pair->n; i++)
            pair->lit[i] = pair->white[i] > 0 ? mean[i] / pair->white[i] * light[i] : 0;
        detector_response(pair->probes[0].sight.weights, pair->lit, pair->n, out->xyz[k]);
    }
    detector_response(pair->probes[0].sight.weights, light, pair->n, out->white);
    out->difference = difference(out->xyz[0], out->xyz[1], out->white);
}

/* Returns the metamerism index of a light beside the recorded one; NaN: a recorded XYZ is 0. */
static double metamerism_index(const struct match *recorded, const struct match *other)
{
    double corrected[3];
    bool exists = true;
    for (int i = 0; i < 3; i++) {
        corrected[i] = other->xyz[1][i] * recorded->xyz[0][i] / recorded->xyz[1][i];
        exists = exists && recorded->xyz[0][i] > 0 && recorded->xyz[1][i] > 0;
    }
    return exists ? difference(other->xyz[0], corrected, other->white) : (double)NAN;
}

/* ---- before ---- */

static bool open_pair(struct pair *pair, const struct options *options, struct error *err)
{
    bool done = true;
    for (int k = 0; done && k < 2; k++)
        done = probe_stack(&pair->probes[k], err);
    if (!done || !cube_open(options->operand, &pair->cube, err))
        return false;
    const int n = pair->n = pair->cube.image.n_pages;
    if (!MAKE_ARRAY(pair->white, 4 * n, err, "spectra of %d bands", n))
        return false;
    pair->light = pair->white + n;
    pair->lit = pair->light + n;
    pair->difference = pair->lit + n;
    for (int i = 0; i < n; i++)
        pair->difference[i] =
            pair->probes[1].columns[MEAN].values[i] - pair->probes[0].columns[MEAN].values[i];
    return cube_white(&pair->cube, NULL, pair->white, err);
}

/* ---- out ---- */

static void print_difference(const struct pair *pair, struct printed *to)
{
    const double *off = pair->difference;
    double squares = 0;
    int largest = 0;
    for (int i = 0; i < pair->n; i++) {
        squares += off[i] * off[i];
        largest = fabs(off[i]) > fabs(off[largest]) ? i : largest;
    }
    print(to, "difference        rms %.6g, largest %.6g at %.10g nm\n", sqrt(squares / pair->n),
          off[largest], pair->cube.image.wavelengths_nm[largest]);
    print(to, "spectral angle    %.6g degrees\n",
          spectral_angle(pair->probes[0].columns[MEAN].values, pair->probes[1].columns[MEAN].values,
                         pair->n));
}

/* Prints a line for each light that the command line names. */
static bool print_lights(struct pair *pair, const struct options *options, struct printed *to,
                         struct error *err)
{
    struct match recorded, other;
    char shown[32];
    match_under(pair, pair->white, &recorded);
    print(to, "CIEDE2000         %.4f under the recorded light\n", recorded.difference);
    for (int i = 0; i < options->n_changes; i++) {
        const char *value = options->changes[i].value, *equals = strchr(value, '=');
        const char *name = equals ? equals + 1 : value;
        if (options->changes[i].apply != scene_set_light)
            return error_usage(err, "--against takes --light, and no other change of a scene");
        if (!cube_white(&pair->cube, name, pair->light, err))
            return false;
        match_under(pair, pair->light, &other);
        const double index = metamerism_index(&recorded, &other);
        snprintf(shown, sizeof shown, "%.4f", index);
        print(to, "CIEDE2000         %.4f under %s, metamerism index %s\n", other.difference, name,
              isnan(index) ? "none" : shown);
    }
    return true;
}

bool probe_against(struct options *options, const struct probe *first, const struct probe *second,
                   bool csv, struct error *err)
{
    struct pair pair = {.probes = {*first, *second}};
    struct printed printed = {.text = NULL};
    char region[2][96];
    bool done = open_pair(&pair, options, err);
    if (done && !csv) {
        for (int k = 0; k < 2; k++)
            region_text(&pair.probes[k], region[k], sizeof region[k]);
        print_fact(&printed, "source", options->operand);
        print(&printed, "regions           %s and %s\n", region[0], region[1]);
        print_difference(&pair, &printed);
        done = print_lights(&pair, options, &printed, err);
    }
    if (done) {
        const struct column columns[] = {{"wavelength", "nm", pair.cube.image.wavelengths_nm},
                                         {"first", NULL, pair.probes[0].columns[MEAN].values},
                                         {"second", NULL, pair.probes[1].columns[MEAN].values},
                                         {"difference", NULL, pair.difference}};
        (csv ? columns_print_csv : columns_print)(columns, 4, pair.n, &printed);
    }
    done = printed_write(&printed, options->output ? options->output : "-", &options->outputs, err);
    for (int k = 0; k < 2; k++)
        probe_free(&pair.probes[k]);
    cube_close(&pair.cube);
    free(pair.white);
    return done;
}
