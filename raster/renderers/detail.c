/* SPDX-License-Identifier: MIT */
/* The level of detail of a texture (OpenGL 2.1 specification, section 3.8.8): the binary logarithm
 * of how many texels a step to the next pixel takes in. The specification defines it by partial
 * derivatives, and lets a driver take differences, other norms and a rough logarithm. Whoever
 * believes a picture with mipmaps believes this file beside the reference. */
#include "raster/renderers/renderers.h"

struct detail_pixels detail_pixels(const struct detail_rule *rule, int x, int y)
{
    if (!rule->quad)
        return (struct detail_pixels){{x, x + 1, x}, {y, y, y + 1}};
    const int left = x - x % 2, upper = y - (y + rule->first_row) % 2, column = left + rule->right,
              row = upper + rule->lower;
    return (struct detail_pixels){{column, left + !rule->right, column},
                                  {row, row, upper + !rule->lower}};
}

/* Finds the place of a textured triangle in its texture, in texels, at a pixel's centre. Off its
 * edges its planes go on. Returns 1 / w. */
static double place_at(const struct screen_triangle *triangle, int x, int y, double out[2])
{
    const struct instance *instance = triangle->surface->instance;
    double share[3];
    const double inverse_w = shares_at(triangle, x + 0.5, y + 0.5, share);
    out[0] = out[1] = 0;
    for (int i = 0; i < 3; i++) {
        const struct vertex *vertex = &instance->vertices[triangle->vertex[i]];
        out[0] += share[i] * vertex->s * instance->texels.width;
        out[1] += share[i] * vertex->t * instance->texels.height;
    }
    return inverse_w;
}

/* From one pixel to the next a place N / w changes by its derivative at the first pixel, times the
 * ratio of 1 / w. */
void detail_steps(const struct detail_rule *rule, const struct screen_triangle *triangle, int x,
                  int y, double steps[2][2])
{
    const struct detail_pixels at = detail_pixels(rule, x, y);
    double here[2], there[2], inverse_w = place_at(triangle, at.x[0], at.y[0], here);
    for (int i = 0; i < 2; i++) {
        const double ratio = place_at(triangle, at.x[i + 1], at.y[i + 1], there) / inverse_w;
        for (int c = 0; c < 2; c++)
            steps[i][c] = (there[c] - here[c]) * (rule->quad ? 1 : ratio);
    }
}

/* The binary logarithm of a length: exact; half of that of its square, linear between powers of
 * two; or that of the nearest of 256 steps between powers of two. */
static double logarithm_of(const struct detail_rule *rule, double square)
{
    int exponent;
    if (rule->logarithm == LOGARITHM_LINEAR) {
        const double mantissa = frexp(square, &exponent);
        return 0.5 * (exponent - 2 + 2 * mantissa);
    }
    if (rule->logarithm == LOGARITHM_TABLE) {
        const double mantissa = frexp(sqrt(square), &exponent);
        return exponent - 9 + binary_logarithm(floor(512 * mantissa + 0.5));
    }
    return 0.5 * binary_logarithm(square);
}

/* Beyond all levels of any texture; logarithms are asked for finite numbers only. */
static const double longest = 0x1p64;

double detail_of(const struct detail_rule *rule, int n_levels, double steps[2][2])
{
    double most = 0;
    for (int i = 0; i < 2; i++) {
        const double s = steps[i][0] * steps[i][0], t = steps[i][1] * steps[i][1];
        most = fmax(most, rule->largest ? fmax(s, t) : s + t);
    }
    return most > 1 ? fmin(fmax(0, logarithm_of(rule, fmin(most, longest))), n_levels - 1) : 0;
}

double detail_find(const struct screen_triangle *triangle, int x, int y)
{
    static const struct detail_rule defined = {.quad = false};
    double steps[2][2];
    detail_steps(&defined, triangle, x, y, steps);
    return detail_of(&defined, triangle->surface->instance->texels.n_levels, steps);
}
