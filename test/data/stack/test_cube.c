/* SPDX-License-Identifier: MIT */
/* A stack's record of its lights and their white is compared with the scene, which was written by
 * hand. A stack whose record is damaged is refused; one without a record is read like a stack of
 * another program. effects.py and positions.py have the object at each pixel, develop.py and
 * probe.py stacks of others, and scenes without light. */
#include "bytes.h"
#include "data/base/inside.h"
#include "data/images/images.h"
#include "data/sampling/inside.h"
#include "data/scene/inside.h"
#include "data/spectra/spectra.h"
#include "data/stack/stack.h"
#include "raster/beside/see/see.h"
#include "raster/plan/plan.h"
#include "raster/render/inside.h"
#include "spectral.h"

static const char *const path = "cube.tif";
static struct detector observer; /* cie1931 */

/* Renders a scene by the reference, at its own wavelengths if sampling is NULL. */
static bool render_sampled(const char *name, const char *sampling, struct error *err)
{
    struct sampling_method method;
    struct scene scene = {.path = NULL};
    struct sampling taken = {.detector = NULL};
    struct plan plan = {.scene = NULL};
    struct plan_options options = {.store_raster = true};
    struct render_output output = {.path = path};
    struct render_result result;
    files_read_forget();
    bool done = scene_read(name, &scene, err) &&
                (sampling == NULL || (sampling_read("--sampling", sampling, &method, err) &&
                                      scene_sample(&scene, &method, "cie1931", &taken, err))) &&
                plan_make(&scene, sampling_or_none(&taken), &options, &plan, err) &&
                render(&plan, &output, NULL, &result, err) && render_agreed(&plan, &result);
    plan_free(&plan);
    sampling_free(&taken);
    scene_free(&scene);
    return done;
}

/* Renders a scene and opens its stack. */
static bool open_rendered(const char *scene, const char *sampling, struct cube *cube)
{
    struct error err = {0};
    return CHECK(render_sampled(scene, sampling, &err) && cube_open(path, cube, &err),
                 "%s %s: rendered and opened %s", scene, sampling ? sampling : "", err.text);
}

static bool open_scene(const char *text, struct cube *cube)
{
    return open_rendered(test_write("cube.scene", text), NULL, cube);
}

static int object_at(const struct cube *cube, int x, int y)
{
    struct error err = {0};
    int object = -2;
    return cube_objects(cube, x, y, 1, &object, &err) ? object : -3;
}

/* ---- white ---- */

static void check_white(const struct cube *cube, const char *spectrum, const double *expected,
                        const char *name)
{
    double white[8];
    struct error err = {0};
    if (!CHECK(cube_white(cube, spectrum, white, &err), "%s: there is a white %s", name, err.text))
        return;
    for (int i = 0; i < cube->image.n_pages; i++)
        CHECK_NEAR(white[i], expected[i], 1e-15, "%s: at %.10g nm", name,
                   cube->image.wavelengths_nm[i]);
}

static void check_no_white(const struct cube *cube, const char *spectrum, const char *what)
{
    double white[8];
    struct error err = {0};
    CHECK(!cube_white(cube, spectrum, white, &err) && err.status == EXIT_INPUT &&
              strstr(err.text, what) != NULL,
          "a white is refused with '%s': %s", what, err.text);
}

#define PLANE "size 4 4\ncamera ortho 4\nobject plane 2 2 material paint\n"

/* (3 lamp + 1 x 0.5 + 4 x 2) / 8, where the lamp is 1 at 400 nm, 4 at 700 nm and 0 at 800 nm. */
static void test_mean(void)
{
    const double mean[] = {11.5 / 8, 14.5 / 8, 17.5 / 8, 20.5 / 8, 8.5 / 8},
                 lamp[] = {2, 4, 6, 8, 0};
    struct cube cube;
    test_write("lamp.csv", "400,1\n700,4\n");
    if (!open_scene("wavelengths 400 800 100\n" PLANE "material paint { diffuse 0.5 }\n"
                    "light lamp.csv 3 direction 0 0 1\nambient 2 4\n"
                    "light 0.25*2 1 position 0 0 9\n",
                    &cube))
        return;
    check_white(&cube, NULL, mean, "a scene has two lights and an ambient one");
    check_white(&cube, "lamp.csv*2", lamp, "the command line adds a spectrum");
    CHECK_NEAR(record_illumination(&cube.record), 8, 0, "their intensities add up");
    CHECK(cube.record.lights.n == 2 && cube.record.ambients.n == 1,
          "lights and ambient lights are listed separately");
    CHECK_TEXT(cube.record.lights.text[0], "lamp.csv*3", "the first light");
    CHECK_TEXT(cube.record.lights.text[1], "0.25*2*1",
               "the second light, whose spectrum has a factor");
    CHECK_TEXT(cube.record.ambients.text[0], "2*4", "the ambient light");
    check_no_white(&cube, "0", "the white is 0 at all of the stack's wavelengths");
    check_no_white(&cube, "an unknown light is refused", "--white:1:1: error: ");
    check_no_white(&cube, "", "expected one line");
    check_no_white(&cube, "-1", "--white:1:1: error: ");
    cube_close(&cube);
    cube_close(&cube);
}

