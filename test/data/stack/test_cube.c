/* SPDX-License-Identifier: MIT */
/* A stack whose record is damaged is refused; one without a record is read like a stack of another
 * program. whites.py has the lights of a stack and their white, effects.py and positions.py the
 * object at each pixel, develop.py and probe.py stacks of others, and scenes without light. */
#include "bytes.h"
#include "data/base/inside.h"
#include "data/scene/inside.h"
#include "raster/beside/see/see.h"
#include "raster/render/inside.h"

static const char *const path = "cube.tif";

/* Renders a scene by the reference and opens its stack. */
static bool open_scene(const char *name, struct cube *cube)
{
    struct scene scene = {.path = NULL};
    struct plan plan = {.scene = NULL};
    struct plan_options options = {.store_raster = true};
    struct render_output output = {.path = path};
    struct render_result result;
    struct error err = {0};
    files_read_forget();
    const bool done = scene_read(name, &scene, &err) &&
                      plan_make(&scene, NULL, &options, &plan, &err) &&
                      render(&plan, &output, NULL, &result, &err) && cube_open(path, cube, &err);
    plan_free(&plan);
    scene_free(&scene);
    return CHECK(done, "a scene is rendered and its stack opened %s", err.text);
}

static int object_at(const struct cube *cube, int x, int y)
{
    struct error err = {0};
    int object = -2;
    return cube_objects(cube, x, y, 1, &object, &err) ? object : -3;
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
    test_write("cube.scene", "wavelengths 400 700 100\nsize 4 4\ncamera ortho 4\n"
                             "object plane 2 2 material paint\nmaterial paint { diffuse 0.5 }\n"
                             "light d65 1 direction 0 0 1\n");
    if (!open_scene("cube.scene", &cube))
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
    if (!open_scene("cube.scene", &cube))
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

int main(void)
{
    test_enter();
    test_forged();
    test_stray();
    test_cuts();
    unlink(path);
    unlink("forged.tif");
    unlink("cube.scene");
    return test_end();
}
