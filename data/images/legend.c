/* SPDX-License-Identifier: MIT */
/* A legend below a picture: words and squares of colours, in lines that are as wide as the picture.
 * The letters are drawn here, since a library for them would be the program's largest one. */
#include "data/images/inside.h"

/* Rows of five points, from the top. */
static const struct glyph {
    char character;
    const char *rows;
} glyphs[] = {
    {'0', " ### #   ##  ### # ###  ##   # ### "}, {'1', "  #   ##    #    #    #    #   ### "},
    {'2', " ### #   #    #   #   #   #   #####"}, {'3', " ### #   #    #  ##     ##   # ### "},
    {'4', "   #   ##  # # #  # #####   #    # "}, {'5', "######    ####     #    ##   # ### "},
    {'6', " ### #    #    #### #   ##   # ### "}, {'7', "#####    #   #   #   #    #    #   "},
    {'8', " ### #   ##   # ### #   ##   # ### "}, {'9', " ### #   ##   # ####    #    # ### "},
    {'a', "           ###     # #####   # ####"}, {'b', "#    #    #### #   ##   ##   ##### "},
    {'c', "           ### #   ##    #   # ### "}, {'d', "    #    # #####   ##   ##   # ####"},
    {'e', "           ### #   #######     ### "}, {'f', "  ##  #   ###   #    #    #    #   "},
    {'g', "           #####   # ####    # ### "}, {'h', "#    #    #### #   ##   ##   ##   #"},
    {'i', "  #        ##    #    #    #   ### "}, {'j', "   #        #    #    # #  #  ##   "},
    {'k', "#    #  # # #  ##   # #  #  # #   #"}, {'l', " ##    #    #    #    #    #   ### "},
    {'m', "          ## # # # ## # ## # ## # #"}, {'n', "          #### #   ##   ##   ##   #"},
    {'o', "           ### #   ##   ##   # ### "}, {'p', "          #### #   ##### #    #    "},
    {'q', "           #####   # ####    #    #"}, {'r', "          # ## ##  ##    #    #    "},
    {'s', "           #####     ###     ##### "}, {'t', " #    #   ###   #    #    #  # ##  "},
    {'u', "          #   ##   ##   ##   # ####"}, {'v', "          #   ##   ##   # # #   #  "},
    {'w', "          # # ## # ## # ## # # # # "}, {'x', "          #   # # #   #   # # #   #"},
    {'y', "          #   ##   # ####    # ### "}, {'z', "          #####   #   #   #   #####"},
    {'C', " ### #   ##    #    #    #   # ### "}, {'D', "#### #   ##   ##   ##   ##   ##### "},
    {'E', "######    #    #### #    #    #####"}, {'I', " ###   #    #    #    #    #   ### "},
    {'G', " ### #   ##    # ####   ##   # ####"}, {'L', "#    #    #    #    #    #    #####"},
    {'O', " ### #   ##   ##   ##   ##   # ### "}, {'P', "#### #   ##   ##### #    #    #    "},
    {'.', "                          ##   ##  "}, {',', "                      ##    #   #  "},
    {':', "      ##   ##         ##   ##      "}, {'/', "    #   #    #   #   #    #   #    "},
    {'(', "   #   #   #    #    #     #     # "}, {')', " #     #     #    #    #   #   #   "},
    {'<', "   #   #   #   #     #     #     # "}, {'>', " #     #     #     #   #   #   #   "}};
enum { GLYPH_WIDTH = 5, GLYPH_HEIGHT = 7, LINE = 12, SQUARE = 9, BLANK = 4, MARGIN = 3 };

/* A legend that is laid out, and painted if there are pixels. */
struct page {
    int width, x, y; /* x, y: of the next word */
    int scale;       /* points of a letter are squares of so many pixels */
    uint8_t *rgb;    /* NULL: only measured */
};

static void paint(const struct page *page, const int at[2], int width, int height,
                  const uint8_t rgb[3])
{
    for (int y = at[1]; page->rgb && y < at[1] + height; y++)
        for (int x = at[0]; x < at[0] + width && x < page->width; x++)
            memcpy(page->rgb + 3 * ((size_t)y * (size_t)page->width + (size_t)x), rgb, 3);
}

static void paint_glyph(const struct page *page, int x, char character)
{
    static const uint8_t black[3] = {0, 0, 0};
    const struct glyph *glyph = glyphs, *end = glyphs + sizeof glyphs / sizeof *glyphs;
    while (glyph < end && glyph->character != character)
        glyph++;
    for (int i = 0; glyph < end && i < GLYPH_WIDTH * GLYPH_HEIGHT; i++)
        if (glyph->rows[i] == '#')
            paint(page,
                  (int[]){x + i % GLYPH_WIDTH * page->scale,
                          page->y + (1 + i / GLYPH_WIDTH) * page->scale},
                  page->scale, page->scale, black);
}

/* Puts a word, behind a square of a colour (NULL: none), in the next line if this one is full. */
static void put_word(struct page *page, const char *word, size_t length, const uint8_t *colour)
{
    const int square = colour ? (SQUARE + BLANK / 2) * page->scale : 0,
              letter = (GLYPH_WIDTH + 1) * page->scale, width = square + (int)length * letter;
    if (page->x + width > page->width && page->x > MARGIN) {
        page->x = MARGIN;
        page->y += LINE * page->scale;
    }
    if (colour)
        paint(page, (int[]){page->x, page->y}, SQUARE * page->scale, SQUARE * page->scale, colour);
    for (size_t i = 0; i < length; i++)
        paint_glyph(page, page->x + square + (int)i * letter, word[i]);
    page->x += width + BLANK * page->scale;
}

static void put_words(struct page *page, const char *text)
{
    for (size_t n; *text != '\0'; text += n + (text[n] == ' ')) {
        n = strcspn(text, " ");
        put_word(page, text, n, NULL);
    }
}

/* Lays the legend out, and paints it. Returns its height. */
static int put_legend(const struct picture_legend *legend, int width, uint8_t *rgb)
{
    struct page page = {width, MARGIN, MARGIN, width >= 1000 ? 2 : 1, rgb};
    char label[32];
    uint8_t colour[3];
    put_words(&page, legend->text);
    for (int step = 0; scale_step(step, legend->least, colour, label); step++)
        put_word(&page, label, strlen(label), colour);
    for (int i = 0; i < MOST_MARKS && legend->marks[i].text; i++)
        put_word(&page, legend->marks[i].text, strlen(legend->marks[i].text), legend->marks[i].rgb);
    return page.y + LINE * page.scale;
}

bool legend_make(const struct picture_legend *legend, int width, uint8_t **out, int *rows,
                 struct error *err)
{
    *rows = put_legend(legend, width, NULL);
    const size_t n = 3 * (size_t)width * (size_t)*rows;
    if (!MAKE_ARRAY(*out, n, err, "a legend"))
        return false;
    memset(*out, 255, n);
    put_legend(legend, width, *out);
    return true;
}
