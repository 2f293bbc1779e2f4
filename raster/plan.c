/* SPDX-License-Identifier: MIT */
/* What a scene calls for, decided once and before anything is drawn: which lights shine, which
 * terms each material needs, which passes and tiles follow. What is not planned here is not
 * computed. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef _OPENMP
#include <omp.h>
#endif

#include "spectral.h"

/* Bytes that a pixel of a tile takes apart from its terms: Mesa's own colour and depth (20), our
 * copy of its colour (16), counts (4), surface and flag (5), the constant part's error (4), and
 * room for contested pixels (15). A term adds a weight (8) and an error (4). */
enum { PIXEL_BYTES = 64, TERM_BYTES = 12 };
/* What a tile may take, so that a render stays well below 300 MiB with Mesa's own memory. */
static const size_t tile_budget = (size_t)96 << 20;
/* Tiles no larger than Mesa's largest viewport (16384), with room for older drivers. */
enum { LARGEST_TILE = 8192 };

/* ---- what cannot be simulated is refused, never left out in silence ---- */

static bool refuse(struct error *err, struct place place, const char *what)
{
    return error_at(err, place, "%s cannot be simulated by this version; remove it from the scene",
                    what);
}

static bool refuse_material(const struct material *material, struct error *err)
{
    if (material->excitation.kind != SPECTRUM_NONE)
        return refuse(err, material->excitation.place, "fluorescence");
    if (material->donaldson)
        return refuse(err, material->donaldson_place, "bispectral fluorescence");
    if (material->texture)
        return refuse(err, material->texture_place, "a texture");
    if (material->spectral_texture)
        return refuse(err, material->spectral_texture_place, "a spectral texture");
    if (material->glow.kind != SPECTRUM_NONE)
        return refuse(err, material->glow.place, "emission");
    if (material->partner || material->partner_name)
        return refuse(err, material->partner_place, "a metameric partner");
    return true;
}

static bool refuse_light(const struct light *light, struct error *err)
{
    if (light->spot)
        return refuse(err, light->spot_place, "a spot light");
    if (light->attenuation[0] != 1 || light->attenuation[1] != 0 || light->attenuation[2] != 0)
        return refuse(err, light->attenuation_place, "attenuation with distance");
    return true;
}

static bool refuse_unsupported(const struct scene *scene, struct error *err)
{
    if (scene->flat_shading)
        return refuse(err, scene->shading_place, "flat shading");
    for (int i = 0; i < scene->n_lights; i++)
        if (!refuse_light(&scene->lights[i], err))
            return false;
    for (int i = 0; i < scene->n_objects; i++) {
        const struct object *object = &scene->objects[i];
        if (object->shape.material_map)
            return refuse(err, object->shape.place, "a material map");
        if (!refuse_material(&scene->materials[object->material], err))
            return false;
    }
    return true;
}

/* ---- memory ---- */

static bool plan_array(void *out, size_t count, size_t size, struct error *err)
{
    void *memory = calloc(count ? count : 1, size);
    memcpy(out, &memory, sizeof memory);
    return memory || error_memory(err);
}

/* ---- lights ---- */

static bool light_is_dark(const struct light *light, const struct scene *scene)
{
    if (light->intensity == 0)
        return true;
    for (int i = 0; i < scene->n_wavelengths; i++)
        if (spectrum_at(&light->spectrum, scene->wavelengths_nm[i], SPECTRUM_ZERO) != 0)
            return false;
    return true;
}

static bool plan_lights(struct plan *plan, const struct matrix *view, struct error *err)
{
    const struct scene *scene = plan->scene;
    for (int i = 0; i < scene->n_lights; i++) {
        const struct light *light = &scene->lights[i];
        if (light_is_dark(light, scene))
            continue;
        if (plan->n_lights == MAX_GL_LIGHTS)
            return error_at(err, light->place, "more than %d lights shine; this version draws %d",
                            MAX_GL_LIGHTS, MAX_GL_LIGHTS);
        struct plan_light *planned = &plan->lights[plan->n_lights++];
        planned->light = light;
        planned->eye_position =
            light->directional
                ? vector_normalise(matrix_direction(view, vector_normalise(light->position)))
                : matrix_point(view, light->position);
    }
    return true;
}

