/* SPDX-License-Identifier: MIT */
/* Draws a scene that `spectral export` has written, through OpenGL by EGL without a window, and
 * writes the pixels for `spectral judge`. It needs no part of spectral: it shows what a program of
 * your own has to do. data/doc/exchange.md explains each file.
 *
 *     cc -O2 draw.c -o draw -lEGL -lGL -lm
 *     spectral export room --size 300x200 -o room
 *     ./draw room
 *     spectral judge room */
#define EGL_EGLEXT_PROTOTYPES
#define GL_GLEXT_PROTOTYPES
#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MOST = 65536, LIGHTS = 8 }; /* LIGHTS: of a group */

struct mesh {
    int n_vertices, n_triangles;
    float *vertices;    /* 8 each: position, normal, texture coordinates */
    int32_t *triangles; /* 3 each: their corners */
};
struct texture {
    int width, height, linear, mipmaps, spectral;
    GLuint name;
};
struct source {
    int present, positional, spot;
    double place[3], attenuation[3], axis[3], cutoff_deg, exponent;
};
struct instance {
    int number, mesh, material, texture, two_sided, clockwise;
    double matrix[16];
};
struct volume { /* the shadow of an object: the caps, its sides, its far end, caps turned inward */
    int group, n_triangles, n_outward, n_caps, clockwise;
    double matrix[16];
    float *corners; /* 9 a triangle */
};
struct material { /* in a pass, under a group of lights */
    float constant[4], diffuse[LIGHTS][4], specular[LIGHTS][4], gloss;
    int lit[LIGHTS];
};
static struct {
    const char *folder;
    char id[80];
    int width, height, flat, local, n_bands, n_instances, n_sources, n_materials, n_volumes;
    int first[MOST], n_lights[MOST]; /* of the lights of each group, and how many they are */
    double projection[16];
    struct mesh mesh[MOST];
    struct texture texture[MOST];
    struct source source[MOST];
    struct instance instance[MOST];
    struct material material[MOST];
    struct volume volume[MOST];
} scene;

