/* SPDX-License-Identifier: MIT */
/* OSMesa's contexts and the buffers that they draw into: floats, or counts of 8 or 16 bits. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <GL/osmesa.h>

#include "raster/gl/gl.h"

/* ---- the driver ---- */

static const char *renderer(void)
{
    return (const char *)glGetString(GL_RENDERER);
}

struct gl_names gl_names(const struct gl *gl)
{
    struct gl_names names;
    (void)gl; /* the current context is this one's */
    snprintf(names.renderer, sizeof names.renderer, "%s", renderer());
    snprintf(names.version, sizeof names.version, "%s", (const char *)glGetString(GL_VERSION));
    return names;
}

bool gl_is_built(void)
{
    return true;
}

#ifdef OSMESA_VERSION /* built in; asking a context of softpipe would take tens of milliseconds */
void gl_library(char *out, size_t capacity)
{
    snprintf(out, capacity, "OSMesa " OSMESA_VERSION " (softpipe), built in");
}
#else
void gl_library(char *out, size_t capacity)
{
    GLfloat pixel[4];
    OSMesaContext context = OSMesaCreateContext(OSMESA_RGBA, NULL);
    if (context && OSMesaMakeCurrent(context, pixel, GL_FLOAT, 1, 1))
        snprintf(out, capacity, "OSMesa %s (%s)", (const char *)glGetString(GL_VERSION),
                 renderer());
    else
        snprintf(out, capacity, "OSMesa gives no context");
    if (context)
        OSMesaDestroyContext(context);
}
#endif

/* The driver that draws is the wanted one, which was chosen before the first context. */
static bool check_driver(const struct gl *gl, struct error *err)
{
    const char *wanted = gl->plan->options.gl_driver;
    return !wanted || strncmp(renderer(), wanted, strlen(wanted)) == 0 ||
           error_unsupported(err,
                             "this OSMesa draws with %.100s, not with %s; --renderer gl takes any "
                             "driver",
                             renderer(), wanted);
}

/* ---- contexts ---- */

static bool check_context(const struct plan *plan, int needed_bits, struct error *err)
{
    GLint red_bits = 0, depth_bits = 0, stencil_bits = 0, viewport[2] = {0, 0};
    glGetIntegerv(GL_RED_BITS, &red_bits);
    glGetIntegerv(GL_DEPTH_BITS, &depth_bits);
    glGetIntegerv(GL_STENCIL_BITS, &stencil_bits);
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    if (red_bits != needed_bits || depth_bits < 24 || stencil_bits < 8)
        return error_unsupported(
            err,
            "OSMesa gives %d bits of colour, %d of depth and %d of stencil; %d, 24 "
            "and 8 are needed",
            red_bits, depth_bits, stencil_bits, needed_bits);
    return (viewport[0] >= plan->tile_width && viewport[1] >= plan->tile_height) ||
           error_unsupported(err, "OSMesa draws at most %d x %d pixels at once", viewport[0],
                             viewport[1]);
}

/* Each type of buffer has a context of its own. One context for both would work, but OSMesa of Mesa
 * 22.3.6 would make new buffers at every change, and keep the old ones. */
bool gl_draw_into(struct gl *gl, float *floats, bool numbers, struct error *err)
{
    const struct plan *plan = gl->plan;
    const int bits = floats ? 32 : plan->options.buffer_bits;
    OSMesaContext context = numbers && gl->numbers ? gl->numbers : gl->context;
    GLenum type = bits == 32 ? GL_FLOAT : bits == 16 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_BYTE;
    if (!OSMesaMakeCurrent(context, floats ? floats : gl->steps, type, plan->tile_width,
                           plan->tile_height))
        return error_system(err, "OSMesa gives no context of %d x %d pixels of %d bits a channel",
                            plan->tile_width, plan->tile_height, bits);
    if (gl->current == context)
        return true;
    gl->current = context;
    OSMesaPixelStore(OSMESA_Y_UP, 0); /* first row on top, as in the picture */
    if (gl->lit)
        gl_load_view(gl);
    return check_context(plan, bits, err);
}

