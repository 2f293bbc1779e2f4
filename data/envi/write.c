/* SPDX-License-Identifier: MIT */
/* Writes ENVI headers. */
#include <inttypes.h>
#include <stdlib.h>

#include "data/envi/envi.h"

/* Prints a text without the braces, line ends and other control characters that would end a value.
 */
static void put_text(FILE *to, const char *text)
{
    for (; *text != '\0'; text++) {
        const unsigned char c = (unsigned char)*text;
        putc(c == '{' ? '(' : c == '}' ? ')' : c < ' ' || c == 0x7f ? '?' : *text, to);
    }
}

/* Names are separated by commas. */
static void put_name(FILE *to, const char *name)
{
    for (; *name != '\0'; name++)
        put_text(to, *name == ',' ? ";" : (char[]){*name, '\0'});
}

/* Ends a value of a list, and begins a new line behind each eighth. */
static void put_comma(FILE *to, int i, int n)
{
    fputs(i == n - 1 ? "}\n" : i % 8 == 7 ? ",\n " : ", ", to);
}

static void put_numbers(FILE *to, const char *key, const double *numbers, int n)
{
    fprintf(to, "%s = {\n ", key);
    for (int i = 0; i < n; i++) {
        fprintf(to, "%.10g", numbers[i]);
        put_comma(to, i, n);
    }
}

static void put_layout(FILE *to, const struct envi_layout *layout)
{
    fprintf(to,
            "samples = %d\nlines = %d\nbands = %d\nheader offset = %" PRIu64 "\n"
            "file type = ENVI Standard\ndata type = %d\ninterleave = %s\nbyte order = %d\n",
            layout->samples, layout->lines, layout->bands, layout->offset, (int)layout->type,
            envi_interleave_name(layout->interleave), layout->big_endian);
}

static void put_header(FILE *to, const struct envi_sidecar *sidecar)
{
    const int n = sidecar->layout.bands;
    fputs("ENVI\ndescription = {", to);
    put_text(to, sidecar->description);
    fputs("}\n", to);
    put_layout(to, &sidecar->layout);
    fputs("band names = {\n ", to);
    for (int i = 0; i < n; i++) {
        put_name(to, sidecar->names[i]);
        put_comma(to, i, n);
    }
    if (sidecar->wavelengths_nm) {
        fputs("wavelength units = Nanometers\n", to);
        put_numbers(to, "wavelength", sidecar->wavelengths_nm, n);
    }
    if (sidecar->fwhm_nm)
        put_numbers(to, "fwhm", sidecar->fwhm_nm, n);
    if (sidecar->gain != 1)
        fputs("data gain values = {\n ", to);
    for (int i = 0; i < n && sidecar->gain != 1; i++) {
        fprintf(to, "%.17g", sidecar->gain);
        put_comma(to, i, n);
    }
    if (sidecar->is_reflectance)
        fprintf(to, "reflectance scale factor = %.17g\n", 1 / sidecar->gain);
}

char *envi_header_text(const struct envi_sidecar *sidecar)
{
    struct printed printed;
    FILE *to = printed_begin(&printed);
    if (to)
        put_header(to, sidecar);
    return printed_end(&printed);
}
