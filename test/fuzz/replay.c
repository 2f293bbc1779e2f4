/* SPDX-License-Identifier: MIT */
/* Runs a fuzz target once for each file: replay TARGET FILE... Prints each name before, so that the
 * last line names the input that ends the program. */
#include <stdlib.h>

#include "test/fuzz/fuzz.h"

static bool read_input(const char *path, unsigned char **bytes, size_t *length)
{
    FILE *file = fopen(path, "rb");
    long size = -1;
    *bytes = NULL;
    *length = 0;
    if (file == NULL)
        return false;
    if (fseek(file, 0, SEEK_END) == 0 && (size = ftell(file)) >= 0 && fseek(file, 0, SEEK_SET) == 0)
        *bytes = malloc((size_t)size + 1);
    if (*bytes != NULL)
        *length = fread(*bytes, 1, (size_t)size, file);
    fclose(file);
    return *bytes != NULL && *length == (size_t)size;
}

int main(int argc, char **argv)
{
    const struct fuzz_target *target = argc > 1 ? fuzz_target(argv[1]) : NULL;
    if (target == NULL) {
        fputs("usage: replay TARGET FILE...\n", stderr);
        return 2;
    }
    for (int i = 2; i < argc; i++) {
        unsigned char *bytes;
        size_t length;
        puts(argv[i]);
        fflush(stdout);
        if (!read_input(argv[i], &bytes, &length))
            return 2;
        fuzz_run(target, bytes, length);
        free(bytes);
    }
    return 0;
}
