/* SPDX-License-Identifier: MIT */
/* Decides, once and before anything is drawn, what a scene calls for: which lights shine, which
 * terms each material needs, which meshes, passes and tiles follow. Nothing else is computed. */
#include "raster/plan/inside.h"

/* Bytes that a pixel of a tile takes apart from its rows: Mesa's own colour and depth (20), our
 * copies of a frame, of its triangles and depths (36), of the next frame (16) and of those that
 * hold pilots (48), samples of three bands, twice (12), surface, triangle, depth and its bound
 * (20), fragments and steepness (8), floors and the mean bound (12), flags (2), and room for
 * ambiguous pixels (18). A row has a weight (8), its errors (8) and an estimate (4); a sum of
 * passes is a colour, and Mesa keeps a copy (32). Checked steps of 16 bits have a colour and depth
 * of Mesa's own (12) and our copy (8) beside what floats have. Shaders draw four frames at once:
 * Mesa's own (48) and our copies (64) come on top. Lights with shadows have a mask (4). Rows of the
 * check have their weights again (8).
 */
enum { PIXEL_BYTES = 192, ROW_BYTES = 20, SUM_BYTES = 32, STEPS_BYTES = 20, SHADER_BYTES = 112 };
enum { MASK_BYTES = 4, CHECKED_ROW_BYTES = 8 };
/* The memory of a tile, without what stages need to work side by side, so that a render stays well
 * below 300 MiB with Mesa's own memory. Tiles should keep their sizes: the last bits of what OpenGL
 * draws depend on where a tile begins. */
static const size_t tile_budget = (size_t)165 << 20;
enum { SIDE_BY_SIDE_BYTES = 32 };
/* A tile has a multiple of so many rows. A chunk has so many, too: more take memory; but where a
 * tile is narrower than this, twice as many, since triangles are set up anew for each chunk. */
enum { TILE_STEP = 16, NARROW = 1024 };
/* Tiles no larger than Mesa's largest viewport (16384), with room for older drivers. */
enum { LARGEST_TILE = 8192 };

/* ---- camera and tiles ---- */

/* Returns a unit for eye space, a power of two, in which the visible part of the scene measures
 * 1024 to 2048. So squares and determinants of lengths are numbers in single precision, however
 * small or large the scene is, and Mesa takes no difference that matters for 0. A power of two
 * changes no digit. */
static double eye_unit(const struct camera *camera)
{
    int exponent;
    double size = fmax(fabs(camera->near), fabs(camera->far));
    if (!camera->perspective)
        size = fmax(size, camera->extent);
    frexp(size, &exponent);
    return ldexp(1, exponent - 11);
}

/* Eye space to clip space, as OpenGL's glOrtho and glFrustum define it. */
static struct matrix projection_of(const struct camera *camera, int width, int height)
{
    const double aspect = (double)width / height, near = camera->near, far = camera->far,
                 depth = far - near;
    if (camera->perspective) {
        double sine, cosine;
        sine_cosine(camera->extent / 2, &sine, &cosine);
        const double cotangent = cosine / sine;
        return (struct matrix){{{cotangent / aspect, 0, 0, 0},
                                {0, cotangent, 0, 0},
                                {0, 0, -(far + near) / depth, -2 * far * near / depth},
                                {0, 0, -1, 0}}};
    }
    return (struct matrix){{{2 / camera->extent, 0, 0, 0},
                            {0, 2 / camera->extent * aspect, 0, 0},
                            {0, 0, -2 / depth, -(far + near) / depth},
                            {0, 0, 0, 1}}};
}

/* Places a plane of 1 x 1 a little before the far plane, so that it fills the view and more: the
 * depths of its pixels are well apart from that of the far plane. */
static struct matrix background_of(const struct camera *camera, const struct matrix *projection)
{
    const double distance = camera->far - (camera->far - camera->near) / 128;
    const double size = (camera->perspective ? distance : 1) * 2.0625;
    const struct vector sizes = {size / projection->row[0][0], size / projection->row[1][1], 1};
    return matrix_product(matrix_translation((struct vector){0, 0, -distance}),
                          matrix_scaling(sizes));
}

