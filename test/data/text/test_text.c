/* SPDX-License-Identifier: MIT */
/* Words, numbers and their places. Numbers are compared with strtod, which rounds correctly.
 * test/cases/bad has most messages. */
#include <errno.h>
#include <limits.h>

#include "data/base/base.h"
#include "data/text/text.h"
#include "spectral.h"
#include "test.h"

static struct text open_string(const char *string)
{
    struct text text;
    struct error err = {0};
    text_open_string(&text, "t", string, &err);
    return text;
}

static void check_words(void)
{
    struct text text = open_string("\xEF\xBB\xBFone\ttwo # three\r\n\n\"a # b\" c#d\nlast");
    struct error err = {0};
    struct word word;
    char *copy;
    CHECK(text_place(&text).line == 0, "before the first line, a place is the whole file");
    CHECK(text_next_line(&text) && text_word(&text, &word) && word_is(&word, "one") &&
              word.place.column == 1,
          "a byte order mark is no part of the first word");
    CHECK(text_word(&text, &word) && word_is(&word, "two") && word.place.column == 5 &&
              word.place.line == 1,
          "a tab separates words, and counts as one column");
    CHECK(!text_word(&text, &word), "a comment ends the line");
    CHECK(text_next_line(&text) && !text_word(&text, &word), "an empty line has no words");
    CHECK(text_next_line(&text) && text_word(&text, &word) && word.quoted &&
              !word_is(&word, "a # b"),
          "a quoted word is no statement name");
    copy = word_copy(&word, &err);
    CHECK_TEXT(copy, "a # b", "a quoted word holds blanks and #");
    free(copy);
    CHECK(text_word(&text, &word) && word_is(&word, "c#d") && word.place.column == 9 &&
              word.place.line == 3,
          "a # in the middle of a word belongs to it");
    CHECK(text_next_line(&text) && text_word(&text, &word) && word_is(&word, "last"),
          "the last line needs no newline");
    CHECK(!word_is(&word, "las") && !word_is(&word, "lastly"), "a word is compared whole");
    CHECK(!text_next_line(&text) && !text_next_line(&text) && text_place(&text).line == 4 &&
              text_place(&text).column == 5,
          "the end stays after the last word");
    text_free(&text);
    text = open_string("");
    CHECK(!text_next_line(&text) && text_place(&text).line == 0, "an empty text has no line");
    text_free(&text);
    text = open_string("1,2;;3 4");
    text.separators = ",;";
    text_next_line(&text);
    for (int i = 1; i <= 4; i++)
        CHECK(text_word(&text, &word) && word.length == 1 && *word.start == '0' + i,
              "word %d between mixed separators", i);
    text_free(&text);
}

/* Returns the error of reading the first word of a line as a number, or "". */
static const char *number_error(const char *string, double lowest, double highest,
                                struct error *err)
{
    struct text text = open_string(string);
    double value;
    *err = (struct error){0};
    text_next_line(&text);
    if (text_number(&text, "gloss", lowest, highest, &value, err))
        text_end(&text, "gloss", err);
    text_free(&text);
    return err->text;
}

static void check_refusals(void)
{
    const char *bad =
        "1.5abc 1e999 -1e999 nan NAN inf 0x10 1,5 1e 1e+ . - + e5 1..2 --1 1.2.3 1e5.5 \"1\" "
        "1\x01 infinity";
    char word[64];
    struct error err;
    while (test_word(&bad, word))
        CHECK(number_error(word, -HUGE_VAL, HUGE_VAL, &err)[0] != '\0' && err.status == EXIT_INPUT,
              "'%s' is no number", word[1] == '\x01' ? "1 and a control character" : word);
    CHECK_TEXT(number_error("3", -HUGE_VAL, 2, &err),
               "t:1:1: error: gloss 3 is above 2; it is at most 2",
               "the message names an upper bound");
    static const char *const meant[][2] = {{"400nm", "400"},
                                           {"-5deg", "-5"},
                                           {"0,5", "0.5"},
                                           {"50%", "0.5"},
                                           {"1,0,0", "1"},
                                           {"<1,", "1"},
                                           {"1,", "1"},
                                           {"0x190", "400"},
                                           {"1.5abc", "1.5"},
                                           {"1.000,5", "2.5 or 1e-3"},
                                           {"1..2", "2.5 or 1e-3"},
                                           {"red", "2.5 or 1e-3"},
                                           {"inf", "2.5 or 1e-3"},
                                           {"\"4\"", "2.5 or 1e-3"}};
    for (size_t i = 0; i < sizeof meant / sizeof *meant; i++) {
        char expected[64];
        snprintf(expected, sizeof expected, "must be a number such as %s, not", meant[i][1]);
        CHECK(strstr(number_error(meant[i][0], -HUGE_VAL, HUGE_VAL, &err), expected),
              "%s is refused, and stands for %s", meant[i][0], meant[i][1]);
    }
    CHECK_TEXT(number_error("", 0, 1, &err), "t: error: expected a number: gloss",
               "the message for a missing word without a line names the file");
    CHECK_TEXT(number_error(" # 1", 0, 1, &err), "t:1:2: error: expected a number: gloss",
               "the message for a missing word names the line's end");
    CHECK_TEXT(number_error("1 \"2", 0, 1, &err),
               "t:1:3: error: the quote before '2' must be closed on its line and a blank follow "
               "it",
               "an unclosed quote after the last word is named as such");
    CHECK(number_error("\"1\"2 \"", 0, 1, &err)[0] != '\0', "a closing quote ends the word");
    CHECK_TEXT(number_error("abcdefghijklmnopqrstuvwxyzabcdefghijklm\xC3\xA4z", 0, 1, &err),
               "t:1:1: error: gloss must be a number such as 2.5 or 1e-3, not "
               "'abcdefghijklmnopqrstuvwxyzabcdefghijklm'",
               "a long word is cut between characters");
}

