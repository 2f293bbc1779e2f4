/* SPDX-License-Identifier: MIT */
/* Lists the work that a scene does not call for, each with the reason why it is left out. */
#include "raster/notes/notes.h"
#include "raster/passes/passes.h"

static void add(struct left_out_list *to, const char *what, long n, long of, const char *reason)
{
    struct left_out *added = &to->list[to->n];
    if (n == 0)
        return;
    *added = (struct left_out){.what = what, .n = n, .of = of};
    snprintf(added->reason, sizeof added->reason, "%s", reason);
    to->n++;
}

/* Instances whose vertices may decide the full scale are lit; those of others are only placed. */
static void add_instances(const struct plan *plan, struct left_out_list *to)
{
    static const char *const where[VIEW_PLANES] = {
        [VIEW_LEFT] = "left of the view",      [VIEW_RIGHT] = "right of the view",
        [VIEW_BELOW] = "below the view",       [VIEW_ABOVE] = "above the view",
        [VIEW_NEAR] = "before the near plane", [VIEW_FAR] = "beyond the far plane"};
    long n[VIEW_PLANES] = {0};
    bool is_lit = false;
    char reason[LEFT_OUT_REASON];
    for (int i = 0; i < plan->n_instances; i++)
        if (!plan->instances[i].in_view) {
            n[plan->instances[i].outside]++;
            is_lit = instance_is_lit(plan, &plan->instances[i]);
        }
    for (int plane = 0; plane < VIEW_PLANES; plane++) {
        snprintf(reason, sizeof reason, "%s; %s", where[plane],
                 is_lit ? "lit all the same, since a vertex may decide the full scale" : "not lit");
        add(to, "instances", n[plane], plan->n_instances, reason);
    }
}

static void add_lights(const struct plan *plan, struct left_out_list *to)
{
    int idle_groups = 0;
    for (int group = 0; group < plan->n_light_groups; group++)
        idle_groups += !group_is_drawn(plan, group);
    add(to, "lights", plan->work.idle_lights, plan->n_lights, "they reach no object in view");
    add(to, "groups of lights", idle_groups, plan->n_light_groups,
        "no light of theirs reaches an object in view");
}

static void add_textures(const struct plan *plan, struct left_out_list *to)
{
    long unseen = 0, alike = 0;
    for (int i = 0; i < plan->n_textures; i++) {
        unseen += !plan->shows_texture[i];
        alike += plan->shows_texture[i] && !texture_is_drawn(plan, &plan->textures[i]);
    }
    add(to, "textures", unseen, plan->n_textures, "only objects out of view have them");
    add(to, "textures", alike, plan->n_textures,
        "all of their texels have one value, which multiplies colours without rounding");
}

bool left_out_make(const struct plan *plan, struct left_out_list *out, struct error *err)
{
    struct passes passes;
    const bool done = passes_make(plan, &passes, err);
    *out = (struct left_out_list){.n = 0};
    if (done) {
        for (int group = 0; group < plan->n_light_groups; group++)
            out->drawn_passes += group_is_drawn(plan, group) ? passes.n_frames : 0;
        add_instances(plan, out);
        add_lights(plan, out);
        add_textures(plan, out);
        add(out, "passes", passes.n_dark, plan->n_passes,
            "nothing in view has light in their bands");
        add(out, "passes", plan->n_passes - passes.n_dark - passes.n_frames, plan->n_passes,
            "they show the same as the pass before");
    }
    passes_free(&passes);
    return done;
}
