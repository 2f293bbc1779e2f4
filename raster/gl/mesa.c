/* SPDX-License-Identifier: MIT */
/* The same picture through OSMesa: OpenGL 1.x lighting into a buffer of floats, or of 8 or 16 bits.
 * Three wavelengths ride in the red, green and blue of a pass; each channel is lit by itself, so
 * that a pass is three exact single-wavelength renderings.
 *
 * Products of light and material spectra are made in double and given to OpenGL as the colours of
 * the lights, with white materials: what fluoresces, too, is then one pass under eight lights. More
 * lights take more passes, whose colours are added here; each draws everything anew, so that all
 * agree on what is seen. Geometry is uploaded once; a pass changes colours only. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
/* after GL/gl.h, which osmesa.h includes */
#include <GL/glext.h>

#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "data/scene/scene.h"
#include "data/tiff/tiff.h"
#include "raster/bounds/bounds.h"
#include "raster/gl/gl.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "spectral.h"

enum { VERTICES, INDICES, PLACES, BUFFERS };

/* A vertex as OpenGL reads it; its place in a texture lies apart, where there is one. */
struct gl_vertex {
    GLfloat position[3], normal[3];
};
struct gl_place {
    GLfloat s, t;
};

static const GLfloat white[4] = {1, 1, 1, 1}, black[4] = {0, 0, 0, 1};

/* ---- where to look ---- */

/* OpenGL keeps matrices by column. */
void gl_load_matrix(const struct matrix *m)
{
    GLdouble columns[16];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            columns[4 * j + i] = m->row[i][j];
    glLoadMatrixd(columns);
}

/* Row of a projection that maps [low, high] of the picture's clip space to [-1, 1]. */
static void aim_row(struct matrix *m, int row, double low, double high)
{
    for (int j = 0; j < 4; j++)
        m->row[row][j] = (2 * m->row[row][j] - (low + high) * m->row[3][j]) / (high - low);
}

static void aim(const struct gl *gl)
{
    const struct rectangle *tile = &gl->tile;
    double width = gl->plan->scene->width, height = gl->plan->scene->height;
    struct matrix projection = gl->plan->view.projection;
    aim_row(&projection, 0, 2 * tile->x / width - 1, 2 * (tile->x + tile->width) / width - 1);
    aim_row(&projection, 1, 1 - 2 * (tile->y + tile->height) / height, 1 - 2 * tile->y / height);
    glMatrixMode(GL_PROJECTION);
    gl_load_matrix(&projection);
    glMatrixMode(GL_MODELVIEW);
    /* a smaller tile lies in the first rows of the buffer */
    glViewport(0, gl->plan->tile_height - tile->height, tile->width, tile->height);
}

void gl_aim(struct gl *gl, const struct lit_scene *lit, const struct rectangle *tile)
{
    gl->lit = lit;
    gl->tile = *tile;
    aim(gl);
}

/* ---- opening ---- */

static bool check_context(const struct plan *plan, int needed_bits, struct error *err)
{
    GLint red_bits = 0, depth_bits = 0, stencil_bits = 0, viewport[2] = {0, 0};
    glGetIntegerv(GL_RED_BITS, &red_bits);
    glGetIntegerv(GL_DEPTH_BITS, &depth_bits);
    glGetIntegerv(GL_STENCIL_BITS, &stencil_bits);
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    if (red_bits != needed_bits || depth_bits < 24 || stencil_bits < 8)
        return error_system(err,
                            "OSMesa gives %d bits of colour, %d of depth and %d of stencil; %d, 24 "
                            "and 8 are needed",
                            red_bits, depth_bits, stencil_bits, needed_bits);
    return (viewport[0] >= plan->tile_width && viewport[1] >= plan->tile_height) ||
           error_system(err, "OSMesa draws at most %d x %d pixels at once", viewport[0],
                        viewport[1]);
}

/* Each type has a context of its own: one that goes from type to type works, but OSMesa of Mesa
 * 22.3.6 then makes new buffers every time, and keeps the old ones. */
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
        aim(gl);
    return check_context(plan, bits, err);
}

