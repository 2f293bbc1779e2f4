/* SPDX-License-Identifier: MIT */
/* Contexts of EGL without a window: of the platform "surfaceless" (EGL_MESA_platform_surfaceless),
 * or of a device (EGL_EXT_platform_device). They draw into a framebuffer object, whose first row is
 * the top of the picture, and which is read back.
 *
 * The first row is the top one because OpenGL turns window coordinates around
 * (GL_ARB_clip_control). Without this extension the projection must: then Mesa clips triangles in
 * another order, and rounds otherwise. With it, colours and depths of Mesa 22.3.6 are those of
 * OSMesa to the bit, since OSMesa turns its window around inside of Mesa. */
#include "raster/gl/inside.h"

#ifdef OSMESA_VERSION /* the static program has no loader */
static const char *const files[] = {NULL};
const struct context_kind egl_kind = {.name = "EGL", .files = files};

bool contexts_devices(int *out, struct error *err)
{
    (void)err;
    *out = 0;
    return true;
}
#else
#define EGL_NO_X11
#define EGL_EGL_PROTOTYPES 0
#include <EGL/egl.h>
/* after EGL/egl.h */
#include <EGL/eglext.h>

struct egl {
    /* of the library: see `functions` */
    struct library_functions find;
    PFNEGLQUERYSTRINGPROC query_string;
    PFNEGLINITIALIZEPROC initialize;
    PFNEGLTERMINATEPROC terminate;
    PFNEGLBINDAPIPROC bind_api;
    PFNEGLCHOOSECONFIGPROC choose_config;
    PFNEGLCREATECONTEXTPROC create_context;
    PFNEGLDESTROYCONTEXTPROC destroy_context;
    PFNEGLMAKECURRENTPROC make_current;
    /* of extensions */
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display;
    PFNEGLQUERYDEVICESEXTPROC query_devices; /* NULL: EGL has no devices */
    PFNGLCLIPCONTROLPROC clip_control;       /* of OpenGL; NULL: it has none */
    EGLDisplay display;
    EGLConfig config;
};

static const struct egl *egl_of(const struct canvas *canvas)
{
    return canvas->contexts->own;
}

/* ---- a canvas ---- */

/* Makes a buffer, and lets the canvas draw on it. */
static void add_buffer(const struct canvas *canvas, GLenum format, GLenum at)
{
    const struct gl_functions *call = &canvas->contexts->call;
    GLuint buffer;
    call->GenRenderbuffers(1, &buffer);
    call->BindRenderbuffer(GL_RENDERBUFFER, buffer);
    call->RenderbufferStorage(GL_RENDERBUFFER, format, canvas->width, canvas->height);
    call->FramebufferRenderbuffer(GL_FRAMEBUFFER, at, GL_RENDERBUFFER, buffer);
}

/* Makes the buffers that the canvas draws on; its context is current. */
static bool make_buffers(const struct canvas *canvas, struct error *err)
{
    const struct gl_functions *call = &canvas->contexts->call;
    const int n = canvas->contexts->n_colours, bits = canvas->bits;
    const GLenum format = bits == 32   ? GL_RGBA32F
                          : bits == 16 ? GL_RGBA16
                          : bits == 10 ? GL_RGB10_A2
                                       : GL_RGBA8;
    GLenum colours[MOST_AT_ONCE];
    GLuint framebuffer;
    call->GenFramebuffers(1, &framebuffer);
    call->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    for (int i = 0; i < n; i++) {
        colours[i] = GL_COLOR_ATTACHMENT0 + (GLenum)i;
        add_buffer(canvas, format, colours[i]);
    }
    if (n > 1)
        call->DrawBuffers(n, colours);
    add_buffer(canvas, GL_DEPTH24_STENCIL8, GL_DEPTH_STENCIL_ATTACHMENT);
    return call->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE ||
           error_unsupported(err, "EGL's OpenGL gives no framebuffer of %d x %d pixels of %d bits",
                             canvas->width, canvas->height, bits);
}

static bool make_current(const struct egl *egl, EGLContext context, struct error *err)
{
    return egl->make_current(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) ||
           error_unsupported(err, "EGL cannot draw without a window");
}

static bool open_canvas(struct canvas *canvas, struct error *err)
{
    /* without attributes, the compatibility profile */
    static const EGLint attributes[][7] = {
        [GL_WITHOUT_SHADERS] = {EGL_NONE},
        [GL_CORE] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3,
                     EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                     EGL_NONE},
        [GL_ES] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 0, EGL_NONE}};
    static const char *const names[] = {"OpenGL with lighting of its own", "OpenGL 3.3 core",
                                        "OpenGL ES 3"};
    const enum gl_way way = canvas->contexts->way;
    const struct egl *egl = egl_of(canvas);
    canvas->context =
        egl->create_context(egl->display, egl->config, EGL_NO_CONTEXT, attributes[way]);
    if (!canvas->context)
        return error_unsupported(err, "EGL gives no context of %s", names[way]);
    canvas->contexts->current = NULL;
    if (!make_current(egl, canvas->context, err) || !make_buffers(canvas, err))
        return false;
    const char *name = way == GL_ES ? "GL_EXT_clip_control" : "GL_ARB_clip_control";
    canvas->contexts->mirrored = !egl->clip_control || !contexts_have(canvas->contexts, name);
    if (!canvas->contexts->mirrored)
        egl->clip_control(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    return true;
}

static bool use_canvas(struct canvas *canvas, void *pixels, struct error *err)
{
    (void)pixels;
    return canvas->contexts->current == canvas ||
           make_current(egl_of(canvas), canvas->context, err);
}

