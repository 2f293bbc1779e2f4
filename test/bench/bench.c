/* SPDX-License-Identifier: MIT */
/* Measures the cost of a render by part and compares it with the loop of the 1998 thesis on the
 * same OpenGL: one wavelength a pass, only the red channel used, read back row by row, no check and
 * no file. Both draw the built-in colorchecker at 2000 x 2000 pixels and 93 wavelengths, in turn,
 * in one run. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
#include <GL/glext.h>

#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "data/scene/scene.h"
#include "raster/plan/plan.h"
#include "raster/render/render.h"
#include "spectral.h"

enum { RUNS = 5 };

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void fail(const struct error *err)
{
    fprintf(stderr, "%s\n", err->text);
    exit((int)err->status);
}

/* ---- the thesis's loop ---- */

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

static double thesis_loop(const struct plan *plan)
{
    int width = plan->scene->width, height = plan->scene->height;
    float *buffer = malloc((size_t)width * (size_t)height * 4 * sizeof *buffer);
    float *row = malloc((size_t)width * sizeof *row);
    static const GLfloat position[4] = {0, 0, 8, 1};
    double start = now();
    OSMesaContext context = OSMesaCreateContextExt(OSMESA_RGBA, 24, 0, 0, NULL);
    if (!buffer || !row || !OSMesaMakeCurrent(context, buffer, GL_FLOAT, width, height))
        exit(3);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_LIGHTING);
    glEnable(GL_LIGHT0);
    glEnable(GL_NORMALIZE);
    glEnable(GL_CULL_FACE);
    glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, GL_TRUE);
    glMatrixMode(GL_PROJECTION);
    load(&plan->view.projection);
    glMatrixMode(GL_MODELVIEW);
    glLightfv(GL_LIGHT0, GL_POSITION, position);
    compile_lists(plan);
    for (int band = 0; band < plan->n_bands; band++) {
        draw_band(plan, band);
        for (int y = 0; y < height; y++)
            glReadPixels(0, y, width, 1, GL_RED, GL_FLOAT, row);
    }
    double seconds = now() - start;
    OSMesaDestroyContext(context);
    free(buffer);
    free(row);
    return seconds;
}

/* ---- the comparison ---- */

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values)
{
    qsort(values, RUNS, sizeof *values, by_value);
    return values[RUNS / 2];
}

int main(void)
{
    struct error err = {.status = EXIT_AGREED};
    struct scene scene;
    struct plan plan;
    struct plan_options options = {.check = true, .use_gl = true};
    const struct render_output output = {.path = "build/bench.tif"};
    double total[RUNS], thesis[RUNS], ratio[RUNS];
    if (!scene_read("colorchecker", &scene, &err) || !scene_set_size(&scene, "2000x2000", &err) ||
        !scene_set_ambient(&scene, "d65*0", &err) || /* the thesis has none */
        !plan_make(&scene, NULL, &options, &plan, &err))
        fail(&err);
    printf("%s, %d x %d pixels, %d wavelengths; seconds\n", scene.path, scene.width, scene.height,
           plan.n_bands);
    printf("  total     gl raster  check  write  thesis's loop  ratio\n");
    for (int i = 0; i < RUNS; i++) {
        struct render_result result;
        if (!render(&plan, &output, NULL, &result, &err))
            fail(&err);
        const struct part_seconds *s = &result.seconds;
        total[i] = s->total;
        thesis[i] = thesis_loop(&plan);
        ratio[i] = total[i] / thesis[i];
        printf("%7.3f %6.3f %6.3f %6.3f %6.3f %14.3f  %5.3f\n", s->total, s->gl, s->raster,
               s->check, s->write, thesis[i], ratio[i]);
        if (result.check.unexplained != 0)
            return 1;
    }
    printf("%7.3f %43.3f  %5.3f  (medians)\n", median(total), median(thesis), median(ratio));
    remove("build/bench.tif");
    plan_free(&plan);
    scene_free(&scene);
    return 0;
}
