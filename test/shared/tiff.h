/* SPDX-License-Identifier: MIT */
/* A test that opens a TIFF file by libtiff itself, as another program does. The handlers that the
 * program sets take every handle for one of its own. */
#ifndef TEST_SHARED_TIFF_H
#define TEST_SHARED_TIFF_H

#include <tiffio.h>

static inline TIFF *tiff_open(const char *path, const char *mode)
{
    TIFFSetErrorHandlerExt(NULL);
    TIFFSetWarningHandlerExt(NULL);
    return TIFFOpen(path, mode);
}

#endif