/* A driver of Mesa is chosen before the first context. */
static bool check_driver(const struct gl *gl, struct error *err)
{
    const char *wanted = gl->plan->options.gl_driver;
    errno = 0;
    return !wanted || strncmp(gl_renderer(gl), wanted, strlen(wanted)) == 0 ||
           error_system(err,
                        "this OSMesa draws with %.100s, and has no %s; --renderer gl takes what "
                        "there is",
                        gl_renderer(gl), wanted);
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

#ifdef OSMESA_VERSION /* built in; asked for another one, Mesa crashes */
static const char *const only_driver = "softpipe";
#else
static const char *const only_driver = NULL;
#endif

static bool open_context(struct gl *gl, struct error *err)
{
    static const int attributes[] = {OSMESA_FORMAT,
                                     OSMESA_RGBA,
                                     OSMESA_DEPTH_BITS,
                                     24,
                                     OSMESA_STENCIL_BITS,
                                     8,
                                     OSMESA_ACCUM_BITS,
                                     0,
                                     OSMESA_PROFILE,
                                     OSMESA_COMPAT_PROFILE,
                                     0};
    const struct plan *plan = gl->plan;
    const char *driver = only_driver ? only_driver : plan->options.gl_driver;
    char threads[16];
    if (!allocate(gl, err))
        return false;
    snprintf(threads, sizeof threads, "%d", plan->options.threads);
    setenv("LP_NUM_THREADS", threads, 0); /* for llvmpipe; a user's own configuration stands */
    if (driver)
        setenv("GALLIUM_DRIVER", driver, 1);
    gl->context = OSMesaCreateContextAttribs(attributes, NULL);
    if (gl->steps && plan->options.check)
        gl->numbers = OSMesaCreateContextAttribs(attributes, NULL);
    if (!gl->context || (gl->steps && plan->options.check && !gl->numbers))
        return error_system(err, "OSMesa gives no context");
    return gl_draw_into(gl, false, err) && check_driver(gl, err);
}

static bool upload_vertices(const struct mesh *mesh, struct error *err)
{
    struct gl_vertex *copy = malloc((size_t)mesh->n_vertices * sizeof *copy);
    if (!copy)
        return error_memory(err);
    for (int i = 0; i < mesh->n_vertices; i++) {
        struct vector p = mesh->vertices[i].position, n = mesh->vertices[i].normal;
        copy[i] = (struct gl_vertex){{(GLfloat)p.x, (GLfloat)p.y, (GLfloat)p.z},
                                     {(GLfloat)n.x, (GLfloat)n.y, (GLfloat)n.z}};
    }
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)((size_t)mesh->n_vertices * sizeof *copy), copy,
                 GL_STATIC_DRAW);
    free(copy);
    return true;
}

static bool upload_places(const struct mesh *mesh, struct error *err)
{
    struct gl_place *copy = malloc((size_t)mesh->n_vertices * sizeof *copy);
    if (!copy)
        return error_memory(err);
    for (int i = 0; i < mesh->n_vertices; i++)
        copy[i] = (struct gl_place){(GLfloat)mesh->vertices[i].s, (GLfloat)mesh->vertices[i].t};
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)((size_t)mesh->n_vertices * sizeof *copy), copy,
                 GL_STATIC_DRAW);
    free(copy);
    return true;
}

static bool upload_mesh(const struct gl *gl, int index, struct error *err)
{
    const struct mesh *mesh = &gl->plan->meshes[index].mesh;
    const GLuint *buffers = gl->buffers + BUFFERS * index;
    if (mesh->n_triangles == 0)
        return true;
    glBindBuffer(GL_ARRAY_BUFFER, buffers[VERTICES]);
    if (!upload_vertices(mesh, err))
        return false;
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[INDICES]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER,
                 (GLsizeiptr)((size_t)mesh->n_triangles * sizeof *mesh->triangles), mesh->triangles,
                 GL_STATIC_DRAW);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[PLACES]);
    return !gl->plan->meshes[index].textured || upload_places(mesh, err);
}

static bool upload_meshes(struct gl *gl, struct error *err)
{
    int n_meshes = gl->plan->n_meshes;
    gl->buffers = calloc(BUFFERS * (size_t)n_meshes + 1, sizeof *gl->buffers);
    if (!gl->buffers)
        return error_memory(err);
    glGenBuffers(BUFFERS * n_meshes, gl->buffers);
    for (int i = 0; i < n_meshes; i++)
        if (!upload_mesh(gl, i, err))
            return false;
    return true;
}

