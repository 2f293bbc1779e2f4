/* SPDX-License-Identifier: MIT */
/* Draws the built-in colorchecker as the loop of the 1998 thesis does: one wavelength a pass, only
 * the red channel used, read back row by row, no check and no file. A process of its own, so that
 * ratios.py can time it beside the program.
 * usage: thesis SIZE WAVELENGTHS [at-once], both as the options of `spectral render`
 * at-once: the fastest loop that makes the same floats: it lights one side, and leaves a picture
 * where OSMesa puts it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
#include <GL/glext.h>

#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "data/scene/inside.h"
#include "raster/plan/plan.h"
#include "spectral.h"

static void load(const struct matrix *m)
{
    GLdouble columns[16];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            columns[4 * j + i] = m->row[i][j];
    glLoadMatrixd(columns);
}

/* Draws by display lists, as in the thesis; Mesa stores them itself, like vertex buffers. */
static void compile_lists(const struct plan *plan)
{
    for (int i = 0; i < plan->n_meshes; i++) {
        const struct mesh *mesh = &plan->meshes[i].mesh;
        glNewList((GLuint)i + 1, GL_COMPILE);
        glBegin(GL_TRIANGLES);
        for (int t = 0; t < mesh->n_triangles; t++)
            for (int c = 0; c < 3; c++) {
                const struct vertex *vertex = &mesh->vertices[mesh->triangles[t][c]];
                glNormal3d(vertex->normal.x, vertex->normal.y, vertex->normal.z);
                glVertex3d(vertex->position.x, vertex->position.y, vertex->position.z);
            }
        glEnd();
        glEndList();
    }
}

static void draw_band(const struct plan *plan, int band)
{
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    for (int i = 0; i < plan->n_instances; i++) {
        const struct placed_instance *placed = &plan->instances[i];
        GLfloat radiance[4] = {(GLfloat)plan->materials[placed->shaded].made.spectra[band], 0, 0,
                               1};
        glMaterialfv(GL_FRONT_AND_BACK, GL_DIFFUSE, radiance);
        load(&placed->instance.model_view);
        glCallList((GLuint)placed->mesh + 1);
    }
}

static void draw_bands(const struct plan *plan, bool at_once)
{
    int width = plan->scene->width, height = plan->scene->height;
    float *buffer = malloc((size_t)width * (size_t)height * 4 * sizeof *buffer);
    float *row = malloc((size_t)width * sizeof *row);
    static const GLfloat position[4] = {0, 0, 8, 1};
    OSMesaContext context = OSMesaCreateContextExt(OSMESA_RGBA, 24, 0, 0, NULL);
    if (!buffer || !row || !OSMesaMakeCurrent(context, buffer, GL_FLOAT, width, height))
        exit(3);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_LIGHTING);
    glEnable(GL_LIGHT0);
    glEnable(GL_NORMALIZE);
    glEnable(GL_CULL_FACE);
    glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, !at_once);
    glMatrixMode(GL_PROJECTION);
    load(&plan->view.projection);
    glMatrixMode(GL_MODELVIEW);
    glLightfv(GL_LIGHT0, GL_POSITION, position);
    compile_lists(plan);
    for (int band = 0; band < plan->n_bands; band++) {
        draw_band(plan, band);
        glFinish();
        for (int y = 0; y < height && !at_once; y++)
            glReadPixels(0, y, width, 1, GL_RED, GL_FLOAT, row);
    }
    OSMesaDestroyContext(context);
    free(buffer);
    free(row);
}

int main(int argc, char **argv)
{
    struct error err = {.status = EXIT_AGREED};
    struct scene scene;
    struct plan plan;
    const struct plan_options options = {.use_gl = true};
    if (argc != 3 && (argc != 4 || strcmp(argv[3], "at-once") != 0)) {
        fprintf(stderr, "usage: thesis SIZE WAVELENGTHS [at-once]\n");
        return EXIT_INPUT;
    }
    if (!scene_read("colorchecker", &scene, &err) || !scene_set_size(&scene, argv[1], &err) ||
        !scene_set_wavelengths(&scene, argv[2], &err) ||
        !scene_set_ambient(&scene, "d65*0", &err) || /* the thesis has none */
        !plan_make(&scene, NULL, &options, &plan, &err)) {
        fprintf(stderr, "%s\n", err.text);
        return (int)err.status;
    }
    draw_bands(&plan, argc == 4);
    plan_free(&plan);
    scene_free(&scene);
    return 0;
}
