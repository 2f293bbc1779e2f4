/* SPDX-License-Identifier: MIT */
/* The view of a scene: wavelengths, size, camera, shading. The same functions read the statements
 * of the scene and the options of the command line that replace them. */
#include <float.h>

#include "data/scene/inside.h"

static const double smallest_positive = DBL_MIN;
static const double longest_nm = 1e6; /* a millimetre: beyond, nothing is light */

/* ---- wavelengths ---- */

static bool check_count(double count, struct place place, struct error *err)
{
    return count < MOST_WAVELENGTHS ||
           error_at(err, place, "more than %d wavelengths; a stack holds no more pages",
                    MOST_WAVELENGTHS);
}

static bool add_wavelength(struct scene *scene, double nm, struct place place, struct error *err)
{
    const int n = scene->n_wavelengths;
    if (n > 0 && nm <= scene->wavelengths_nm[n - 1])
        return error_at(err, place,
                        "wavelength %.15g nm follows %.15g nm; wavelengths must increase", nm,
                        scene->wavelengths_nm[n - 1]);
    return check_count(n, place, err) &&
           array_add(&scene->wavelengths_nm, &scene->n_wavelengths, &nm, sizeof nm, err);
}

/* Adds START + i STEP up to END. Numbers such as 0.1 are rounded to 2^-53 of their size. So the
 * quotient misses a whole number of steps by some units of 2^-53 (START + END) / STEP: 2.5e-10 for
 * 380 to 730 by 0.001. An END within 1e-9 of a whole number of steps is therefore included; nobody
 * wants to leave out a step for so little. */
static bool add_range(struct scene *scene, const double range[3], struct place place,
                      struct error *err)
{
    double steps = (range[1] - range[0]) / range[2], whole = floor(steps + 0.5);
    if (fabs(steps - whole) > 1e-9 * whole)
        whole = floor(steps);
    if (!check_count(whole, place, err))
        return false;
    for (int i = 0; i <= (int)whole; i++)
        if (!add_wavelength(scene, range[0] + i * range[2], place, err))
            return false;
    return true;
}

static bool read_range(struct scene *scene, struct text *text, struct error *err)
{
    static const char *const names[] = {"START", "END", "STEP"};
    double range[3];
    struct word word[3];
    for (int i = 0; i < 3; i++)
        if (!text_expect(text, &word[i], names[i], err) ||
            !word_number(&word[i], names[i], smallest_positive, i < 2 ? longest_nm : HUGE_VAL,
                         &range[i], err))
            return false;
    if (range[1] < range[0])
        return error_at(err, word[1].place, "END %.15g is below START %.15g; write START END STEP",
                        range[1], range[0]);
    return add_range(scene, range, word[2].place, err);
}

static bool read_wavelength_list(struct scene *scene, struct text *text, struct error *err)
{
    struct word word;
    double nm;
    do
        if (!text_expect(text, &word, "a wavelength", err) ||
            !word_number(&word, "wavelength", smallest_positive, longest_nm, &nm, err) ||
            !add_wavelength(scene, nm, word.place, err))
            return false;
    while (text_peek(*text, &word));
    return true;
}

/* Refuses wavelengths that all lie below 10 nm: light is meant. */
static bool check_unit(const struct scene *scene, struct error *err)
{
    const double last_nm = scene->wavelengths_nm[scene->n_wavelengths - 1];
    return last_nm >= 10 ||
           error_at(err, scene->wavelengths_place,
                    "wavelengths up to %.15g nm; expected nm: multiply %s", last_nm,
                    last_nm < 1e-3 ? "metres by 1e9" : "micrometres by 1000");
}

bool wavelengths_read(struct scene_reader *reader, struct error *err)
{
    struct text *text = reader->text, before = *text;
    struct word word;
    reader->scene->wavelengths_place = reader->place;
    if (!text_expect(text, &word, "START END STEP or list and wavelengths", err))
        return false;
    const bool list = word_is(&word, "list");
    if (!list)
        *text = before;
    return (list ? read_wavelength_list : read_range)(reader->scene, text, err) &&
           text_end(text, "wavelengths", err) && check_unit(reader->scene, err);
}