/* ---- textures ---- */

/* Single-precision texels: Mesa filters those of 8 bits with weights of 8 bits. */
static bool open_texture(const struct texture *texture, GLuint name, struct error *err)
{
    GLint filter = texture->linear ? GL_LINEAR : GL_NEAREST, largest = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    if (texture->image.width > largest || texture->image.height > largest)
        return error_system(err, "%.500s: this OpenGL has textures of at most %d texels a side",
                            texture->image.path, largest);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_REPEAT);
    if (!texture->spectral)
        glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE32F_ARB, texture->image.width,
                     texture->image.height, 0, GL_LUMINANCE, GL_FLOAT, texture->plane[0]);
    return true;
}

static bool open_textures(struct gl *gl, struct error *err)
{
    int n_textures = gl->plan->n_textures;
    if (n_textures == 0)
        return true;
    gl->textures = calloc((size_t)n_textures, sizeof *gl->textures);
    if (!gl->textures)
        return error_memory(err);
    glGenTextures(n_textures, gl->textures);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, GL_MODULATE);
    for (int i = 0; i < n_textures; i++)
        if (!open_texture(&gl->plan->textures[i], gl->textures[i], err))
            return false;
    return true;
}

/* Gives OpenGL the planes of a spectral texture's loaded bands. */
static bool upload_planes(const struct texture *texture, GLuint name, struct error *err)
{
    size_t n = (size_t)texture->image.width * (size_t)texture->image.height;
    float *texels = malloc(n * BANDS_PER_PASS * sizeof *texels);
    if (!texels)
        return error_memory(err);
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < BANDS_PER_PASS; c++)
            texels[BANDS_PER_PASS * i + c] = texture->plane[c] ? texture->plane[c][i] : 0;
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F_ARB, texture->image.width, texture->image.height, 0,
                 GL_RGB, GL_FLOAT, texels);
    free(texels);
    return true;
}

static void use_texture(const struct gl *gl, const struct shaded_material *shaded)
{
    if (!shaded->texture) {
        glDisable(GL_TEXTURE_2D);
        glDisableClientState(GL_TEXTURE_COORD_ARRAY);
        return;
    }
    glBindTexture(GL_TEXTURE_2D, gl->textures[shaded->texture - gl->plan->textures]);
    glEnable(GL_TEXTURE_2D);
    glEnableClientState(GL_TEXTURE_COORD_ARRAY);
}

/* ---- state ---- */

/* State that no pass changes. Clamps are off: colours may exceed 1 on their way through a triangle
 * (Mesa clamps vertex colours by default, even for float buffers). */
static void set_state(const struct gl *gl)
{
    glClampColorARB(GL_CLAMP_VERTEX_COLOR_ARB, GL_FALSE);
    glClampColorARB(GL_CLAMP_FRAGMENT_COLOR_ARB, GL_FALSE);
    glClampColorARB(GL_CLAMP_READ_COLOR_ARB, GL_FALSE);
    glDisable(GL_DITHER);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glShadeModel(gl->plan->scene->shading == SHADING_FLAT ? GL_FLAT : GL_SMOOTH);
    glEnable(GL_NORMALIZE);
    glEnable(GL_LIGHTING);
    glLightModelfv(GL_LIGHT_MODEL_AMBIENT, white);
    glLightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, gl->plan->scene->local_viewer);
    glMaterialfv(GL_FRONT_AND_BACK, GL_DIFFUSE, white);
    glMaterialfv(GL_FRONT_AND_BACK, GL_EMISSION, black);
    glClearColor(0, 0, 0, 0);
    glMatrixMode(GL_MODELVIEW);
    glEnableClientState(GL_VERTEX_ARRAY);
    glEnableClientState(GL_NORMAL_ARRAY);
}

