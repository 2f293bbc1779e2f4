/* SPDX-License-Identifier: MIT */
/* Reads ICC profiles as the specification says. `test_profile srgb` writes a profile to standard
 * output, for the readers of other programs. */
#include "raster/beside/colour/colour.h"
#include "test.h"

struct profile {
    unsigned char bytes[LARGEST_PROFILE];
    size_t length;
};

static uint32_t number(const struct profile *profile, size_t at)
{
    uint32_t out = 0;
    for (size_t i = 0; i < 4; i++)
        out = out << 8 | (at + i < profile->length ? profile->bytes[at + i] : 0);
    return out;
}

static double fixed(const struct profile *profile, size_t at)
{
    return (int32_t)number(profile, at) / 65536.0;
}

static bool named(const struct profile *profile, size_t at, const char *name)
{
    return at + 4 <= profile->length && memcmp(profile->bytes + at, name, 4) == 0;
}

/* Finds a tag's data and their size; 0 means no such tag. */
static size_t tag(const struct profile *profile, const char *name, size_t *size)
{
    for (size_t i = 0; i < number(profile, 128); i++)
        if (named(profile, 132 + 12 * i, name)) {
            *size = number(profile, 132 + 12 * i + 8);
            return number(profile, 132 + 12 * i + 4);
        }
    return *size = 0;
}

static void check_header(const struct profile *profile)
{
    CHECK(number(profile, 0) == profile->length && profile->length % 4 == 0,
          "the profile records its size");
    CHECK(profile->bytes[8] == 4 && profile->bytes[9] == 0x30 && named(profile, 12, "mntr") &&
              named(profile, 16, "RGB ") && named(profile, 20, "XYZ ") &&
              named(profile, 36, "acsp"),
          "it is a display's profile, from RGB to XYZ, of version 4.3");
    CHECK(number(profile, 68) == 0xF6D6 && number(profile, 72) == 0x10000 &&
              number(profile, 76) == 0xD32D,
          "its D50 is the specification's");
}

/* All data lie after the table and within the file, at multiples of 4, and do not overlap. */
static void check_table(const struct profile *profile)
{
    static const struct {
        const char *name, *type;
    } required[] = {{"desc", "mluc"}, {"cprt", "mluc"}, {"wtpt", "XYZ "}, {"chad", "sf32"},
                    {"rXYZ", "XYZ "}, {"gXYZ", "XYZ "}, {"bXYZ", "XYZ "}, {"rTRC", "para"},
                    {"gTRC", "para"}, {"bTRC", "para"}};
    const size_t n = sizeof required / sizeof required[0];
    size_t end = 132 + 12 * n, size;
    CHECK(number(profile, 128) == n, "it has %zu tags", n);
    for (size_t i = 0; i < n; i++) {
        const size_t at = tag(profile, required[i].name, &size);
        CHECK(at == end && named(profile, at, required[i].type) && number(profile, at + 4) == 0 &&
                  size >= 12 && at + size <= profile->length,
              "%s follows, of type '%s'", required[i].name, required[i].type);
        end = (at + size + 3) / 4 * 4;
    }
    CHECK(end == profile->length, "no data follow the last tag");
}

/* Reads each colorant's three numbers into its row. */
static void colorants(const struct profile *profile, double out[3][3])
{
    static const char *const names[] = {"rXYZ", "gXYZ", "bXYZ"};
    size_t size;
    for (int i = 0; i < 9; i++)
        out[i / 3][i % 3] =
            fixed(profile, tag(profile, names[i / 3], &size) + 8 + 4 * (size_t)(i % 3));
}

static void check_white(const struct profile *profile)
{
    static const double d50[3] = {0.9642, 1, 0.8249};
    double colour[3][3];
    size_t size;
    colorants(profile, colour);
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(colour[0][i] + colour[1][i] + colour[2][i], d50[i], 1.5 / 65536 + 1e-5,
                   "the colorants add up to D50, %c", "XYZ"[i]);
        CHECK_NEAR(fixed(profile, tag(profile, "wtpt", &size) + 8 + 4 * (size_t)i), d50[i],
                   0.5 / 65536 + 1e-9, "the white has D50's coordinates");
    }
}

