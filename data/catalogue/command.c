/* SPDX-License-Identifier: MIT */
/* spectral list: the names that scenes and options can use. */
#include <stdio.h>
#include <string.h>

#include "data/catalogue/catalogue.h"
#include "data/mesh/mesh.h"
#include "data/spectra/spectra.h"
#include "data/text/text.h"

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

static const struct list {
    const char *name;
    void (*print)(void);         /* NULL: the list has the names of built-in files */
    const char *folder, *ending; /* of these files */
    bool detectors;              /* the files are tables of detectors */
} lists[] = {
    {"illuminants", NULL, "tables/", ".csv", false},
    {"observers", NULL, "tables/", ".csv", true},
    {"materials", NULL, "materials/", ".txt", false},
    {"shapes", list_shapes, NULL, NULL, false},
    {"scenes", NULL, "scenes/", ".scene", false},
    {"samplings", list_samplings, NULL, NULL, false},
};
enum { N_LISTS = sizeof lists / sizeof lists[0] };

static void print_list(const struct list *list)
{
    char name[BUILTIN_NAME];
    printf("%s\n", list->name);
    if (list->print)
        list->print();
    else
        for (size_t i = 0; i < builtin_file_count; i++)
            if (table_is_detector(&builtin_files[i]) == list->detectors &&
                builtin_name(&builtin_files[i], list->folder, list->ending, name))
                printf("  %s\n", name);
}

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
        print_list(&lists[i]);
    }
    return found || error_usage(err, "unknown list '%s'; known are %s", wanted, known);
}
