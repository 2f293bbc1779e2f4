/* SPDX-License-Identifier: MIT */
/* The plan's lights: where they stand in eye space, and which of them light anything. */
#include "raster/plan/inside.h"

/* Distances in eye space are below this: their squares are numbers in single precision. */
static const double farthest = 1e18;

static struct eye_light place_light(const struct plan *plan, const struct shining_light *shining)
{
    const struct light *light = shining->light;
    struct eye_light out = {
        .directional = light->directional, .first = shining->first, .share = shining->share};
    const double *k = light->attenuation;
    if (light->directional) {
        struct vector towards = vector_normalise(light->position);
        out.position = vector_normalise(matrix_direction(&plan->world_to_eye, towards));
        return out;
    }
    out.position = matrix_point(&plan->world_to_eye, light->position);
    for (int i = 0; i < 3; i++)
        out.attenuation[i] = k[i] * (i > 0 ? plan->unit : 1) * (i > 1 ? plan->unit : 1);
    out.attenuated = k[0] != 1 || k[1] != 0 || k[2] != 0;
    out.spot = light->spot && light->spot_cutoff_deg <= 90;
    if (out.spot) {
        double sine;
        struct vector axis = vector_normalise(light->spot_direction);
        out.axis = vector_normalise(matrix_direction(&plan->world_to_eye, axis));
        out.spot_exponent = light->spot_exponent;
        sine_cosine(light->spot_cutoff_deg, &sine, &out.cutoff_cosine);
    }
    return out;
}

/* Refuses a light unless OpenGL can take its distances and their squares in single precision. */
static bool check_light(const struct eye_light *placed, const struct light *light,
                        struct error *err)
{
    const double *k = placed->attenuation;
    if (light->directional)
        return true;
    if (!(vector_length(placed->position) < farthest))
        return error_at(err, light->place,
                        "this light is too far away for single precision; give it a direction");
    for (int i = 0; i < 3; i++)
        if (!(k[i] < 1e18))
            return error_at(err, light->attenuation_place,
                            "attenuation %g is too strong for single precision, beside the "
                            "picture's size",
                            light->attenuation[i]);
    return true;
}

/* Lights that share a spectrum are kept or left out together. Exchangeable ones are all kept. */
bool lights_list(struct plan *plan, struct error *err)
{
    const struct illumination *illumination = &plan->illumination;
    const int n = illumination->n_lights;
    bool *used;
    bool done = MAKE_ARRAY(used, n, err, "%d lights", n) &&
                MAKE_ARRAY(plan->lights, n, err, "%d lights", n) &&
                MAKE_ARRAY(plan->sources, n, err, "%d lights", n);
    for (int m = 0; m < plan->n_materials && done; m++)
        for (int t = 0; t < plan->materials[m].n_terms; t++)
            if (plan->materials[m].terms[t].light >= 0)
                used[plan->materials[m].terms[t].light] = true;
    for (int i = 0; i < n && done; i++) {
        const struct shining_light *shining = &illumination->lights[i];
        const struct eye_light light = place_light(plan, shining);
        done = check_light(&light, shining->light, err);
        if (used[light.first] || plan->options.exchangeable) {
            plan->lights[plan->n_lights] = light;
            plan->sources[plan->n_lights++] = shining->light;
        }
    }
    free(used);
    return done;
}
