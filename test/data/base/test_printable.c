/* SPDX-License-Identifier: MIT */
/* No byte of a stranger's file drives the terminal: messages, tables and JSON hold printable
 * characters of valid UTF-8 only; XML has its own characters only, and a shell reads a printed word
 * back. */

#include "data/base/base.h"
#include "data/text/text.h"
#include "test.h"

static const struct {
    const char *what, *bytes;
    int length;
} characters[] = {{"a letter", "a", 1},
                  {"a letter of two bytes", "\xc3\xa9", 2},
                  {"a no-break space", "\xc2\xa0", 2},
                  {"a letter of three bytes", "\xe2\x82\xac", 3},
                  {"a picture of four bytes", "\xf0\x9f\x98\x80", 4},
                  {"an escape", "\x1b", 0},
                  {"a delete", "\x7f", 0},
                  {"U+0080", "\xc2\x80", 0},
                  {"U+009B, which begins commands of a terminal", "\xc2\x9b", 0},
                  {"U+009F", "\xc2\x9f", 0},
                  {"a raw byte 0x9B", "\x9b", 0},
                  {"a raw byte 0x80", "\x80", 0},
                  {"an overlong slash", "\xc0\xaf", 0},
                  {"a surrogate", "\xed\xa0\x80", 0},
                  {"a cut character", "\xe2\x82", 0},
                  {"U+202E, which turns letters around", "\xe2\x80\xae", 0},
                  {"U+2066, an isolate", "\xe2\x81\xa6", 0},
                  {"U+200F, a mark of direction", "\xe2\x80\x8f", 0},
                  {"U+061C, a mark of direction", "\xd8\x9c", 0},
                  {"U+2028, a line's end", "\xe2\x80\xa8", 0},
                  {"U+FEFF, without a width", "\xef\xbb\xbf", 0},
                  {"U+E0041, a tag", "\xf3\xa0\x81\x81", 0},
                  {"U+10FFFF, no character", "\xf4\x8f\xbf\xbf", 0}};

static void check_xml(void)
{
    struct printed printed = {.text = NULL};
    print_xml(&printed,
              "<a "
              "b=\"c\">&"
              "\t\n\x01\x7f\xff\xc3\xa9\xed\xa0\x80\xef\xbf\xbd\xef\xbf\xbe\xef\xbf\xbf\xe2\x82");
    print_xml(&printed, NULL);
    char *text = printed_end(&printed);
    CHECK_TEXT(text, "&lt;a b=&quot;c&quot;&gt;&amp;\t\n\?\?\?\xc3\xa9\?\?\?\xef\xbf\xbd\?\?\?\?",
               "XML has no control characters, no surrogates, and neither U+FFFE nor U+FFFF");
    free(text);
}

static void check_shell(void)
{
    static const char *const words[][2] = {{"--size=9x6", "--size=9x6"},
                                           {"", "''"},
                                           {"a b", "'a b'"},
                                           {"it's", "'it'\\''s'"},
                                           {"$HOME*\n\xc3\xa9", "'$HOME*\n\xc3\xa9'"}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        struct printed printed = {.text = NULL};
        print_shell(&printed, words[i][0]);
        char *text = printed_end(&printed);
        CHECK_TEXT(text + 1, words[i][1], "a shell reads back the word %s", words[i][0]);
        free(text);
    }
}

int main(void)
{
    check_xml();
    check_shell();
    for (size_t i = 0; i < sizeof characters / sizeof characters[0]; i++) {
        const int length = characters[i].length;
        char shown[16];
        snprintf(shown, sizeof shown, "%s", characters[i].bytes);
        hide_unprintable(shown, "");
        CHECK(length > 0 ? strncmp(shown, characters[i].bytes, (size_t)length) == 0
                         : shown[0] == (characters[i].bytes[0] ? '?' : '\0'),
              "%s has %d printable bytes", characters[i].what, length);
    }
    char text[] = "a\xc2\x9b"
                  "b\x9b\xe2\x80\xae\xc3\xa9\n\x1b[2J\xe2\x82";
    hide_unprintable(text, "\n");
    CHECK_TEXT(text, "a\?b\?\?\xc3\xa9\n\?[2J\?\?", "each unprintable character becomes one mark");
    struct error err = {.status = EXIT_AGREED};
    error_usage(&err, "no file '%s'", "x\xc2\x9b\x9b\n\xe2\x80\xae");
    CHECK_TEXT(err.text, "error: no file 'x\?\?\?\?'", "a message has printable characters only");
    struct printed printed = {.text = NULL};
    print_fact(&printed, "scene", "a\nverdict agreed\x9b");
    char *fact = printed_end(&printed);
    CHECK_TEXT(fact, "scene             a?verdict agreed?\n", "a fact stays in its line");
    free(fact);
    struct json json;
    json_begin(&json);
    json_string(&json, "key", "\xc2\x9b\x9b\xc3\xa9\x7f");
    CHECK(!json_take(&json, &err), "JSON is not taken after a failure");
    err = (struct error){.status = EXIT_AGREED};
    json_begin(&json);
    json_string(&json, "key", "\xc2\x9b\x9b\xc3\xa9\x7f");
    char *value = json_take(&json, &err);
    CHECK_TEXT(value, "{\"key\": \"\\u009b\xef\xbf\xbd\xc3\xa9\\u007f\"}\n", "JSON is valid UTF-8");
    free(value);
    return test_end();
}
