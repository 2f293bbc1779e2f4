/* SPDX-License-Identifier: MIT */
/* Runs a fuzz target once for each file: replay TARGET FILE... Prints each name before, so that the
 * last line names the input that ends the program. */
#include "test/fuzz/fuzz.h"
#include "test/shared/bytes.h"

int main(int argc, char **argv)
{
    const struct fuzz_target *target = argc > 1 ? fuzz_target(argv[1]) : NULL;
    if (target == NULL) {
        fputs("usage: replay TARGET FILE...\n", stderr);
        return 2;
    }
    for (int i = 2; i < argc; i++) {
        size_t length;
        puts(argv[i]);
        fflush(stdout);
        unsigned char *bytes = bytes_read(argv[i], &length);
        test_need(access(argv[i], R_OK) == 0 && bytes != NULL, argv[i]);
        fuzz_run(target, bytes, length);
        free(bytes);
    }
    return 0;
}
