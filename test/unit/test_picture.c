/* SPDX-License-Identifier: MIT */
/* Pictures are read back with libtiff. */
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tiffio.h>
#include <unistd.h>

#include "data/base/base.h"
#include "data/pages/pages.h"
#include "spectral.h"
#include "test.h"

static const unsigned char profile[] = "a profile of an odd number of bytes!!";

static struct picture_options options_of(enum picture_samples samples, int width, int height)
{
    return (struct picture_options){.width = width,
                                    .height = height,
                                    .samples = samples,
                                    .channels = {"X", "Y", "Z"},
                                    .profile = samples == PICTURE_FLOAT ? NULL : profile,
                                    .profile_length = sizeof profile,
                                    .description = "two\nlines"};
}

/* A different number for every sample of a small picture. */
static unsigned sample_at(int width, int x, int y, int channel)
{
    const unsigned pixel = (unsigned)y * (unsigned)width + (unsigned)x;
    return (3 * pixel + (unsigned)channel) * 7 % 65521;
}

static void fill_row(const struct picture_options *options, int y, void *row)
{
    for (int i = 0; i < 3 * options->width; i++) {
        const unsigned sample = sample_at(options->width, i / 3, y, i % 3);
        if (options->samples == PICTURE_8)
            ((uint8_t *)row)[i] = (uint8_t)sample;
        else if (options->samples == PICTURE_16)
            ((uint16_t *)row)[i] = (uint16_t)sample;
        else
            ((float *)row)[i] = (float)sample / -7;
    }
}

/* Writes the picture, `step` rows at a time. */
static bool write_rows(struct picture_writer *writer, int step, struct error *err)
{
    const struct picture_options *options = &writer->options;
    const size_t size = options->samples == PICTURE_8 ? 1 : options->samples == PICTURE_16 ? 2 : 4;
    const size_t pitch = 3 * (size_t)options->width * size;
    char *rows = malloc(pitch * (size_t)step);
    bool done = rows != NULL;
    while (done && writer->row < options->height) {
        const int left = options->height - writer->row, n = left < step ? left : step;
        for (int i = 0; i < n; i++)
            fill_row(options, writer->row + i, rows + (size_t)i * pitch);
        done = picture_write(writer, rows, n, err);
    }
    free(rows);
    return done;
}

static bool write_picture(const char *path, const struct picture_options *options, int step,
                          struct error *err)
{
    struct picture_writer writer;
    if (!picture_open(&writer, path, options, err))
        return false;
    const bool done = write_rows(&writer, step, err) && picture_commit(&writer, err);
    picture_discard(&writer);
    return done;
}

static bool same_files(const char *one, const char *other)
{
    char a[65], b[65];
    struct error err = {0};
    return digest_file(one, a, &err) && digest_file(other, b, &err) && strcmp(a, b) == 0;
}

static double read_sample(const struct picture_options *options, const void *row, size_t at)
{
    if (options->samples == PICTURE_8)
        return ((const uint8_t *)row)[at];
    return options->samples == PICTURE_16 ? ((const uint16_t *)row)[at]
                                          : -7 * (double)((const float *)row)[at];
}

/* Returns the number of samples of the current page that differ from those written. */
static int wrong_samples(TIFF *tiff, const struct picture_options *options, int page)
{
    const int n = options->samples == PICTURE_FLOAT ? 1 : 3;
    const unsigned mask = options->samples == PICTURE_8 ? 255 : 65535;
    void *row = malloc((size_t)TIFFScanlineSize64(tiff));
    int wrong = row == NULL;
    for (int y = 0; row != NULL && y < options->height; y++) {
        if (TIFFReadScanline(tiff, row, (uint32_t)y, 0) != 1)
            wrong++;
        for (int i = 0; i < n * options->width; i++) {
            const unsigned expected =
                sample_at(options->width, i / n, y, n == 1 ? page : i % n) & mask;
            wrong += fabs(read_sample(options, row, (size_t)i) - expected) > 0.01;
        }
    }
    free(row);
    return wrong;
}

static bool texts_are_right(TIFF *tiff, const struct picture_options *options, int page)
{
    const char *description = "", *software = "", *name = "";
    const void *bytes = NULL;
    uint32_t length = 0;
    const bool floating = options->samples == PICTURE_FLOAT;
    TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &description);
    TIFFGetField(tiff, TIFFTAG_SOFTWARE, &software);
    TIFFGetField(tiff, TIFFTAG_PAGENAME, &name);
    TIFFGetField(tiff, TIFFTAG_ICCPROFILE, &length, &bytes);
    return strcmp(description, options->description) == 0 && strcmp(software, PROGRAM) == 0 &&
           strcmp(name, floating ? options->channels[page] : "") == 0 &&
           (floating ? length == 0
                     : length == sizeof profile && memcmp(bytes, profile, length) == 0);
}