/* ---- stacks of other programs, and forged ones ---- */

/* Returns the place of `text` among the bytes; it occurs once in a stack's record. */
static unsigned char *find(unsigned char *bytes, size_t length, const char *text)
{
    for (size_t i = 0; i + strlen(text) <= length; i++)
        if (memcmp(bytes + i, text, strlen(text)) == 0)
            return bytes + i;
    return bytes;
}

/* Overwrites `from` in the stack and moves its end: the stack opens, with its record but without
 * objects; without a record; or it is refused. */
enum fate { OWN, FOREIGN, REFUSED };
struct forgery {
    const char *from, *to;
    int longer;
    enum fate fate;
};

static void check_forged(const struct forgery *forgery)
{
    size_t length;
    unsigned char *bytes = bytes_read(path, &length);
    struct error err = {0};
    struct cube cube;
    float row[4];
    memcpy(find(bytes, length, forgery->from), forgery->to, strlen(forgery->to));
    bytes_write("forged.tif", bytes, (size_t)((long)length + forgery->longer));
    const bool opened = cube_open("forged.tif", &cube, &err);
    CHECK(opened == (forgery->fate != REFUSED) &&
              (opened || strstr(err.text, "forged.tif: its record of how it was made is damaged")),
          "'%.13s' made '%.13s', %d bytes more: it %s %s", forgery->from, forgery->to,
          forgery->longer, forgery->fate == REFUSED ? "is refused" : "opens", err.text);
    if (opened) {
        const bool own = forgery->fate == OWN;
        CHECK(object_at(&cube, 1, 1) == -1, "it has no objects");
        CHECK((cube.record.text != NULL) == own && (cube.record.white.n > 0) == own,
              "it is read as %s", own ? "a stack of spectral" : "a stack of another program");
        CHECK(image_read(&cube.image, 1, 1, 1, row, &err) && cube.image.scale > 0,
              "its pixels can be read %s", err.text);
    }
    cube_close(&cube);
    free(bytes);
}

static void test_forged(void)
{
    struct cube cube;
    char offset[64], more[64];
    if (!open_scene("wavelengths 400 700 100\n" PLANE
                    "material paint { diffuse 0.5 }\nlight d65 1 direction 0 0 1\n",
                    &cube))
        return;
    CHECK(object_at(&cube, 1, 1) == 1, "a pixel's object is read");
    const unsigned long long at = cube.record.map_offset;
    snprintf(offset, sizeof offset, "object_map: %llu 1", at);
    snprintf(more, sizeof more, "object_map: %llu 1", at + 1);
    cube_close(&cube);
    const struct forgery forgeries[] = {
        /* test_record.c has more lines that are malformed */
        {offset, more, 0, OWN},
        {offset, "object_map: 99999999999999999999", 0, REFUSED},
        {"object: ", "subject:", 0, OWN},
        {"program", "program", 1, OWN},
        {"program", "program", -1, OWN},
        {"white: 0.", "white: -.", 0, REFUSED},
        {"illumination: 1", "illumination: 0", 0, REFUSED},
        {"program: ", "programme", 0, REFUSED},
        {"scene_sha256", "scene_sha257", 0, FOREIGN},
    };
    for (size_t i = 0; i < sizeof forgeries / sizeof forgeries[0]; i++)
        check_forged(&forgeries[i]);
}

/* Writes a number that belongs to no object. */
static void test_stray(void)
{
    size_t length;
    unsigned char *bytes = bytes_read(path, &length);
    struct error err = {0};
    struct cube cube;
    bytes[length - 16] = 2;
    bytes_write("forged.tif", bytes, length);
    CHECK(cube_open("forged.tif", &cube, &err) && object_at(&cube, 0, 0) == -1 &&
              object_at(&cube, 1, 1) == 1,
          "a number without an object makes the map invalid %s", err.text);
    cube_close(&cube);
    free(bytes);
}

/* Checks that the file is refused in one line that names it and contains `what`. */
static void check_refusal(const char *name, const char *what)
{
    struct cube cube;
    struct error err = {0};
    CHECK(!cube_open(path, &cube, &err) && err.status == EXIT_INPUT &&
              strstr(err.text, what) != NULL && strstr(err.text, path) != NULL &&
              strchr(err.text, '\n') == NULL,
          "%s: refused with '%s': %s", name, what, err.text);
    cube_close(&cube);
}

