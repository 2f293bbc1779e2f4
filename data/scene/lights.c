/* SPDX-License-Identifier: MIT */
/* The lights of a scene: its statements `ambient` and `light`, and the options of the command line
 * that replace them. */
#include <limits.h>

#include "data/scene/inside.h"

/* ---- statements ---- */

/* Adds a light to a list of n; NULL: no memory. */
static struct light *add_light(struct light **list, int *n, struct place place, struct error *err)
{
    const struct light fresh = {.intensity = 1, .attenuation = {1, 0, 0}, .place = place};
    return array_add(list, n, &fresh, sizeof fresh, err) ? &(*list)[*n - 1] : NULL;
}

static bool read_radiation(struct text *text, struct light *out, struct error *err)
{
    struct word word;
    return text_expect(text, &word, "a spectrum", err) &&
           spectrum_read(&word, 0, HUGE_VAL, &out->spectrum, err) &&
           text_number(text, "intensity", 0, HUGE_VAL, &out->intensity, err);
}

static bool read_unit(struct text *text, struct light *out, struct error *err)
{
    static const char *const units[] = {"W", "relative", NULL};
    const int chosen = text_choose(text, "W or relative", units, "unit", err);
    out->absolute = chosen == 0;
    return chosen >= 0;
}

/* Refuses a light whose unit is not that of the others: their sums would have none. These have one
 * unit, and the first or the last one of all is among them. */
static bool check_unit(const struct scene *scene, const struct light *light, struct error *err)
{
    static const char *const words[] = {"relative", "W"};
    const int last = scene->n_lights + scene->n_ambients - 1;
    return (scene_light(scene, 0)->absolute == light->absolute &&
            scene_light(scene, last)->absolute == light->absolute) ||
           error_at(err, light->place,
                    "the unit of this light is %s, of those before it %s; "
                    "expected 'unit %s' here, too",
                    words[light->absolute], words[!light->absolute], words[!light->absolute]);
}

bool ambient_read(struct scene_reader *reader, struct error *err)
{
    static const char *const words[] = {"unit", NULL};
    struct scene *scene = reader->scene;
    struct light *ambient = add_light(&scene->ambients, &scene->n_ambients, reader->place, err);
    struct place given[1] = {{0}};
    struct word word;
    if (!ambient || !read_radiation(reader->text, ambient, err))
        return false;
    while (text_word(reader->text, &word))
        if (word_choose_once(&word, words, "word for ambient light", given, err) < 0 ||
            !read_unit(reader->text, ambient, err))
            return false;
    return check_unit(scene, ambient, err);
}

static bool read_source(struct text *text, struct light *out, struct error *err)
{
    static const char *const words[] = {"position", "direction", NULL};
    int chosen = text_choose(text, "position or direction", words, "word for a light", err);
    out->directional = chosen == 1;
    if (chosen == 1)
        return text_direction(text, "direction", &out->position, err);
    return chosen == 0 && text_vector(text, "position", &out->position, err);
}

static bool read_attenuation(struct text *text, struct light *out, struct error *err)
{
    static const char *const names[] = {"constant attenuation", "linear attenuation",
                                        "quadratic attenuation"};
    double *k = out->attenuation;
    for (int i = 0; i < 3; i++)
        if (!text_number(text, names[i], 0, HUGE_VAL, &k[i], err))
            return false;
    return k[0] > 0 || k[1] > 0 || k[2] > 0 ||
           error_at(err, out->attenuation_place,
                    "attenuation 0 0 0 divides by 0; one of its numbers must be above 0");
}

