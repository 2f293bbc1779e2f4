/* SPDX-License-Identifier: MIT */
/* Writes a reduced scene as files: its text, a mesh an object, a table a spectrum. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "raster/verify/verify.h"

/* The folder that is written, and the text of the scene. */
struct writer {
    const char *folder;
    const struct reduced *of;
    struct printed scene;
};

static bool write_text(const struct writer *writer, const char *name, struct printed *text,
                       struct error *err)
{
    char path[REDUCED_PATH];
    char *bytes = printed_end(text);
    snprintf(path, sizeof path, "%s/%s", writer->folder, name);
    const bool done = bytes ? file_write(path, bytes, strlen(bytes), NULL, err) : error_memory(err);
    free(bytes);
    return done;
}

/* Copies a file of the user's; the scene names a built-in one by its path. */
static bool copy_file(struct writer *writer, const char *path, const char *name, struct error *err)
{
    const struct builtin_file *builtin;
    char to[REDUCED_PATH], *bytes = NULL;
    struct stat is;
    int file;
    if (path_is_builtin(path)) {
        print(&writer->scene, " %s", path);
        return true;
    }
    print(&writer->scene, " %s", name);
    snprintf(to, sizeof to, "%s/%s", writer->folder, name);
    if (!file_open(path, (struct place){NULL, 0, 0}, &file, &builtin, err))
        return false;
    bool done = fstat(file, &is) == 0 && (bytes = malloc((size_t)is.st_size + 1)) != NULL &&
                read_at(file, bytes, (size_t)is.st_size, 0) == is.st_size;
    close(file);
    done = done ? file_write(to, bytes, (size_t)is.st_size, NULL, err)
                : error_system(err, "cannot copy %s", path);
    free(bytes);
    return done;
}

/* ---- spectra ---- */

/* Writes the samples of a spectrum into a table. */
static bool write_samples(const struct writer *writer, const struct spectrum *spectrum,
                          const char *name, struct error *err)
{
    struct printed table = {.text = NULL};
    for (int i = 0; i < spectrum->count; i++)
        print(&table, "%.17g,%.17g\n", spectrum->wavelength_nm[i], spectrum->value[i]);
    return write_text(writer, name, &table, err);
}

/* Adds a spectrum to the scene, whose samples go to a table of that name. */
static bool add_spectrum(struct writer *writer, const struct spectrum *spectrum, const char *name,
                         struct error *err)
{
    struct printed *to = &writer->scene;
    const double *p = spectrum->parameter;
    if (spectrum->kind == SPECTRUM_CONSTANT)
        print(to, " %.17g", p[0]);
    else if (spectrum->kind == SPECTRUM_BLACKBODY)
        print(to, " blackbody:%.17g", p[0]);
    else if (spectrum->kind == SPECTRUM_GAUSSIAN)
        print(to, " gaussian:%.17g,%.17g", p[0], p[1]);
    else {
        print(to, " %s", name);
        if (!write_samples(writer, spectrum, name, err))
            return false;
    }
    if (spectrum->factor != 1)
        print(to, "*%.17g", spectrum->factor);
    return true;
}

/* Adds a word of a material and its spectrum, if there is one. */
static bool add_entry(struct writer *writer, const char *word, const struct spectrum *spectrum,
                      const char *material, struct error *err)
{
    char name[96];
    if (spectrum->kind == SPECTRUM_NONE)
        return true;
    snprintf(name, sizeof name, "%s-%s.csv", material, word);
    print(&writer->scene, " %s", word);
    return add_spectrum(writer, spectrum, name, err);
}

/* ---- materials ---- */

static bool add_fluorescence(struct writer *writer, const struct material *material,
                             const char *name, struct error *err)
{
    char table[2][96];
    if (material->donaldson) {
        snprintf(table[0], sizeof table[0], "%s-donaldson.csv", name);
        print_text(&writer->scene, " donaldson");
        return copy_file(writer, material->donaldson, table[0], err);
    }
    if (material->excitation.kind == SPECTRUM_NONE)
        return true;
    snprintf(table[0], sizeof table[0], "%s-excitation.csv", name);
    snprintf(table[1], sizeof table[1], "%s-emission.csv", name);
    print_text(&writer->scene, " fluorescence");
    return add_spectrum(writer, &material->excitation, table[0], err) &&
           add_spectrum(writer, &material->emission, table[1], err);
}

