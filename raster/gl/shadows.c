/* SPDX-License-Identifier: MIT */
/* Shadows: the stencil buffer counts, for each pixel, the volumes that contain its surface. A side
 * of a volume counts where it lies behind the surface: up where its back is seen, down where its
 * front is (Everitt and Kilgard 2002). A cap has the depth of the surface that it repeats, which is
 * not less: it counts as behind. So a surface that faces its light is not in its own volume. */
#include "raster/gl/inside.h"

bool shadows_can_draw(const struct drawing *of, struct error *err)
{
    static const char *const clamps[] = {[GL_WITHOUT_SHADERS] = "GL_ARB_depth_clamp",
                                         [GL_CORE] = "GL_ARB_depth_clamp",
                                         [GL_ES] = "GL_EXT_depth_clamp"};
    const char *needed = clamps[of->contexts->way];
    if (of->contexts->way == GL_ES && !contexts_have(of->contexts, "GL_NV_read_depth_stencil"))
        needed = "GL_NV_read_depth_stencil";
    return of->plan->view.n_shadowed == 0 || contexts_have(of->contexts, needed) ||
           error_unsupported(err,
                             "%s draws no shadows, which need %s; --renderer raster draws them "
                             "without OpenGL",
                             of->contexts->kind->name, needed);
}

/* Counts the faces of triangles that are turned outward, or inward. */
static void count_faces(const struct drawing *of, bool outward)
{
    of->call->StencilOpSeparate(outward ? GL_BACK : GL_FRONT, GL_KEEP, GL_INCR_WRAP, GL_KEEP);
    of->call->StencilOpSeparate(outward ? GL_FRONT : GL_BACK, GL_KEEP, GL_DECR_WRAP, GL_KEEP);
}

/* Draws triangles of a volume, without numbers; `corners` has room for a batch. */
static void draw_triangles(struct drawing *of, const struct volume *volume, int first, int n,
                           struct numbered_vertex *corners)
{
    for (; n > 0; first += BATCH, n -= BATCH) {
        const int now = n < BATCH ? n : BATCH;
        volume_corners(volume, first, now, sizeof *corners / sizeof(float), (float *)corners);
        of->kind->draw_corners(of, corners, 3 * now);
        of->renderer.work.draw_calls++;
    }
}

static void draw_volume(struct drawing *of, const struct volume *volume,
                        struct numbered_vertex *corners)
{
    const struct placed_instance *placed = &of->plan->instances[volume->instance];
    const int n_inward = volume->n - volume->n_outward, n_caps = volume->n_caps;
    turn_fronts(of, placed->instance.mirrored);
    of->kind->place(of, volume->instance);
    count_faces(of, true);
    draw_triangles(of, volume, n_caps, volume->n_outward - n_caps, corners);
    of->call->Disable(GL_DEPTH_CLAMP);
    draw_triangles(of, volume, 0, n_caps, corners);
    count_faces(of, false);
    draw_triangles(of, volume, volume->n_outward, n_inward, corners);
    of->call->Enable(GL_DEPTH_CLAMP);
}

/* Reads where the count of a light is 0, and clears it. */
static void read_reached(struct drawing *of, int shadowed)
{
    const int width = of->plan->tile_width, height = of->plan->tile_height;
    const size_t n = (size_t)width * (size_t)height;
    uint8_t *reached = of->reached + (size_t)shadowed * n;
    of->call->ReadPixels(0, 0, width, height, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, of->counts);
    for (int y = 0; y < height; y++) {
        const uint32_t *row =
            of->counts + (size_t)(of->contexts->kind->flipped ? y : height - 1 - y) * (size_t)width;
        for (int x = 0; x < width; x++)
            if ((row[x] & 0xff) != 0)
                reached[(size_t)y * (size_t)width + (size_t)x] = 0;
    }
    of->call->Clear(GL_STENCIL_BUFFER_BIT);
}

/* Counts the volumes of a light, some at a time: 8 bits count to 255. A surface lies in no more
 * volumes than there are caps. A volume with more caps has no ray that meets so many: see may_wrap
 * in raster/volumes. */
static void count_volumes(struct drawing *of, int shadowed, struct numbered_vertex *corners)
{
    const struct volumes *volumes = of->lit->volumes;
    const size_t n = (size_t)of->plan->tile_width * (size_t)of->plan->tile_height;
    int n_caps = 0;
    memset(of->reached + (size_t)shadowed * n, 1, n);
    of->call->Clear(GL_STENCIL_BUFFER_BIT);
    for (int i = 0; i < volumes->n; i++) {
        const struct volume *volume = &volumes->list[i];
        const int more = volume->n_caps + volume->n - volume->n_outward;
        if (volume->shadowed != shadowed || !surface_reaches(&volumes->lit.bounds[i], &of->tile))
            continue;
        if (n_caps > 0 && n_caps + more > UINT8_MAX) {
            read_reached(of, shadowed);
            n_caps = 0;
        }
        draw_volume(of, volume, corners);
        n_caps += more;
    }
    read_reached(of, shadowed);
}

bool shadows_draw(struct drawing *of, struct error *err)
{
    const struct gl_functions *call = of->call;
    struct numbered_vertex *corners;
    call->Clear(GL_DEPTH_BUFFER_BIT);
    call->ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    const bool done =
        MAKE_ARRAY(corners, 3 * BATCH, err, "the corners of a shadow") && numbers_draw(of, err);
    call->DepthMask(GL_FALSE);
    call->Enable(GL_DEPTH_CLAMP);
    call->Enable(GL_STENCIL_TEST);
    for (int i = 0; done && i < of->plan->view.n_shadowed; i++)
        count_volumes(of, i, corners);
    call->Disable(GL_STENCIL_TEST);
    call->Disable(GL_DEPTH_CLAMP);
    call->DepthMask(GL_TRUE);
    call->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    call->StencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP);
    free(corners);
    of->has_shadows = done;
    return done;
}

const uint8_t *shadows_of(const struct drawing *of, int group)
{
    const int shadowed = light_group(of->plan, group).shadowed;
    return shadowed < 0 ? NULL
                        : of->reached + (size_t)shadowed * (size_t)of->plan->tile_width *
                                            (size_t)of->plan->tile_height;
}
