/* SPDX-License-Identifier: MIT */
/* ICC profiles of displays: three colorants and three curves, version 4.3 (ICC.1:2010). */
#include "raster/beside/colour/inside.h"

enum { HEADER = 128, TAGS = 10, TAG_ENTRY = 12 };

/* XYZ of the illuminant of the profile connection space, D50 (7.2.16). */
static const double d50[3] = {0.9642, 1, 0.8249};

struct profile {
    unsigned char *bytes; /* zeroed before */
    size_t at, end;       /* places of the next byte and of the next tag's data */
    int n_tags;
};

/* ---- numbers, big-endian ---- */

static void put(struct profile *to, int n_bytes, uint32_t value)
{
    for (int i = n_bytes - 1; i >= 0; i--)
        to->bytes[to->at++] = (unsigned char)(value >> 8 * i);
}

/* Puts signatures of four characters each. */
static void put_name(struct profile *to, const char *names)
{
    for (; *names != '\0'; names++)
        put(to, 1, (unsigned char)*names);
}

/* Puts an s15Fixed16Number. */
static void put_fixed(struct profile *to, double value)
{
    put(to, 4, (uint32_t)(int32_t)floor(value * 65536 + 0.5));
}

/* ---- tags ---- */

/* Puts a tag into the table behind the header, and begins its data at a multiple of 4. */
static void begin_tag(struct profile *to, const char *name, const char *type, size_t size)
{
    to->at = (size_t)(HEADER + 4 + TAG_ENTRY * to->n_tags++);
    put_name(to, name);
    put(to, 4, (uint32_t)to->end);
    put(to, 4, (uint32_t)size);
    to->at = to->end;
    to->end += (size + 3) / 4 * 4;
    put_name(to, type);
    put(to, 4, 0);
}

/* Puts a multiLocalizedUnicodeType (10.13) with one text in ASCII. */
static void put_text(struct profile *to, const char *name, const char *text)
{
    const size_t length = 2 * strlen(text);
    begin_tag(to, name, "mluc", 28 + length);
    put(to, 4, 1);
    put(to, 4, 12);
    put_name(to, "enUS");
    put(to, 4, (uint32_t)length);
    put(to, 4, 28);
    for (; *text != '\0'; text++)
        put(to, 2, (unsigned char)*text);
}

/* Puts an array of n numbers, as of XYZ, or of the rows of a matrix. */
static void put_array(struct profile *to, const char *name, const char *type, const double *numbers,
                      int n)
{
    begin_tag(to, name, type, (size_t)(8 + 4 * n));
    for (int i = 0; i < n; i++)
        put_fixed(to, numbers[i]);
}

/* Puts a parametricCurveType (10.15): function 3, or function 0 if the curve is a power alone. The
 * gain is left out there, because the largest value of a profile is 1. */
static void put_curve(struct profile *to, const char *name, struct display_curve curve)
{
    const bool plain = curve.from == 0 && curve.offset == 0;
    const double numbers[5] = {curve.exponent, curve.gain, curve.offset, curve.slope, curve.from};
    const int n = plain ? 1 : 5;
    begin_tag(to, name, "para", (size_t)(12 + 4 * n));
    put(to, 2, plain ? 0 : 3);
    put(to, 2, 0);
    for (int i = 0; i < n; i++)
        put_fixed(to, numbers[i]);
}

/* ---- the profile ---- */

/* Writes XYZ of the primaries at their largest value as columns. Their sum has Y = 1. */
static void colorants(enum display_kind kind, double out[3][3])
{
    double from_xyz[3][3], y = 0;
    display_matrix(kind, from_xyz);
    tristimulus_inverse(from_xyz, out);
    for (int j = 0; j < 3; j++) {
        for (int i = 0; i < 3; i++)
            out[i][j] *= display_largest(kind, j);
        y += out[1][j];
    }
    for (int i = 0; i < 9; i++)
        out[i / 3][i % 3] /= y;
}

/* Writes Bradford's matrix from the display's own white to D50, by way of D65. No adaptation fails,
 * because the whites are positive. */
static void to_d50(double of_display[3][3], double out[3][3])
{
    static const struct adaptation bradford = {.kind = ADAPTATION_BRADFORD};
    const double none[3] = {1, 1, 1};
    double white[3], to_d65[3][3], d50_to_d65[3][3], back[3][3];
    struct error err = {0};
    tristimulus_apply(of_display, none, white);
    adaptation_matrix(&bradford, white, none, to_d65, &err);
    adaptation_matrix(&bradford, d50, none, d50_to_d65, &err);
    tristimulus_inverse(d50_to_d65, back);
    tristimulus_product(back, to_d65, out);
}

/* Puts the header. The date is fixed, so that each run writes the same bytes. */
static void put_header(struct profile *to)
{
    to->at = 0;
    put(to, 4, (uint32_t)to->end);
    put(to, 4, 0);
    put(to, 4, 0x04300000);
    put_name(to, "mntrRGB XYZ ");
    put(to, 2, 2000);
    put(to, 2, 1);
    put(to, 2, 1);
    to->at = 36;
    put_name(to, "acsp");
    to->at = 68;
    for (int i = 0; i < 3; i++)
        put_fixed(to, d50[i]);
    to->at = HEADER;
    put(to, 4, TAGS);
}

size_t profile_write(enum display_kind kind, unsigned char out[LARGEST_PROFILE])
{
    static const char *const colorant[] = {"rXYZ", "gXYZ", "bXYZ"};
    static const char *const curve[] = {"rTRC", "gTRC", "bTRC"};
    struct profile profile = {.bytes = out, .end = HEADER + 4 + TAGS * TAG_ENTRY};
    double of_display[3][3], chad[3][3], adapted[3][3];
    memset(out, 0, LARGEST_PROFILE);
    colorants(kind, of_display);
    to_d50(of_display, chad);
    tristimulus_product(chad, of_display, adapted);
    put_text(&profile, "desc", kind == DISPLAY_SRGB ? "sRGB" : "Monitor of 1998");
    put_text(&profile, "cprt", "No copyright, use freely");
    put_array(&profile, "wtpt", "XYZ ", d50, 3);
    put_array(&profile, "chad", "sf32", chad[0], 9);
    for (int j = 0; j < 3; j++)
        put_array(&profile, colorant[j], "XYZ ",
                  (const double[]){adapted[0][j], adapted[1][j], adapted[2][j]}, 3);
    for (int j = 0; j < 3; j++)
        put_curve(&profile, curve[j], display_curve(kind, j));
    put_header(&profile);
    return profile.end;
}