static void check_picture(const char *path, const struct picture_options *options)
{
    const int n_pages = options->samples == PICTURE_FLOAT ? 3 : 1;
    TIFF *tiff = TIFFOpen(path, "rc");
    struct stat status;
    uint64_t end = 0;
    if (!CHECK(tiff != NULL && stat(path, &status) == 0, "%s: libtiff opens it", path))
        return;
    CHECK(TIFFNumberOfDirectories(tiff) == (unsigned)n_pages, "%s: it has %d pages", path, n_pages);
    for (int page = 0; page < n_pages; page++) {
        CHECK(TIFFSetDirectory(tiff, (uint16_t)page) && texts_are_right(tiff, options, page),
              "%s, page %d: description, software, name and profile are right", path, page + 1);
        CHECK(wrong_samples(tiff, options, page) == 0, "%s, page %d: every sample is right", path,
              page + 1);
        const uint64_t offset = TIFFGetStrileOffset(tiff, 0);
        CHECK(TIFFNumberOfStrips(tiff) == 1 && (page == 0 ? offset % 4 == 0 : offset == end),
              "%s, page %d: it has one strip, and the first page's begins at a multiple of 4 bytes",
              path, page + 1);
        end = offset + TIFFGetStrileByteCount(tiff, 0);
    }
    CHECK(end == (uint64_t)status.st_size, "%s: pixels fill the file up to its end without gaps",
          path);
    TIFFClose(tiff);
}

static void test_samples(void)
{
    static const struct {
        enum picture_samples samples;
        const char *name;
    } kinds[] = {{PICTURE_8, "8 bits"}, {PICTURE_16, "16 bits"}, {PICTURE_FLOAT, "float"}};
    static const int sizes[][2] = {{7, 5}, {1, 1}, {300, 301}, {30000, 3}};
    for (size_t kind = 0; kind < sizeof kinds / sizeof kinds[0]; kind++)
        for (size_t size = 0; size < sizeof sizes / sizeof sizes[0]; size++) {
            const struct picture_options options =
                options_of(kinds[kind].samples, sizes[size][0], sizes[size][1]);
            char path[64], other[] = "picture_other.tif";
            struct error err = {0};
            snprintf(path, sizeof path, "picture_%dx%d (%s).tif", options.width, options.height,
                     kinds[kind].name);
            if (CHECK(write_picture(path, &options, options.height, &err), "%s: written %s", path,
                      err.text))
                check_picture(path, &options);
            CHECK(write_picture(other, &options, 2, &err) && same_files(path, other),
                  "%s: written two rows at a time it has the same bytes", path);
            unlink(other);
            unlink(path);
        }
}

/* Writes only the last row, so that the file is sparse and takes no room. */
static void test_big(enum picture_samples samples, int size)
{
    const char *path = "picture_big.tif";
    const struct picture_options options = options_of(samples, size, size);
    struct picture_writer writer;
    struct error err = {0};
    bool done = picture_open(&writer, path, &options, &err);
    writer.row = size - 1;
    done = done && write_rows(&writer, 1, &err) && picture_commit(&writer, &err);
    CHECK(done, "a picture above 4 GiB is written %s", err.text);
    TIFF *tiff = done ? TIFFOpen(path, "r") : NULL;
    CHECK(tiff != NULL && TIFFIsBigTIFF(tiff), "it is a BigTIFF");
    float *row = tiff != NULL ? malloc((size_t)TIFFScanlineSize64(tiff)) : NULL;
    for (int page = 0; row != NULL && page < (samples == PICTURE_FLOAT ? 3 : 1); page++) {
        const unsigned expected = sample_at(size, 0, size - 1, page);
        CHECK(TIFFSetDirectory(tiff, (uint16_t)page) &&
                  TIFFReadScanline(tiff, row, (uint32_t)size - 1, 0) == 1 &&
                  fabs(read_sample(&options, row, 0) -
                       (samples == PICTURE_8 ? expected & 255 : expected)) < 0.01,
              "its last row is in its place, on page %d", page + 1);
    }
    free(row);
    if (tiff != NULL)
        TIFFClose(tiff);
    unlink(path);
}

static void test_impossible(void)
{
    const struct picture_options options = options_of(PICTURE_FLOAT, INT32_MAX, INT32_MAX);
    struct picture_writer writer;
    struct error err = {0};
    CHECK(!picture_open(&writer, "picture_huge.tif", &options, &err) && err.status == EXIT_INPUT &&
              access("picture_huge.tif", F_OK) != 0,
          "%s", err.text);
}

static void limit_files(rlim_t size)
{
    struct rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = size;
    setrlimit(RLIMIT_FSIZE, &limit);
}

