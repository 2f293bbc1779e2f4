/* SPDX-License-Identifier: MIT */
/* The words of --gl and --renderer. */
#include <stdlib.h>
#include <string.h>

#include "data/text/text.h"
#include "raster/renderers/renderers.h"

/* ---- --renderer ---- */

static const char *const drivers[] = {"llvmpipe", "softpipe", NULL};

/* Returns the driver of this name; NULL: there is none. */
static const char *find_driver(const char *name)
{
    for (int i = 0; drivers[i]; i++)
        if (strcmp(name, drivers[i]) == 0)
            return drivers[i];
    return NULL;
}

enum gl_way driver_way(const char *renderer, const char **driver)
{
    static const char *const words[] = {[GL_CORE] = "gl-shader", [GL_ES] = "es-shader"};
    const char *colon = renderer ? strchr(renderer, ':') : NULL;
    *driver = renderer ? find_driver(colon ? colon + 1 : renderer) : NULL;
    for (int way = GL_CORE; renderer && way <= GL_ES; way++)
        if (strncmp(renderer, words[way], strlen(words[way])) == 0)
            return (enum gl_way)way;
    return GL_WITHOUT_SHADERS;
}

static bool refuse_renderer(const char *option, const char *value, struct error *err)
{
    static const char *const known[] = {"gl",     "llvmpipe",         "softpipe",
                                        "raster", "gl-shader:DRIVER", "es-shader:DRIVER"};
    const struct word typed = {.start = value, .length = strlen(value)};
    struct suggestion suggestion = {.distance = 0};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        suggestion_add(&suggestion, &typed, known[i], strlen(known[i]));
    return error_usage(err, "%s: unknown renderer '%.100s'; %s", option, value,
                       suggestion_end(&suggestion, "known are"));
}

bool driver_accepts_renderer(const char *option, const char *value, struct error *err)
{
    const size_t length = strlen("gl-shader"); /* es-shader is as long */
    const char *driver;
    const bool shaders = driver_way(value, &driver) != GL_WITHOUT_SHADERS;
    if (shaders && (value[length] == '\0' || (value[length] == ':' && driver)))
        return true;
    return (!shaders && find_driver(value)) || strcmp(value, "gl") == 0 ||
           strcmp(value, "raster") == 0 || refuse_renderer(option, value, err);
}

/* ---- --gl ---- */

int driver_device(const char *library)
{
    static const char prefix[] = "egl:";
    const size_t length = sizeof prefix - 1;
    const char *digits = library + length;
    if (strncmp(library, prefix, length) != 0 || !*digits || strlen(digits) > 2 ||
        digits[strspn(digits, "0123456789")] != '\0')
        return -1;
    return atoi(digits);
}

bool driver_accepts_library(const char *option, const char *value, struct error *err)
{
    return strcmp(value, "osmesa") == 0 || strcmp(value, "egl") == 0 ||
           strcmp(value, "auto") == 0 || driver_device(value) >= 0 ||
           error_usage(err, "%s is osmesa, egl, egl:N (EGL's device N) or auto, not '%.100s'",
                       option, value);
}
