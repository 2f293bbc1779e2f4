/* SPDX-License-Identifier: MIT */
/* The texels of a pass: the planes of three bands, side by side. */
#include <stdlib.h>

#include "raster/plan/plan.h"

bool pass_texels(const struct plan *plan, struct texture *texture, int first_band, float *out,
                 struct error *err)
{
    const size_t n = (size_t)texture->image.width * (size_t)texture->image.height;
    const int left = plan->n_bands - first_band;
    float *planes;
    if (!MAKE_ARRAY(planes, BANDS_PER_PASS * n, err, "the texels of %s", texture->image.path))
        return false;
    float *const rooms[BANDS_PER_PASS] = {planes, planes + n, planes + 2 * n};
    const bool done = texture_fill(texture, plan->scene->wavelengths_nm + first_band,
                                   left < BANDS_PER_PASS ? left : BANDS_PER_PASS, rooms, err);
    for (size_t i = 0; i < n && done; i++)
        for (size_t c = 0; c < BANDS_PER_PASS; c++)
            out[BANDS_PER_PASS * i + c] = rooms[c][i];
    free(planes);
    return done;
}
