/* SPDX-License-Identifier: MIT */
/* Fuzz target: a list of renders. None is run. Each line that is read has its own output, and can
 * be printed as a command. */
#include <stdlib.h>
#include <string.h>

#include "raster/batch/batch.h"
#include "test/fuzz/fuzz.h"

static void check_lines(const struct batch *batch)
{
    fuzz_holds(batch->n_lines > 0, "a list has lines");
    for (int i = 0; i < batch->n_lines; i++) {
        struct printed printed = {.text = NULL};
        fuzz_holds(batch->lines[i].n_words > 0 && batch->lines[i].output, "a line has an output");
        batch_print_command("spectral", &batch->lines[i], &printed);
        char *text = printed_end(&printed);
        fuzz_holds(!text || text[strlen(text) - 1] == '\n', "a command ends its line");
        free(text);
    }
}

void fuzz_batch(const struct fuzz_input *input)
{
    struct error err = {.status = EXIT_AGREED};
    char path[FUZZ_PATH];
    struct options options = {.table = fuzz_options(), .operand = path};
    struct batch batch;
    fuzz_write(".txt", input->bytes, input->length, path);
    if (fuzz_ends(batch_read(&options, &batch, &err), &err))
        check_lines(&batch);
    batch_free(&batch);
}