/* ---- materials become finishes ---- */

static double ambient_at(const struct scene *scene, double wavelength_nm)
{
    double sum = 0;
    for (int i = 0; i < scene->n_ambients; i++)
        sum += scene->ambients[i].intensity *
               spectrum_at(&scene->ambients[i].spectrum, wavelength_nm, SPECTRUM_ZERO);
    return sum;
}

/* Fills one row of term spectra; true when any wavelength of it is not 0. */
static bool term_spectrum(const struct scene *scene, const struct light *light,
                          const struct spectrum *reflectance, double *row)
{
    bool lit = false;
    for (int i = 0; i < scene->n_wavelengths; i++) {
        double wavelength = scene->wavelengths_nm[i];
        row[i] = light->intensity * spectrum_at(&light->spectrum, wavelength, SPECTRUM_ZERO) *
                 spectrum_at(reflectance, wavelength, SPECTRUM_HOLD);
        lit = lit || row[i] != 0;
    }
    return lit;
}

static void add_term(struct plan *plan, struct finish *finish, enum term_kind kind, int light)
{
    static const struct spectrum white = {
        .kind = SPECTRUM_CONSTANT, .factor = 1, .parameter = {1, 0}};
    const struct material *material = finish->material;
    const struct spectrum *reflectance = &material->diffuse;
    if (kind == TERM_SPECULAR)
        reflectance = material->specular.kind ? &material->specular : &white;
    double *row = finish->spectra + (size_t)finish->n_terms * (size_t)plan->n_bands;
    if (term_spectrum(plan->scene, plan->lights[light].light, reflectance, row))
        finish->terms[finish->n_terms++] = (struct term){kind, light};
}

static bool plan_finish(struct plan *plan, const struct material *material, struct finish *finish,
                        struct error *err)
{
    size_t n_bands = (size_t)plan->n_bands;
    finish->material = material;
    if (!plan_array(&finish->constant, n_bands, sizeof(double), err) ||
        !plan_array(&finish->spectra, 2 * (size_t)plan->n_lights * n_bands, sizeof(double), err))
        return false;
    for (size_t i = 0; i < n_bands; i++) {
        double wavelength = plan->scene->wavelengths_nm[i];
        finish->constant[i] = ambient_at(plan->scene, wavelength) *
                              spectrum_at(&material->diffuse, wavelength, SPECTRUM_HOLD);
    }
    for (int light = 0; light < plan->n_lights; light++) {
        add_term(plan, finish, TERM_DIFFUSE, light);
        if (material->gloss > 0)
            add_term(plan, finish, TERM_SPECULAR, light);
    }
    if (finish->n_terms > plan->max_terms)
        plan->max_terms = finish->n_terms;
    return true;
}

/* ---- objects become bodies ---- */

static bool same_shape(const struct shape *a, const struct shape *b)
{
    if (a->kind != b->kind)
        return false;
    if (a->kind == SHAPE_MESH)
        return strcmp(a->path, b->path) == 0 && a->unitize == b->unitize &&
               a->crease_deg == b->crease_deg;
    return memcmp(a->parameter, b->parameter, sizeof a->parameter) == 0;
}

static struct vector centre_of(const struct mesh *mesh)
{
    struct vector low = mesh->vertices[0].position, high = low;
    for (int i = 1; i < mesh->n_vertices; i++) {
        struct vector p = mesh->vertices[i].position;
        low = (struct vector){fmin(low.x, p.x), fmin(low.y, p.y), fmin(low.z, p.z)};
        high = (struct vector){fmax(high.x, p.x), fmax(high.y, p.y), fmax(high.z, p.z)};
    }
    return vector_add(vector_scale(low, 0.5), vector_scale(high, 0.5));
}

/* Builds the mesh, moved so that its bounding box is centred on the origin: single precision then
 * spends its digits on the shape and not on where it stands. */
static bool plan_mesh(struct plan *plan, const struct shape *shape, struct error *err)
{
    int index = plan->n_meshes++; /* counted first, so that plan_free reaches it after a failure */
    struct mesh *mesh = &plan->meshes[index];
    if (!shape_build(shape, mesh, err))
        return false;
    struct vector centre = centre_of(mesh);
    for (int i = 0; i < mesh->n_vertices; i++)
        mesh->vertices[i].position = vector_subtract(mesh->vertices[i].position, centre);
    plan->mesh_centre[index] = centre;
    return true;
}

