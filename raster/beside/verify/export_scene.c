/* SPDX-License-Identifier: MIT */
/* A scene as another program needs it: numbers of single precision as OpenGL gets them, in the byte
 * order of this machine, and lines of words. */
#include "raster/beside/verify/inside.h"

/* A description that grows. */
struct description {
    const struct lit_scene *lit;
    const struct plan *plan;     /* of that */
    const struct folder *folder; /* gets the files; NULL: only their digests are wanted */
    const char *prefix;          /* of their names there */
    struct printed scene;        /* the lines of scene.txt */
};

/* ---- files ---- */

static bool write_file(const struct description *of, const char *name, const void *bytes,
                       size_t length, struct error *err)
{
    char path[sizeof of->folder->path + FILE_NAME + 1];
    if (!of->folder)
        return true;
    if (is_interrupted())
        return error_failed(err, "interrupted; nothing was written");
    snprintf(path, sizeof path, "%s/%s%s", of->folder->path, of->prefix, name);
    return file_write(path, bytes, length, NULL, err);
}

/* Adds a complete file. */
static bool add_file(struct description *to, const char *name, const void *bytes, size_t length,
                     struct error *err)
{
    char digest[DIGEST_TEXT];
    digest_bytes(bytes, length, digest);
    print(&to->scene, "file %s %zu %s\n", name, length, digest);
    return write_file(to, name, bytes, length, err);
}

/* ---- meshes ---- */

static bool add_mesh(struct description *to, int index, struct error *err)
{
    const struct mesh *mesh = &to->plan->meshes[index].mesh;
    const size_t n = (size_t)mesh->n_vertices;
    float *floats;
    char name[FILE_NAME];
    print(&to->scene, "mesh %d %d %d\n", index, mesh->n_vertices, mesh->n_triangles);
    if (!MAKE_ARRAY(floats, n * VERTEX_NUMBERS, err, "the corners of a mesh"))
        return false;
    for (size_t i = 0; i < n; i++)
        vertex_numbers(&mesh->vertices[i], floats + VERTEX_NUMBERS * i);
    snprintf(name, sizeof name, "vertices-%d.bin", index);
    bool done = add_file(to, name, floats, VERTEX_NUMBERS * n * sizeof *floats, err);
    free(floats);
    snprintf(name, sizeof name, "triangles-%d.bin", index);
    return done && add_file(to, name, mesh->triangles,
                            (size_t)mesh->n_triangles * sizeof *mesh->triangles, err);
}

/* ---- textures ---- */

/* Adds the texels of a texture; of a spectral one, for each pass. */
static bool add_texture(struct description *to, int index, struct error *err)
{
    struct texture *texture = &to->plan->textures[index];
    const size_t n = texture->plane_size;
    float *texels;
    char name[FILE_NAME];
    if (!texture->shown)
        return true;
    print(&to->scene, "texture %d %d %d %s %s\n", index, texture->image.width,
          texture->image.height,
          texture->n_levels > 1 ? "mipmaps"
          : texture->linear     ? "linear"
                                : "nearest",
          texture->spectral ? "spectral" : "grey");
    snprintf(name, sizeof name, "texture-%d.bin", index);
    if (!texture->spectral)
        return add_file(to, name, texture->plane[0], n * sizeof *texels, err);
    bool done =
        MAKE_ARRAY(texels, n * BANDS_PER_PASS, err, "the texels of %s", texture->image.path);
    for (int band = 0; band < to->plan->n_bands && done; band += BANDS_PER_PASS) {
        snprintf(name, sizeof name, "texture-%d-%d.bin", index, band);
        done = pass_texels(to->plan, texture, band, texels, err) &&
               add_file(to, name, texels, n * BANDS_PER_PASS * sizeof *texels, err);
    }
    free(texels);
    return done;
}

/* ---- passes ---- */

static void print_colour(const float colour[4], struct printed *to)
{
    for (int c = 0; c < BANDS_PER_PASS; c++)
        print(to, " %.9g", (double)colour[c]);
}

/* Prints a material under a group of lights in a pass: its constant colour and gloss (-1: no
 * highlight), then diffuse and specular colours of each light. */
