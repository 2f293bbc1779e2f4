/* SPDX-License-Identifier: MIT */
/* Matrices that act on tristimulus values, and those that lead from them to a display and to the
 * cones of the eye. */
#include "data/spectra/spectra.h"

const double display_white[3] = {100 * 0.3127 / 0.3290, 100, 100 * (1 - 0.3127 - 0.3290) / 0.3290};

/* The inverse is the adjugate over the determinant. Cyclic indices give the cofactors their signs.
 */
void tristimulus_inverse(double m[3][3], double out[3][3])
{
    double determinant = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const int up = (i + 1) % 3, over = (i + 2) % 3, right = (j + 1) % 3, far = (j + 2) % 3;
            out[j][i] = m[up][right] * m[over][far] - m[up][far] * m[over][right];
        }
    for (int j = 0; j < 3; j++)
        determinant += m[0][j] * out[j][0];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[i][j] /= determinant;
}

void tristimulus_apply(double m[3][3], const double xyz[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i][0] * xyz[0] + m[i][1] * xyz[1] + m[i][2] * xyz[2];
}

void tristimulus_apply_all(double m[3][3], int n, double *columns)
{
    for (int i = 0; i < n; i++) {
        double out[3];
        tristimulus_apply(m, (double[]){columns[i], columns[n + i], columns[2 * n + i]}, out);
        for (int row = 0; row < 3; row++)
            columns[row * n + i] = out[row];
    }
}

/* Computes the matrix from the chromaticities of sRGB's primaries (ITU-R BT.709), whose amounts add
 * up to the white. The standard rounds the inverse of this matrix to four decimals, and inverts
 * that. */
void tristimulus_to_srgb(double out[3][3])
{
    double primaries[3][3] = {{0.64, 0.30, 0.15},
                              {0.33, 0.60, 0.06},
                              {1 - 0.64 - 0.33, 1 - 0.30 - 0.60, 1 - 0.15 - 0.06}};
    double amounts[3];
    tristimulus_inverse(primaries, out);
    tristimulus_apply(out, display_white, amounts);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[i][j] /= amounts[i];
}

/* Hunt, Pointer and Estevez's, scaled for D65, with the figures of the thesis's program; the thesis
 * prints them rounded, and -0.023 for -0.2263. */
void tristimulus_to_cones(double out[3][3])
{
    static const double cones[3][3] = {
        {0.4002, 0.7076, -0.0808}, {-0.2263, 1.1653, 0.0457}, {0, 0, 0.9182}};
    memcpy(out, cones, sizeof cones);
}
