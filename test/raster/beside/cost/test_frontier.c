/* SPDX-License-Identifier: MIT */
/* level: none; frontier.py runs this program */
/* Draws the chart of the points on standard input. A line of each has its seconds, its error,
 * whether it lies on the frontier, whether only noise may keep it off, and its name. */
#include <stdio.h>

#include "raster/beside/cost/inside.h"

int main(int argc, char **argv)
{
    enum { MOST = MOST_CONFIGURATIONS };
    static struct cost_entry entries[MOST];
    static char scene[] = "cost & <accuracy>", name[sizeof entries->name];
    struct cost cost = {.observer = "cie1931", .scene = scene, .entries = entries};
    struct printed printed = {.text = NULL};
    double seconds, error;
    int best, uncertain;
    (void)argv;
    if (argc == 1)
        return puts("1..0 # SKIP test/raster/beside/cost/frontier.py runs this program") < 0;
    while (cost.n < MOST &&
           scanf("%lf %lf %d %d %127[^\n]", &seconds, &error, &best, &uncertain, name) == 5) {
        struct cost_entry *entry = &entries[cost.n++];
        *entry = (struct cost_entry){.seconds = seconds,
                                     .fastest = 0.95 * seconds,
                                     .slowest = 1.1 * seconds,
                                     .accuracy.quantile_95 = error,
                                     .best = best == 1,
                                     .uncertain = uncertain == 1};
        memcpy(entry->name, name, sizeof name);
    }
    cost_svg(&cost, &printed);
    char *svg = printed_end(&printed);
    const bool done = svg != NULL && fputs(svg, stdout) >= 0;
    free(svg);
    return !done;
}
