/* SPDX-License-Identifier: MIT */
/* All measurements, one after the other. */

#include "raster/beside/measure/inside.h"

bool traits_measure(struct contexts *contexts, struct traits *out, struct error *err)
{
    struct target *target;
    *out = (struct traits){.subpixel_bits = 0};
    bool done = target_open(contexts, &target, err);
    if (done) {
        target->call->GetIntegerv(GL_SUBPIXEL_BITS, &out->subpixel_bits);
        out->depth_bits = 24; /* those of the buffer that canvas_open makes */
        if (target->way == GL_WITHOUT_SHADERS)
            target->call->GetIntegerv(GL_DEPTH_BITS, &out->depth_bits);
        measure_coverage(target, out);
        measure_values(target, out);
        measure_lighting(target, out);
        done = measure_passes(target, out, err);
        const GLenum code = target->call->GetError();
        if (done && code != GL_NO_ERROR)
            done = error_failed(err, "OpenGL reports error 0x%04x on small targets", code);
    }
    target_close(target);
    return done;
}

bool driver_measure(struct contexts *contexts, const char *gl_renderer, struct driver *out,
                    struct error *err)
{
    struct canvas *in_use = contexts->current;
    struct traits traits;
    char reason[TRAITS_REASON];
    return traits_measure(contexts, &traits, err) && canvas_use(in_use, in_use->pixels, err) &&
           (traits_profile(&traits, out, reason) ||
            error_unsupported(err,
                              "%s cannot be checked: %s; spectral drivers --measure prints more",
                              gl_renderer, reason));
}
