/* SPDX-License-Identifier: MIT */
/* The plan's lights: where they stand in eye space, and which of them light anything. */
#include <stdlib.h>

#include "plan.h"

static struct plan_light plan_light(const struct plan *plan, const struct shining_light *shining)
{
    const struct light *light = shining->light;
    struct plan_light out = {.light = light, .first = shining->first, .share = shining->share};
    const double *k = light->attenuation;
    if (light->directional) {
        struct vector towards = vector_normalise(light->position);
        out.eye_position = vector_normalise(matrix_direction(&plan->view, towards));
        return out;
    }
    out.eye_position = matrix_point(&plan->view, light->position);
    for (int i = 0; i < 3; i++)
        out.attenuation[i] = k[i] * (i > 0 ? plan->unit : 1) * (i > 1 ? plan->unit : 1);
    out.attenuated = k[0] != 1 || k[1] != 0 || k[2] != 0;
    out.spot = light->spot && light->spot_cutoff_deg <= 90;
    if (out.spot) {
        double sine;
        struct vector axis = vector_normalise(light->spot_direction);
        out.eye_spot = vector_normalise(matrix_direction(&plan->view, axis));
        sine_cosine(light->spot_cutoff_deg, &sine, &out.spot_cosine);
    }
    return out;
}

/* Whether OpenGL can take a light's distances and their squares in single precision. */
static bool check_light(const struct plan_light *light, struct error *err)
{
    const double *k = light->attenuation;
    if (light->light->directional)
        return true;
    if (!(vector_length(light->eye_position) < FARTHEST))
        return error_at(err, light->light->place,
                        "this light is too far away for single precision; give it a direction");
    for (int i = 0; i < 3; i++)
        if (!(k[i] < 1e18))
            return error_at(err, light->light->attenuation_place,
                            "attenuation %g is too strong for single precision, beside the "
                            "picture's size",
                            light->light->attenuation[i]);
    return true;
}

bool lights_list(struct plan *plan, struct error *err)
{
    const struct illumination *illumination = &plan->illumination;
    plan->lights = calloc((size_t)illumination->n_lights + 1, sizeof *plan->lights);
    if (!plan->lights)
        return error_memory(err);
    for (; plan->n_lights < illumination->n_lights; plan->n_lights++) {
        struct plan_light *light = &plan->lights[plan->n_lights];
        *light = plan_light(plan, &illumination->lights[plan->n_lights]);
        if (!check_light(light, err))
            return false;
    }
    return true;
}

/* Gives the terms of a light another number; whether there are any. */
static bool renumber_terms(struct plan *plan, int from, int to)
{
    bool any = false;
    for (int f = 0; f < plan->n_finishes; f++)
        for (int t = 0; t < plan->finishes[f].n_terms; t++) {
            struct term *term = &plan->finishes[f].terms[t];
            if (term->light != from)
                continue;
            term->light = to;
            any = true;
        }
    return any;
}

/* Lights that share a spectrum are kept or dropped together. */
bool lights_drop_idle(struct plan *plan, struct error *err)
{
    if (plan->options.exchangeable)
        return true;
    int *number = calloc((size_t)plan->n_lights + 1, sizeof *number); /* new one; -1: dropped */
    if (!number)
        return error_memory(err);
    int n = 0;
    for (int i = 0; i < plan->n_lights; i++) {
        struct plan_light light = plan->lights[i];
        bool kept = light.first == i ? renumber_terms(plan, i, n) : number[light.first] >= 0;
        number[i] = kept ? n : -1;
        light.first = number[light.first];
        if (kept)
            plan->lights[n++] = light;
    }
    free(number);
    plan->n_lights = n;
    return true;
}
