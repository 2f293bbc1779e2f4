/* SPDX-License-Identifier: MIT */
/* spectral list: the names that scenes and options can use. */
#include <stdio.h>
#include <string.h>

#include "data/base/base.h"
#include "data/catalogue/catalogue.h"
#include "data/mesh/mesh.h"
#include "data/options/options.h"
#include "data/spectra/spectra.h"
#include "data/text/text.h"
#include "spectral.h"

/* Prints the built-in files that begin with the folder and end with the ending, without both. */
static void list_folder(const char *folder, const char *ending)
{
    size_t before = strlen(folder), after = strlen(ending);
    for (size_t i = 0; i < builtin_file_count; i++) {
        const char *name = builtin_files[i].name;
        size_t length = strlen(name);
        if (length > before + after && strncmp(name, folder, before) == 0 &&
            strcmp(name + length - after, ending) == 0)
            printf("  %.*s\n", (int)(length - before - after), name + before);
    }
}

/* A table of three value columns is an observer, a table of one is an illuminant. */
static void list_tables(bool observers)
{
    static const char folder[] = "tables/";
    const size_t before = strlen(folder);
    for (size_t i = 0; i < builtin_file_count; i++) {
        const char *name = builtin_files[i].name, *dot = strrchr(name, '.');
        if (strncmp(name, folder, before) == 0 && table_is_detector(&builtin_files[i]) == observers)
            printf("  %.*s\n", (int)((size_t)(dot - name) - before), name + before);
    }
}

static void list_illuminants(void)
{
    list_tables(false);
}

static void list_observers(void)
{
    list_tables(true);
}

static void list_materials(void)
{
    list_folder("materials/", ".txt");
}

static void list_scenes(void)
{
    list_folder("scenes/", ".scene");
}

static void list_shapes(void)
{
    for (enum shape_kind kind = SHAPE_SPHERE; kind < SHAPE_MESH; kind++) {
        printf("  %s", shape_name(kind));
        for (int i = 0; shape_size_name(kind, i); i++)
            printf(" %s", shape_size_name(kind, i));
        putchar('\n');
    }
    puts("  mesh FILE.obj [unitize] [crease ANGLE]");
}

static void list_samplings(void)
{
    fputs(
        "  box:N               N boxes of equal area under the detector's functions\n"
        "  riemann:STEP        a sample every STEP nm\n"
        "  gauss:N             Gaussian quadrature weighted by the detector's functions\n"
        "  gauss:N,open        by none: the detector is left open\n"
        "  gauss:N,xyz|lms|acc by tristimulus values, cones or opponent functions, each its own\n"
        "  adaptive:TOLERANCE  emission peaks, and quadrature between them\n"
        "  basis:K             K principal components of lights x reflectances: no spectra\n"
        "  rgb, xyz            three numbers a light and a material: no spectra, no fluorescence\n",
        stdout);
}

static const struct {
    const char *name;
    void (*print)(void);
} lists[] = {
    {"illuminants", list_illuminants}, {"observers", list_observers}, {"materials", list_materials},
    {"shapes", list_shapes},           {"scenes", list_scenes},       {"samplings", list_samplings},
};
enum { N_LISTS = sizeof lists / sizeof lists[0] };

bool command_list(struct options *options, struct error *err)
{
    const char *wanted = options->operand;
    char known[LIST_SIZE] = "";
    bool found = false;
    for (int i = 0; i < N_LISTS; i++) {
        list_add(known, lists[i].name, strlen(lists[i].name));
        if (wanted && strcmp(wanted, lists[i].name) != 0)
            continue;
        found = true;
        printf("%s\n", lists[i].name);
        lists[i].print();
    }
    return found || error_usage(err, "unknown list '%s'; known are %s", wanted, known);
}
