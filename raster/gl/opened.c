/* SPDX-License-Identifier: MIT */
/* Renderers through OpenGL share this: uploads, the library as it describes itself, and the driver
 * by which it is judged. Geometry is uploaded once, and drawn once more in numbers. Only this file
 * says how a vertex lies in a buffer. */
#include "raster/gl/inside.h"

/* ---- meshes ---- */

/* Fills the bound buffer with the vertices of a mesh. */
static bool upload_vertices(const struct drawing *of, const struct mesh *mesh, struct error *err)
{
    const size_t n = VERTEX_NUMBERS * (size_t)mesh->n_vertices;
    float *floats;
    if (!MAKE_ARRAY(floats, n, err, "%d vertices of a mesh", mesh->n_vertices))
        return false;
    for (int i = 0; i < mesh->n_vertices; i++)
        vertex_numbers(&mesh->vertices[i], floats + VERTEX_NUMBERS * (size_t)i);
    of->call->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(n * sizeof *floats), floats, GL_STATIC_DRAW);
    free(floats);
    return true;
}

/* Returns the name of the buffer of an instance's triangles: its mesh's, or its own if it hides
 * some of them. 0: there is none yet. */
static GLuint *index_buffer(const struct drawing *of, int instance)
{
    return &of->indices[of->lit->bounds[instance].hidden ? of->plan->n_meshes + instance
                                                         : of->plan->instances[instance].mesh];
}

/* Fills the bound buffer with the triangles of an instance that are not hidden. */
static bool upload_triangles(const struct drawing *of, int instance, struct error *err)
{
    const struct mesh *mesh = &of->plan->meshes[of->plan->instances[instance].mesh].mesh;
    const bool *hidden = of->lit->bounds[instance].hidden;
    size_t n = 0;
    int32_t(*indices)[3];
    if (!MAKE_ARRAY(indices, mesh->n_triangles, err, "the triangles of %s",
                    object_name(of->plan, instance)))
        return false;
    for (int i = 0; i < mesh->n_triangles; i++)
        if (!hidden || !hidden[i])
            memcpy(indices[n++], mesh->triangles[i], sizeof *indices);
    of->call->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(n * sizeof *indices), indices,
                         GL_STATIC_DRAW);
    free(indices);
    return true;
}

/* Makes a buffer, unless it has a name already, and binds it. Returns whether it is new. */
static bool bind_buffer(const struct drawing *of, GLenum target, GLuint *name)
{
    const bool is_new = *name == 0;
    if (is_new)
        of->call->GenBuffers(1, name);
    of->call->BindBuffer(target, *name);
    return is_new;
}

static bool upload_instance(const struct drawing *of, int instance, struct error *err)
{
    const int mesh = of->plan->instances[instance].mesh;
    return !of->plan->instances[instance].in_view ||
           ((!bind_buffer(of, GL_ARRAY_BUFFER, &of->objects[mesh]) ||
             upload_vertices(of, &of->plan->meshes[mesh].mesh, err)) &&
            (!bind_buffer(of, GL_ELEMENT_ARRAY_BUFFER, index_buffer(of, instance)) ||
             upload_triangles(of, instance, err)));
}

/* Uploads all meshes that are drawn. Nothing is uploaded twice, and nothing of an instance out of
 * view. */
static bool meshes_upload(struct drawing *of, struct error *err)
{
    const int n = of->plan->n_instances, n_meshes = of->plan->n_meshes;
    if (!MAKE_ARRAY(of->objects, n_meshes, err, "%d meshes", n_meshes) ||
        !MAKE_ARRAY(of->indices, n_meshes + n, err, "%d objects", n))
        return false;
    for (int i = 0; i < n; i++)
        if (!upload_instance(of, i, err))
            return false;
    return true;
}

int mesh_bind(struct drawing *of, int instance)
{
    turn_fronts(of, of->plan->instances[instance].instance.mirrored);
    of->call->BindBuffer(GL_ARRAY_BUFFER, of->objects[of->plan->instances[instance].mesh]);
    of->call->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, *index_buffer(of, instance));
    return 3 * (of->plan->instances[instance].instance.n_triangles -
                of->lit->bounds[instance].n_hidden);
}

/* ---- triangles with their numbers as colours ---- */

static void number_triangle(const struct mesh *mesh, int triangle, int placed,
                            struct numbered_vertex out[3])
{
    for (int i = 0; i < 3; i++) {
        struct vector p = mesh->vertices[mesh->triangles[triangle][i]].position;
        out[i] = (struct numbered_vertex){
            {(float)p.x, (float)p.y, (float)p.z},
            {(float)(triangle & 0xffff), (float)(triangle >> 16), (float)(placed + 1)}};
    }
}

