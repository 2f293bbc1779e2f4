/* SPDX-License-Identifier: MIT */
/* Lists the work that a scene does not call for, each with the reason why it is left out. */
#include "raster/plan/inside.h"

static void put(struct json *json, const char *what, long n, long of, const char *reason)
{
    if (n == 0)
        return;
    json_open(json, NULL, '{');
    json_string(json, "what", what);
    json_count(json, "count", (uint64_t)n);
    json_count(json, "of", (uint64_t)of);
    json_string(json, "reason", reason);
    json_close(json, '}');
}

/* Instances whose vertices may decide the full scale are lit; those of others are only placed. */
static void put_instances(struct json *json, const struct plan *plan)
{
    static const char *const where[VIEW_PLANES] = {
        [VIEW_LEFT] = "left of the view",      [VIEW_RIGHT] = "right of the view",
        [VIEW_BELOW] = "below the view",       [VIEW_ABOVE] = "above the view",
        [VIEW_NEAR] = "before the near plane", [VIEW_FAR] = "beyond the far plane"};
    long n[VIEW_PLANES] = {0};
    bool is_lit = false;
    char reason[128];
    for (int i = 0; i < plan->n_instances; i++)
        if (!plan->instances[i].in_view) {
            n[plan->instances[i].outside]++;
            is_lit = instance_is_lit(plan, &plan->instances[i]);
        }
    for (int plane = 0; plane < VIEW_PLANES; plane++) {
        snprintf(reason, sizeof reason, "%s; %s", where[plane],
                 is_lit ? "lit all the same, since a vertex may decide the full scale" : "not lit");
        put(json, "instances", n[plane], plan->n_instances, reason);
    }
}

static void put_lights(struct json *json, const struct plan *plan)
{
    int idle_groups = 0;
    for (int group = 0; group < plan->n_light_groups; group++)
        idle_groups += !group_is_drawn(plan, group);
    put(json, "lights", plan->work.idle_lights, plan->n_lights, "they reach no object in view");
    put(json, "groups of lights", idle_groups, plan->n_light_groups,
        "no light of theirs reaches an object in view");
}

static void put_textures(struct json *json, const struct plan *plan)
{
    long unseen = 0, alike = 0;
    for (int i = 0; i < plan->n_textures; i++) {
        unseen += !plan->shows_texture[i];
        alike += plan->shows_texture[i] && !texture_is_drawn(plan, &plan->textures[i]);
    }
    put(json, "textures", unseen, plan->n_textures, "only objects out of view have them");
    put(json, "textures", alike, plan->n_textures,
        "all of their texels have one value, which multiplies colours without rounding");
}

void left_out_put(const struct plan *plan, const struct passes *passes, struct json *json)
{
    json_open(json, "left_out", '[');
    put_instances(json, plan);
    put_lights(json, plan);
    put_textures(json, plan);
    put(json, "passes", passes->n_dark, plan->n_passes, "nothing in view has light in their bands");
    put(json, "passes", plan->n_passes - passes->n_dark - passes->n_frames, plan->n_passes,
        "they show the same as the pass before");
    json_close(json, ']');
}