/* A stack of spectral may be cut short in its object map. images.py cuts stacks anywhere else.
 */
static void test_cuts(void)
{
    struct error err = {0};
    struct cube cube;
    if (!open_rendered("cube.scene", NULL, &cube))
        return;
    const off_t pixels = (off_t)cube.record.map_offset;
    cube_close(&cube);
    CHECK(truncate(path, pixels) == 0 && cube_open(path, &cube, &err), "it opens without its map");
    CHECK(object_at(&cube, 1, 1) == -1 && cube.record.white.n == 4, "it lacks nothing but the map");
    cube_close(&cube);
    CHECK(truncate(path, pixels - 1) == 0, "another byte is cut off");
    check_refusal("cut within pixels",
                  "page 4 (700 nm): its pixels end beyond the end of the file");
}

/* ---- sampled stacks ---- */

/* Renders a scene with a lamp that rises by 3 in 350 nm, from 1. */
#define LAMP_SCENE                                                                                 \
    "wavelengths 380 730 1\n" PLANE "material paint { diffuse 0.5 }\n"                             \
    "light lamp.csv 1 direction 0 0 1\n"

static bool open_sampled(const char *sampling, struct cube *cube)
{
    test_write("lamp.csv", "380,1\n730,4\n");
    return open_rendered(test_write("cube.scene", LAMP_SCENE), sampling, cube);
}

/* A fixed sampling records its white exactly: the detector's sum at 1 nm. */
static void white_at_1nm(double out[3])
{
    enum { N = 351 };
    double nm[N], white[N], weights[3 * N];
    for (int i = 0; i < N; i++) {
        nm[i] = 380 + i;
        white[i] = 1 + 3 * i / 350.0;
    }
    detector_weights(&observer, nm, N, weights);
    detector_response(weights, white, N, out);
}

/* Finds a stack's response to a white. */
static bool responds(const struct cube *cube, const char *spectrum, bool required, bool *found,
                     double white[3], struct error *err)
{
    double weights[3 * 64];
    *err = (struct error){0};
    return cube_weights(cube, &observer, weights, err) &&
           cube_white_response(cube, &(struct white_request){spectrum, required}, weights, found,
                               white, err);
}

static void check_response(const struct cube *cube, const char *spectrum, double tolerance,
                           const char *name)
{
    double weights[3 * 64] = {0}, white[3] = {0}, expected[3] = {0};
    bool found = false;
    struct error err;
    struct detector other;
    white_at_1nm(expected);
    CHECK(responds(cube, spectrum, true, &found, white, &err) && found &&
              detector_read("cie1964", &other, &err),
          "%s: there are weights and a white %s", name, err.text);
    for (int channel = 0; channel < 3; channel++)
        CHECK_NEAR(white[channel], expected[channel], tolerance * expected[channel],
                   "%s: the white in channel %d", name, channel + 1);
    const bool open = cube_weights(cube, &other, weights, &err);
    CHECK(open == (cube->record.response.n == 0) &&
              (open || strstr(err.text, "expected --detector cie1931") != NULL),
          "%s: another detector works unless the sampling is fixed for one %s", name, err.text);
    detector_free(&other);
}

static void test_sampled(void)
{
    const struct {
        const char *sampling;
        double tolerance; /* of the white, which is linear: most samplings reproduce it but for the
                             10 digits of the recorded wavelengths */
        bool fixed, components;
    } samplings[] = {{"gauss:8", 1e-9, false, false},     {"gauss:8,open", 1e-9, false, false},
                     {"gauss:9,xyz", 1e-12, true, false}, {"gauss:9,lms", 1e-12, true, false},
                     {"gauss:8,acc", 1e-12, true, false}, {"basis:2", 1e-12, true, true},
                     {"rgb", 1e-12, true, true},          {"xyz", 1e-12, true, true},
                     {"box:12", 0.05, false, false},      {"adaptive:0.001", 0.001, false, false},
                     {"riemann:10", 0.01, false, false}};
    for (size_t i = 0; i < sizeof samplings / sizeof samplings[0]; i++) {
        struct cube cube;
        struct error err = {0};
        double white[64];
        if (!open_sampled(samplings[i].sampling, &cube))
            continue;
        const char *name = samplings[i].sampling;
        CHECK_TEXT(cube.record.sampling, name, "%s: the sampling is recorded", name);
        CHECK(cube.components == samplings[i].components &&
                  (cube.record.response.n > 0) == samplings[i].fixed &&
                  cube_needs_radiance(&cube, "this", &err) == !samplings[i].components,
              "%s: the record says rightly if it is fixed and has components %s", name, err.text);
        check_response(&cube, NULL, samplings[i].tolerance, name);
        check_response(&cube, "lamp.csv", samplings[i].tolerance, name);
        CHECK(cube_white(&cube, NULL, white, &err) == !samplings[i].components &&
                  (!cube.components ||
                   cube.image.wavelengths_nm[cube.image.n_pages - 1] == cube.image.n_pages),
              "%s: the white has radiances if pages have wavelengths %s", name, err.text);
        cube_close(&cube);
    }
}