static void place_light(GLenum name, const struct eye_light *light, const struct light *source)
{
    struct vector at = light->position, axis = light->axis;
    GLfloat position[4] = {(GLfloat)at.x, (GLfloat)at.y, (GLfloat)at.z,
                           source->directional ? 0.0F : 1.0F};
    GLfloat direction[3] = {(GLfloat)axis.x, (GLfloat)axis.y, (GLfloat)axis.z};
    static const GLenum attenuations[] = {GL_CONSTANT_ATTENUATION, GL_LINEAR_ATTENUATION,
                                          GL_QUADRATIC_ATTENUATION};
    glEnable(name);
    glLightfv(name, GL_AMBIENT, black);
    glLightfv(name, GL_POSITION, position);
    for (int i = 0; i < 3; i++)
        glLightf(name, attenuations[i], (GLfloat)light->attenuation[i]);
    glLightf(name, GL_SPOT_CUTOFF, light->spot ? (GLfloat)source->spot_cutoff_deg : 180.0F);
    glLightf(name, GL_SPOT_EXPONENT, light->spot ? (GLfloat)source->spot_exponent : 0.0F);
    if (light->spot)
        glLightfv(name, GL_SPOT_DIRECTION, direction);
}

/* The lights of a group, in eye coordinates. */
static void place_lights(const struct gl *gl, int group)
{
    glLoadIdentity();
    for (int i = 0; i < LIGHTS_PER_PASS; i++) {
        int light = group * LIGHTS_PER_PASS + i;
        if (light < gl->plan->n_lights)
            place_light(GL_LIGHT0 + (GLenum)i, &gl->plan->lights[light], gl->plan->sources[light]);
        else
            glDisable(GL_LIGHT0 + (GLenum)i);
    }
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
    if (!open_context(gl, err) || !upload_meshes(gl, err) || !open_textures(gl, err))
        return false;
    set_state(gl);
    if (gl->numbers) {
        if (!gl_succeeded(err) || !gl_draw_into(gl, true, err))
            return false;
        set_state(gl);
    }
    return gl_succeeded(err);
}

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

/* ---- drawing ---- */

/* Colour of a term in the three bands of a pass; black without one (row NULL). */
static void band_colour(const struct plan *plan, const double *row, int first_band,
                        double full_scale, GLfloat out[4])
{
    for (int c = 0; c < BANDS_PER_PASS; c++)
        out[c] = row && first_band + c < plan->n_bands ? (GLfloat)(row[first_band + c] / full_scale)
                                                       : 0.0F;
    out[3] = 1;
}

static const double *term_row(const struct plan *plan, const struct shaded_material *shaded,
                              enum reflection reflection, int light)
{
    for (int t = 0; t < shaded->n_terms; t++)
        if (shaded->terms[t].reflection == reflection && shaded->terms[t].light == light)
            return shaded->made.spectra + (size_t)t * (size_t)plan->n_bands;
    return NULL;
}

/* What one pass draws: the bands and the lights of it. */
struct pass {
    int first_band, group;
    double full_scale;
};

static void set_material(const struct gl *gl, const struct shaded_material *shaded,
                         const struct pass *pass)
{
    const struct plan *plan = gl->plan;
    const double *constant = pass->group == 0 ? term_row(plan, shaded, CONSTANT, -1) : NULL;
    GLfloat colour[4];
    bool shiny = false;
    for (int i = 0; i < LIGHTS_PER_PASS; i++) {
        GLenum name = GL_LIGHT0 + (GLenum)i;
        int light = pass->group * LIGHTS_PER_PASS + i;
        if (light >= plan->n_lights)
            break;
        int first = plan->lights[light].first;
        double full_scale = pass->full_scale / plan->lights[light].share;
        const double *specular = term_row(plan, shaded, SPECULAR, first);
        band_colour(plan, term_row(plan, shaded, DIFFUSE, first), pass->first_band, full_scale,
                    colour);
        glLightfv(name, GL_DIFFUSE, colour);
        band_colour(plan, specular, pass->first_band, full_scale, colour);
        glLightfv(name, GL_SPECULAR, colour);
        shiny = shiny || specular;
    }
    band_colour(plan, constant, pass->first_band, pass->full_scale, colour);
    glMaterialfv(GL_FRONT_AND_BACK, GL_AMBIENT, colour);
    glMaterialfv(GL_FRONT_AND_BACK, GL_SPECULAR, shiny ? white : black);
    glMaterialf(GL_FRONT_AND_BACK, GL_SHININESS, shiny ? (GLfloat)shaded->material->gloss : 0.0F);
    use_texture(gl, shaded);
}