static void print_material(const struct description *of, int material, int group, int first_band,
                           struct printed *to)
{
    const struct shaded_material *shaded = &of->plan->materials[material];
    struct pass_colours colours;
    pass_colours(of->plan, shaded, group, first_band, of->lit->full_scale, &colours);
    print(to, "material %d %d %d", first_band, group, material);
    print_colour(colours.constant, to);
    print(to, " %.9g\n", colours.shines ? shaded->material->gloss : -1);
    for (int i = 0; i < colours.n_lights; i++) {
        const int light = light_group(of->plan, group).first + i;
        if (of->plan->is_idle[light])
            continue;
        print(to, "light %d %d %d %d", first_band, group, material, light);
        print_colour(colours.diffuse[i], to);
        print_colour(colours.specular[i], to);
        print_text(to, "\n");
    }
}

static bool add_passes(struct description *to, struct error *err)
{
    const struct plan *plan = to->plan;
    struct printed lines = {.text = NULL};
    for (int band = 0; band < plan->n_bands; band += BANDS_PER_PASS)
        for (int group = 0; group < plan->n_light_groups; group++)
            for (int m = 0; m < plan->n_materials && group_is_drawn(plan, group); m++)
                if (plan->materials[m].shown)
                    print_material(to, m, group, band, &lines);
    print_text(&lines, "end\n");
    char *bytes = printed_take(&lines, err);
    const bool done = bytes && add_file(to, "passes.txt", bytes, lines.length, err);
    free(bytes);
    return done;
}

/* ---- scene.txt ---- */

static void print_matrix(const struct matrix *m, struct printed *to)
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            print(to, " %.17g", m->row[i][j]);
    print_text(to, "\n");
}

/* Prints a light in eye coordinates; a directional one by the direction towards it. */
static void print_source(const struct plan *plan, int index, struct printed *to)
{
    const struct eye_light *light = &plan->lights[index];
    const struct light *source = plan->sources[index];
    if (plan->is_idle[index])
        return;
    print(to, "source %d %s %.17g %.17g %.17g attenuation %.17g %.17g %.17g", index,
          light->directional ? "directional" : "positional", light->position.x, light->position.y,
          light->position.z, light->attenuation[0], light->attenuation[1], light->attenuation[2]);
    if (light->spot)
        print(to, " spot %.17g %.17g %.17g %.17g %.17g", light->axis.x, light->axis.y,
              light->axis.z, source->spot_cutoff_deg, source->spot_exponent);
    print_text(to, "\n");
}

/* Prints an instance: its number, which is drawn as the third colour, its mesh, its material, its
 * texture (-1: none), and how it is lit and turned. */
static void print_instance(const struct plan *plan, int index, struct printed *to)
{
    const struct placed_instance *placed = &plan->instances[index];
    const struct texture *texture = plan->materials[placed->shaded].texture;
    if (!placed->in_view)
        return;
    print(to, "instance %d mesh %d material %d texture %d %s %s matrix", index + 1, placed->mesh,
          placed->shaded, texture ? (int)(texture - plan->textures) : -1,
          placed->object->two_sided ? "two-sided" : "one-sided",
          placed->instance.mirrored ? "clockwise" : "counter-clockwise");
    print_matrix(&placed->instance.model_view, to);
}

/* ---- shadows ---- */

/* Adds a shadow volume: the group of its light, its triangles, how many of them are turned outward
 * and how many begin these as caps, how fronts turn, and where it lies. */
static bool add_volume(struct description *to, int index, struct error *err)
{
    const struct volume *volume = &to->lit->volumes->list[index];
    const struct instance *instance = &to->plan->instances[volume->instance].instance;
    const size_t n = 3 * (size_t)volume->n;
    float(*corners)[3];
    char name[FILE_NAME];
    print(&to->scene, "volume %d group %d triangles %d outward %d caps %d %s matrix", index,
          to->plan->n_light_groups - to->plan->view.n_shadowed + volume->shadowed, volume->n,
          volume->n_outward, volume->n_caps,
          instance->mirrored ? "clockwise" : "counter-clockwise");
    print_matrix(&instance->model_view, &to->scene);
    snprintf(name, sizeof name, "volume-%d.bin", index);
    if (!MAKE_ARRAY(corners, n, err, "the corners of a shadow"))
        return false;
    volume_corners(volume, 0, volume->n, 3, corners[0]);
    const bool done = add_file(to, name, corners, n * sizeof *corners, err);
    free(corners);
    return done;
}

