/* SPDX-License-Identifier: MIT */
/* Fuzz target: the record of a stack, in the description of its first page. A byte before it says
 * whether the pages have wavelengths. */
#include <stdlib.h>
#include <string.h>

#include "data/images/images.h"
#include "data/stack/inside.h"
#include "test/fuzz/fuzz.h"

enum { N_PAGES = 3 };

static bool read_record(char *description, bool has_wavelengths, struct record *out)
{
    static char path[] = "stack.tif", verdict[] = "";
    double nm[N_PAGES] = {400, 500, 600};
    const struct image image = {.path = path,
                                .width = 4,
                                .height = 4,
                                .n_pages = N_PAGES,
                                .scale = 1,
                                .wavelengths_nm = has_wavelengths ? nm : NULL,
                                .description = description,
                                .verdict = verdict};
    struct error err = {.status = EXIT_AGREED};
    return fuzz_ends(record_read(&image, out, &err), &err);
}

void fuzz_record(const struct fuzz_input *input)
{
    const bool has_wavelengths = input->bytes[0] != '-';
    char *description = strdup(input->bytes + (input->length > 0));
    struct record record = {.text = NULL};
    if (description != NULL && read_record(description, has_wavelengths, &record))
        for (int i = 0; i < record.white.n; i++)
            fuzz_holds(record.white.value[i] >= 0, "a white is not negative");
    free(description);
    record_free(&record);
}