static void draw_instance(const struct gl *gl, const struct placed_instance *placed)
{
    const struct gl_vertex *first = NULL; /* offsets into the bound buffer */
    const GLuint *buffers = gl->buffers + BUFFERS * placed->mesh;
    glBindBuffer(GL_ARRAY_BUFFER, buffers[VERTICES]);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[INDICES]);
    glVertexPointer(3, GL_FLOAT, sizeof *first, (const void *)offsetof(struct gl_vertex, position));
    glNormalPointer(GL_FLOAT, sizeof *first, (const void *)offsetof(struct gl_vertex, normal));
    if (gl->plan->materials[placed->shaded].texture) {
        glBindBuffer(GL_ARRAY_BUFFER, buffers[PLACES]);
        glTexCoordPointer(2, GL_FLOAT, 0, NULL);
    }
    glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, placed->object->two_sided);
    glFrontFace(placed->instance.mirrored ? GL_CW : GL_CCW);
    gl_load_matrix(&placed->instance.model_view);
    glDrawElements(GL_TRIANGLES, 3 * gl->plan->meshes[placed->mesh].mesh.n_triangles,
                   GL_UNSIGNED_INT, NULL);
}

/* Clears the colour by drawing over it: Mesa fills 16-byte pixels one by one, at ten times the
 * price of a rectangle. */
void gl_blacken(void)
{
    glDisable(GL_LIGHTING);
    glDisable(GL_TEXTURE_2D);
    glDisable(GL_DEPTH_TEST); /* which also leaves the cleared depth alone */
    glMatrixMode(GL_PROJECTION);
    glPushMatrix();
    glLoadIdentity();
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    glColor4f(0, 0, 0, 0);
    glRectf(-1, -1, 1, 1);
    glMatrixMode(GL_PROJECTION);
    glPopMatrix();
    glMatrixMode(GL_MODELVIEW);
}

static void draw_pass(struct gl *gl, const struct pass *pass)
{
    const struct plan *plan = gl->plan;
    int shaded = -1;
    glClear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    gl_blacken();
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_LIGHTING);
    place_lights(gl, pass->group);
    for (int i = 0; i < plan->n_instances; i++) {
        const struct placed_instance *placed = &plan->instances[i];
        if (!surface_reaches(&gl->lit->bounds[i], &gl->tile))
            continue;
        if (placed->shaded != shaded)
            set_material(gl, &plan->materials[placed->shaded], pass);
        shaded = placed->shaded;
        draw_instance(gl, placed);
        gl->work.draw_calls++;
    }
    glFinish(); /* only now does OSMesa fill the buffer */
    gl->work.passes++;
}

/* Steps as parts of full scale. */
static void fetch_steps(struct gl *gl)
{
    size_t n = 4 * (size_t)gl->plan->tile_width * (size_t)gl->plan->tile_height;
    const uint16_t *words = gl->steps;
    const uint8_t *bytes = gl->steps;
    float whole = (float)buffer_steps(gl->plan);
    bool wide = gl->plan->options.buffer_bits == 16;
    for (size_t i = 0; i < n && wide; i++)
        gl->pixels[i] = (float)words[i] / whole;
    for (size_t i = 0; i < n && !wide; i++)
        gl->pixels[i] = (float)bytes[i] / whole;
}

static void add_pass(struct gl *gl, bool first)
{
    size_t n = 4 * (size_t)gl->plan->tile_width * (size_t)gl->plan->tile_height;
    for (size_t i = 0; i < n; i++)
        gl->sum[i] = first ? gl->pixels[i] : gl->sum[i] + gl->pixels[i];
}

bool gl_draw(struct gl *gl, int first_band, double full_scale, const float **pixels,
             struct error *err)
{
    const struct plan *plan = gl->plan;
    if (!gl_draw_into(gl, false, err))
        return false;
    for (int i = 0; i < plan->n_textures; i++)
        if (plan->textures[i].spectral && !upload_planes(&plan->textures[i], gl->textures[i], err))
            return false;
    for (int group = 0; group < plan->n_light_groups; group++) {
        draw_pass(gl, &(struct pass){first_band, group, full_scale});
        if (gl->steps)
            fetch_steps(gl);
        if (gl->sum)
            add_pass(gl, group == 0);
    }
    *pixels = gl->sum ? gl->sum : gl->pixels;
    return gl_succeeded(err);
}

struct gl_work gl_work(const struct gl *gl)
{
    return gl->work;
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