static bool add_texture(struct writer *writer, const struct material *material, const char *name,
                        struct error *err)
{
    char file[96];
    const char *path = material->spectral_texture ? material->spectral_texture : material->texture;
    if (!path)
        return true;
    snprintf(file, sizeof file, "%s-texture.tif", name);
    print(&writer->scene, " %stexture", material->spectral_texture ? "spectral-" : "");
    if (!copy_file(writer, path, file, err))
        return false;
    print(&writer->scene, " %s", material->texture_linear ? "linear" : "nearest");
    return true;
}

/* partner: the name of the metameric partner; NULL: none. */
static bool add_material(struct writer *writer, const struct material *material, const char *name,
                         const char *partner, struct error *err)
{
    print(&writer->scene, "material %s {", name);
    if (!add_entry(writer, "diffuse", &material->diffuse, name, err) ||
        !add_entry(writer, "specular", &material->specular, name, err))
        return false;
    if (material->gloss > 0)
        print(&writer->scene, " gloss %.17g", material->gloss);
    if (!add_fluorescence(writer, material, name, err) ||
        !add_entry(writer, "emission", &material->glow, name, err) ||
        !add_texture(writer, material, name, err))
        return false;
    if (partner)
        print(&writer->scene, " metamer %s", partner);
    print_text(&writer->scene, " }\n");
    return true;
}

static bool is_used(const struct reduced *of, int material)
{
    for (int i = 0; i < of->n_objects; i++)
        if (of->kept[REDUCED_OBJECTS][i] && of->objects[i].material == material)
            return true;
    return false;
}

static bool add_materials(struct writer *writer, struct error *err)
{
    const struct scene *scene = writer->of->scene;
    for (int i = 0; i < scene->n_materials; i++) {
        const struct material *partner =
            is_used(writer->of, i) ? scene_partner(scene, &scene->materials[i]) : NULL;
        char name[32], other[32];
        snprintf(name, sizeof name, "m%d", i + 1);
        snprintf(other, sizeof other, "partner%d", i + 1);
        if (is_used(writer->of, i) &&
            ((partner && !add_material(writer, partner, other, NULL, err)) ||
             !add_material(writer, &scene->materials[i], name, partner ? other : NULL, err)))
            return false;
    }
    return true;
}

/* ---- objects ---- */

/* The vertices that no kept triangle uses are left out. `triangles` are the marks of this mesh. */
static bool write_mesh(const struct writer *writer, const struct mesh *mesh, const bool *triangles,
                       const char *name, struct error *err)
{
    struct printed obj = {.text = NULL};
    int32_t *number = calloc((size_t)mesh->n_vertices + 1, sizeof *number), n = 0;
    if (!number)
        return error_memory(err);
    for (int i = 0; i < 3 * mesh->n_triangles; i++) {
        const int32_t index = mesh->triangles[i / 3][i % 3];
        const struct vertex *v = &mesh->vertices[index];
        if (!triangles[i / 3] || number[index])
            continue;
        number[index] = ++n;
        print(&obj, "v %.17g %.17g %.17g\nvt %.17g %.17g\nvn %.17g %.17g %.17g\n", v->position.x,
              v->position.y, v->position.z, v->s, v->t, v->normal.x, v->normal.y, v->normal.z);
    }
    for (int i = 0; i < mesh->n_triangles; i++) {
        int32_t corner[3];
        for (int k = 0; k < 3; k++)
            corner[k] = number[mesh->triangles[i][k]];
        if (triangles[i])
            print(&obj, "f %d/%d/%d %d/%d/%d %d/%d/%d\n", corner[0], corner[0], corner[0],
                  corner[1], corner[1], corner[1], corner[2], corner[2], corner[2]);
    }
    free(number);
    return write_text(writer, name, &obj, err);
}

static bool has_triangles(const bool *triangles, int n)
{
    for (int i = 0; i < n; i++)
        if (triangles[i])
            return true;
    return false;
}

