/* SPDX-License-Identifier: MIT */
/* The table of the fuzz targets, their files, and the rules that hold for each result. */
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "data/base/base.h"
#include "test/fuzz/fuzz.h"

static const struct fuzz_target targets[] = {
    {"scene", ".scene", fuzz_scene},
    {"list", ".list", fuzz_list},
    {"material", ".txt", fuzz_material},
    {"table", ".csv", fuzz_table},
    {"mesh", ".obj", fuzz_mesh},
    {"mtl", ".mtl", fuzz_mtl},
    {"map", ".map", fuzz_map},
    {"matrix", ".csv", fuzz_matrix},
    {"display", ".csv", fuzz_display},
    {"texture", ".texture.tif", fuzz_texture},
    {"png", NULL, fuzz_png},
    {"set", ".ti3", fuzz_table},
    {"record", NULL, fuzz_record},
    {"stack", ".tif", fuzz_stack},
    {"line", NULL, fuzz_line},
};

const struct fuzz_target *fuzz_target(const char *name)
{
    for (size_t i = 0; i < sizeof targets / sizeof targets[0]; i++)
        if (strcmp(targets[i].name, name) == 0)
            return &targets[i];
    return NULL;
}

void fuzz_holds(bool truth, const char *what)
{
    if (truth)
        return;
    fprintf(stderr, "does not hold: %s\n", what);
    abort();
}

bool fuzz_ends(bool done, const struct error *err)
{
    if (done) {
        fuzz_holds(err->status == EXIT_AGREED, "a success has status 0");
        fuzz_holds(err->text[0] == '\0', "a success has no message");
    } else {
        fuzz_holds(err->status == EXIT_INPUT || err->status == EXIT_SYSTEM,
                   "a failure has status 2 or 3");
        fuzz_holds(strstr(err->text, "error: ") != NULL, "a failure has a message");
        fuzz_holds(strpbrk(err->text, "\r\n\033") == NULL,
                   "a message has one line, without controls");
    }
    return done;
}

void fuzz_run(const struct fuzz_target *target, const unsigned char *bytes, size_t length)
{
    char *copy = malloc(length + 1);
    struct fuzz_input input = {copy, length, ""};
    if (copy == NULL)
        return;
    memcpy(copy, bytes, length);
    copy[length] = '\0';
    if (target->ending != NULL)
        fuzz_write(target->ending, copy, length, input.path);
    target->run(&input);
    free(copy);
}

void fuzz_write(const char *ending, const char *bytes, size_t length, char path[FUZZ_PATH])
{
    const char *folder = getenv("FUZZ_FOLDER");
    int file;
    snprintf(path, FUZZ_PATH, "%s/%ld%s", folder != NULL ? folder : ".", (long)getpid(), ending);
    file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    fuzz_holds(file >= 0 && write_all(file, bytes, length) && close(file) == 0,
               "the input is written to a file");
}
