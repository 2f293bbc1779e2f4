/* SPDX-License-Identifier: MIT */
/* OSMesa's contexts and the buffers that they draw into: floats, or counts of 8 or 16 bits. */
#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <GL/osmesa.h>

#include "raster/gl/gl.h"

/* ---- the driver ---- */

const char *gl_renderer(const struct gl *gl)
{
    (void)gl; /* the current context is this one's */
    return (const char *)glGetString(GL_RENDERER);
}

const char *gl_version(const struct gl *gl)
{
    (void)gl;
    return (const char *)glGetString(GL_VERSION);
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
                 (const char *)glGetString(GL_RENDERER));
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
    return !wanted || strncmp(gl_renderer(gl), wanted, strlen(wanted)) == 0 ||
           error_unsupported(err,
                             "this OSMesa draws with %.100s, not with %s; --renderer gl takes any "
                             "driver",
                             gl_renderer(gl), wanted);
}

/* ---- the threads of llvmpipe ---- */

enum { THREAD_NAME = 16 }; /* Linux cuts names of threads to 15 characters */

/* Threads of this process: of llvmpipe, and those that have this thread's name, which a new thread
 * has until it takes its own. */
struct threads {
    long of_llvmpipe, unnamed;
};

static void read_name(const char *task, char out[THREAD_NAME])
{
    char path[64];
    int file;
    memset(out, 0, THREAD_NAME);
    snprintf(path, sizeof path, "/proc/self/task/%.16s/comm", task);
    UNTIL_DONE(file, open(path, O_RDONLY | O_CLOEXEC));
    if (file < 0)
        return;
    read_at(file, out, THREAD_NAME - 1, 0);
    close(file);
}

/* Returns false where they cannot be counted. */
static bool count_threads(struct threads *out)
{
    static const char prefix[] = "llvmpipe-";
    char own[THREAD_NAME], name[THREAD_NAME], self[24];
    DIR *tasks = opendir("/proc/self/task");
    *out = (struct threads){0, 0};
    if (!tasks)
        return false;
    snprintf(self, sizeof self, "%ld", (long)getpid());
    read_name(self, own);
    for (const struct dirent *task; (task = readdir(tasks));) {
        read_name(task->d_name, name);
        out->of_llvmpipe += strncmp(name, prefix, strlen(prefix)) == 0;
        out->unnamed += name[0] != '\0' && strcmp(name, own) == 0;
    }
    closedir(tasks);
    return true;
}

/* Where the system gives llvmpipe fewer threads than it asks for, Mesa 22.3.6 goes on, and then
 * waits for ever: its fences count the threads that were asked for (lp_fence_create in lp_setup.c).
 * A new thread may take a moment to name itself; as many threads for compute shaders never do.
 * `before`: before the first context. */
static bool has_threads(const struct gl *gl, const struct threads *before, struct error *err)
{
    const struct timespec pause = {0, 2000000};
    const int patience = 1000, most = 5000; /* pauses: without, and with a thread that is new */
    const char *wanted = getenv("LP_NUM_THREADS");
    const long asked = wanted ? strtol(wanted, NULL, 10) : 0;
    struct threads now = {0, 0};
    if (strncmp(gl_renderer(gl), "llvmpipe", strlen("llvmpipe")) != 0)
        return true;
    for (int i = 0; i < (now.unnamed - before->unnamed > asked ? most : patience); i++) {
        /* llvmpipe has at most 16 threads, in later versions of Mesa at most 32 (LP_MAX_THREADS) */
        if (!count_threads(&now) || now.of_llvmpipe >= asked || now.of_llvmpipe == 16 ||
            now.of_llvmpipe == 32)
            return true;
        nanosleep(&pause, NULL);
    }
    errno = 0;
    return error_system(err, "OpenGL has started %ld of its %ld threads", now.of_llvmpipe, asked);
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
bool gl_draw_into(struct gl *gl, bool floats, struct error *err)
{
    const struct plan *plan = gl->plan;
    int bits = floats || !gl->steps ? 32 : plan->options.buffer_bits;
    OSMesaContext context = floats && gl->numbers ? gl->numbers : gl->context;
    void *buffer = bits == 32 ? gl->pixels : gl->steps;
    GLenum type = bits == 32 ? GL_FLOAT : bits == 16 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_BYTE;
    if (gl->current == buffer)
        return true;
    if (!OSMesaMakeCurrent(context, buffer, type, plan->tile_width, plan->tile_height))
        return error_system(err, "OSMesa gives no context of %d x %d pixels of %d bits a channel",
                            plan->tile_width, plan->tile_height, bits);
    gl->current = buffer;
    OSMesaPixelStore(OSMESA_Y_UP, 0); /* first row on top, as in the picture */
    if (gl->lit)
        gl_load_view(gl);
    return check_context(plan, bits, err);
}

static bool allocate(struct gl *gl, struct error *err)
{
    const struct plan *plan = gl->plan;
    size_t n_pixels = (size_t)plan->tile_width * (size_t)plan->tile_height;
    bool adding = plan->n_light_groups > 1, stepping = buffer_steps(plan) > 0;
    gl->pixels = calloc(n_pixels, 4 * sizeof *gl->pixels);
    gl->steps = stepping ? calloc(n_pixels, 4 * (size_t)plan->options.buffer_bits / 8) : NULL;
    gl->sum = adding ? calloc(n_pixels, 4 * sizeof *gl->sum) : NULL;
    gl->depths = plan->options.check ? calloc(n_pixels, sizeof *gl->depths) : NULL;
    return (gl->pixels && (gl->steps || !stepping) && (gl->sum || !adding) &&
            (gl->depths || !plan->options.check)) ||
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

static bool open_context(struct gl *gl, struct error *err)
{
    const struct plan *plan = gl->plan;
    const char *driver = only_driver ? only_driver : plan->options.gl_driver;
    struct threads before;
    char threads[16];
    if (!allocate(gl, err))
        return false;
    count_threads(&before);
    snprintf(threads, sizeof threads, "%d", plan->options.threads);
    setenv("LP_NUM_THREADS", threads, 0); /* for llvmpipe; a user's own configuration stands */
    if (driver)
        setenv("GALLIUM_DRIVER", driver, 1);
    gl->context = create_context();
    if (gl->steps && plan->options.check)
        gl->numbers = create_context();
    if (!gl->context || (gl->steps && plan->options.check && !gl->numbers))
        return error_system(err, "OSMesa gives no context");
    return gl_draw_into(gl, false, err) && check_driver(gl, err) && has_threads(gl, &before, err);
}

bool gl_succeeded(struct error *err)
{
    GLenum code = glGetError();
    return code == GL_NO_ERROR || error_system(err, "OpenGL reports error 0x%04x", code);
}

bool gl_open(const struct plan *plan, struct gl **out, struct error *err)
{
    struct gl *gl = calloc(1, sizeof *gl);
    *out = gl;
    if (!gl)
        return error_memory(err);
    gl->plan = plan;
    if (!open_context(gl, err) || !gl_upload(gl, err))
        return false;
    gl_set_state(gl);
    if (gl->numbers) {
        if (!gl_succeeded(err) || !gl_draw_into(gl, true, err))
            return false;
        gl_set_state(gl);
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
    free(gl->buffers);
    free(gl->textures);
    free(gl->pixels);
    free(gl->steps);
    free(gl->sum);
    free(gl->depths);
    free(gl);
}