static bool read_spot(struct text *text, struct light *out, struct error *err)
{
    double *cutoff = &out->spot_cutoff_deg;
    struct word word;
    out->spot = true;
    if (!text_direction(text, "spot", &out->spot_direction, err) ||
        !text_expect(text, &word, "a cutoff", err) ||
        !word_number(&word, "cutoff", -HUGE_VAL, HUGE_VAL, cutoff, err))
        return false;
    if (!(*cutoff >= 0 && *cutoff <= 90) && *cutoff != 180)
        return error_at(err, word.place,
                        "cutoff %.15g is out of range; it lies between 0 and 90, or is 180",
                        *cutoff);
    return text_number(text, "exponent", 0, 128, &out->spot_exponent, err);
}

static bool read_light_options(struct text *text, struct light *light, struct error *err)
{
    static const char *const words[] = {"attenuation", "spot", "unit", "shadows", NULL};
    struct place given[4] = {{0}};
    struct word word;
    while (text_word(text, &word)) {
        int option = word_choose_once(&word, words, "word for a light", given, err);
        if (option < 0)
            return false;
        light->attenuation_place = given[0];
        if (light->directional && option < 2)
            return error_at(err, word.place,
                            "%s needs a light with a position; a direction has no distance",
                            words[option]);
        light->shadows = light->shadows || option == 3;
        if ((option == 0 && !read_attenuation(text, light, err)) ||
            (option == 1 && !read_spot(text, light, err)) ||
            (option == 2 && !read_unit(text, light, err)))
            return false;
    }
    return true;
}

bool light_read(struct scene_reader *reader, struct error *err)
{
    struct scene *scene = reader->scene;
    struct light *light = add_light(&scene->lights, &scene->n_lights, reader->place, err);
    return light && read_radiation(reader->text, light, err) &&
           read_source(reader->text, light, err) && read_light_options(reader->text, light, err) &&
           check_unit(scene, light, err);
}

/* ---- options of the command line ---- */

/* Reads SPECTRUM[*INTENSITY] up to the end. Without INTENSITY the light keeps its own, and one that
 * is off, as the second lamp of lists, gets 1. */
static bool read_light_option(const struct text *text, const char *start, struct light *out,
                              struct error *err)
{
    const char *end = text->bytes + text->length, *star = strrchr(start, '*');
    const struct word word = option_word(text, start, star ? star : end),
                      number = option_word(text, star ? star + 1 : end, end);
    if (star && !word_number(&number, "intensity", 0, HUGE_VAL, &out->intensity, err))
        return false;
    if (word.length == 0)
        return error_at(err, word.place, "expected a spectrum");
    spectrum_free(&out->spectrum);
    return spectrum_read(&word, 0, HUGE_VAL, &out->spectrum, err);
}

bool scene_set_light(struct scene *scene, const char *value, struct error *err)
{
    struct text text;
    long n;
    if (!option_open(scene, "--light", value, &text, err))
        return false;
    const char *equals = strchr(text.at, '=');
    if (!equals)
        return error_at(err, text_place(&text), "expected N=SPECTRUM[*FACTOR], not '%s'", value);
    const struct word number = option_word(&text, text.at, equals);
    if (!word_integer(&number, "light", 1, LONG_MAX, &n, err))
        return false;
    if (n > scene->n_lights)
        return error_at(err, number.place, "there is no light %ld; the scene has %d", n,
                        scene->n_lights);
    struct light *light = &scene->lights[n - 1];
    light->intensity = light->intensity > 0 ? light->intensity : 1;
    return read_light_option(&text, equals + 1, light, err);
}

bool scene_set_ambient(struct scene *scene, const char *value, struct error *err)
{
    struct text text;
    const bool absolute = scene_is_absolute(scene);
    if (!option_open(scene, "--ambient", value, &text, err))
        return false;
    for (int i = 0; i < scene->n_ambients; i++)
        spectrum_free(&scene->ambients[i].spectrum);
    scene->n_ambients = 0;
    struct light *ambient = add_light(&scene->ambients, &scene->n_ambients, text_place(&text), err);
    if (!ambient)
        return false;
    ambient->absolute = absolute;
    return read_light_option(&text, text.at, ambient, err);
}
