/* SPDX-License-Identifier: MIT */
/* Reads charts without trusting their writer: an XML parser takes them, and they hold only finite
 * numbers. */
#ifndef SVG_H
#define SVG_H

#include <unistd.h>

#include "data/base/base.h"
#include "test.h"

/* Returns whether Python's parser takes the file, and no number in it is infinite or NaN. */
static inline bool svg_is_sound(const char *svg)
{
    char path[256], command[400];
    snprintf(path, sizeof path, "%s/chart-%d.svg", test_folder(), (int)getpid());
    snprintf(command, sizeof command,
             "/usr/bin/python3 -ISc 'import sys, xml.parsers.expat as xml\n"
             "xml.ParserCreate().ParseFile(open(sys.argv[1], \"rb\"))' %s",
             test_write(path, svg));
    const bool parsed = system(command) == 0;
    remove(path);
    return parsed && strncmp(svg, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n", 39) == 0 &&
           strstr(svg, "nan") == NULL && strstr(svg, "inf") == NULL;
}

/* Returns the text that was printed. */
static inline char *svg_end(struct printed *printed)
{
    char *svg = printed_end(printed);
    test_need(svg != NULL, "no memory");
    return svg;
}

#endif