static void draw_instance(const struct drawing *of, int instance,
                          struct numbered_vertex batch[3 * BATCH])
{
    const struct mesh *mesh = &of->plan->meshes[of->plan->instances[instance].mesh].mesh;
    const bool *hidden = of->lit->bounds[instance].hidden;
    int n = 0;
    of->kind->place(of, instance);
    for (int i = 0; i < mesh->n_triangles; i++) {
        if (!hidden || !hidden[i])
            number_triangle(mesh, i, instance, batch + 3 * (size_t)n++);
        if (n == BATCH || (n > 0 && i + 1 == mesh->n_triangles)) {
            of->kind->draw_corners(of, batch, 3 * n);
            n = 0;
        }
    }
}

bool numbers_draw(struct drawing *of, struct error *err)
{
    struct numbered_vertex *batch;
    if (!MAKE_ARRAY(batch, 3 * BATCH, err, "%d triangles", BATCH))
        return false;
    for (int i = 0; i < of->plan->n_instances; i++)
        if (surface_reaches(&of->lit->bounds[i], &of->tile))
            draw_instance(of, i, batch);
    free(batch);
    return true;
}

/* ---- textures ---- */

/* Textures as OpenGL keeps them. Texels are of single precision: Mesa filters texels of 8 bits with
 * weights of 8 bits. */

static bool fits(const struct drawing *of, const struct texture *texture, struct error *err)
{
    GLint largest = 0;
    of->call->GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    if (texture->image.width > largest || texture->image.height > largest)
        return error_system(err, "%.500s: this OpenGL has textures of at most %d texels a side",
                            texture->image.path, largest);
    return !texture->linear || !of->renderer.unfiltered ||
           error_unsupported(err, "%.500s: this OpenGL ES does not filter floats; add `nearest`",
                             texture->image.path);
}

/* The names of a texture: one for each frame of a batch if it is spectral, otherwise one. */
static GLuint *texture_names(const struct drawing *of, const struct texture *texture)
{
    return of->textures + (texture - of->plan->textures) * of->renderer.n_at_once;
}

static int count_names(const struct drawing *of, const struct texture *texture)
{
    return texture->spectral ? of->renderer.n_at_once : 1;
}

/* The next calls set the texture of this unit. */
static void choose_unit(const struct drawing *of, int unit)
{
    if (of->renderer.n_at_once > 1)
        of->call->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
}

void texture_bind(struct drawing *of, const struct texture *texture)
{
    for (int i = 0; i < count_names(of, texture) && of->texture != texture; i++) {
        choose_unit(of, i);
        of->call->BindTexture(GL_TEXTURE_2D, texture_names(of, texture)[i]);
    }
    of->texture = texture;
}

struct texel_format {
    GLint internal;
    GLenum format;
    size_t n_channels;
};

static void upload_levels(const struct drawing *of, const struct texture *texture,
                          const struct texel_format *format, const float *values)
{
    const struct texels texels = {
        .values = values, .width = texture->image.width, .height = texture->image.height};
    for (int k = 0; k < texture->n_levels; k++) {
        const struct texels level = texel_level(&texels, k);
        of->call->TexImage2D(GL_TEXTURE_2D, k, format->internal, level.width, level.height, 0,
                             format->format, GL_FLOAT,
                             values + (size_t)(level.values - values) * format->n_channels);
    }
}

/* A spectral texture has no texels yet. */
static bool upload_texture(struct drawing *of, int index, struct error *err)
{
    const struct texture *texture = &of->plan->textures[index];
    const bool shaders = of->contexts->way != GL_WITHOUT_SHADERS;
    const GLint filter = texture->linear ? GL_LINEAR : GL_NEAREST,
                smaller = texture->mipmapped ? GL_LINEAR_MIPMAP_LINEAR : filter;
    if (!fits(of, texture, err))
        return false;
    of->call->GenTextures(count_names(of, texture), texture_names(of, texture));
    texture_bind(of, texture);
    for (int i = 0; i < count_names(of, texture); i++) {
        choose_unit(of, i);
        of->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, smaller);
        of->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
        of->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
        of->call->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_REPEAT);
    }
    const struct texel_format grey = {shaders ? GL_R32F : GL_LUMINANCE32F_ARB,
                                      shaders ? GL_RED : GL_LUMINANCE, 1};
    if (!texture->spectral)
        upload_levels(of, texture, &grey, texture->plane[0]);
    return true;
}