/* The camera and the lights as the reference takes them. */
static struct view view_of(const struct plan *plan, const struct camera *camera)
{
    static const enum shading_model shadings[] = {
        [SHADING_SMOOTH] = GOURAUD, [SHADING_FLAT] = FLAT, [SHADING_PHONG] = PHONG};
    const struct scene *scene = plan->scene;
    return (struct view){.width = scene->positions * scene->width,
                         .height = scene->positions * scene->height,
                         .projection = projection_of(camera, scene->width, scene->height),
                         .local_viewer = scene->local_viewer,
                         .shading = shadings[scene->shading],
                         .lights = plan->lights,
                         .n_lights = plan->n_lights,
                         .find_detail = detail_find};
}

/* Whole rows of the picture where they fit, so that a band of a tile is one piece of its page. */
static void size_tiles(struct plan *plan)
{
    const int n = plan->n_instances;
    /* without a check, the objects that OpenGL shows are not known */
    const bool map_is_unknown =
        plan->options.use_gl && !plan->options.check && !plan->options.store_raster;
    const size_t n_rows = (size_t)plan->max_rows;
    size_t pixel = PIXEL_BYTES + ROW_BYTES * n_rows + (plan->view.n_shadowed > 0 ? MASK_BYTES : 0) +
                   (checks_other_rows(plan) ? CHECKED_ROW_BYTES * n_rows : 0) +
                   (plan->n_light_groups > 1 ? SUM_BYTES : 0) +
                   (plan->options.check && buffer_steps(plan) > 0 ? STEPS_BYTES : 0) +
                   (plan->options.gl_way != GL_WITHOUT_SHADERS ? SHADER_BYTES : 0);
    /* another program draws the picture in one piece */
    size_t pixels = plan->options.complete ? (size_t)LARGEST_TILE * LARGEST_TILE
                                           : tile_budget / (pixel - SIDE_BY_SIDE_BYTES),
           most = pixels / TILE_STEP, columns = LARGEST_TILE;
    int width = plan->view.width, height = plan->view.height;
    while (columns > most && columns > 1)
        columns /= 2;
    plan->tile_width = width < (int)columns ? width : (int)columns;
    const size_t fit = pixels / (size_t)plan->tile_width, rows = fit < TILE_STEP ? TILE_STEP
                                                                 : fit > LARGEST_TILE
                                                                     ? LARGEST_TILE
                                                                     : fit - fit % TILE_STEP;
    plan->tile_height = (int)rows < height ? (int)rows : height;
    plan->chunk_rows = plan->tile_width < NARROW ? 2 * TILE_STEP : TILE_STEP;
    plan->tiled = plan->tile_width < width || plan->tile_height < height;
    plan->tile_bytes = (uint64_t)pixel * (uint64_t)plan->tile_width * (uint64_t)plan->tile_height;
    plan->map_bytes = map_is_unknown || n == 0 || n > UINT16_MAX ? 0 : n > UINT8_MAX ? 2 : 1;
    plan->file_bytes =
        (uint64_t)plan->scene->width * (uint64_t)plan->scene->height *
        ((uint64_t)plan->n_bands * (uint64_t)plan->options.bits / 8 + (uint64_t)plan->map_bytes);
}

int buffer_steps(const struct plan *plan)
{
    const int bits = plan->options.buffer_bits;
    return bits > 0 && bits < 32 ? (1 << bits) - 1 : 0;
}

bool has_components(const struct plan *plan)
{
    return plan->sampling && !plan->sampling->spectral;
}

int pass_bands(const struct plan *plan, int first_band)
{
    const int left = plan->n_bands - first_band;
    return left < BANDS_PER_PASS ? left : BANDS_PER_PASS;
}

void band_name(const struct plan *plan, int band, char out[BAND_NAME])
{
    if (has_components(plan))
        sampling_label(&plan->sampling->method, band, out);
    else
        snprintf(out, BAND_NAME, "%.10g nm", plan->scene->wavelengths_nm[band]);
}

const char *object_name(const struct plan *plan, int surface)
{
    return surface < 0 ? "background"
                       : plan->materials[plan->instances[surface].shaded].material->name;
}

void object_text(const struct plan *plan, int surface, char *out, size_t capacity)
{
    const struct place place = surface >= 0 ? plan->instances[surface].object->place : NOWHERE;
    if (place.path)
        snprintf(out, capacity, "%s (%s:%d)", object_name(plan, surface), place.path, place.line);
    else
        snprintf(out, capacity, "%s", object_name(plan, surface));
}