static void fill_canvas(const struct canvas *canvas, int colours, void *pixels)
{
    const struct gl_functions *call = &canvas->contexts->call;
    if (canvas->contexts->n_colours > 1)
        call->ReadBuffer(GL_COLOR_ATTACHMENT0 + (GLenum)colours);
    call->ReadPixels(0, 0, canvas->width, canvas->height, GL_RGBA, canvas_type(canvas), pixels);
}

static void close_canvas(struct canvas *canvas)
{
    const struct egl *egl = egl_of(canvas);
    egl->make_current(egl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    egl->destroy_context(egl->display, canvas->context);
}

static void end(struct contexts *contexts)
{
    const struct egl *egl = contexts->own;
    if (egl->display != EGL_NO_DISPLAY)
        egl->terminate(egl->display);
}

/* ---- the display ---- */

enum { MOST_DEVICES = 64 };

/* Finds the display of a device. */
static bool find_device(struct egl *egl, int device, struct error *err)
{
    EGLDeviceEXT devices[MOST_DEVICES];
    EGLint n = 0;
    if (!egl->query_devices || !egl->query_devices(MOST_DEVICES, devices, &n))
        return error_unsupported(err, "this EGL lists no devices; --gl egl takes its default");
    if (device >= n)
        return error_unsupported(err, "EGL has %d devices, from egl:0 on; there is no egl:%d", n,
                                 device);
    egl->display = egl->get_platform_display(EGL_PLATFORM_DEVICE_EXT, devices[device], NULL);
    return true;
}

static bool find_display(struct egl *egl, int device, struct error *err)
{
    const char *extensions = egl->query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    const bool surfaceless = has_extension(extensions, "EGL_MESA_platform_surfaceless");
    EGLint major, minor;
    egl->display = EGL_NO_DISPLAY;
    if (device < 0 && surfaceless)
        egl->display =
            egl->get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    else if (!find_device(egl, device < 0 ? 0 : device, err))
        return false;
    if (egl->display == EGL_NO_DISPLAY || !egl->initialize(egl->display, &major, &minor)) {
        const char *driver = getenv("GALLIUM_DRIVER");
        const bool named = driver && *driver;
        egl->display = EGL_NO_DISPLAY;
        return error_unsupported(
            err, "EGL gives no display without a window%s%.60s%s",
            named ? " by GALLIUM_DRIVER=" : "", named ? driver : "",
            named ? " of the environment; unset that, or add --renderer llvmpipe"
                  : "; Mesa's drivers are in libgl1-mesa-dri (Debian), mesa-dri-drivers (Fedora), "
                    "mesa-dri-gallium (Alpine) or mesa (Arch)");
    }
    return true;
}

/* Finds a configuration, or none where contexts need none. */
static bool find_config(struct egl *egl, enum gl_way way, struct error *err)
{
    const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                             way == GL_ES ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT, EGL_NONE};
    const char *extensions = egl->query_string(egl->display, EGL_EXTENSIONS);
    EGLint n = 0;
    egl->config = EGL_NO_CONFIG_KHR;
    if (!egl->bind_api(way == GL_ES ? EGL_OPENGL_ES_API : EGL_OPENGL_API))
        return error_unsupported(err, "this EGL has no OpenGL%s",
                                 way == GL_ES ? " ES" : "; --renderer es-shader takes OpenGL ES");
    return has_extension(extensions, "EGL_KHR_no_config_context") ||
           (egl->choose_config(egl->display, wanted, &egl->config, 1, &n) && n == 1) ||
           error_unsupported(err, "EGL has no configuration for OpenGL");
}

/* ---- the library ---- */

static const char *const files[] = {"libEGL.so.1", "libEGL.so", NULL};
static const char *const functions[] = {"eglGetProcAddress", "eglQueryString",    "eglInitialize",
                                        "eglTerminate",      "eglBindAPI",        "eglChooseConfig",
                                        "eglCreateContext",  "eglDestroyContext", "eglMakeCurrent"};
enum { N_FUNCTIONS = sizeof functions / sizeof *functions };

/* Finds the functions of extensions. */
static void find_extensions(struct egl *egl, enum gl_way way)
{
    any_function *(*const get)(const char *name) = egl->find.get;
    egl->get_platform_display = (PFNEGLGETPLATFORMDISPLAYEXTPROC)get("eglGetPlatformDisplayEXT");
    egl->query_devices = (PFNEGLQUERYDEVICESEXTPROC)get("eglQueryDevicesEXT");
    egl->clip_control =
        (PFNGLCLIPCONTROLPROC)get(way == GL_ES ? "glClipControlEXT" : "glClipControl");
}

bool contexts_devices(int *out, struct error *err)
{
    struct egl egl = {.display = EGL_NO_DISPLAY};
    EGLDeviceEXT devices[MOST_DEVICES];
    EGLint n = 0;
    void *library;
    *out = 0;
    if (!library_open(files, &library, err))
        return false;
    if (!library || !library_find_all(library, functions, N_FUNCTIONS, &egl))
        return true;
    find_extensions(&egl, GL_WITHOUT_SHADERS);
    if (egl.get_platform_display && egl.query_devices &&
        egl.query_devices(MOST_DEVICES, devices, &n))
        *out = n;
    return true;
}

static const char too_old[] = "this EGL is too old: version 1.4 with platforms is needed";

static bool begin(struct contexts *contexts, int device, struct error *err)
{
    struct egl *egl = contexts->own;
    find_extensions(egl, contexts->way);
    if (!egl->get_platform_display)
        return error_unsupported(err, "%s", too_old);
    return find_display(egl, device, err) && find_config(egl, contexts->way, err);
}

const struct context_kind egl_kind = {
    "EGL", true, files,       functions,  N_FUNCTIONS, sizeof(struct egl), too_old,
    begin, end,  open_canvas, use_canvas, fill_canvas, close_canvas};
#endif