/* Applies a channel's curve to a value; ICC.1:2010, 10.15. */
static double curve(const struct profile *profile, const char *name, double value)
{
    size_t size;
    const size_t at = tag(profile, name, &size);
    const bool plain = number(profile, at + 8) == 0;
    const double gamma = fixed(profile, at + 12);
    if (plain)
        return size == 16 ? pow(value, gamma) : (double)NAN;
    if (number(profile, at + 8) != 3u << 16 || size != 32)
        return (double)NAN;
    return value >= fixed(profile, at + 28)
               ? pow(fixed(profile, at + 16) * value + fixed(profile, at + 20), gamma)
               : fixed(profile, at + 24) * value;
}

/* The curve inverts the display's encoding. Its numbers are rounded to 0.5/65536 each, which
 * changes a value by up to 6 times that. */
static void check_curves(const struct profile *profile, enum display_kind kind)
{
    static const char *const names[] = {"rTRC", "gTRC", "bTRC"};
    for (int channel = 0; channel < 3; channel++) {
        double worst = 0;
        for (int i = 0; i <= 1000; i++) {
            const double part = i / 1000.;
            const double shown =
                display_encode(kind, channel, part * display_largest(kind, channel));
            const double back = curve(profile, names[channel], shown);
            worst = isnan(back) ? HUGE_VAL : fmax(worst, fabs(back - part));
        }
        CHECK_NEAR(worst, 0, 3. / 65536, "%s is the inverse of %s", names[channel],
                   display_names[kind]);
    }
}

/* Undoes the chromatic adaptation and the scale to a white of Y = 1: the display's own matrix must
 * then turn a colorant's XYZ into one channel. test/raster/beside/colour/profiles.py computes colorants from
 * chromaticities. */
static void check_primaries(const struct profile *profile, enum display_kind kind)
{
    double colour[3][3], chad[3][3], back[3][3], matrix[3][3], worst = 0, scale = 0;
    size_t size;
    const size_t at = tag(profile, "chad", &size);
    for (size_t i = 0; i < 9; i++)
        chad[i / 3][i % 3] = fixed(profile, at + 8 + 4 * i);
    tristimulus_inverse(chad, back);
    colorants(profile, colour);
    display_matrix(kind, matrix);
    for (int channel = 0; channel < 3; channel++) {
        double xyz[3], linear[3];
        tristimulus_apply(back, colour[channel], xyz);
        tristimulus_apply(matrix, xyz, linear);
        if (channel == 0)
            scale = display_largest(kind, 0) / linear[0];
        for (int i = 0; i < 3; i++) {
            const double largest = i == channel ? display_largest(kind, i) : 0;
            worst = fmax(worst, fabs(scale * linear[i] - largest));
        }
    }
    /* 1/65536 of XYZ is 1e-4 of the linear values, with the matrix's and the white's scale */
    CHECK_NEAR(worst, 0, 3e-4, "%s: the colorants are its primaries at their largest value",
               display_names[kind]);
}

int main(int n_arguments, char **arguments)
{
    static const enum display_kind kinds[] = {DISPLAY_SRGB, DISPLAY_MONITOR};
    for (int i = 0; i < 2; i++) {
        struct profile profile;
        profile.length = profile_write(kinds[i], profile.bytes);
        if (n_arguments == 1) {
            check_header(&profile);
            check_table(&profile);
            check_white(&profile);
            check_curves(&profile, kinds[i]);
            check_primaries(&profile, kinds[i]);
        } else if (strcmp(arguments[1], display_names[kinds[i]]) == 0)
            return fwrite(profile.bytes, 1, profile.length, stdout) != profile.length;
    }
    return test_end();
}