/* The body that an earlier object with the same shape, or the same material, shares with it. */
static int find_mesh(const struct plan *plan, const struct object *object)
{
    for (int i = 0; i < plan->n_bodies; i++)
        if (same_shape(&plan->bodies[i].object->shape, &object->shape))
            return plan->bodies[i].mesh;
    return -1;
}

static int find_finish(const struct plan *plan, const struct object *object)
{
    for (int i = 0; i < plan->n_bodies; i++)
        if (plan->bodies[i].object->material == object->material)
            return plan->bodies[i].finish;
    return -1;
}

static bool plan_body(struct plan *plan, const struct object *object, const struct matrix *view,
                      struct error *err)
{
    struct body body = {
        .object = object, .mesh = find_mesh(plan, object), .finish = find_finish(plan, object)};
    if (body.mesh < 0) {
        body.mesh = plan->n_meshes;
        if (!plan_mesh(plan, &object->shape, err))
            return false;
    }
    if (body.finish < 0) {
        body.finish = plan->n_finishes++;
        if (!plan_finish(plan, &plan->scene->materials[object->material],
                         &plan->finishes[body.finish], err))
            return false;
    }
    struct matrix placed =
        matrix_product(object->transform, matrix_translation(plan->mesh_centre[body.mesh]));
    body.model_view = matrix_product(*view, placed);
    if (!matrix_normal(&body.model_view, &body.normal_matrix))
        return error_at(err, object->place,
                        "the object's transform is singular or not finite; "
                        "scale factors must not be 0 nor overflow together");
    plan->bodies[plan->n_bodies++] = body;
    plan->n_vertices += plan->meshes[body.mesh].n_vertices;
    plan->n_triangles += plan->meshes[body.mesh].n_triangles;
    return true;
}

static bool plan_bodies(struct plan *plan, const struct matrix *view, struct error *err)
{
    const struct scene *scene = plan->scene;
    size_t n = (size_t)scene->n_objects;
    if (!plan_array(&plan->bodies, n, sizeof *plan->bodies, err) ||
        !plan_array(&plan->meshes, n, sizeof *plan->meshes, err) ||
        !plan_array(&plan->mesh_centre, n, sizeof *plan->mesh_centre, err) ||
        !plan_array(&plan->finishes, n, sizeof *plan->finishes, err))
        return false;
    for (int i = 0; i < scene->n_objects; i++)
        if (!plan_body(plan, &scene->objects[i], view, err))
            return false;
    return true;
}

/* ---- camera and tiles ---- */

/* Eye space to clip space, as OpenGL's glOrtho and glFrustum define it. */
static struct matrix projection_of(const struct camera *camera, int width, int height)
{
    double aspect = (double)width / height, depth = camera->far - camera->near;
    struct matrix m = {{{0}}};
    if (camera->perspective) {
        double sine, cosine, cotangent;
        sine_cosine(camera->extent / 2, &sine, &cosine);
        cotangent = cosine / sine;
        m.row[0][0] = cotangent / aspect;
        m.row[1][1] = cotangent;
        m.row[2][2] = -(camera->far + camera->near) / depth;
        m.row[2][3] = -2 * camera->far * camera->near / depth;
        m.row[3][2] = -1;
    } else {
        m.row[0][0] = 2 / camera->extent;
        m.row[1][1] = 2 / camera->extent * aspect;
        m.row[2][2] = -2 / depth;
        m.row[2][3] = -(camera->far + camera->near) / depth;
        m.row[3][3] = 1;
    }
    return m;
}

/* Whole rows of the picture where they fit, so that a band of a tile is one piece of its page. */
static void plan_tiles(struct plan *plan)
{
    size_t pixel = PIXEL_BYTES + TERM_BYTES * (size_t)plan->max_terms;
    size_t pixels = tile_budget / pixel;
    int width = plan->scene->width, height = plan->scene->height;
    plan->tile_width = width < LARGEST_TILE ? width : LARGEST_TILE;
    size_t rows = pixels / (size_t)plan->tile_width;
    rows -= rows % CHUNK_ROWS;
    if (rows < CHUNK_ROWS)
        rows = CHUNK_ROWS;
    if (rows > LARGEST_TILE)
        rows = LARGEST_TILE;
    plan->tile_height = (int)rows < height ? (int)rows : height;
    plan->tile_bytes = (uint64_t)pixel * (uint64_t)plan->tile_width * (uint64_t)plan->tile_height;
    plan->file_bytes = (uint64_t)width * (uint64_t)height * (uint64_t)plan->n_bands *
                       (plan->options.floating ? 4 : 2);
}