static void fail(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("draw: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(1);
}

/* ---- files ---- */

static FILE *open_file(const char *folder, const char *name, const char *mode)
{
    char path[4096];
    snprintf(path, sizeof path, "%s%s", folder, name);
    FILE *file = fopen(path, mode);
    if (!file)
        fail("cannot open %s", path);
    return file;
}

static void *read_numbers(const char *name, size_t n, size_t size)
{
    FILE *file = open_file(scene.folder, name, "rb");
    void *out = malloc(n * size + 1);
    if (!out || fread(out, size, n, file) != n)
        fail("cannot read %s", name);
    fclose(file);
    return out;
}

static void write_numbers(const char *folder, const char *name, const void *from, size_t n,
                          size_t size)
{
    FILE *file = open_file(folder, name, "wb");
    if (fwrite(from, size, n, file) != n || fclose(file) != 0)
        fail("cannot write %s", name);
}

/* Reads the next numbers of a line. */
static const char *read_doubles(const char *at, int n, double *out)
{
    for (int i = 0; i < n; i++) {
        char *end;
        out[i] = strtod(at, &end);
        if (end == at)
            fail("scene.txt has too few numbers: %s", at);
        at = end;
    }
    return at;
}

static int checked(int index)
{
    if (index < 0 || index >= MOST)
        fail("the scene is too large");
    return index;
}

/* ---- scene.txt ---- */

static void read_mesh(int index, int n_vertices, int n_triangles)
{
    struct mesh *mesh = &scene.mesh[checked(index)];
    char name[64];
    snprintf(name, sizeof name, "vertices-%d.bin", index);
    mesh->vertices = read_numbers(name, (size_t)n_vertices, 8 * sizeof(float));
    snprintf(name, sizeof name, "triangles-%d.bin", index);
    mesh->triangles = read_numbers(name, (size_t)n_triangles, 3 * sizeof(int32_t));
    mesh->n_vertices = n_vertices;
    mesh->n_triangles = n_triangles;
}

static void read_source(const char *line)
{
    char kind[16];
    int index, length;
    if (sscanf(line, "source %d %15s%n", &index, kind, &length) != 2)
        fail("cannot read: %s", line);
    struct source *source = &scene.source[checked(index)];
    *source = (struct source){.present = 1, .positional = strcmp(kind, "positional") == 0};
    const char *at = read_doubles(line + length, 3, source->place);
    at = read_doubles(at + strlen(" attenuation"), 3, source->attenuation);
    if (strncmp(at, " spot", 5) == 0) {
        source->spot = 1;
        at = read_doubles(at + 5, 3, source->axis);
        at = read_doubles(at, 1, &source->cutoff_deg);
        read_doubles(at, 1, &source->exponent);
    }
    if (index >= scene.n_sources)
        scene.n_sources = index + 1;
}

static void read_instance(const char *line)
{
    struct instance *to = &scene.instance[checked(scene.n_instances++)];
    char sides[16], turn[24];
    int length;
    if (sscanf(line, "instance %d mesh %d material %d texture %d %15s %23s matrix%n", &to->number,
               &to->mesh, &to->material, &to->texture, sides, turn, &length) != 6)
        fail("cannot read: %s", line);
    to->two_sided = strcmp(sides, "two-sided") == 0;
    to->clockwise = strcmp(turn, "clockwise") == 0;
    read_doubles(line + length, 16, to->matrix);
    if (to->material >= scene.n_materials)
        scene.n_materials = checked(to->material) + 1;
}

static void read_volume(const char *line)
{
    struct volume *to = &scene.volume[checked(scene.n_volumes++)];
    char turn[24], name[64];
    int index, length;
    if (sscanf(line, "volume %d group %d triangles %d outward %d caps %d %23s matrix%n", &index,
               &to->group, &to->n_triangles, &to->n_outward, &to->n_caps, turn, &length) != 6)
        fail("cannot read: %s", line);
    to->clockwise = strcmp(turn, "clockwise") == 0;
    read_doubles(line + length, 16, to->matrix);
    snprintf(name, sizeof name, "volume-%d.bin", index);
    to->corners = read_numbers(name, (size_t)to->n_triangles, 9 * sizeof(float));
}

static void read_line(const char *line)
{
    char word[16] = "";
    int a, b, c;
    sscanf(line, "%15s", word);
    if (sscanf(line, "size %d %d", &a, &b) == 2) {
        scene.width = a;
        scene.height = b;
    } else if (sscanf(line, "mesh %d %d %d", &a, &b, &c) == 3) {
        read_mesh(a, b, c);
    } else if (strcmp(word, "id") == 0) {
        sscanf(line, "id %79s", scene.id);
    } else if (strcmp(word, "shading") == 0) {
        scene.flat = strstr(line, "flat") != NULL;
    } else if (strcmp(word, "viewer") == 0) {
        scene.local = strstr(line, "local") != NULL;
    } else if (strcmp(word, "projection") == 0) {
        read_doubles(line + strlen(word), 16, scene.projection);
    } else if (strcmp(word, "band") == 0) {
        scene.n_bands++;
    } else if (strcmp(word, "source") == 0) {
        read_source(line);
    } else if (strcmp(word, "instance") == 0) {
        read_instance(line);
    } else if (strcmp(word, "volume") == 0) {
        read_volume(line);
    } else if (sscanf(line, "group %d lights %d %d", &a, &b, &c) == 3) {
        scene.first[checked(a)] = b;
        scene.n_lights[a] = c;
    } else if (sscanf(line, "texture %d %d %d", &a, &b, &c) == 3) {
        scene.texture[checked(a)] = (struct texture){b,
                                                     c,
                                                     strstr(line, "nearest") == NULL,
                                                     strstr(line, "mipmaps") != NULL,
                                                     strstr(line, "spectral") != NULL,
                                                     0};
    }
}

static void read_scene(const char *folder)
{
    static char line[4096];
    scene.folder = folder;
    FILE *file = open_file(folder, "scene.txt", "r");
    if (!fgets(line, sizeof line, file) || strcmp(line, "spectral-scene 1\n") != 0)
        fail("scene.txt is not of version 1");
    while (fgets(line, sizeof line, file))
        read_line(line);
    fclose(file);
}

/* ---- passes.txt ---- */

/* A line of passes.txt. */
struct line {
    int is_light, band, group, material, light;
    float colour[2][3]; /* of a light: diffuse, specular; of a material: constant, gloss */
};

/* Reads a line; returns 0 at the end. */
static int next_line(FILE *file, struct line *out)
{
    char text[256];
    float *a = out->colour[0], *b = out->colour[1];
    if (!fgets(text, sizeof text, file))
        fail("passes.txt ends too early");
    if (strcmp(text, "end\n") == 0)
        return 0;
    out->is_light = text[0] == 'l';
    if (sscanf(text, "light %d %d %d %d %f %f %f %f %f %f", &out->band, &out->group, &out->material,
               &out->light, &a[0], &a[1], &a[2], &b[0], &b[1], &b[2]) != 10 &&
        sscanf(text, "material %d %d %d %f %f %f %f", &out->band, &out->group, &out->material,
               &a[0], &a[1], &a[2], &b[0]) != 7)
        fail("cannot read: %s", text);
    checked(out->material);
    return 1;
}

static void set_colour(float out[4], const float from[3])
{
    memcpy(out, from, 3 * sizeof *from);
    out[3] = 1;
}

static void take_line(const struct line *line)
{
    struct material *to = &scene.material[line->material];
    if (!line->is_light) {
        *to = (struct material){.gloss = line->colour[1][0]};
        set_colour(to->constant, line->colour[0]);
        return;
    }
    const int i = line->light - scene.first[line->group];
    if (i < 0 || i >= LIGHTS)
        fail("light %d is not of group %d", line->light, line->group);
    to->lit[i] = 1;
    set_colour(to->diffuse[i], line->colour[0]);
    set_colour(to->specular[i], line->colour[1]);
}

/* ---- OpenGL ---- */

static const GLfloat white[4] = {1, 1, 1, 1}, black[4] = {0, 0, 0, 1};

static void open_context(void)
{
    EGLDisplay display =
        eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL) ||
        !eglBindAPI(EGL_OPENGL_API))
        fail("EGL gives no display without a window");
    EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, NULL);
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
        fail("EGL gives no context");
}

