/* SPDX-License-Identifier: MIT */
/* Writes ENVI headers. */
#include <inttypes.h>
#include <stdlib.h>

#include "data/envi/envi.h"

/* Prints a text without the braces, line ends and other control characters that would end a value.
 */
static void put_text(struct printed *to, const char *text)
{
    for (; *text != '\0'; text++) {
        const unsigned char c = (unsigned char)*text;
        print(to, "%c", c == '{' ? '(' : c == '}' ? ')' : c < ' ' || c == 0x7f ? '?' : *text);
    }
}

/* Names are separated by commas. */
static void put_name(struct printed *to, const char *name)
{
    for (; *name != '\0'; name++)
        put_text(to, *name == ',' ? ";" : (char[]){*name, '\0'});
}

/* Ends a value of a list, and begins a new line behind each eighth. */
static void put_comma(struct printed *to, int i, int n)
{
    print_text(to, i == n - 1 ? "}\n" : i % 8 == 7 ? ",\n " : ", ");
}

static void put_numbers(struct printed *to, const char *key, const double *numbers, int n)
{
    print(to, "%s = {\n ", key);
    for (int i = 0; i < n; i++) {
        print(to, "%.10g", numbers[i]);
        put_comma(to, i, n);
    }
}

static void put_layout(struct printed *to, const struct envi_layout *layout)
{
    print(to,
          "samples = %d\nlines = %d\nbands = %d\nheader offset = %" PRIu64 "\n"
          "file type = ENVI Standard\ndata type = %d\ninterleave = %s\nbyte order = %d\n",
          layout->samples, layout->lines, layout->bands, layout->offset, (int)layout->type,
          envi_interleave_name(layout->interleave), layout->big_endian);
}

static void put_header(struct printed *to, const struct envi_sidecar *sidecar)
{
    const int n = sidecar->layout.bands;
    print_text(to, "ENVI\ndescription = {");
    put_text(to, sidecar->description);
    print_text(to, "}\n");
    put_layout(to, &sidecar->layout);
    print_text(to, "band names = {\n ");
    for (int i = 0; i < n; i++) {
        put_name(to, sidecar->names[i]);
        put_comma(to, i, n);
    }
    if (sidecar->wavelengths_nm) {
        print_text(to, "wavelength units = Nanometers\n");
        put_numbers(to, "wavelength", sidecar->wavelengths_nm, n);
    }
    if (sidecar->fwhm_nm)
        put_numbers(to, "fwhm", sidecar->fwhm_nm, n);
    if (sidecar->gain != 1)
        print_text(to, "data gain values = {\n ");
    for (int i = 0; i < n && sidecar->gain != 1; i++) {
        print(to, "%.17g", sidecar->gain);
        put_comma(to, i, n);
    }
    if (sidecar->is_reflectance)
        print(to, "reflectance scale factor = %.17g\n", 1 / sidecar->gain);
}

char *envi_header_text(const struct envi_sidecar *sidecar)
{
    struct printed printed = {.text = NULL};
    put_header(&printed, sidecar);
    return printed_end(&printed);
}