struct rectangle plan_picture(const struct plan *plan)
{
    return (struct rectangle){0, 0, plan->view.width, plan->view.height};
}

struct rectangle plan_pixels(const struct plan *plan, const struct rectangle *positions)
{
    const int side = plan->scene->positions;
    return (struct rectangle){positions->x / side, positions->y / side, positions->width / side,
                              positions->height / side};
}

static int tile_columns(const struct plan *plan, const struct rectangle *region)
{
    return (region->width + plan->tile_width - 1) / plan->tile_width;
}

int plan_tiles(const struct plan *plan, const struct rectangle *region)
{
    return tile_columns(plan, region) *
           ((region->height + plan->tile_height - 1) / plan->tile_height);
}

struct rectangle plan_tile(const struct plan *plan, const struct rectangle *region, int index)
{
    const int columns = tile_columns(plan, region);
    const int x = index % columns * plan->tile_width, y = index / columns * plan->tile_height;
    const int width = region->width - x, height = region->height - y;
    return (struct rectangle){region->x + x, region->y + y,
                              width < plan->tile_width ? width : plan->tile_width,
                              height < plan->tile_height ? height : plan->tile_height};
}

/* Refuses more positions a side than a picture may have pixels. */
static bool check_size(const struct scene *scene, struct error *err)
{
    const int longer = scene->width > scene->height ? scene->width : scene->height;
    return (int64_t)longer * scene->positions <= LONGEST_SIDE ||
           error_usage(err,
                       "--samples %d draws %lld positions a side, but %d are possible; expected a "
                       "smaller --size or fewer samples",
                       scene->positions, (long long)longer * scene->positions, LONGEST_SIDE);
}

bool plan_make(const struct scene *scene, const struct sampling *sampling,
               const struct plan_options *options, struct plan *out, struct error *err)
{
    const struct spectral_pages pages = sampling ? sampling->pages : scene_pages(scene);
    struct camera camera = scene->camera;
    *out = (struct plan){
        .scene = scene, .sampling = sampling, .options = *options, .unit = eye_unit(&camera)};
    camera.near /= out->unit;
    camera.far /= out->unit;
    camera.extent /= camera.perspective ? 1 : out->unit;
    out->options.threads = threads_count(options->threads);
    out->options.bits = options->bits > 0 ? options->bits : 16;
    out->n_bands = pages.n;
    out->n_passes = (out->n_bands + BANDS_PER_PASS - 1) / BANDS_PER_PASS;
    out->near = camera.near;
    out->world_to_eye =
        matrix_product(matrix_scaling((struct vector){1 / out->unit, 1 / out->unit, 1 / out->unit}),
                       matrix_look_at(camera.eye, camera.look, camera.up));
    const struct matrix projection = projection_of(&camera, scene->width, scene->height);
    out->background_to_eye = background_of(&camera, &projection);
    /* Arrays that pointers lead into have their final size from the start: every material, and its
     * partner from the same file, has at most one material and one texture. */
    const size_t most = 2 * (size_t)scene->n_materials + 1;
    if (!check_size(scene, err) || !MAKE_ARRAY(out->materials, most, err, "%zu materials", most) ||
        !MAKE_ARRAY(out->textures, most, err, "%zu textures", most) ||
        !illumination_make(scene, &pages, options->exchangeable, &out->illumination, err) ||
        !instances_make(out, err) || !lights_list(out, err))
        return false;
    out->view = view_of(out, &camera);
    if (!reach_find(out, err))
        return false;
    size_tiles(out);
    plan_effects(out);
    return passes_make(out, err);
}

void plan_free(struct plan *plan)
{
    for (int i = 0; i < plan->n_meshes; i++)
        mesh_free(&plan->meshes[i].mesh);
    for (int i = 0; i < plan->n_materials; i++) {
        free(plan->materials[i].terms);
        material_terms_free(&plan->materials[i].made);
    }
    for (int i = 0; i < plan->n_textures; i++)
        texture_free(&plan->textures[i]);
    FREE_ALL(plan->meshes, plan->instances, plan->is_idle, plan->passes.frame, plan->materials,
             plan->textures, plan->lights, plan->sources);
    index_free(&plan->by_material);
    illumination_free(&plan->illumination);
    *plan = (struct plan){0};
}
