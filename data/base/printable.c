/* SPDX-License-Identifier: MIT */
/* Finds the characters that must not reach a terminal. A file of a stranger could otherwise forge a
 * line, drive the terminal, or show its letters in another order. */
#include "data/base/base.h"

/* By table 3-7 of Unicode. */
int utf8_length(const unsigned char *at)
{
    int length = at[0] < 0x80 ? 1 : 2 + (at[0] >= 0xe0) + (at[0] >= 0xf0);
    if ((at[0] >= 0x80 && at[0] < 0xc2) || at[0] > 0xf4 || (at[0] == 0xe0 && at[1] < 0xa0) ||
        (at[0] == 0xed && at[1] > 0x9f) || (at[0] == 0xf0 && at[1] < 0x90) ||
        (at[0] == 0xf4 && at[1] > 0x8f))
        return 0;
    for (int i = 1; i < length; i++)
        if ((at[i] & 0xc0) != 0x80)
            return 0;
    return length;
}

/* Returns the code point of a valid character of UTF-8. */
static uint32_t code_point(const unsigned char *at, int length)
{
    uint32_t code = length == 1 ? at[0] : at[0] & (0x7fu >> length);
    for (int i = 1; i < length; i++)
        code = code << 6 | (at[i] & 0x3fu);
    return code;
}

/* Code points of Unicode 15 that are no picture: controls (category Cc), marks that set directions
 * or have no width (Cf: UAX #9, Bidi_Control, and its neighbours), separators of lines, tags, and
 * code points that are no characters. */
static const struct {
    uint32_t first, last;
} unprintable[] = {{0x0000, 0x001f},  {0x007f, 0x009f}, {0x00ad, 0x00ad}, {0x061c, 0x061c},
                   {0x180e, 0x180e},  {0x200b, 0x200f}, {0x2028, 0x202e}, {0x2060, 0x206f},
                   {0xfdd0, 0xfdef},  {0xfeff, 0xfeff}, {0xfff0, 0xfffb}, {0xfffe, 0xffff},
                   {0xe0000, 0xe0fff}};

/* Returns the length of a character that has a picture; 0: it has none, or is not valid. */
static int printable_length(const unsigned char *at)
{
    const int length = utf8_length(at);
    const uint32_t code = length > 0 ? code_point(at, length) : 0;
    for (size_t i = 0; i < sizeof unprintable / sizeof unprintable[0]; i++)
        if (code >= unprintable[i].first && code <= unprintable[i].last)
            return 0;
    return (code & 0xfffe) == 0xfffe ? 0 : length;
}

void hide_unprintable(char *text, const char *kept)
{
    unsigned char *to = (unsigned char *)text;
    for (const unsigned char *at = to; *at != '\0';) {
        const int printable = *at < 0x80 && strchr(kept, *at) ? 1 : printable_length(at);
        const int length = printable > 0 ? printable : utf8_length(at) > 0 ? utf8_length(at) : 1;
        if (printable > 0)
            memmove(to, at, (size_t)length);
        else
            *to = '?';
        to += printable > 0 ? length : 1;
        at += length;
    }
    *to = '\0';
}