/* Draws into a buffer of floats, with 24 bits of depth and 8 of stencil. Its first row is the top
 * one. */
static void open_buffer(void)
{
    GLuint framebuffer, buffers[2];
    glGenFramebuffers(1, &framebuffer);
    glGenRenderbuffers(2, buffers);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glBindRenderbuffer(GL_RENDERBUFFER, buffers[0]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA32F, scene.width, scene.height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffers[0]);
    glBindRenderbuffer(GL_RENDERBUFFER, buffers[1]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, scene.width, scene.height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER,
                              buffers[1]);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        fail("there is no buffer of floats");
    glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glViewport(0, 0, scene.width, scene.height);
}

/* Colours may exceed 1 on their way through a triangle: nothing may clamp them. */
static void set_state(void)
{
    glClampColor(GL_CLAMP_VERTEX_COLOR, GL_FALSE);
    glClampColor(GL_CLAMP_FRAGMENT_COLOR, GL_FALSE);
    glClampColor(GL_CLAMP_READ_COLOR, GL_FALSE);
    glDisable(GL_DITHER);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glShadeModel(scene.flat ? GL_FLAT : GL_SMOOTH);
    glEnable(GL_NORMALIZE);
    glEnable(GL_LIGHTING);
    glLightModelfv(GL_LIGHT_MODEL_AMBIENT, white);
    glLightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, scene.local);
    glMaterialfv(GL_FRONT_AND_BACK, GL_DIFFUSE, white);
    glMaterialfv(GL_FRONT_AND_BACK, GL_EMISSION, black);
    glStencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP);
    glEnableClientState(GL_VERTEX_ARRAY);
    glClearColor(0, 0, 0, 0);
}

static void load_matrix(GLenum which, const double rows[16])
{
    glMatrixMode(which);
    glLoadTransposeMatrixd(rows);
    glMatrixMode(GL_MODELVIEW);
}

static int side_of(int side, int level)
{
    return side >> level > 0 ? side >> level : 1;
}

/* The texels of a level; 0: there is no such level. */
static int texels_of(const struct texture *texture, int level)
{
    const int largest = texture->width > texture->height ? texture->width : texture->height;
    if (level > 0 && (!texture->mipmaps || largest >> level == 0))
        return 0;
    return side_of(texture->width, level) * side_of(texture->height, level);
}

static void load_texture(struct texture *texture, const float *texels)
{
    const GLint filter = texture->linear ? GL_LINEAR : GL_NEAREST,
                smaller = texture->mipmaps ? GL_LINEAR_MIPMAP_LINEAR : filter;
    if (!texture->name)
        glGenTextures(1, &texture->name);
    glBindTexture(GL_TEXTURE_2D, texture->name);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, smaller);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_REPEAT);
    for (int level = 0, size; (size = texels_of(texture, level)) > 0; level++) {
        glTexImage2D(GL_TEXTURE_2D, level, texture->spectral ? GL_RGB32F : GL_LUMINANCE32F_ARB,
                     side_of(texture->width, level), side_of(texture->height, level), 0,
                     texture->spectral ? GL_RGB : GL_LUMINANCE, GL_FLOAT, texels);
        texels += size * (texture->spectral ? 3 : 1);
    }
}