static bool add_objects(struct writer *writer, struct error *err)
{
    const struct reduced *of = writer->of;
    const bool *triangles = of->kept[REDUCED_TRIANGLES];
    for (int i = 0; i < of->n_objects; triangles += of->objects[i++].mesh.n_triangles) {
        const struct reduced_object *object = &of->objects[i];
        char name[32];
        if (!of->kept[REDUCED_OBJECTS][i] || !has_triangles(triangles, object->mesh.n_triangles))
            continue;
        snprintf(name, sizeof name, "object%d.obj", i + 1);
        print(&writer->scene, "object mesh %s material m%d%s%s\n", name, object->material + 1,
              object->two_sided ? " two-sided" : "", object->placement ? object->placement : "");
        if (!write_mesh(writer, &object->mesh, triangles, name, err))
            return false;
    }
    return true;
}

/* ---- the view and the lights ---- */

static void add_view(struct writer *writer)
{
    const struct reduced *of = writer->of;
    const struct scene *scene = of->scene;
    const struct camera *camera = &scene->camera;
    struct printed *to = &writer->scene;
    print_text(to, "wavelengths list");
    for (int i = 0; i < scene->n_wavelengths; i++)
        if (of->kept[REDUCED_BANDS][i])
            print(to, " %.17g", scene->wavelengths_nm[i]);
    print(to, "\nsize %d %d\ncamera %s %.17g near %.17g far %.17g eye %.17g %.17g %.17g", of->width,
          of->height, camera->perspective ? "perspective" : "ortho", camera->extent, camera->near,
          camera->far, camera->eye.x, camera->eye.y, camera->eye.z);
    print(to, " look %.17g %.17g %.17g up %.17g %.17g %.17g\n", camera->look.x, camera->look.y,
          camera->look.z, camera->up.x, camera->up.y, camera->up.z);
    if (scene->local_viewer)
        print_text(to, "viewer local\n");
    print(to, "shading %s\n", shading_words[scene->shading]);
}

static void add_light(struct writer *writer, const struct light *light)
{
    const struct vector at = light->position, axis = light->spot_direction;
    const double *k = light->attenuation;
    print(&writer->scene, " %.17g %s %.17g %.17g %.17g", light->intensity,
          light->directional ? "direction" : "position", at.x, at.y, at.z);
    if (k[0] != 1 || k[1] != 0 || k[2] != 0)
        print(&writer->scene, " attenuation %.17g %.17g %.17g", k[0], k[1], k[2]);
    if (light->spot)
        print(&writer->scene, " spot %.17g %.17g %.17g %.17g %.17g", axis.x, axis.y, axis.z,
              light->spot_cutoff_deg, light->spot_exponent);
    print_text(&writer->scene, "\n");
}

static bool add_lights(struct writer *writer, struct error *err)
{
    const struct scene *scene = writer->of->scene;
    char name[32];
    for (int i = 0; i < scene->n_ambients; i++) {
        if (!writer->of->kept[REDUCED_AMBIENTS][i])
            continue;
        snprintf(name, sizeof name, "ambient%d.csv", i + 1);
        print_text(&writer->scene, "ambient");
        if (!add_spectrum(writer, &scene->ambients[i].spectrum, name, err))
            return false;
        print(&writer->scene, " %.17g\n", scene->ambients[i].intensity);
    }
    for (int i = 0; i < scene->n_lights; i++) {
        if (!writer->of->kept[REDUCED_LIGHTS][i])
            continue;
        snprintf(name, sizeof name, "light%d.csv", i + 1);
        print_text(&writer->scene, "light");
        if (!add_spectrum(writer, &scene->lights[i].spectrum, name, err))
            return false;
        add_light(writer, &scene->lights[i]);
    }
    return true;
}

bool reduced_write(const struct reduced *of, const char *folder, struct error *err)
{
    struct writer writer = {folder, of, {.text = NULL}};
    add_view(&writer);
    if (add_lights(&writer, err) && add_materials(&writer, err) && add_objects(&writer, err))
        return write_text(&writer, "case.scene", &writer.scene, err);
    free(printed_end(&writer.scene));
    return false;
}
