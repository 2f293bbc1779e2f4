/* SPDX-License-Identifier: MIT */
/* Maps of a picture, by the reference: what each light gives to a pixel, and where its point lies.
 * The pages hold the weights and the textures of its decomposition, and the lines of the record
 * hold the spectra. Each light has terms of its own here, and a texture stays apart from the
 * weights. So the picture is drawn once more, from a plan of its own: the stack does not depend on
 * its maps. */
#include "raster/beside/see/inside.h"

enum { KEY = 64 };

/* The pages behind the weights. Lengths are those of the scene. */
enum { DEPTH, EYE, WORLD = EYE + 3, NORMAL = WORLD + 3, S = NORMAL + 3, T, OBJECT, TRIANGLE };
static const char *const place_names[] = {"depth",   "eye x",   "eye y",    "eye z",    "world x",
                                          "world y", "world z", "normal x", "normal y", "normal z",
                                          "s",       "t",       "object",   "triangle", "material"};
enum { MAP_MATERIAL = TRIANGLE + 1, PLACES };

struct maps {
    struct render_job job; /* its plan; scene and sampling are those of the render */
    struct lit_scene lit;
    int n_weights, n_textures; /* pages; those of places come after weights */
    struct stack_writer writer;
    float *values;                 /* of a chunk: the places; owned */
    const struct picture *picture; /* the chunk at hand */
};

/* ---- a file of pages ---- */

bool named_pages_open(struct stack_writer *out, const char *path, struct stack_options layout,
                      struct printed *record, struct printed *names, struct error *err)
{
    char *text = printed_take(record, err), *lines = printed_take(names, err);
    layout.provenance = text;
    layout.names = lines;
    const bool done = text && lines && stack_open(out, path, &layout, err);
    free(text);
    free(lines);
    return done;
}

bool named_pages_end(struct stack_writer *writer, bool done, const char *check,
                     struct outputs *outputs, struct error *err)
{
    done = done && stack_finish(writer, check, err) &&
           output_pass(&writer->pages.output, outputs, err);
    stack_discard(writer);
    return done;
}

/* ---- the pages ---- */

/* Prints the names of the pages in lines. */
static void name_pages(const struct maps *of, struct printed *to)
{
    const struct plan *plan = &of->job.plan;
    char band[BAND_NAME];
    print_text(to, "constant\n");
    for (int i = 0; i < 2 * plan->n_lights; i++)
        print(to, "light %d %s\n", 1 + i / 2, i % 2 ? "specular" : "diffuse");
    for (int i = 0; i < PLACES; i++)
        print(to, "%s\n", place_names[i]);
    for (int i = 0; i < of->n_textures; i++) {
        const bool alone = of->n_textures == 1;
        band_name(plan, i, band);
        print(to, "texture%s%s\n", alone ? "" : " ", alone ? "" : band);
    }
}

/* ---- the point of a pixel ---- */

/* Finds the point of the mesh that a pixel shows: of the triangle's parts, the one whose depth is
 * the pixel's. Returns the side that is seen. */
static int find_point(const struct maps *of, size_t pixel, struct vertex *out)
{
    const struct picture *picture = of->picture;
    const struct surface *surface = &of->lit.surfaces[picture->surface[pixel]];
    const double x = picture->at.x + (int)(pixel % (size_t)picture->at.width) + 0.5,
                 y = picture->at.y + (int)(pixel / (size_t)picture->at.width) + 0.5;
    struct screen_triangle parts[SCREEN_TRIANGLES];
    const int n = screen_triangles(&of->job.plan.view, surface, picture->triangle[pixel],
                                   depth_planes, 2, parts);
    int shown = 0;
    double share[3];
    while (shown < n - 1 && covered_depth(&parts[shown], x, y) != picture->depth[pixel])
        shown++;
    shares_at(&parts[shown], x, y, share);
    *out = (struct vertex){.s = 0};
    for (int j = 0; j < 3; j++) {
        const struct vertex *vertex = &surface->instance->vertices[parts[shown].vertex[j]];
        out->position = vector_add(out->position, vector_scale(vertex->position, share[j]));
        out->normal = vector_add(out->normal, vector_scale(vertex->normal, share[j]));
        out->s += share[j] * vertex->s;
        out->t += share[j] * vertex->t;
    }
    return parts[shown].side;
}

