/* SPDX-License-Identifier: MIT */
/* Surfaces of a plan in the window, lit where light is needed. */
#include <stdlib.h>

#include "data/threads/threads.h"
#include "raster/refine/refine.h"

/* Vertices that a thread takes at a time. */
enum { BLOCK_VERTICES = 256 };

struct lighting {
    const struct view *view;
    struct surface *surface;
    const unsigned char *wanted; /* of each vertex; NULL: all */
};

static void light_block(void *context, size_t first, size_t end)
{
    const struct lighting *of = context;
    struct light_work ignored = {0};
    for (size_t i = first; i < end; i++)
        if (!of->wanted || of->wanted[i])
            surface_light(of->view, of->surface, (int)i, &ignored);
}

void light_vertices(const struct plan *plan, const struct view *view, struct surface *surface,
                    const unsigned char *wanted)
{
    struct lighting of = {view, surface, wanted};
    threads_blocks(plan->options.threads, (size_t)surface->instance->n_vertices, BLOCK_VERTICES,
                   light_block, &of);
}

void surfaces_close(struct surface *surfaces, int n)
{
    for (int i = 0; surfaces && i < n; i++)
        surface_close(&surfaces[i]);
    free(surfaces);
}

struct surface *surfaces_place(const struct plan *plan, struct error *err)
{
    struct surface *out = calloc((size_t)plan->n_instances + 1, sizeof *out);
    struct view unlit = plan->view;
    bool done = out != NULL;
    unlit.n_lights = 0;
    for (int i = 0; done && i < plan->n_instances; i++) {
        if (!plan->instances[i].in_view)
            continue;
        done = surface_open(&plan->instances[i].instance, &out[i]);
        if (done)
            light_vertices(plan, &unlit, &out[i], NULL);
    }
    if (done)
        return out;
    surfaces_close(out, plan->n_instances);
    error_memory(err);
    return NULL;
}
