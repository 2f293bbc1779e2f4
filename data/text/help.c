/* SPDX-License-Identifier: MIT */
/* Prints the help of commands and options, in lines of a terminal's width. */
#include <string.h>

#include "data/text/inside.h"

enum { HELP_WIDTH = 80, HELP_COLUMN = 34 }; /* of a line; where an explanation begins */

void help_words(struct printed *to, const char *text, int column)
{
    const char *gap = "";
    for (int at = column, length; *(text += strspn(text, " \n")); text += length) {
        length = (int)strcspn(text, " \n");
        if (at + (int)strlen(gap) + length > HELP_WIDTH) {
            print(to, "\n%*s", column, "");
            at = column;
            gap = "";
        }
        print(to, "%s%.*s", gap, length, text);
        at += (int)strlen(gap) + length;
        gap = " ";
    }
    print_text(to, "\n");
}

/* Prints an option as the user types it, and its explanation beside it, or below if there is no
 * room. */
static void help_explain(struct printed *to, const char *typed, const char *explanation)
{
    const int used = 2 + (int)strlen(typed);
    print(to, "  %s", typed);
    if (used + 2 > HELP_COLUMN)
        print_text(to, "\n");
    print(to, "%*s", used + 2 > HELP_COLUMN ? HELP_COLUMN : HELP_COLUMN - used, "");
    help_words(to, explanation, HELP_COLUMN);
}

void help_options(const struct command *command, struct printed *to)
{
    struct option_walk walk = {.command = command};
    for (const struct option *option; (option = option_next(&walk));)
        help_explain(to, option->usage, option->help);
}
