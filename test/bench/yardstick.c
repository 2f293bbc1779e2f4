/* SPDX-License-Identifier: MIT */
/* The yardstick of the machine: a fixed amount of arithmetic on one thread, such as a path tracer
 * does. ratios.py divides seconds of the program by its seconds, so that a goal in seconds holds on
 * a faster and on a slower machine.
 * usage: yardstick [RAYS] */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* A path tracer takes 1.7 s for 512 x 512 pixels and 93 wavelengths; so many rays take as long on
 * one thread of an Intel Xeon of 2.3 GHz (family 6, model 207). */
enum { RAYS = 42000000, SPHERES = 24 };

/* A linear congruential generator: the same numbers everywhere. */
static double random_number(unsigned long long *state)
{
    *state = *state * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(*state >> 11) / 9007199254740992.0;
}

/* Returns the depth at which the ray x, y that runs along z first meets a sphere; 100: none. */
static double nearest(const double centre[SPHERES][3], double x, double y)
{
    double depth = 100;
    for (int i = 0; i < SPHERES; i++) {
        const double dx = x - centre[i][0], dy = y - centre[i][1];
        const double inside = 0.81 - dx * dx - dy * dy;
        const double at = inside > 0 ? centre[i][2] - sqrt(inside) : 100;
        depth = at < depth ? at : depth;
    }
    return depth;
}

int main(int argc, char **argv)
{
    const long rays = argc > 1 ? atol(argv[1]) : RAYS;
    unsigned long long state = 1;
    double centre[SPHERES][3], sum = 0;
    for (int i = 0; i < SPHERES; i++) {
        centre[i][0] = 2 * (i % 6) - 5;
        centre[i][1] = 2 * (i / 6) - 3;
        centre[i][2] = 8 + random_number(&state);
    }
    for (long i = 0; i < rays; i++) {
        const double x = 12 * random_number(&state) - 6;
        sum += nearest((const double(*)[3])centre, x, 8 * random_number(&state) - 4);
    }
    printf("%.17g\n", sum);
    return 0;
}
