/* SPDX-License-Identifier: MIT */
/* Spectra from words, as scenes and options have them. */
#ifndef SPECTRA_H
#define SPECTRA_H

#include "data/spectra/spectra.h"
#include "data/text/text.h"
#include "test.h"

/* Returns an absent spectrum after an error. */
static inline struct spectrum spectrum_of(const char *text)
{
    struct spectrum out = {0};
    struct error err = {0};
    const struct word word = {.start = text, .length = strlen(text)};
    if (!spectrum_read(&word, 0, HUGE_VAL, &out, &err))
        printf("# %s\n", err.text);
    return out;
}

#endif
