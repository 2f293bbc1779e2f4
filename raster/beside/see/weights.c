/* SPDX-License-Identifier: MIT */
/* Finds the weights that develop a stack. Detector, adaptation and display are linear: together
 * they become three numbers a page. */
#include "raster/beside/see/inside.h"

static bool check_detector(const struct development *of, struct error *err)
{
    const struct image *image = &of->cube.image;
    const struct detector *detector = &of->detector;
    /* Rendering checked a recorded response; that of a black scene is 0. A scene may be black. */
    bool sees = of->options->lit || of->cube.record.response.n > 0;
    for (int i = 0; i < 3 * image->n_pages; i++)
        sees = sees || of->weights[i] != 0;
    if (!sees)
        return error_usage(err, "%s: %s sees nothing from %.10g to %.10g nm", image->path,
                           detector->name, of->first_nm, of->last_nm);
    if (!detector->observer && of->adaptation.kind != ADAPTATION_NONE)
        return error_usage(err,
                           "%s is a camera or film, which does not adapt but is balanced to the"
                           " white; %s is for observers",
                           detector->name, adaptation_names[of->adaptation.kind]);
    if (!detector->observer && of->options->values != DEVELOP_RGB)
        return error_usage(err,
                           "%s is a camera or film, which has no %s; expected an observer, or "
                           "--raw for the camera's own values",
                           detector->name,
                           of->options->values == DEVELOP_XYZ ? "tristimulus values" : "CIELAB");
    return true;
}

/* Divides each channel by the white's. */
static bool balance(const struct development *of, struct error *err)
{
    const double *white = of->seen_white;
    const int n = of->cube.image.n_pages;
    for (int channel = 0; channel < 3; channel++) {
        if (!(white[channel] > 0))
            return error_usage(err,
                               "channel %d of %s responds to the white with %.6g, and cannot be"
                               " divided by that; expected a white that all three channels see",
                               channel + 1, of->detector.name, white[channel]);
        for (int i = 0; i < n; i++)
            of->weights[channel * n + i] /= white[channel];
    }
    return true;
}

/* Adapts the weights, and the white. As in the thesis, the luminance of Fairchild's adaptation is
 * ten times the light's intensity; of absolute radiances, the white's. */
static bool adapt(struct development *of, struct error *err)
{
    const double recorded = record_illumination(&of->cube.record);
    const int n = of->cube.image.n_pages;
    struct adaptation *adaptation = &of->adaptation;
    double m[3][3];
    if (adaptation->kind == ADAPTATION_FAIRCHILD && !(adaptation->luminance > 0))
        adaptation->luminance = of->cube.record.unit
                                    ? (recorded > 0 ? recorded : 1) * of->seen_white[1]
                                    : 10 * (recorded > 0 ? recorded : 1);
    if (!adaptation_matrix(adaptation, of->seen_white, of->equal, m, err))
        return false;
    tristimulus_apply_all(m, n, of->weights);
    tristimulus_apply(m, of->seen_white, of->adapted_white);
    if (of->options->values == DEVELOP_RGB) {
        display_matrix(of->options->display, m);
        tristimulus_apply_all(m, n, of->weights);
    }
    return true;
}

/* The result reports a recorded white even where none is needed. */
static bool needs_white(const struct development *of)
{
    return !of->detector.observer || of->adaptation.kind != ADAPTATION_NONE ||
           of->options->values == DEVELOP_LAB;
}

/* Describes the range of the stack. */
static void describe_stack(struct development *of)
{
    const struct image *image = &of->cube.image;
    const struct record *record = &of->cube.record;
    const double half_cell = 0.5;
    const bool components = of->cube.components;
    of->first_nm = components ? record->range_nm.value[0] + half_cell : image->wavelengths_nm[0];
    of->last_nm = components ? record->range_nm.value[1] - half_cell
                             : image->wavelengths_nm[image->n_pages - 1];
    cube_lost(&of->cube, &of->detector, of->lost);
}

/* Finds the weights that take pages to the detector's channels, and the response to the white and
 * to radiance 1 everywhere. */
static bool channel_weights(struct development *of, struct error *err)
{
    const struct cube *cube = &of->cube;
    const struct white_request request = {of->options->white, needs_white(of)};
    if (!cube_weights(cube, &of->detector, of->weights, err) || !check_detector(of, err) ||
        !cube_white_response(cube, &request, of->weights, &of->has_white, of->seen_white, err) ||
        !cube_equal_response(cube, &of->detector, of->weights, of->equal, err))
        return false;
    const double luminance = cube_luminance(cube, &of->detector);
    for (int i = 0; i < 3 * cube->image.n_pages; i++)
        of->weights[i] *= luminance;
    for (int i = 0; i < 3; i++) {
        of->seen_white[i] *= luminance;
        of->equal[i] *= luminance;
    }
    return true;
}

bool develop_weights(struct development *of, struct error *err)
{
    const size_t n = 3 * (size_t)of->cube.image.n_pages;
    if (!MAKE_ARRAY(of->weights, n, err, "the weights of %s", of->cube.image.path) ||
        !detector_read(of->options->detector_name, &of->detector, err))
        return false;
    describe_stack(of);
    return channel_weights(of, err) && (of->detector.observer ? adapt(of, err) : balance(of, err));
}