static bool textures_upload(struct drawing *of, struct error *err)
{
    const int n = of->plan->n_textures;
    if (!MAKE_ARRAY(of->textures, n * of->renderer.n_at_once, err, "%d textures", n))
        return false;
    for (int i = 0; i < n; i++)
        if (of->plan->textures[i].shown && !upload_texture(of, i, err))
            return false;
    return true;
}

static bool upload_bands(struct drawing *of, struct texture *texture,
                         const struct frame_batch *batch, struct error *err)
{
    static const struct texel_format rgb = {GL_RGB32F_ARB, GL_RGB, BANDS_PER_PASS};
    float *texels;
    bool done = MAKE_ARRAY(texels, texture->plane_size * BANDS_PER_PASS, err, "the texels of %s",
                           texture->image.path);
    texture_bind(of, texture);
    for (int i = 0; i < batch->n && done; i++) {
        done = pass_texels(of->plan, texture, batch->first_bands[i], texels, err);
        choose_unit(of, i);
        if (done)
            upload_levels(of, texture, &rgb, texels);
    }
    free(texels);
    return done;
}

bool textures_upload_bands(struct drawing *of, const struct frame_batch *batch, struct error *err)
{
    for (int i = 0; i < of->plan->n_textures; i++) {
        struct texture *texture = &of->plan->textures[i];
        if (texture->spectral && texture_names(of, texture)[0] &&
            !upload_bands(of, texture, batch, err))
            return false;
    }
    return true;
}

/* ---- a library as it describes itself ---- */

#ifdef OSMESA_VERSION /* built in; asking a context of softpipe would take tens of milliseconds */
static const char *const built_in = "OSMesa " OSMESA_VERSION " (softpipe), built in";
#else
static const char *const built_in = NULL;
#endif

static void copy_text(const struct gl_functions *call, GLenum name, char out[128])
{
    snprintf(out, 128, "%s", (const char *)call->GetString(name));
}

static void identify(const struct contexts *contexts, struct renderer_names *out)
{
    snprintf(out->library, sizeof out->library, "%s", contexts->kind->name);
    copy_text(&contexts->call, GL_RENDERER, out->renderer);
    copy_text(&contexts->call, GL_VERSION, out->version);
}

bool contexts_describe(const struct plan_options *wish, struct context_description *out,
                       struct error *err)
{
    struct contexts *contexts;
    struct canvas *canvas;
    GLfloat pixel[4];
    const bool done = contexts_open(wish, &contexts, err) &&
                      canvas_open(contexts, 32, 1, 1, &canvas, err) &&
                      canvas_use(canvas, pixel, err);
    if (done) {
        const struct gl_functions *call = &contexts->call;
        identify(contexts, &out->names);
        copy_text(call, GL_VENDOR, out->vendor);
        call->GetIntegerv(GL_MAX_VIEWPORT_DIMS, out->largest_viewport);
        call->GetIntegerv(GL_MAX_TEXTURE_SIZE, &out->largest_texture);
        call->GetIntegerv(GL_SUBPIXEL_BITS, &out->subpixel_bits);
        call->GetIntegerv(GL_DEPTH_BITS, &out->depth_bits);
        if (out->depth_bits == 0) /* a core profile does not say what a canvas has asked for */
            out->depth_bits = 24;
    }
    contexts_close(contexts);
    return done;
}

bool gl_library(char *out, size_t capacity)
{
    const struct plan_options wish = {.threads = 1};
    struct context_description is;
    struct error err = {.status = EXIT_AGREED};
    const bool done = built_in || contexts_describe(&wish, &is, &err);
    if (built_in)
        snprintf(out, capacity, "%s", built_in);
    else if (done)
        snprintf(out, capacity, "%s %s (%s)", is.names.library, is.names.version,
                 is.names.renderer);
    else
        snprintf(out, capacity, "OpenGL cannot draw: %s", error_words(&err));
    return done;
}

/* ---- opening ---- */