static void print_picture(struct description *to)
{
    const struct plan *plan = to->plan;
    const struct rectangle picture = plan_picture(plan);
    const struct matrix projection = pass_projection(plan, &picture, false);
    print(&to->scene, "size %d %d\nfull-scale %.17g\nshading %s\nviewer %s\nprojection",
          picture.width, picture.height, to->lit->full_scale,
          plan->view.shading == FLAT ? "flat" : "smooth",
          plan->view.local_viewer ? "local" : "distant");
    print_matrix(&projection, &to->scene);
    for (int i = 0; i < plan->n_bands; i++) {
        char name[BAND_NAME];
        band_name(plan, i, name);
        print(&to->scene, "band %d %s\n", i, name);
    }
    for (int i = 0; i < plan->n_lights; i++)
        print_source(plan, i, &to->scene);
    for (int i = 0; i < plan->n_light_groups; i++) {
        const struct light_group group = light_group(plan, i);
        print(&to->scene, "group %d lights %d %d\n", i, group.first, group.n);
    }
}

static bool print_scene(struct description *to, struct error *err)
{
    const struct plan *plan = to->plan;
    bool done = true;
    print_picture(to);
    for (int i = 0; i < plan->n_meshes && done; i++)
        done = add_mesh(to, i, err);
    for (int i = 0; i < plan->n_textures && done; i++)
        done = add_texture(to, i, err);
    for (int i = 0; i < plan->n_instances; i++)
        print_instance(plan, i, &to->scene);
    for (int i = 0; to->lit->volumes && i < to->lit->volumes->n && done; i++)
        done = add_volume(to, i, err);
    return done && add_passes(to, err);
}

/* Puts the first lines before the others. */
static bool finish(struct description *of, char id[DIGEST_TEXT], struct error *err)
{
    struct printed whole = {.text = NULL};
    char *lines = printed_take(&of->scene, err), *bytes = NULL;
    if (lines) {
        digest_bytes(lines, of->scene.length, id);
        print(&whole, "spectral-scene 1\nid %s\n%s", id, lines);
        bytes = printed_take(&whole, err);
    }
    const bool done = bytes && write_file(of, "scene.txt", bytes, whole.length, err);
    free(lines);
    free(bytes);
    return done;
}

bool scene_describe(const struct lit_scene *lit, const struct folder *folder, const char *prefix,
                    char id[DIGEST_TEXT], struct error *err)
{
    struct description of = {.lit = lit, .plan = lit->plan, .folder = folder, .prefix = prefix};
    print_scene(&of, err);
    return finish(&of, id, err);
}

/* ---- a folder ---- */

/* bounds: gets the legal counts; NULL: they are not wanted. They come first: without memory libtiff
 * may crash, and only an empty folder is removed then. */
static bool describe_plan(const struct plan *plan, const struct folder *folder, const char *prefix,
                          const struct interval_file *bounds, struct error *err)
{
    struct lit_scene lit = {.plan = NULL};
    char id[DIGEST_TEXT];
    struct volumes volumes = {.n = 0};
    uint64_t n_open;
    const bool done = light_plan(plan, driver_of(NULL), &lit, &volumes, err) &&
                      (!bounds || interval_write(&lit, bounds, &n_open, err)) &&
                      scene_describe(&lit, folder, prefix, id, err);
    volumes_free(&volumes);
    lit_free(&lit);
    return done;
}

bool export_plans(const struct plan *plan, const struct plan *targets, const char *words,
                  const struct options *options, struct error *err)
{
    struct folder folder;
    char name[sizeof folder.path + FILE_NAME], bounds_name[sizeof name];
    const struct interval_file bounds = {options, bounds_name, NULL};
    guard_hold();
    bool done = folder_open_beside(options->output, &folder, err);
    snprintf(name, sizeof name, "%s/exported.txt", folder.path);
    snprintf(bounds_name, sizeof bounds_name, "%s/bounds.tif", folder.path);
    done = done && describe_plan(plan, &folder, "", &bounds, err) &&
           describe_plan(targets, &folder, targets_prefix, NULL, err) &&
           file_write(name, words, strlen(words), NULL, err) &&
           folder_keep(&folder, options->output, err);
    folder_close(&folder);
    guard_release();
    return done;
}
