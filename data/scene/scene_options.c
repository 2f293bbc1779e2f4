/* SPDX-License-Identifier: MIT */
/* A scene as the command line names and changes it. */
#include "data/scene/inside.h"

/* ---- changes that only options make ---- */

/* Gives all lights shadows; the text is of no matter. */
static bool set_shadows(struct scene *scene, const char *value, struct error *err)
{
    (void)value, (void)err;
    for (int i = 0; i < scene->n_lights; i++)
        scene->lights[i].shadows = true;
    return true;
}

/* Gives all objects of lists this shape, as large as the thesis's sphere. Objects that have it keep
 * their sizes. Refuses a scene without a list. */
static bool set_shape(struct scene *scene, const char *value, struct error *err)
{
    struct text text;
    struct shape shape = {.path = NULL};
    bool done = option_open(scene, "--shape", value, &text, err) &&
                shape_read(&text, &shape, err) && text_end(&text, "a shape", err),
         listed = false;
    shape.unitize = true;
    shape.parameter[0] *= shape.kind == SHAPE_TEAPOT ? 0.58 : 1; /* its spout reaches to 1.72 */
    for (int i = 0; done && i < scene->n_objects; i++) {
        struct object *object = &scene->objects[i];
        const struct vector fit = {object->fit, object->fit, object->fit};
        listed = listed || object->fit > 0;
        if (object->fit == 0 || (shape.kind != SHAPE_MESH && shape.kind == object->shape.kind))
            continue;
        object->transform = matrix_product(object->transform, matrix_scaling(fit));
        object->fit = 1;
        shape_free(&object->shape);
        object->shape = shape;
        done = string_copy(shape.path, &object->shape.path, err);
    }
    shape_free(&shape);
    return done && (listed || error_usage(err, "--shape is for a list of materials, or a scene "
                                               "with a checker; this scene has none"));
}

static bool set_samples(struct scene *scene, const char *value, struct error *err)
{
    int *positions = &scene->positions;
    return option_count("--samples", value, 1, MOST_POSITIONS, positions, err) &&
           ((*positions & (*positions - 1)) == 0 ||
            error_at(err, VALUE_OF("--samples"), "expected 1, 2, 4, 8 or 16, not %d", *positions));
}

/* ---- the options ---- */

static const struct option changes[] = {
    {"--wavelengths START:END:STEP", "wavelengths in nm, or a list of them: 450,500.5,620",
     CHANGES(scene_set_wavelengths), .marks = ":,0123456789", .recorded = true},
    {"--size WxH", "width and height in pixels, as 300x200", CHANGES(scene_set_size), .marks = "x",
     .recorded = true},
    {"--light N=SPECTRUM[*INTENSITY]", "replaces the spectrum of light N (from 1); may be repeated",
     CHANGES(scene_set_light), .recorded = true},
    {"--ambient SPECTRUM[*INTENSITY]", "replaces the ambient light", CHANGES(scene_set_ambient),
     .recorded = true},
    {"--shadows", "objects throw shadows in the light of all lights", CHANGES(set_shadows),
     .recorded = true},
    {"--shape SHAPE", "the shape of all objects of a list: sphere, teapot, 'mesh chair', ...",
     CHANGES(set_shape), .recorded = true},
    {"--samples K", "stores the mean of K x K positions of each pixel: 1 (default), 2, 4, 8 or 16",
     CHANGES(set_samples), .recorded = true},
};
static const struct option shading[] = {
    {"--shading smooth|flat|phong", "replaces the scene's; phong lights each pixel",
     CHANGES(scene_set_shading), .recorded = true},
    {"--tessellation FACTOR", "multiplies the slices, stacks, ... of built-in shapes",
     CHANGES(scene_set_tessellation), .recorded = true},
};
const struct option_list scene_options = OPTION_LIST(changes),
                         shading_options = OPTION_LIST(shading);

/* ---- SCENE ---- */

/* Refuses a stack or a picture where a scene is expected. */
static bool refuse_picture(const char *scene, struct error *err)
{
    const char *format;
    if (!file_format(scene, &format, err))
        return false;
    return format[0] == '\0' || strcmp(format, "text") == 0 ||
           error_usage(err, "%s is a %s file, not a scene%s", scene, format,
                       strcmp(format, "TIFF") == 0
                           ? "; a stack is for develop, probe, compare, view and info"
                           : "");
}

bool scene_read_options(const struct options *options, struct scene *out, struct error *err)
{
    *out = (struct scene){0};
    bool done =
        refuse_picture(options_scene(options), err) && scene_read(options_scene(options), out, err);
    for (int i = 0; done && i < options->n_changes; i++)
        done = options->changes[i].apply(out, options->changes[i].value, err);
    return done;
}

bool scene_refuse(const char *stack, struct error *err)
{
    const char *format;
    if (!file_format(stack, &format, err))
        return false;
    const bool is_text = strcmp(format, "text") == 0;
    bool missing = true;
    if (!is_text && file_is_missing(stack) && !scene_is_missing(stack, &missing, err))
        return false;
    return (!is_text && missing) ||
           error_usage(err, "%s is %s, not a stack; spectral render writes the stack of a scene",
                       stack, is_text ? "a text file" : "a scene");
}