static double read_number(const char *string)
{
    struct text text = open_string(string);
    struct error err = {0};
    double value = 0;
    text_next_line(&text);
    if (!text_number(&text, "value", -HUGE_VAL, HUGE_VAL, &value, &err))
        value = (double)NAN;
    text_free(&text);
    return value;
}

static void check_values(void)
{
    const char *good =
        "0 -0 1 +1 1. .5 -2.5e-3 1E5 9007199254740992 9007199254740993 9007199254740991e22 "
        "9007199254740991e-22 9007199254740991e23 0.1 123456e-30 2.2250738585072011e-308 "
        "4.9e-324 2.4703282292062328e-324 1e-999 1.7976931348623157e308 "
        "0.00000000000000000000000000000000000000001 "
        "100000000000000000000000000000000000000000000000000 18446744073709551616 "
        "1844674407370955161.6 0e9999999999999999999";
    char word[64];
    struct error err = {0};
    unsigned long seed = 1;
    int wrong = 0;
    while (test_word(&good, word)) {
        double value = read_number(word), expected = strtod(word, NULL);
        CHECK(memcmp(&value, &expected, sizeof value) == 0, "%s is read as strtod reads it", word);
    }
    for (int i = 0; i < 20000; i++) {
        char string[64];
        seed = (seed * 1103515245 + 12345) & 0x7fffffff;
        snprintf(string, sizeof string, "%.*ge%d", (int)(seed % 18) + 1, (double)seed / 12345.678,
                 (int)(seed / 64 % 60) - 30);
        if (strchr(string, 'e') == strrchr(string, 'e') &&
            read_number(string) != strtod(string, NULL))
            wrong++;
    }
    CHECK(wrong == 0, "20000 random decimals are rounded as strtod rounds them");
    CHECK(number_error("1e-3", 1e-3, 1e-3, &err)[0] == '\0', "bounds are inclusive");
}

static bool read_integer(const char *string, long lowest, long highest, long *out)
{
    struct text text = open_string(string);
    struct error err = {0};
    bool done;
    text_next_line(&text);
    done = text_integer(&text, "count", lowest, highest, out, &err);
    text_free(&text);
    return done;
}

static void check_integers(void)
{
    const char *bad = "5.0 1e3 - 0x1 11 -1 \"5\" 18446744073709551621 99999999999999999999999";
    char word[64];
    char largest[32];
    long value = 0;
    CHECK(!read_integer("", 0, 10, &value), "nothing is no count");
    while (test_word(&bad, word))
        CHECK(!read_integer(word, 0, 10, &value), "'%s' is no count from 0 to 10", word);
    CHECK(read_integer("+10", 0, 10, &value) && value == 10, "an integer may have a plus");
    CHECK(read_integer("-0007", -7, 0, &value) && value == -7,
          "an integer may have a minus and zeros");
    snprintf(largest, sizeof largest, "%ld", LONG_MAX);
    CHECK(read_integer(largest, 0, LONG_MAX, &value) && value == LONG_MAX,
          "the largest integer is read");
    largest[strlen(largest) - 1]++;
    CHECK(!read_integer(largest, 0, LONG_MAX, &value), "the next one is refused");
}

static void check_errors(void)
{
    struct error err = {0};
    struct place nowhere = {NULL, 0, 0}, far = {NULL, 0, 0};
    char longer[4096];
    CHECK(!error_at(&err, nowhere, "a %d", 1) && strcmp(err.text, "error: a 1") == 0 &&
              err.status == EXIT_INPUT,
          "an error without a file has no place");
    CHECK(!memory_lacks(&err, 1, "a name") && err.status == EXIT_INPUT &&
              strcmp(err.text, "error: a 1") == 0,
          "the first failure wins");
    memset(longer, 'p', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    far.path = longer;
    err = (struct error){0};
    error_at(&err, far, "the cause");
    CHECK(strstr(err.text, "the cause") != NULL, "a long path leaves room for the message");
    err = (struct error){0};
    errno = ENOSPC;
    error_system(&err, "cannot write %s", longer);
    CHECK(strlen(err.text) == sizeof err.text - 1 && err.status == EXIT_SYSTEM &&
              strstr(err.text, strerror(ENOSPC)) != NULL,
          "a long message keeps the cause");
    err = (struct error){0};
    memory_lacks(&err, 1, "a name");
    CHECK(err.status == EXIT_SYSTEM, "a lack of memory is a failure of the system");
}

int main(void)
{
    check_words();
    check_refusals();
    check_values();
    check_integers();
    check_errors();
    return test_end();
}