/* ---- picture ---- */

bool size_read(struct scene_reader *reader, struct error *err)
{
    long width, height;
    struct word word;
    int length = 0;
    if (text_peek(*reader->text, &word) &&
        sscanf(word.start, "%6ldx%6ld%n", &width, &height, &length) == 2 &&
        length == (int)word.length)
        return error_at(err, word.place, "'%.*s' is written as behind --size; write size %ld %ld",
                        length, word.start, width, height);
    if (!text_integer(reader->text, "width", 1, LONGEST_SIDE, &width, err) ||
        !text_integer(reader->text, "height", 1, LONGEST_SIDE, &height, err))
        return false;
    reader->scene->width = (int)width;
    reader->scene->height = (int)height;
    return text_end(reader->text, "size", err);
}

bool viewer_read(struct scene_reader *reader, struct error *err)
{
    static const char *const words[] = {"infinite", "local", NULL};
    const int chosen = text_choose(reader->text, "viewer", words, "viewer", err);
    reader->scene->local_viewer = chosen == 1;
    return chosen >= 0 && text_end(reader->text, "viewer", err);
}

const char *const shading_words[] = {
    [SHADING_SMOOTH] = "smooth", [SHADING_FLAT] = "flat", [SHADING_PHONG] = "phong", NULL};

bool shading_read(struct scene_reader *reader, struct error *err)
{
    const int chosen = text_choose(reader->text, "shading", shading_words, "shading", err);
    reader->scene->shading = chosen < 0 ? SHADING_SMOOTH : (enum shading_kind)chosen;
    return chosen >= 0 && text_end(reader->text, "shading", err);
}

/* ---- camera ---- */

static const char *const camera_words[] = {"ortho", "perspective", NULL};
static const struct camera camera_defaults[] = {
    {.extent = 12, .near = -10, .far = 10, .look = {0, 0, -1}, .up = {0, 1, 0}},
    {.perspective = true, .near = 1, .far = 64, .look = {0, 0, -1}, .up = {0, 1, 0}}};

static bool read_extent(struct text *text, struct camera *out, struct error *err)
{
    double *angle = &out->extent;
    struct word word;
    if (!out->perspective)
        return text_number(text, "width of the view", smallest_positive, HUGE_VAL, angle, err);
    if (!text_expect(text, &word, "the vertical angle of the view", err) ||
        !word_number(&word, "angle", -HUGE_VAL, HUGE_VAL, angle, err))
        return false;
    return (*angle > 0 && *angle < 180) ||
           error_at(err, word.place, "angle %.15g is out of range; it is above 0 and below 180",
                    *angle);
}

enum { CAMERA_FAR = 1, CAMERA_EYE, CAMERA_UP = 4, CAMERA_OPTIONS };
static const char *const camera_options[] = {"near", "far", "eye", "look", "up", NULL};

static bool read_camera_option(struct text *text, int option, struct camera *out, struct error *err)
{
    const double nearest = out->perspective ? smallest_positive : -HUGE_VAL;
    double *const numbers[] = {&out->near, &out->far};
    struct vector *const vectors[] = {&out->eye, &out->look, &out->up};
    const char *name = camera_options[option];
    if (option <= CAMERA_FAR)
        return text_number(text, name, nearest, HUGE_VAL, numbers[option], err);
    return (option == CAMERA_UP ? text_direction : text_vector)(text, name,
                                                                vectors[option - CAMERA_EYE], err);
}

/* Refuses a camera without a direction or with nothing between near and far. Rounding moves each
 * part of a unit vector by some 4 units of 2^-53, so the cross product of two parallel ones is
 * shorter than 2^-49. */
static bool check_camera(const struct camera *camera, struct place place, struct error *err)
{
    struct vector view = vector_subtract(camera->look, camera->eye), side;
    double depth = camera->far - camera->near, length = vector_length(view);
    if (!(depth > 0 && isfinite(depth)))
        return error_at(err, place, "near %.15g must be below far %.15g", camera->near,
                        camera->far);
    if (!(length > 0 && isfinite(length)))
        return error_at(err, place,
                        "eye and look are one point or too far apart; the view needs a direction");
    side = vector_cross(vector_normalise(camera->up), vector_normalise(view));
    return vector_length(side) > 0x1p-49 ||
           error_at(err, place, "up is parallel to the view; expected a direction across it");
}

