/* SPDX-License-Identifier: MIT */
/* Reads fail cleanly, names resolve, and outputs appear whole or not at all. files.py compares
 * digests with Python's; cli.sh and kills.py fill outputs; spared.py tries inputs as outputs,
 * outputs.py all kinds of outputs; test/cases/bad/commands.cases has names that are refused. */
#include <dirent.h>
#include <limits.h>

#include "bytes.h"
#include "data/base/inside.h"
#include "data/files/files.h"
#include "spectral.h"

enum { LARGE = 200001 };
static const struct place nowhere = {NULL, 0, 0};

static int count_entries(void)
{
    DIR *folder = opendir(".");
    int count = 0;
    while (folder != NULL && readdir(folder) != NULL)
        count++;
    closedir(folder);
    return count;
}

/* Returns whether the file holds exactly this string. */
static bool holds(const char *path, const char *string)
{
    struct error err = {0};
    char *bytes = file_read(path, nowhere, &err);
    const bool same = bytes && strcmp(bytes, string) == 0;
    files_read_forget(); /* a look is no input */
    free(bytes);
    return same;
}

static bool refuses_read(const char *path, const char *with)
{
    struct error err = {0};
    struct place from = {"scene", 2, 3};
    char *bytes = file_read(path, from, &err);
    if (!bytes && err.status == EXIT_INPUT && strstr(err.text, with) != NULL)
        return true;
    printf("# %s\n", err.text);
    free(bytes);
    return false;
}

static void check_reads(void)
{
    struct error err = {0};
    const char *const path = "read";
    char large[LARGE];
    bytes_write(path, "a\nb", 3);
    CHECK(holds(path, "a\nb"), "a file is read whole");
    bytes_write(path, "", 0);
    CHECK(holds(path, ""), "an empty file is read");
    memset(large, 'x', LARGE - 1);
    large[LARGE - 1] = '\0';
    bytes_write(path, large, LARGE - 1);
    CHECK(holds(path, large), "a larger file is read");
    bytes_write(path, "ab\0c", 4);
    CHECK(refuses_read(path, "byte 3 is NUL"), "a NUL byte is refused and its place named");
    CHECK(truncate(path, (off_t)1 << 40) == 0 && refuses_read(path, "too long"),
          "a terabyte is refused before it is read");
    CHECK(refuses_read("/dev/zero", "no regular file"),
          "a device is refused where a file names it");
    CHECK(!file_read("/dev/zero", nowhere, &err) && strstr(err.text, "byte 1 is NUL"),
          "an endless file of zeros ends");
    CHECK(refuses_read("none", "scene:2:3: error: cannot read"),
          "the message for a missing file names the place that refers to it");
    CHECK(refuses_read(".", "folder"), "a folder is refused as a file");
    CHECK(refuses_read("builtin:none", "built-in"), "an unknown built-in file is refused");
    err = (struct error){0};
    CHECK(!digest_file(".", large, &err) && err.status == EXIT_SYSTEM,
          "the digest of a folder is refused");
}

