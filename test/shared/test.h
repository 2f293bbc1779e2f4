/* SPDX-License-Identifier: MIT */
/* A test program prints TAP: one line for each truth about the program. A failed truth
 * also prints the values seen. A test ends with `return test_end();`. */
#ifndef TEST_H
#define TEST_H

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int test_count, test_failures;

/* Prints "ok" or "not ok", then the truth in words. Returns `holds`. */
static bool test_truth(bool holds, const char *file, int line, const char *format, ...)
{
    va_list arguments;
    printf("%s %d - ", holds ? "ok" : "not ok", ++test_count);
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
    putchar('\n');
    if (!holds) {
        test_failures++;
        printf("# %s:%d\n", file, line);
    }
    return holds;
}

#define CHECK(condition, ...) test_truth((condition), __FILE__, __LINE__, __VA_ARGS__)

/* Checks that |seen - expected| <= tolerance. NaN fails. The text follows the numbers. */
#define CHECK_NEAR(seen, expected, tolerance, ...)                                                 \
    do {                                                                                           \
        double seen_ = (seen), expected_ = (expected), tolerance_ = (tolerance);                   \
        if (!CHECK(fabs(seen_ - expected_) <= tolerance_, __VA_ARGS__))                            \
            printf("# saw %.17g, expected %.17g within %.3g\n", seen_, expected_, tolerance_);     \
    } while (0)

#define CHECK_TEXT(seen, expected, ...)                                                            \
    do {                                                                                           \
        const char *seen_ = (seen), *expected_ = (expected);                                       \
        if (!CHECK(strcmp(seen_, expected_) == 0, __VA_ARGS__))                                    \
            printf("# saw      %s\n# expected %s\n", seen_, expected_);                            \
    } while (0)

/* Returns the folder for temporary files, and makes it if it does not exist. */
static inline const char *test_folder(void)
{
    const char *folder = getenv("TEST_TMP");
    if (folder == NULL)
        folder = "build/tmp";
    mkdir(folder, 0777);
    return folder;
}

/* Writes a text file and returns `path`. */
static inline const char *test_write(const char *path, const char *content)
{
    FILE *file = fopen(path, "w");
    if (file != NULL) {
        fputs(content, file);
        fclose(file);
    }
    return path;
}

/* Ends a test that cannot go on. */
static inline void test_need(bool good, const char *text)
{
    if (!good) {
        printf("Bail out! %s\n", text);
        exit(1);
    }
}

/* Makes a folder for the files of this program, so that programs that run side by side do not share
 * names, and goes there. */
#define test_enter() test_enter_folder(__FILE__)
static inline void test_enter_folder(const char *source)
{
    const char *name = strrchr(source, '/');
    test_need(chdir(test_folder()) == 0, "there is no folder for temporary files");
    name = name ? name + 1 : source;
    mkdir(name, 0777);
    test_need(chdir(name) == 0, "there is no folder for temporary files");
}

/* Copies the next word of a list, where blanks separate words; the list then begins behind it. */
static inline bool test_word(const char **list, char word[64])
{
    int length = 0;
    const bool found = sscanf(*list, "%63s%n", word, &length) == 1;
    *list += length;
    return found;
}

static inline int test_end(void)
{
    printf("1..%d\n", test_count);
    return test_failures != 0;
}

/* Returns a random number between two. A small generator in this file (Knuth's MMIX constants), so
 * that every machine tests the same cases. */
static inline double test_random(uint64_t *state, double low, double high)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(*state >> 11) / 9007199254740992.0;
}

#endif
