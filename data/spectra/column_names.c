/* SPDX-License-Identifier: MIT */
/* The names of columns: units, observers, percent, wavelengths. */
#include <strings.h>

#include "data/spectra/inside.h"

enum { SPELLED = 80 };

/* Writes the letters of a word, in lower case, and those that signs stand for; `gap` for other
 * characters, around the word, too. */
static void spell(const struct word *word, const char *gap, char out[SPELLED])
{
    static const char *const signs[][2] = {
        {"\xC8\xB3", "y"},   {"\xC8\xB2", "y"},   {"\xC2\xB5", "u"},      {"\xCE\xBC", "u"},
        {"\xC3\x85", "ang"}, {"\xC3\xA5", "ang"}, {"\xE2\x84\xAB", "ang"}};
    int n = snprintf(out, SPELLED, "%s", gap);
    for (size_t i = 0; i < word->length && n < SPELLED - 8; i++) {
        const char c = word->start[i], lower = (char)(c | 32),
                   letter[2] = {lower >= 'a' && lower <= 'z' ? lower : '\0', '\0'};
        const char *add = letter[0] ? letter : (c & 128) ? "" : gap;
        for (size_t s = 0; s < sizeof signs / sizeof *signs; s++)
            if (strncmp(word->start + i, signs[s][0], strlen(signs[s][0])) == 0)
                add = signs[s][1];
        n += snprintf(out + n, SPELLED - (size_t)n, "%s", add);
    }
    snprintf(out + n, SPELLED - (size_t)n, "%s", gap);
}

bool name_is_tristimulus(const struct word *word, char letter)
{
    static const char *const rest[] = {"", "bar", "deg", "bardeg", "lambda", "barlambda"};
    char spelled[SPELLED];
    spell(word, "", spelled);
    const char *at = spelled + (strncmp(spelled, "cie", 3) == 0 ? 3 : 0);
    for (size_t i = 0; i < sizeof rest / sizeof *rest && *at == letter; i++)
        if (strcmp(at + 1, rest[i]) == 0)
            return true;
    return false;
}

bool name_check_unit(const struct word *word, struct error *err)
{
    static const char *const units[][3] = {
        {"ngstr", "angstroms", "divide them by 10"},
        {" ang ", "angstroms", "divide them by 10"},
        {"wavenumber", "wavenumbers", "divide 10000000 by those in 1/cm"},
        {"wave number", "wavenumbers", "divide 10000000 by those in 1/cm"},
        {" cm ", "wavenumbers", "divide 10000000 by those in 1/cm"},
        {"micro", "micrometres", "multiply them by 1000"},
        {" um ", "micrometres", "multiply them by 1000"}};
    char spelled[SPELLED];
    spell(word, " ", spelled);
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strstr(spelled, units[i][0]))
            return error_at(err, word->place, "'%.*s' says %s; expected wavelengths in nm: %s",
                            word_shown(word), word->start, units[i][1], units[i][2]);
    return true;
}

bool name_says_wavelength(const struct word *word)
{
    char spelled[SPELLED];
    spell(word, " ", spelled);
    return strstr(spelled, "wave") || strstr(spelled, "lambda") || strstr(spelled, " nm ");
}

double name_wavelength(const struct word *word)
{
    size_t letters = 0;
    char *end;
    while (letters < word->length && (unsigned)(word->start[letters] - '0') > 9)
        letters++;
    const double nm = letters < word->length ? strtod(word->start + letters, &end) : 0;
    const size_t left = nm >= 100 ? (size_t)(word->start + word->length - end) : 1;
    return left == 0 || (left == 2 && strncmp(end, "nm", 2) == 0) ? nm : 0;
}

bool name_says_percent(const struct word *word)
{
    static const char percent[] = "percent";
    const size_t length = sizeof percent - 1;
    for (size_t i = 0; i < word->length; i++)
        if (word->start[i] == '%' ||
            (i + length <= word->length && strncasecmp(word->start + i, percent, length) == 0))
            return true;
    return false;
}

bool word_is_numeric(const struct word *word, const char *characters)
{
    return strspn(word->start, characters) >= word->length &&
           strcspn(word->start, "0123456789") < word->length;
}

bool word_begins_wavelength(const struct word *word)
{
    const size_t at = word->length > 0 && strchr("+-.", word->start[0]) ? 1 : 0;
    return word->length > at && word->start[at] >= '0' && word->start[at] <= '9';
}