/* ---- effects and their reasons ---- */

static void add_effect(struct plan *plan, const char *name, bool used, const char *format,
                       long first, long second)
{
    struct plan_effect *effect = &plan->effects[plan->n_effects++];
    effect->name = name;
    effect->used = used;
    snprintf(effect->reason, sizeof effect->reason, format, first, second);
}

static bool has_term(const struct finish *finish, enum term_kind kind)
{
    for (int i = 0; i < finish->n_terms; i++)
        if (finish->terms[i].kind == kind)
            return true;
    return false;
}

static bool has_constant(const struct plan *plan, const struct finish *finish)
{
    for (int i = 0; i < plan->n_bands; i++)
        if (finish->constant[i] != 0)
            return true;
    return false;
}

static void plan_effects(struct plan *plan)
{
    long ambient = 0, diffuse = 0, specular = 0, all = plan->n_finishes;
    for (int i = 0; i < plan->n_finishes; i++) {
        const struct finish *finish = &plan->finishes[i];
        ambient += has_constant(plan, finish);
        diffuse += has_term(finish, TERM_DIFFUSE);
        specular += has_term(finish, TERM_SPECULAR);
    }
    add_effect(plan, "ambient", ambient > 0,
               ambient ? "%ld of %ld materials" : "no ambient light reflected", ambient, all);
    add_effect(plan, "lights", plan->n_lights > 0, "%ld of %ld shine", plan->n_lights,
               plan->scene->n_lights);
    add_effect(plan, "diffuse", diffuse > 0,
               diffuse ? "%ld of %ld materials" : "no material reflects a light", diffuse, all);
    add_effect(plan, "specular", specular > 0,
               specular ? "%ld of %ld materials" : "no lit material has gloss", specular, all);
    add_effect(plan, "local_viewer", specular > 0 && plan->scene->local_viewer,
               !plan->scene->local_viewer ? "the viewer is infinite"
               : specular                 ? "the scene asks for it"
                                          : "no highlight depends on it",
               0, 0);
    add_effect(plan, "fluorescence", false, "no material has excitation", 0, 0);
    add_effect(plan, "bispectral", false, "no material has a Donaldson matrix", 0, 0);
    add_effect(plan, "texture", false, "no material has a texture", 0, 0);
    add_effect(plan, "spectral_texture", false, "no material has a spectral texture", 0, 0);
    add_effect(plan, "emission", false, "no material emits", 0, 0);
    add_effect(plan, "metamer", false, "no material has a partner", 0, 0);
}

static int available_threads(void)
{
#ifdef _OPENMP
    return omp_get_max_threads();
#else
    return 1;
#endif
}

bool plan_make(const struct scene *scene, const struct plan_options *options, struct plan *out,
               struct error *err)
{
    *out = (struct plan){.scene = scene, .options = *options};
    if (out->options.threads == 0)
        out->options.threads = available_threads();
    out->n_bands = scene->n_wavelengths;
    out->n_passes = (out->n_bands + BANDS_PER_PASS - 1) / BANDS_PER_PASS;
    struct matrix view = matrix_look_at(scene->camera.eye, scene->camera.look, scene->camera.up);
    out->projection = projection_of(&scene->camera, scene->width, scene->height);
    if (!refuse_unsupported(scene, err) || !plan_lights(out, &view, err) ||
        !plan_bodies(out, &view, err))
        return false;
    plan_tiles(out);
    plan_effects(out);
    return true;
}

/* ---- the plan in words ---- */