bool camera_read(struct scene_reader *reader, struct error *err)
{
    struct camera *camera = &reader->scene->camera;
    struct place given[CAMERA_OPTIONS] = {{0}};
    struct word word;
    int option = text_choose(reader->text, "ortho or perspective", camera_words, "camera", err);
    if (option < 0)
        return false;
    *camera = camera_defaults[option];
    if (!read_extent(reader->text, camera, err))
        return false;
    while (text_word(reader->text, &word)) {
        option = word_choose_once(&word, camera_options, "word for a camera", given, err);
        if (option < 0 || !read_camera_option(reader->text, option, camera, err))
            return false;
    }
    return check_camera(camera, reader->place, err);
}

/* ---- defaults ---- */

void view_set_defaults(struct scene *scene)
{
    scene->camera = camera_defaults[0];
    scene->width = 1200;
    scene->height = 800;
    scene->positions = 1;
    scene->tessellation = 1;
}

bool wavelengths_complete(struct scene *scene, struct error *err)
{
    static const double range[3] = {300, 760, 5};
    const struct place place = {scene->path, 0, 0};
    return scene->n_wavelengths > 0 || add_range(scene, range, place, err);
}

/* ---- options of the command line ---- */

bool option_open(struct scene *scene, const char *option, const char *value, struct text *out,
                 struct error *err)
{
    if (!text_open_string(out, option, value, err))
        return false;
    if (text_next_line(out) && !strchr(value, '\n'))
        return scene_keep(scene, out, err);
    error_at(err, text_place(out), "expected one line, not '%s'", value);
    text_free(out);
    return false;
}

struct word option_word(const struct text *text, const char *start, const char *end)
{
    struct word word = {.start = start, .length = (size_t)(end - start)};
    word.place = text_place(text);
    word.place.column += (int)(start - text->at);
    return word;
}

/* Opens an option whose numbers have one separator between them. Refuses a #, which would begin a
 * comment. */
static bool open_numbers(struct scene *scene, const char *option, const char *value,
                         const char *separator, struct text *out, struct error *err)
{
    const char stops[] = {separator[0], '#', '\0'}, *at;
    size_t length;
    if (!option_open(scene, option, value, out, err))
        return false;
    out->separators = separator;
    at = out->at;
    do {
        at += strspn(at, " \t");
        length = strcspn(at, stops);
        at += length;
        if (length == 0 || *at == '#')
            return error_at(err, option_word(out, at, at).place,
                            "expected numbers with one '%s' between them", separator);
    } while (*at++ != '\0');
    return true;
}

bool scene_set_wavelengths(struct scene *scene, const char *value, struct error *err)
{
    const bool range = strchr(value, ':');
    struct text text;
    if (!open_numbers(scene, "--wavelengths", value, range ? ":" : ",", &text, err))
        return false;
    scene->n_wavelengths = 0;
    scene->wavelengths_place = text_place(&text);
    return (range ? read_range(scene, &text, err) && text_end(&text, "START:END:STEP", err)
                  : read_wavelength_list(scene, &text, err)) &&
           check_unit(scene, err);
}

bool scene_set_size(struct scene *scene, const char *value, struct error *err)
{
    struct text text;
    struct scene_reader reader = {.scene = scene, .text = &text};
    return open_numbers(scene, "--size", value, "x", &text, err) && size_read(&reader, err);
}

bool scene_set_shading(struct scene *scene, const char *value, struct error *err)
{
    struct text text;
    struct scene_reader reader = {.scene = scene, .text = &text};
    return option_open(scene, "--shading", value, &text, err) && shading_read(&reader, err);
}

bool scene_set_tessellation(struct scene *scene, const char *value, struct error *err)
{
    return option_number("--tessellation", value, smallest_positive, HUGE_VAL, &scene->tessellation,
                         err);
}