/* Loads the grey textures (band -1), or the spectral ones for the pass that begins with a band. */
static void load_textures(int band)
{
    for (int i = 0; i < MOST; i++) {
        struct texture *texture = &scene.texture[i];
        char name[64];
        if (texture->width == 0 || texture->spectral != (band >= 0))
            continue;
        if (band < 0)
            snprintf(name, sizeof name, "texture-%d.bin", i);
        else
            snprintf(name, sizeof name, "texture-%d-%d.bin", i, band);
        size_t all = 0;
        for (int level = 0; texels_of(texture, level) > 0; level++)
            all += (size_t)texels_of(texture, level);
        float *texels = read_numbers(name, all, (texture->spectral ? 3 : 1) * sizeof *texels);
        load_texture(texture, texels);
        free(texels);
    }
}

/* ---- a pass ---- */

static void place_light(int index, GLenum name)
{
    const struct source *source = &scene.source[index];
    const GLfloat place[4] = {(GLfloat)source->place[0], (GLfloat)source->place[1],
                              (GLfloat)source->place[2], source->positional ? 1.0F : 0.0F};
    const GLfloat axis[3] = {(GLfloat)source->axis[0], (GLfloat)source->axis[1],
                             (GLfloat)source->axis[2]};
    glEnable(name);
    glLightfv(name, GL_AMBIENT, black);
    glLightfv(name, GL_POSITION, place);
    glLightf(name, GL_CONSTANT_ATTENUATION, (GLfloat)source->attenuation[0]);
    glLightf(name, GL_LINEAR_ATTENUATION, (GLfloat)source->attenuation[1]);
    glLightf(name, GL_QUADRATIC_ATTENUATION, (GLfloat)source->attenuation[2]);
    glLightf(name, GL_SPOT_CUTOFF, source->spot ? (GLfloat)source->cutoff_deg : 180.0F);
    glLightf(name, GL_SPOT_EXPONENT, source->spot ? (GLfloat)source->exponent : 0.0F);
    if (source->spot)
        glLightfv(name, GL_SPOT_DIRECTION, axis);
}

/* Products of spectra are the colours of the lights; the material is white. */
static void set_material(const struct material *material)
{
    const int shines = material->gloss >= 0;
    for (int i = 0; i < LIGHTS; i++) {
        if (!material->lit[i])
            continue;
        glLightfv(GL_LIGHT0 + (GLenum)i, GL_DIFFUSE, material->diffuse[i]);
        glLightfv(GL_LIGHT0 + (GLenum)i, GL_SPECULAR, material->specular[i]);
    }
    glMaterialfv(GL_FRONT_AND_BACK, GL_AMBIENT, material->constant);
    glMaterialfv(GL_FRONT_AND_BACK, GL_SPECULAR, shines ? white : black);
    if (shines)
        glMaterialf(GL_FRONT_AND_BACK, GL_SHININESS, material->gloss);
}

static void draw_instance(const struct instance *instance)
{
    const struct mesh *mesh = &scene.mesh[instance->mesh];
    const GLsizei step = 8 * sizeof(float);
    set_material(&scene.material[instance->material]);
    glDisable(GL_TEXTURE_2D);
    glDisableClientState(GL_TEXTURE_COORD_ARRAY);
    if (instance->texture >= 0) {
        glEnable(GL_TEXTURE_2D);
        glEnableClientState(GL_TEXTURE_COORD_ARRAY);
        glBindTexture(GL_TEXTURE_2D, scene.texture[instance->texture].name);
        glTexCoordPointer(2, GL_FLOAT, step, mesh->vertices + 6);
    }
    glVertexPointer(3, GL_FLOAT, step, mesh->vertices);
    glNormalPointer(GL_FLOAT, step, mesh->vertices + 3);
    glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, instance->two_sided);
    glFrontFace(instance->clockwise ? GL_CW : GL_CCW);
    load_matrix(GL_MODELVIEW, instance->matrix);
    glDrawElements(GL_TRIANGLES, 3 * mesh->n_triangles, GL_UNSIGNED_INT, mesh->triangles);
}

/* ---- shadows ---- */

/* Counts triangles that are turned outward, or inward: up where a back is hidden, down where a
 * front is. */