/* Turns a direction in eye space into one of the world, of the same length. */
static struct vector to_world(const struct plan *plan, struct vector eye)
{
    const struct vector scaled = vector_scale(eye, plan->unit);
    const double(*row)[4] = plan->world_to_eye.row;
    return (struct vector){row[0][0] * scaled.x + row[1][0] * scaled.y + row[2][0] * scaled.z,
                           row[0][1] * scaled.x + row[1][1] * scaled.y + row[2][1] * scaled.z,
                           row[0][2] * scaled.x + row[1][2] * scaled.y + row[2][2] * scaled.z};
}

static void put_vector(float *values, size_t n, struct vector vector)
{
    values[0] = (float)vector.x;
    values[n] = (float)vector.y;
    values[2 * n] = (float)vector.z;
}

static void put_place(const struct maps *of, size_t pixel, float *values)
{
    const struct plan *plan = &of->job.plan;
    const size_t n = picture_pixels(of->picture);
    const int surface = of->picture->surface[pixel];
    const struct instance *instance = &plan->instances[surface].instance;
    struct vertex point;
    const int side = find_point(of, pixel, &point);
    const struct vector eye = vector_scale(matrix_point(&instance->model_view, point.position),
                                           plan->unit),
                        normal = vector_normalise(
                            matrix_direction(&instance->normal_matrix, point.normal));
    values[DEPTH * n] = (float)-eye.z;
    put_vector(values + EYE * n, n, eye);
    put_vector(values + WORLD * n, n, vector_add(plan->scene->camera.eye, to_world(plan, eye)));
    put_vector(values + NORMAL * n, n, to_world(plan, vector_scale(normal, side == 1 ? -1 : 1)));
    values[S * n] = (float)point.s;
    values[T * n] = (float)point.t;
    values[OBJECT * n] = (float)(surface + 1);
    values[TRIANGLE * n] = (float)(of->picture->triangle[pixel] + 1);
    values[MAP_MATERIAL * n] = (float)(plan->instances[surface].shaded + 1);
}

/* Finds the places of the pixels of the chunk. */
static void put_places(const struct maps *of)
{
    const size_t n = picture_pixels(of->picture);
    for (size_t i = 0; i < n; i++) {
        for (size_t page = 0; page < PLACES; page++)
            of->values[page * n + i] = 0;
        if (of->picture->surface[i] >= 0)
            put_place(of, i, of->values + i);
    }
}

/* ---- the chunks ---- */

static bool write_page(const struct maps *of, int page, const float *values, struct error *err)
{
    const struct rectangle *at = &of->picture->at;
    const struct page_rectangle to = {page, at->x, at->y, at->width, at->height};
    return pages_write(&of->writer.pages, &to, values, err);
}

/* Writes a page of the decomposition; beside the first one, the places. */
static bool take_page(void *context, const struct picture *picture, int page, const float *values,
                      struct error *err)
{
    struct maps *of = context;
    const size_t n = picture_pixels(picture);
    bool done = true;
    of->picture = picture;
    if (page == 0)
        put_places(of);
    for (int i = 0; page == 0 && done && i < PLACES; i++)
        done = write_page(of, of->n_weights + i, of->values + (size_t)i * n, err);
    return done && write_page(of, page < of->n_weights ? page : page + PLACES, values, err);
}

/* ---- the record ---- */

static void put_numbers(struct printed *to, const char *key, const double *numbers, int n)
{
    print(to, "%s:", key);
    for (int i = 0; i < n; i++)
        print(to, " %.*g", exact_digits(numbers[i]), numbers[i]);
    print_text(to, "\n");
}

/* Prints the spectra of terms in lines "WHOSE constant: ..." and "WHOSE light N diffuse: ...". */
static void put_terms(const struct plan *plan, const char *whose, const struct material_terms *made,
                      struct printed *to)
{
    static const char *const kinds[] = {[TERM_DIFFUSE] = "diffuse", [TERM_SPECULAR] = "specular"};
    char key[KEY];
    for (int t = 0; t < made->n; t++) {
        const struct spectral_term *term = &made->terms[t];
        if (term->kind == TERM_CONSTANT)
            snprintf(key, sizeof key, "%s constant", whose);
        else
            snprintf(key, sizeof key, "%s light %d %s", whose, term->light + 1, kinds[term->kind]);
        put_numbers(to, key, made->spectra + (size_t)t * (size_t)plan->n_bands, plan->n_bands);
    }
}