static bool make_buffers(struct drawing *of, int n_buffers, struct error *err)
{
    const struct plan *plan = of->plan;
    const size_t n = (size_t)plan->tile_width * (size_t)plan->tile_height,
                 size = plan->options.buffer_bits > 8 ? 8 : 4,
                 n_shadows = (size_t)plan->view.n_shadowed;
    return renderer_make_buffers(&of->renderer, n_buffers + of->renderer.n_at_once - 1, n,
                                 "the pixels of a tile", err) &&
           (n_shadows == 0 ||
            (MAKE_ARRAY(of->reached, n_shadows * n, err, "the shadows of a tile") &&
             MAKE_ARRAY(of->counts, n, err, "the shadows of a tile"))) &&
           (plan->n_light_groups == 1 ||
            MAKE_ARRAY(of->part, 4 * n, err, "the pixels of a tile")) &&
           (!plan->options.check || (MAKE_ARRAY(of->shown, 4 * n, err, "the numbers of a tile") &&
                                     MAKE_ARRAY(of->depths, n, err, "the depths of a tile"))) &&
           (buffer_steps(plan) == 0 ||
            MAKE_ARRAY(of->steps, size * n, err, "the pixels of a tile"));
}

/* Opens a canvas of the size of a tile, and lets OpenGL draw there. */
static bool open_canvas(struct drawing *of, bool numbers, struct error *err)
{
    const struct plan *plan = of->plan;
    return canvas_open(of->contexts, of->steps && !numbers ? plan->options.buffer_bits : 32,
                       plan->tile_width, plan->tile_height, numbers ? &of->numbers : &of->colours,
                       err) &&
           frame_begin(of, numbers ? of->shown : of->renderer.buffers[0], numbers, err);
}

/* Takes the names of what draws the plan, and the driver of that name. A canvas is in use. Refuses
 * a tile that is too large for OpenGL, another driver than the wanted one, which was chosen before
 * the first canvas, and what driver_has_threads refuses. */
static bool accept(struct drawing *of, struct error *err)
{
    const struct contexts *contexts = of->contexts;
    const bool is_es = contexts->way == GL_ES;
    const char *wanted = of->plan->options.gl_driver;
    struct renderer_names *names = &of->renderer.names;
    GLint largest[2] = {0, 0};
    of->call->GetIntegerv(GL_MAX_VIEWPORT_DIMS, largest);
    if (largest[0] < of->plan->tile_width || largest[1] < of->plan->tile_height)
        return error_unsupported(err, "%s draws at most %d x %d pixels at once",
                                 contexts->kind->name, largest[0], largest[1]);
    identify(contexts, names);
    /* OpenGL ES filters floats, and has its depths read, where an extension allows it */
    of->renderer.unfiltered = is_es && !contexts_have(contexts, "GL_OES_texture_float_linear");
    of->renderer.lacks.depths =
        is_es && of->plan->options.check && !contexts_have(contexts, "GL_NV_read_depth_stencil");
    if (wanted && strncmp(names->renderer, wanted, strlen(wanted)) != 0)
        return error_unsupported(err,
                                 "this %s draws with %.100s, not with %s; --renderer %s takes any "
                                 "driver",
                                 names->library, names->renderer, wanted,
                                 renderer_words[contexts->way * WAY_WORDS]);
    of->renderer.driver = *driver_of(names->renderer);
    driver_of_version(&of->renderer.driver, names->version);
    return driver_has_threads(names->renderer, err) && shadows_can_draw(of, err);
}

bool drawing_open(const struct drawing_kind *kind, const struct plan *plan, int n_buffers,
                  struct renderer **out, struct error *err)
{
    struct drawing *of;
    *out = NULL;
    if (!memory_make(&of, 1, kind->size))
        return memory_lacks(err, (double)kind->size, "a renderer");
    *out = &of->renderer;
    of->renderer.kind = &drawing_renderer;
    of->kind = kind;
    of->plan = plan;
    of->front = GL_CCW;
    of->renderer.n_at_once =
        plan->n_passes < kind->most_at_once ? plan->n_passes : kind->most_at_once;
    if (!make_buffers(of, n_buffers, err) || !contexts_open(&plan->options, &of->contexts, err))
        return false;
    of->contexts->n_colours = of->renderer.n_at_once;
    of->call = &of->contexts->call;
    if (!open_canvas(of, false, err) || !accept(of, err) || !kind->set_state(of, err))
        return false;
    if (of->steps && plan->options.check &&
        (!open_canvas(of, true, err) || !kind->set_state(of, err) ||
         !frame_begin(of, NULL, false, err)))
        return false;
    return functions_succeeded(of->call, err);
}

bool drawing_take_scene(struct renderer *renderer, const struct lit_scene *lit, struct error *err)
{
    struct drawing *of = (struct drawing *)renderer;
    of->lit = lit;
    return meshes_upload(of, err) && textures_upload(of, err) && functions_succeeded(of->call, err);
}