static void count_triangles(const struct volume *volume, int first, int n, int outward)
{
    glStencilOpSeparate(outward ? GL_BACK : GL_FRONT, GL_KEEP, GL_INCR_WRAP, GL_KEEP);
    glStencilOpSeparate(outward ? GL_FRONT : GL_BACK, GL_KEEP, GL_DECR_WRAP, GL_KEEP);
    glVertexPointer(3, GL_FLOAT, 0, volume->corners + 9 * first);
    glDrawArrays(GL_TRIANGLES, 0, 3 * n);
}

/* Depths are clamped but for the caps, which are cut as surfaces are. */
static void count_volume(const struct volume *volume)
{
    const int n_caps = volume->n_caps, n = volume->n_triangles;
    glFrontFace(volume->clockwise ? GL_CW : GL_CCW);
    load_matrix(GL_MODELVIEW, volume->matrix);
    glEnable(GL_DEPTH_CLAMP);
    count_triangles(volume, n_caps, volume->n_outward - n_caps, 1);
    glDisable(GL_DEPTH_CLAMP);
    count_triangles(volume, 0, n_caps, 1);
    count_triangles(volume, volume->n_outward, n - volume->n_outward, 0);
}

/* Makes black what lies in some volume, and clears the counts. */
static void darken(float *pixels)
{
    const size_t n = (size_t)scene.width * (size_t)scene.height;
    uint32_t *counts = calloc(n, sizeof *counts);
    glReadPixels(0, 0, scene.width, scene.height, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, counts);
    for (size_t i = 0; i < n; i++)
        if ((counts[i] & 0xff) != 0)
            memset(pixels + 4 * i, 0, 4 * sizeof *pixels);
    glClear(GL_STENCIL_BUFFER_BIT);
    free(counts);
}

/* Makes black, in the picture of a group, what its light does not reach: where the surfaces, whose
 * depths are there, lie in some volume. A surface lies in no more volumes than there are caps. */
