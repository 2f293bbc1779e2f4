/* SPDX-License-Identifier: MIT */
/* The words of --gl. */
#include <stdlib.h>
#include <string.h>

#include "raster/driver/driver.h"

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
