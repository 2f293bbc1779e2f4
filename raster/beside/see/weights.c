/* SPDX-License-Identifier: MIT */
/* Finds the weights that develop a stack. Detector, adaptation and display are linear: together
 * they become three numbers a page. */
#include "raster/beside/see/inside.h"

static bool check_detector(const struct development *of, struct error *err)
{
    const struct image *image = &of->cube.image;
    const struct detector *detector = &of->sight.detector;
    const bool observes = of->sight.observes;
    /* Rendering checked a recorded response; that of a black scene is 0. A scene may be black. */
    bool sees = of->lit || of->cube.record.response.n > 0;
    for (int i = 0; i < of->sight.n * image->n_pages; i++)
        sees = sees || of->sight.weights[i] != 0;
    if (!sees)
        return error_usage(err, "%s: %s sees nothing from %.10g to %.10g nm", image->path,
                           detector->name, of->first_nm, of->last_nm);
    if (!observes && of->adaptation.kind != ADAPTATION_NONE)
        return error_usage(err,
                           "%s is a camera or film, which does not adapt but is balanced to the"
                           " white; %s is for observers",
                           detector->name, adaptation_names[of->adaptation.kind]);
    if (!observes && (of->values == DEVELOP_XYZ || of->values == DEVELOP_LAB))
        return error_usage(err,
                           "%s is a camera or film, which has no %s; expected an observer, or "
                           "--raw for the camera's own values",
                           detector->name,
                           of->values == DEVELOP_XYZ ? "tristimulus values" : "CIELAB");
    return true;
}

/* Divides each channel by the white's. */
static bool balance(const struct development *of, struct error *err)
{
    const double *white = of->sight.white;
    const int n = of->cube.image.n_pages;
    for (int channel = 0; channel < 3; channel++) {
        if (!(white[channel] > 0))
            return error_usage(err,
                               "channel %d of %s responds to the white with %.6g, and cannot be"
                               " divided by that; expected a white that all three channels see",
                               channel + 1, of->sight.detector.name, white[channel]);
        for (int i = 0; i < n; i++)
            of->sight.weights[channel * n + i] /= white[channel];
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
    struct sight *sight = &of->sight;
    double m[3][3];
    if (adaptation->kind == ADAPTATION_FAIRCHILD && !(adaptation->luminance > 0))
        adaptation->luminance = of->cube.record.unit
                                    ? (recorded > 0 ? recorded : 1) * sight->white[1]
                                    : 10 * (recorded > 0 ? recorded : 1);
    if (!adaptation_matrix(adaptation, sight->white, sight->equal, m, err))
        return false;
    tristimulus_apply_all(m, n, sight->weights);
    tristimulus_apply(m, sight->white, of->adapted_white);
    if (of->values == DEVELOP_RGB) {
        memcpy(m, of->display.matrix, sizeof m);
        tristimulus_apply_all(m, n, sight->weights);
    }
    return true;
}

bool develop_weights(struct development *of, struct error *err)
{
    const bool raw = of->values == DEVELOP_RAW, components = of->cube.components;
    const struct image *image = &of->cube.image;
    const double *cells = of->cube.record.range_nm.value, half_cell = 0.5;
    /* The result reports a recorded white even where none is needed. */
    const struct seeing by =
        seeing_of(of->options, of->adaptation.kind != ADAPTATION_NONE || of->values == DEVELOP_LAB);
    if ((raw && !cube_needs_radiance(&of->cube, "--raw", err)) ||
        !sight_make(&of->cube, raw ? SIGHT_OF_CHANNELS : SIGHT_OF_PICTURE, &by, &of->sight, err))
        return false;
    of->first_nm = components ? cells[0] + half_cell : image->wavelengths_nm[0];
    of->last_nm = components ? cells[1] - half_cell : image->wavelengths_nm[image->n_pages - 1];
    return check_detector(of, err) &&
           (raw || (of->sight.observes ? adapt(of, err) : balance(of, err)));
}