static void shadow_group(int group, float *pixels)
{
    int n_caps = 0;
    glDisable(GL_LIGHTING);
    glDisable(GL_TEXTURE_2D);
    glDisableClientState(GL_TEXTURE_COORD_ARRAY);
    glDisableClientState(GL_NORMAL_ARRAY);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDepthMask(GL_FALSE);
    glEnable(GL_STENCIL_TEST);
    glClear(GL_STENCIL_BUFFER_BIT);
    for (int i = 0; i < scene.n_volumes; i++) {
        const struct volume *volume = &scene.volume[i];
        const int more = volume->n_caps + volume->n_triangles - volume->n_outward;
        if (volume->group != group)
            continue;
        if (n_caps > 0 && n_caps + more > 255) {
            darken(pixels);
            n_caps = 0;
        }
        count_volume(volume);
        n_caps += more;
    }
    darken(pixels);
    glDisable(GL_STENCIL_TEST);
    glStencilOp(GL_INCR_WRAP, GL_INCR_WRAP, GL_INCR_WRAP);
    glDepthMask(GL_TRUE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glEnableClientState(GL_NORMAL_ARRAY);
    glEnable(GL_LIGHTING);
}

/* Draws the scene under a group of lights, into 4 floats a pixel. */
static void draw_group(int group, float *pixels)
{
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glLoadIdentity(); /* lights are given in eye coordinates */
    for (int i = 0; i < LIGHTS; i++) {
        const int light = scene.first[group] + i;
        if (i < scene.n_lights[group] && scene.source[checked(light)].present)
            place_light(light, GL_LIGHT0 + (GLenum)i);
        else
            glDisable(GL_LIGHT0 + (GLenum)i);
    }
    for (int i = 0; i < scene.n_instances; i++)
        draw_instance(&scene.instance[i]);
    glReadPixels(0, 0, scene.width, scene.height, GL_RGBA, GL_FLOAT, pixels);
}

/* Draws all passes. Each has three bands; the pictures of its groups of lights are added. */
static void draw_passes(const char *out)
{
    const size_t n = 4 * (size_t)scene.width * (size_t)scene.height;
    float *sum = calloc(n, sizeof *sum), *part = calloc(n, sizeof *part);
    FILE *file = open_file(scene.folder, "passes.txt", "r");
    struct line line;
    int more = next_line(file, &line);
    glEnableClientState(GL_NORMAL_ARRAY);
    for (int band = 0; band < scene.n_bands; band += 3) {
        char name[64];
        load_textures(band);
        memset(sum, 0, n * sizeof *sum);
        while (more && line.band == band) {
            const int group = line.group;
            while (more && line.band == band && line.group == group) {
                take_line(&line);
                more = next_line(file, &line);
            }
            draw_group(group, part);
            shadow_group(group, part);
            for (size_t i = 0; i < n; i++)
                sum[i] += part[i];
        }
        snprintf(name, sizeof name, "colours-%d.bin", band);
        write_numbers(out, name, sum, n, sizeof *sum);
    }
    glDisableClientState(GL_NORMAL_ARRAY);
    fclose(file);
    free(sum);
    free(part);
}

/* ---- triangles, depths and fragments ---- */

/* Draws each triangle in the colour of its number: its low 16 bits, its high bits, the number of
 * its instance. */
static void number_instance(const struct instance *instance)
{
    const struct mesh *mesh = &scene.mesh[instance->mesh];
    const size_t n = 3 * (size_t)mesh->n_triangles;
    float(*corners)[6] = malloc(n * sizeof *corners + 1);
    for (size_t i = 0; i < n; i++) {
        const size_t triangle = i / 3;
        memcpy(corners[i], mesh->vertices + 8 * (size_t)mesh->triangles[i], 3 * sizeof(float));
        corners[i][3] = (float)(triangle & 0xffff);
        corners[i][4] = (float)(triangle >> 16);
        corners[i][5] = (float)instance->number;
    }
    load_matrix(GL_MODELVIEW, instance->matrix);
    glVertexPointer(3, GL_FLOAT, sizeof *corners, corners[0]);
    glColorPointer(3, GL_FLOAT, sizeof *corners, &corners[0][3]);
    glDrawArrays(GL_TRIANGLES, 0, (GLsizei)n);
    free(corners);
}

/* The stencil counts fragments, hidden ones too. */
static void draw_numbers(const char *out)
{
    const size_t n = (size_t)scene.width * (size_t)scene.height;
    float *numbers = calloc(n, 4 * sizeof *numbers);
    uint32_t *depths = calloc(n, sizeof *depths);
    glDisable(GL_LIGHTING);
    glDisable(GL_TEXTURE_2D);
    glDisableClientState(GL_TEXTURE_COORD_ARRAY);
    glShadeModel(GL_FLAT);
    glEnable(GL_STENCIL_TEST);
    glEnableClientState(GL_COLOR_ARRAY);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    for (int i = 0; i < scene.n_instances; i++)
        number_instance(&scene.instance[i]);
    glReadPixels(0, 0, scene.width, scene.height, GL_RGBA, GL_FLOAT, numbers);
    glReadPixels(0, 0, scene.width, scene.height, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, depths);
    write_numbers(out, "numbers.bin", numbers, n, 4 * sizeof *numbers);
    write_numbers(out, "depths.bin", depths, n, sizeof *depths);
    free(numbers);
    free(depths);
}

static void write_names(const char *out)
{
    FILE *file = open_file(out, "drawn.txt", "w");
    GLint bits = 0;
    glGetIntegerv(GL_SUBPIXEL_BITS, &bits);
    fprintf(file, "id %s\nrenderer %s\nversion %s\nsize %d %d\nsubpixel-bits %d\ndepth-bits 24\n",
            scene.id, (const char *)glGetString(GL_RENDERER), (const char *)glGetString(GL_VERSION),
            scene.width, scene.height, bits);
    if (fclose(file) != 0)
        fail("cannot write drawn.txt");
}

/* Draws the files whose names begin with `from`, into files whose names begin with `to`. */
static void draw(const char *from, const char *to)
{
    read_scene(from);
    open_context();
    open_buffer();
    set_state();
    load_matrix(GL_PROJECTION, scene.projection);
    load_textures(-1);
    draw_passes(to);
    draw_numbers(to);
    if (glGetError() != GL_NO_ERROR)
        fail("OpenGL reports an error");
    write_names(to);
}

/* Draws the scene and its targets, by a process each. */
int main(int argc, char **argv)
{
    static const char *const prefixes[] = {"", "targets-"};
    char from[4096], to[4096];
    int status = 0;
    if (argc < 2 || argc > 3)
        fail("usage: draw FOLDER [DRAWN]");
    mkdir(argv[argc - 1], 0777);
    for (int i = 0; i < 2; i++) {
        snprintf(from, sizeof from, "%.4000s/%s", argv[1], prefixes[i]);
        snprintf(to, sizeof to, "%.4000s/%s", argv[argc - 1], prefixes[i]);
        if (fork() == 0) {
            draw(from, to);
            return 0;
        }
        wait(&status);
        if (status != 0)
            return 1;
    }
    return 0;
}
