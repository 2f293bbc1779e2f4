/* SPDX-License-Identifier: MIT */
/* Prints the tables of commands and options, from which tests make command lines: a line for each
 * command, and behind it one for each of its options, in columns between tabs. */
#include <stdio.h>

#include "data/text/text.h"

static void print_option(const struct option *option)
{
    static const char *const kinds[] = {[OPTION_TEXT] = "text",
                                        [OPTION_NUMBER] = "number",
                                        [OPTION_COUNT] = "count",
                                        [OPTION_FLAG] = "flag",
                                        [OPTION_CHANGE] = "change"};
    printf("option\t%s\t%s\t%.17g\t%.17g\t%s\t", option->usage, kinds[option->kind], option->lowest,
           option->highest, option->writes ? "writes" : "");
    for (int i = 0; option->choices && option->choices[i]; i++)
        printf("%s%s", i > 0 ? " " : "", option->choices[i]);
    printf("\n");
}

int main(void)
{
    for (int i = 0; commands[i]; i++) {
        printf("command\t%s\t%d\t%s\n", commands[i]->name, commands[i]->n_operands,
               commands[i]->operands);
        const struct option *option;
        for (int k = 0; (option = option_at(commands[i], k)); k++)
            print_option(option);
    }
    return 0;
}