static void check_relative(void)
{
    static const char *const cases[][3] = {
        {NULL, "a", "a"},
        {"--light", "a", "a"},
        {"b.scene", "a", "a"},
        {"x/b.scene", "a", "x/a"},
        {"x/b.scene", "../a", "x/../a"},
        {"/b", "a", "/a"},
        {"x/b", "/a", "/a"},
        {"x/b", "builtin:a", "builtin:a"},
        {"builtin:b", "a", "builtin:a"},
        {"builtin:scenes/b", "a", "builtin:scenes/a"},
        {"builtin:scenes/b", "../tables/d65.csv", "builtin:tables/d65.csv"},
        {"builtin:scenes/x/b", "../.././tables/./a", "builtin:tables/a"},
        {"builtin:scenes/b", "../../../a", "builtin:a"},
        {"builtin:scenes/b", "..a/b..", "builtin:scenes/..a/b.."},
        {"builtin:scenes/b", "/a", "/a"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char *path = file_relative(cases[i][0], cases[i][1]);
        CHECK_TEXT(path, cases[i][2], "%s as seen from %s", cases[i][1],
                   cases[i][0] != NULL ? cases[i][0] : "the command line");
        free(path);
    }
}

static void check_replacement(void)
{
    const char *const path = "out", *const link = "link";
    struct output output;
    struct error err = {0};
    struct stat status;
    int before;
    unlink(path);
    unlink(link);
    before = count_entries();
    CHECK(output_open(&output, path, &err) && access(path, F_OK) != 0,
          "an open output does not appear under its name");
    output_discard(&output);
    output_discard(&output);
    CHECK(count_entries() == before, "a discarded output leaves nothing");
    umask(027);
    CHECK(file_write(path, "old", 3, NULL, &err) && holds(path, "old") &&
              stat(path, &status) == 0 && (status.st_mode & 0777) == 0640,
          "a new file has the mode that the umask gives");
    chmod(path, 0606);
    symlink("out", link);
    CHECK(output_open(&output, link, &err) && write(output.descriptor, "new", 3) == 3 &&
              holds(path, "old"),
          "the old file stands until the commit");
    CHECK(output_pass(&output, NULL, &err) && holds(path, "new"),
          "the commit replaces the old file");
    output_discard(&output);
    CHECK(stat(path, &status) == 0 && (status.st_mode & 0777) == 0606,
          "the new file has the old one's mode");
    CHECK(lstat(link, &status) == 0 && S_ISLNK(status.st_mode), "a link stays a link");
    CHECK(count_entries() == before + 2, "no temporary file is left");
    unlink(link);
    chmod(path, 0400);
    CHECK(geteuid() == 0 || (!output_open(&output, path, &err) && holds(path, "new")),
          "a write-protected file is kept");
    umask(022);
}

/* ---- inputs ---- */

/* ---- folders ---- */

static void check_folders(void)
{
    char file[sizeof(struct folder) + 16];
    struct folder own, other;
    struct error err = {0};
    setenv("TMPDIR", ".", 1);
    const int before = count_entries();
    CHECK(folder_open(&own, &err) && folder_open(&other, &err) && access(own.path, F_OK) == 0,
          "folders of two that live stand side by side");
    snprintf(file, sizeof file, "%s/file", other.path);
    bytes_write(file, "x", 1);
    folder_close(&other);
    CHECK(access(file, F_OK) != 0 && count_entries() == before + 1,
          "a folder goes with all that is in it");
    folder_close(&own);
    CHECK(count_entries() == before, "no folder is left");
    unsetenv("TMPDIR");
}

/* ---- memory ---- */

static void check_arrays(void)
{
    struct error err = {.status = EXIT_AGREED};
    int *numbers = NULL, n = 0, wrong = 0;
    for (int i = 0; i < 100; i++)
        array_add(&numbers, &n, i % 2 == 0 ? &i : NULL, sizeof i, &err);
    for (int i = 0; i < n; i++)
        wrong += numbers[i] != (i % 2 == 0 ? i : 0);
    CHECK(n == 100 && wrong == 0, "%d items, %d wrong; expected 100, NULL adding zeros", n, wrong);
    n = INT_MAX;
    CHECK(!array_add(&numbers, &n, NULL, sizeof *numbers, &err) && n == INT_MAX &&
              err.status == EXIT_SYSTEM,
          "an array that cannot grow stays");
    free(numbers);
}

static void check_printed(void)
{
    struct printed printed = {.text = NULL};
    for (int i = 0; i < 1000; i++)
        print(&printed, "%d%c%s", 1, '\0', "23");
    print_text(&printed, "4");
    print_bytes(&printed, "\0005", 2);
    char *text = printed_end(&printed);
    bool right = text && printed.length == 4003 && memcmp(text + 4000, "4\0005", 4) == 0;
    for (size_t i = 0; right && i < 1000; i++)
        right = memcmp(text + 4 * i, "1\00023", 4) == 0;
    CHECK(right, "a text has its length, and a NUL behind it");
    free(text);
    CHECK(!printed_end(&printed), "a text is returned once");
    printed = (struct printed){.text = NULL};
    print_text(&printed, "whole");
    print_bytes(&printed, "", SIZE_MAX / 2);
    print_text(&printed, "part");
    CHECK(!printed_end(&printed), "a text that memory has no room for is none, not a part");
}

/* A message says how much memory lacks, and what for. */
static void check_memory(void)
{
    struct error err = {.status = EXIT_AGREED};
    double *numbers = &(double){0};
    int32_t *kept = calloc(1, sizeof *kept), *before = kept;
    CHECK(!MAKE_ARRAY(numbers, SIZE_MAX / 4, &err, "the texels of %s", "a.tif") && !numbers &&
              err.status == EXIT_SYSTEM && strncmp(err.text, "error: out of memory: ", 22) == 0 &&
              strstr(err.text, " MiB for the texels of a.tif; --memory sets the limit"),
          "what is larger than any memory is named with its size: %s", err.text);
    err = (struct error){.status = EXIT_AGREED};
    CHECK(!memory_lacks(&err, 1000, "a name") &&
              strstr(err.text, "out of memory: 1000 bytes for a name;"),
          "small needs are in bytes: %s", err.text);
    CHECK(!memory_resize(&kept, SIZE_MAX / 4, sizeof *kept) && kept == before,
          "an array that cannot grow stays");
    free(kept);
}

int main(void)
{
    test_enter();
    mkdir("file", 0777); /* a folder that only this test uses, so that leftovers can be counted */
    test_need(chdir("file") == 0, "there is no folder");
    check_arrays();
    check_memory();
    check_printed();
    check_reads();
    check_relative();
    check_replacement();
    check_folders();
    return test_end();
}
