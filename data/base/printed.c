/* SPDX-License-Identifier: MIT */
/* A text that is printed into memory. Only a whole text is returned. */
#include <stdlib.h>

#include "data/base/base.h"

FILE *printed_begin(struct printed *out)
{
    *out = (struct printed){.text = NULL};
    out->to = open_memstream(&out->text, &out->length);
    return out->to;
}

char *printed_end(struct printed *printed)
{
    bool whole = printed->to && !ferror(printed->to);
    if (printed->to)
        whole = fclose(printed->to) == 0 && whole;
    char *text = printed->text;
    printed->to = NULL;
    printed->text = NULL;
    if (whole)
        return text;
    free(text);
    return NULL;
}