/* --white gives each box the same white as a scene with that light records. */
static void test_boxes(void)
{
    double white[64], again[64];
    struct cube cube;
    struct error err = {0};
    if (!open_sampled("box:7", &cube))
        return;
    CHECK(cube_white(&cube, NULL, white, &err) && cube_white(&cube, "lamp.csv", again, &err),
          "box:7: both whites are computed %s", err.text);
    for (int i = 0; i < cube.image.n_pages; i++)
        CHECK_NEAR(again[i], white[i], 1e-12, "box %d has the same mean", i + 1);
    cube_close(&cube);
}

enum { N_KINDS = 4 };
static const char *const kinds[N_KINDS] = {"gauss:8", "gauss:9,xyz", "basis:2", "rgb"};

/* A radiance of 1 everywhere equals the white 1 in all of the detector's channels. */
static void test_equal(void)
{
    for (size_t i = 0; i < N_KINDS; i++) {
        double weights[3 * 64], equal[3], white[3];
        bool found;
        struct cube cube;
        struct error err;
        if (!open_sampled(kinds[i], &cube))
            continue;
        CHECK(responds(&cube, "1", true, &found, white, &err) &&
                  cube_weights(&cube, &observer, weights, &err) &&
                  cube_equal_response(&cube, &observer, weights, equal, &err),
              "%s: both whites are computed %s", kinds[i], err.text);
        for (int channel = 0; channel < 3; channel++)
            CHECK_NEAR(equal[channel], white[channel], 1e-12, "%s: they agree in channel %d",
                       kinds[i], channel + 1);
        cube_close(&cube);
    }
}

/* The numbers of a file may be finite although their sums are not. */
static void test_huge(void)
{
    double weights[3 * 64], white[3];
    bool found;
    struct cube cube;
    struct error err = {0};
    if (!open_sampled("gauss:9,xyz", &cube))
        return;
    cube.record.white_response.value[1] = 1e300;
    CHECK(!cube_white_response(&cube, &(struct white_request){NULL, true}, weights, &found, white,
                               &err) &&
              strstr(err.text, "the white has 1e+300 in channel 2") != NULL,
          "a white of 1e300 is refused %s", err.text);
    err = (struct error){0};
    cube.record.response.value[3] = -1e300;
    CHECK(!cube_weights(&cube, &observer, weights, &err) &&
              strstr(err.text, "weight -1e+300 of page 4 cannot be used") != NULL,
          "a weight of -1e300 is refused %s", err.text);
    cube_close(&cube);
}

/* A light that the detector does not see gives no white to adapt to, but still gives a picture. */
static void test_unseen(void)
{
    test_write("lamp.csv", "300,1\n350,1\n");
    test_write("cube.scene",
               "wavelengths 400 700 1\n" PLANE "material paint { diffuse 0.5 emission 1 }\n"
               "light lamp.csv 1 direction 0 0 1\n");
    for (size_t i = 0; i < N_KINDS; i++) {
        double white[3];
        bool found = true;
        struct cube cube;
        struct error err;
        if (!open_rendered("cube.scene", kinds[i], &cube))
            continue;
        CHECK(responds(&cube, NULL, false, &found, white, &err) && !found,
              "%s: ultraviolet light makes no white %s", kinds[i], err.text);
        CHECK(!responds(&cube, NULL, true, &found, white, &err) &&
                  strstr(err.text, "has no white") != NULL,
              "%s: an adaptation to its white is refused %s", kinds[i], err.text);
        CHECK(!responds(&cube, "lamp.csv", true, &found, white, &err) &&
                  strstr(err.text, "0 at all of the stack's wavelengths") != NULL,
              "%s: it is refused as the option --white %s", kinds[i], err.text);
        cube_close(&cube);
    }
}

int main(void)
{
    struct error err = {0};
    test_enter();
    test_need(detector_read("cie1931", &observer, &err), err.text);
    test_mean();
    test_forged();
    test_stray();
    test_cuts();
    test_sampled();
    test_boxes();
    test_equal();
    test_huge();
    test_unseen();
    unlink(path);
    unlink("forged.tif");
    unlink("cube.scene");
    unlink("lamp.csv");
    detector_free(&observer);
    return test_end();
}