static int files_here(void)
{
    int n = 0;
    FILE *list = popen("ls -A | wc -l", "r");
    if (list == NULL || fscanf(list, "%d", &n) != 1)
        n = -1;
    if (list != NULL)
        pclose(list);
    return n;
}

static void test_full_disk(void)
{
    const struct picture_options options = options_of(PICTURE_16, 300, 301);
    const char *path = "picture_full.tif";
    const int before = files_here();
    signal(SIGXFSZ, SIG_IGN);
    for (rlim_t size = 0; size <= 400000; size += 100000) {
        struct error err = {0};
        limit_files(size);
        const bool done = write_picture(path, &options, 50, &err);
        limit_files(RLIM_INFINITY);
        CHECK(!done && err.status == EXIT_SYSTEM && files_here() == before,
              "no room for more than %d bytes: %s", (int)size, err.text);
    }
    struct error err = {0};
    CHECK(!write_picture("/dev/full", &options, 50, &err) && err.status == EXIT_SYSTEM,
          "a full device: %s", err.text);
}

/* A picture that is not committed leaves the old file. */
static void test_discard(void)
{
    const struct picture_options options = options_of(PICTURE_8, 300, 301);
    const char *path = "picture_kept.tif";
    struct picture_writer writer;
    struct error err = {0};
    char kept[5] = "";
    test_write(path, "kept");
    const int before = files_here();
    CHECK(picture_open(&writer, path, &options, &err) && write_rows(&writer, 1000, &err),
          "a picture is written over a file");
    picture_discard(&writer);
    picture_discard(&writer);
    FILE *file = fopen(path, "r");
    CHECK(file != NULL && fgets(kept, sizeof kept, file) != NULL && strcmp(kept, "kept") == 0 &&
              files_here() == before,
          "a discarded picture leaves the file as it was, and no other file");
    if (file != NULL)
        fclose(file);
    unlink(path);
}

static void test_damage(void)
{
    const struct picture_options options = options_of(PICTURE_FLOAT, 7, 5);
    const char *path = "picture_damaged.tif";
    struct picture_writer writer;
    struct stat status;
    struct error err = {0};
    CHECK(picture_open(&writer, path, &options, &err) && write_rows(&writer, 5, &err) &&
              fstat(writer.pages.output.descriptor, &status) == 0 &&
              ftruncate(writer.pages.output.descriptor, status.st_size - 1) == 0,
          "a picture loses its last byte");
    CHECK(!picture_commit(&writer, &err) && err.status == EXIT_SYSTEM && access(path, F_OK) != 0,
          "the damaged picture does not appear: %s", err.text);
}

/* A reader in another process takes up to `most` bytes of a pipe into a file. */
static pid_t read_pipe(const char *pipe, const char *copy, size_t most)
{
    const pid_t child = fork();
    if (child != 0)
        return child;
    FILE *from = fopen(pipe, "r"), *to = fopen(copy, "w");
    int byte;
    while (from != NULL && to != NULL && most-- > 0 && (byte = getc(from)) != EOF)
        putc(byte, to);
    _exit(to == NULL || fclose(to) != 0);
}

static void test_pipe(void)
{
    const struct picture_options options = options_of(PICTURE_16, 300, 301);
    const char *pipe = "picture_pipe", *copy = "picture_copy.tif", *path = "picture_file.tif";
    struct error err = {0};
    signal(SIGPIPE, SIG_IGN);
    if (!CHECK(mkfifo(pipe, 0600) == 0, "a pipe is made"))
        return;
    pid_t child = read_pipe(pipe, copy, SIZE_MAX);
    CHECK(write_picture(pipe, &options, 50, &err), "a picture goes through a pipe %s", err.text);
    waitpid(child, NULL, 0);
    CHECK(write_picture(path, &options, 50, &err) && same_files(copy, path),
          "the pipe delivers the same bytes as a file");
    child = read_pipe(pipe, copy, 10);
    CHECK(!write_picture(pipe, &options, 50, &err) && err.status == EXIT_SYSTEM,
          "a pipe that closes: %s", err.text);
    waitpid(child, NULL, 0);
    unlink(pipe);
    unlink(copy);
    unlink(path);
}

int main(void)
{
    const char *folder = test_folder();
    if (!CHECK(chdir(folder) == 0, "the folder for temporary files exists"))
        return test_end();
    mkdir("test_picture", 0777);
    if (!CHECK(chdir("test_picture") == 0, "this test's folder exists"))
        return test_end();
    test_samples();
    test_big(PICTURE_8, 40000);
    test_big(PICTURE_FLOAT, 20000);
    test_impossible();
    test_full_disk();
    test_discard();
    test_damage();
    test_pipe();
    return test_end();
}