void gl_clear_stale(struct gl *gl)
{
    bool *is_stale = &gl->is_stale[gl->current != gl->context];
    if (*is_stale)
        gl_blacken(gl);
    *is_stale = false;
}

static bool allocate(struct gl *gl, int n_buffers, struct error *err)
{
    const struct plan *plan = gl->plan;
    const size_t n = (size_t)plan->tile_width * (size_t)plan->tile_height,
                 pixel = 4 * sizeof(float);
    const bool adding = plan->n_light_groups > 1, stepping = buffer_steps(plan) > 0,
               checking = plan->options.check;
    bool done = true;
    for (int i = 0; i < n_buffers && done; i++)
        done = (gl->buffers[i] = calloc(n, pixel)) != NULL;
    gl->part = adding ? calloc(n, pixel) : NULL;
    gl->shown = checking ? calloc(n, pixel) : NULL;
    gl->steps = stepping ? calloc(n, 4 * (size_t)plan->options.buffer_bits / 8) : NULL;
    gl->depths = checking ? calloc(n, sizeof *gl->depths) : NULL;
    return (done && (gl->part || !adding) && (gl->steps || !stepping) &&
            ((gl->shown && gl->depths) || !checking)) ||
           error_memory(err);
}

#ifdef OSMESA_VERSION /* built in; Mesa crashes when asked for another driver */
static const char *const only_driver = "softpipe";
#else
static const char *const only_driver = NULL;
#endif

/* Colours are RGBA; 24 bits of depth, 8 of stencil, none of accumulation. */
static OSMesaContext create_context(void)
{
    return OSMesaCreateContextExt(OSMESA_RGBA, 24, 8, 0, NULL);
}

static bool open_context(struct gl *gl, int n_buffers, struct error *err)
{
    const struct plan *plan = gl->plan;
    const char *driver = only_driver ? only_driver : plan->options.gl_driver;
    struct driver_threads before;
    char threads[16];
    if (!allocate(gl, n_buffers, err))
        return false;
    driver_count_threads(&before);
    snprintf(threads, sizeof threads, "%d", plan->options.threads);
    setenv("LP_NUM_THREADS", threads, 0); /* for llvmpipe; a user's own configuration stands */
    if (driver)
        setenv("GALLIUM_DRIVER", driver, 1);
    gl->context = create_context();
    if (gl->steps && plan->options.check)
        gl->numbers = create_context();
    if (!gl->context || (gl->steps && plan->options.check && !gl->numbers))
        return error_system(err, "OSMesa gives no context");
    return gl_draw_into(gl, gl->steps ? NULL : gl->buffers[0], false, err) &&
           check_driver(gl, err) && driver_has_threads(renderer(), &before, err);
}

bool gl_succeeded(struct error *err)
{
    GLenum code = glGetError();
    return code == GL_NO_ERROR || error_system(err, "OpenGL reports error 0x%04x", code);
}

bool gl_open(const struct plan *plan, int n_buffers, struct gl **out, struct error *err)
{
    struct gl *gl = calloc(1, sizeof *gl);
    *out = gl;
    if (!gl)
        return error_memory(err);
    gl->plan = plan;
    gl->group = -1;
    gl->gloss = -1;
    if (!open_context(gl, n_buffers, err))
        return false;
    gl_set_state(gl);
    if (gl->numbers) {
        if (!gl_succeeded(err) || !gl_draw_into(gl, gl->shown, true, err))
            return false;
        gl_set_state(gl);
        return gl_succeeded(err) && gl_draw_into(gl, NULL, false, err); /* for uploads */
    }
    return gl_succeeded(err);
}

void gl_close(struct gl *gl)
{
    if (!gl)
        return;
    if (gl->numbers)
        OSMesaDestroyContext(gl->numbers);
    if (gl->context)
        OSMesaDestroyContext(gl->context);
    for (int i = 0; i < MOST_BUFFERS; i++)
        free(gl->buffers[i]);
    free(gl->objects);
    free(gl->textures);
    free(gl->indices);
    free(gl->part);
    free(gl->shown);
    free(gl->steps);
    free(gl->depths);
    free(gl);
}
