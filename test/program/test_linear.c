/* SPDX-License-Identifier: MIT */
/* level: none; linear.py runs this program */
/* Reads one file as `spectral plan` or `spectral info` does, but starts fast: it holds no OpenGL.
 * test/program/linear.py counts its instructions. Without arguments there is nothing to test. */
#include <stdio.h>
#include <string.h>

#include "data/stack/stack.h"
#include "data/text/text.h"
#include "raster/render/render.h"

int main(int argc, char **argv)
{
    struct error err = {.text = ""};
    if (argc != 3) {
        puts("1..0 # SKIP test/program/linear.py runs this program");
        return 0;
    }
    struct options options = {
        .operand = argv[2], .operands = {argv[2]}, .n_operands = 1, .threads = 1};
    const bool done = strcmp(argv[1], "info") == 0 ? info_command.run(&options, &err)
                                                   : plan_command.run(&options, &err);
    if (!done)
        fprintf(stderr, "%s\n", err.text);
    return done ? 0 : (int)err.status;
}
