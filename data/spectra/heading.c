/* SPDX-License-Identifier: MIT */
/* The meaning of the cells of a heading: wavelengths and their units, names, percent, quantities.
 */
#include "data/spectra/inside.h"

enum { SPELLED = 80 };

/* Writes the letters of a word, in lower case, and those that signs stand for; `gap` for a run of
 * other characters, and around the word. */
static void spell(const struct word *word, const char *gap, char out[SPELLED])
{
    static const char *const signs[][2] = {
        {"\xC8\xB3", "y"},       {"\xC8\xB2", "y"},      {"\xC2\xB5", "u"},
        {"\xCE\xBC", "u"},       {"\xC3\x85", "ang"},    {"\xC3\xA5", "ang"},
        {"\xE2\x84\xAB", "ang"}, {"\xCE\xBB", "lambda"}, {"%", " percent "}};
    int n = snprintf(out, SPELLED, "%s", gap);
    for (size_t i = 0; i < word->length && n < SPELLED - 16; i++) {
        const char c = word->start[i], lower = (char)(c | 32),
                   letter[2] = {lower >= 'a' && lower <= 'z' ? lower : '\0', '\0'};
        const char *add = letter[0] ? letter : (c & 128) ? "" : gap;
        for (size_t s = 0; s < sizeof signs / sizeof *signs; s++)
            if (strncmp(word->start + i, signs[s][0], strlen(signs[s][0])) == 0)
                add = *gap || c != '%' ? signs[s][1] : "";
        for (; *add; add++)
            if (*add != ' ' || n == 0 || out[n - 1] != ' ')
                out[n++] = *add;
    }
    snprintf(out + n, SPELLED - (size_t)n, "%s", *gap && out[n - 1] == ' ' ? "" : gap);
}

/* Words of a heading, in the languages of instruments: parts of a spelled cell, which has a blank
 * at each end. Of units and quantities the first that fits counts. */
static const struct {
    unsigned says;
    const char *parts;  /* with a | between them */
    double to_nm;       /* of a unit of length that spectra have; otherwise 1 */
    const char *advice; /* another unit is converted so */
} words[] = {
    {SAYS_UNIT, " nm | nanomet", 1, NULL},
    {SAYS_UNIT, " um |micromet| micron", 1000, NULL},
    {SAYS_UNIT, " ang |ngstr", 0.1, NULL},
    {SAYS_UNIT, "wavenumber|wave number| cm ", 1, "10000000 divided by those in 1/cm"},
    {SAYS_UNIT, " ev |energ", 1, "1239.84198 divided by energies in eV"},
    {SAYS_UNIT, "hz |frequen", 1, "299792.458 divided by frequencies in THz"},
    {SAYS_UNIT, " mm ", 1, "1000000 times those in mm"},
    {SAYS_UNIT, " m ", 1, "1e9 times those in m"},
    {SAYS_WAVELENGTH, " wave| wl | lambda|wellenl| longueur| longitud| lunghezza", 1, NULL},
    {SAYS_NAME | SAYS_LABEL, "name", 1, NULL},
    {SAYS_LABEL, " id |sample| loc|patch| no ", 1, NULL},
    {SAYS_PERCENT, " percent| per cent | pct | prozent | procent | pourcent| porcent", 1, NULL},
    {SAYS_REFLECTANCE, " reflect| reflex| remission| transmi", 1, NULL},
    {SAYS_LIGHT, " counts |radian", 1, NULL},
    {SAYS_OTHER, " absorban| extin| optical density| od | log r | k s ", 1, NULL},
};

/* Returns whether a spelled cell has one of the parts; `whole`: is nothing but one. */
static bool fits(const char *spelled, const char *parts, bool whole)
{
    char part[32];
    for (size_t length; *parts; parts += length + (parts[length] == '|')) {
        length = strcspn(parts, "|");
        snprintf(part, sizeof part, "%.*s", (int)length, parts);
        if (whole ? strcmp(spelled, part) == 0 : strstr(spelled, part) != NULL)
            return true;
    }
    return false;
}

void heading_read(const struct word *cell, struct meaning *out)
{
    char spelled[SPELLED];
    *out = (struct meaning){.to_nm = 1};
    spell(cell, " ", spelled);
    out->is_unit = cell->length > 0 && strchr("[(%", cell->start[0]);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        const unsigned says = words[i].says;
        if (!fits(spelled, words[i].parts, false) || says & out->says & SAYS_UNIT ||
            (says & SAYS_QUANTITY && out->says & SAYS_QUANTITY))
            continue;
        const bool whole = fits(spelled, words[i].parts, true);
        if (says == SAYS_UNIT) {
            out->to_nm = words[i].to_nm;
            out->advice = words[i].advice;
        }
        out->says |= says | (says == SAYS_UNIT && whole ? SAYS_WAVELENGTH : 0U);
        out->is_unit = out->is_unit || whole || says == SAYS_WAVELENGTH;
    }
}

double heading_nm(const struct word *cell, bool named)
{
    struct word number = *cell, unit;
    struct meaning meaning;
    double nm = 0;
    while (number.length > 0 && (unsigned)(*number.start - '0') > 9) {
        number.start++;
        number.length--;
    }
    const size_t letters = cell->length - number.length;
    if (!named && letters > 0 && !(letters == 2 && strncmp(cell->start, "nm", 2) == 0))
        return 0;
    unit = number;
    unit.start += strspn(number.start, "0123456789.");
    if (number.length == 0 || unit.start > number.start + number.length)
        return 0;
    number.length = (size_t)(unit.start - number.start);
    unit.length -= number.length;
    number.quoted = unit.quoted = false;
    heading_read(&unit, &meaning);
    if (meaning.advice || (unit.length > 0 && !meaning.is_unit) || !word_is_number(&number, 0, &nm))
        return 0;
    return nm * meaning.to_nm >= 100 ? nm * meaning.to_nm : 0;
}

const char *heading_channel(const struct word *cell, const char *letters)
{
    static const char *const rest[] = {"",          "bar", "deg",  "bardeg", "lambda",
                                       "barlambda", "ed",  "reen", "lue"};
    char spelled[SPELLED];
    spell(cell, "", spelled);
    const char *at = spelled + (strncmp(spelled, "cie", 3) == 0 ? 3 : 0);
    const char *letter = *at ? strchr(letters, *at) : NULL;
    for (size_t i = 0; i < sizeof rest / sizeof *rest && letter; i++)
        if (strcmp(at + 1, rest[i]) == 0)
            return letter;
    return NULL;
}

bool word_is_numeric(const struct word *word, const char *characters)
{
    return strspn(word->start, characters) >= word->length &&
           strcspn(word->start, "0123456789") < word->length;
}
