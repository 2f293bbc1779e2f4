/* SPDX-License-Identifier: MIT */
/* The verdict on a stack as one line, and the line as numbers. */
#include <inttypes.h>
#include <string.h>

#include "data/stack/inside.h"

void stack_verdict_text(const struct stack_verdict *verdict, char out[STACK_VERDICT])
{
    snprintf(out, STACK_VERDICT,
             "%s; %" PRIu64 " samples, %" PRIu64 " exact, %" PRIu64
             " within 1 count, largest difference %.3g counts, %" PRIu64 " of %" PRIu64
             " pixels unexplained, %" PRIu64 " of %" PRIu64 " object pixels not checked",
             verdict->word, verdict->samples, verdict->exact, verdict->within_1, verdict->largest,
             verdict->unexplained, verdict->pixels, verdict->unchecked, verdict->objects);
}

/* A line counts as read if it is the text of its numbers. */
bool stack_verdict_read(const char *line, struct stack_verdict *out)
{
    char text[STACK_VERDICT];
    *out = (struct stack_verdict){.samples = 0};
    if (sscanf(line,
               "%15[a-z ]; %" SCNu64 " samples, %" SCNu64 " exact, %" SCNu64
               " within 1 count, largest difference %lf counts, %" SCNu64 " of %" SCNu64
               " pixels unexplained, %" SCNu64 " of %" SCNu64 " object pixels not checked",
               out->word, &out->samples, &out->exact, &out->within_1, &out->largest,
               &out->unexplained, &out->pixels, &out->unchecked, &out->objects) != 9)
        return false;
    stack_verdict_text(out, text);
    return strcmp(text, line) == 0;
}