static void print_lights(const struct plan *plan, FILE *to)
{
    for (int i = 0; i < plan->scene->n_lights; i++) {
        const struct light *light = &plan->scene->lights[i];
        bool dark = light_is_dark(light, plan->scene);
        fprintf(to, "light %d           %s (%s, intensity %.6g)\n", i + 1,
                !dark                   ? "on"
                : light->intensity == 0 ? "off: intensity 0"
                                        : "off: spectrum 0 at every wavelength",
                light->spectrum.name, light->intensity);
    }
}

static void print_extrapolation(const struct plan *plan, const char *what, const char *ends,
                                const struct spectrum *spectrum, const char *owner, FILE *to)
{
    const struct scene *scene = plan->scene;
    int outside = 0;
    for (int i = 0; i < scene->n_wavelengths; i++)
        outside += spectrum_extrapolates(spectrum, scene->wavelengths_nm[i]);
    if (outside > 0)
        fprintf(to, "extrapolated      %s %s: %d of %d wavelengths outside %g..%g nm, %s there\n",
                what, owner, outside, scene->n_wavelengths, spectrum->wavelength_nm[0],
                spectrum->wavelength_nm[spectrum->count - 1], ends);
}

static void print_extrapolations(const struct plan *plan, FILE *to)
{
    const struct scene *scene = plan->scene;
    for (int i = 0; i < plan->n_lights; i++)
        print_extrapolation(plan, "light", "0", &plan->lights[i].light->spectrum,
                            plan->lights[i].light->spectrum.name, to);
    for (int i = 0; i < scene->n_ambients; i++)
        print_extrapolation(plan, "ambient", "0", &scene->ambients[i].spectrum,
                            scene->ambients[i].spectrum.name, to);
    for (int i = 0; i < plan->n_finishes; i++) {
        const struct material *material = plan->finishes[i].material;
        print_extrapolation(plan, "diffuse", "the end value holds", &material->diffuse,
                            material->name, to);
        if (has_term(&plan->finishes[i], TERM_SPECULAR))
            print_extrapolation(plan, "specular", "the end value holds", &material->specular,
                                material->name, to);
    }
}

void plan_print(const struct plan *plan, FILE *to)
{
    const struct scene *scene = plan->scene;
    int columns = (scene->width + plan->tile_width - 1) / plan->tile_width;
    int rows = (scene->height + plan->tile_height - 1) / plan->tile_height;
    long terms = 0;
    for (int i = 0; i < plan->n_finishes; i++)
        terms += plan->finishes[i].n_terms;
    fprintf(to, "scene             %s\n", scene->path);
    fprintf(to, "picture           %d x %d pixels\n", scene->width, scene->height);
    fprintf(to, "bands             %d (%.10g to %.10g nm)\n", plan->n_bands,
            scene->wavelengths_nm[0], scene->wavelengths_nm[plan->n_bands - 1]);
    fprintf(to, "objects           %d (%d meshes, %ld vertices, %ld triangles)\n", plan->n_bodies,
            plan->n_meshes, plan->n_vertices, plan->n_triangles);
    fprintf(to, "materials         %d (%ld terms, at most %d in one)\n", plan->n_finishes, terms,
            plan->max_terms);
    fprintf(to, "tiles             %d of %d x %d pixels\n", columns * rows, plan->tile_width,
            plan->tile_height);
    fprintf(to, "passes            %ld (%d a tile, %d bands each)\n",
            (long)plan->n_passes * columns * rows, plan->n_passes, BANDS_PER_PASS);
    fprintf(to, "memory            %.1f MiB for a tile\n", (double)plan->tile_bytes / 1048576);
    fprintf(to, "file              %llu bytes of pixels\n", (unsigned long long)plan->file_bytes);
    for (int i = 0; i < plan->n_effects; i++)
        fprintf(to, "%-17s %s (%s)\n", plan->effects[i].name, plan->effects[i].used ? "yes" : "no",
                plan->effects[i].reason);
    print_lights(plan, to);
    print_extrapolations(plan, to);
}

void plan_free(struct plan *plan)
{
    for (int i = 0; i < plan->n_meshes; i++)
        mesh_free(&plan->meshes[i]);
    for (int i = 0; i < plan->n_finishes; i++) {
        free(plan->finishes[i].constant);
        free(plan->finishes[i].spectra);
    }
    free(plan->meshes);
    free(plan->mesh_centre);
    free(plan->finishes);
    free(plan->bodies);
    *plan = (struct plan){0};
}