/* Prints the record; a failure leaves *err. It is not that of a stack, which could be made again.
 * It has the spectra of all materials, and of a perfect diffuser. */
static void put_record(const struct maps *of, const struct options *options, struct printed *to,
                       struct error *err)
{
    const struct plan *plan = &of->job.plan;
    static const struct material white = {
        .diffuse = {.kind = SPECTRUM_CONSTANT, .parameter = {1}, .factor = 1}};
    struct material_terms diffuser = {.n = 0};
    char whose[32];
    record_put_beside(to, "maps of", plan->scene, options);
    for (int i = 0; i < plan->n_instances; i++)
        record_put(to, "object", object_name(plan, i));
    if (!has_components(plan))
        put_numbers(to, "wavelengths", plan->scene->wavelengths_nm, plan->n_bands);
    if (material_terms_make(&plan->illumination, &white, &diffuser, err))
        put_terms(plan, "white", &diffuser, to);
    material_terms_free(&diffuser);
    for (int i = 0; i < plan->n_materials; i++) {
        snprintf(whose, sizeof whose, "material %d", i + 1);
        put_terms(plan, whose, &plan->materials[i].made, to);
    }
}

/* ---- the file ---- */

static bool write_file(struct maps *of, const struct options *options, struct outputs *outputs,
                       struct error *err)
{
    const struct plan *plan = &of->job.plan;
    const struct render_options *own = options->own;
    const struct decomposition decomposition = {.take = take_page, .context = of};
    const size_t chunk = (size_t)plan->tile_width * (size_t)plan->chunk_rows;
    of->n_textures = texture_pages(plan, false);
    of->n_weights = weight_pages(plan);
    struct printed record = {.text = NULL}, names = {.text = NULL};
    const struct stack_options layout = {.width = plan->scene->width,
                                         .height = plan->scene->height,
                                         .n_wavelengths = of->n_weights + PLACES + of->n_textures,
                                         .full_scale = 1,
                                         .bits = 32,
                                         .scene = plan->scene->path};
    put_record(of, options, &record, err);
    name_pages(of, &names);
    const bool done = named_pages_open(&of->writer, own->maps, layout, &record, &names, err) &&
                      MAKE_ARRAY(of->values, PLACES * chunk, err, "the rows of maps") &&
                      decompose(&of->lit, &decomposition, err);
    return named_pages_end(&of->writer, done, "maps by the reference", outputs, err);
}

static bool maps_write(const struct options *options, const struct render_job *job,
                       struct render_result *result, struct outputs *outputs, struct error *err)
{
    const struct render_options *own = options->own;
    (void)result;
    if (!own->maps)
        return true;
    struct maps of = {.job = {.scene = job->scene, .sampling = job->sampling}};
    of.job.options = (struct plan_options){.exchangeable = true,
                                           .untextured = true,
                                           .store_raster = true,
                                           .threads = options->threads};
    const bool done = job_plan(options, &of.job, err) &&
                      lit_make(&of.job.plan, driver_of(NULL), &of.lit, err) &&
                      write_file(&of, options, outputs, err);
    lit_free(&of.lit);
    notes_free(&of.job.notes);
    plan_free(&of.job.plan);
    free(of.values);
    return done;
}

/* ---- the options ---- */

/* Means of weights and of spectra do not multiply where objects meet. */
static bool maps_check(const struct options *options, const struct scene *scene, struct error *err)
{
    const struct render_options *own = options->own;
    return !own->maps || scene->positions <= 1 ||
           error_usage(err, "--maps shows the middle of each pixel; leave out --samples");
}

static const struct option rows[] = {
    {"--maps FILE.tif",
     "writes the weight of each light, textures, places and normals, by the reference",
     OWN(TEXT, render_options, maps), .writes = true},
};
const struct option_list maps_options = OPTION_LIST(rows);
const struct map_maker reference_maps = {maps_check, maps_write};
