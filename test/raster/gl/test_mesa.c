/* SPDX-License-Identifier: MIT */
/* level: full; packages: libosmesa6-dev */
/* Measures, through OSMesa, the behaviour of Mesa's two software drivers that the program relies
 * on, and draws scenes in which they err; data/doc/mesa.md explains both. Errors must show
 * in 22.3.6; if another version does not err, the test says so and skips them. Behaviour that the
 * program relies on must hold in every version. */
#include <sys/wait.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
/* after GL/gl.h, which osmesa.h includes */
#include <GL/glext.h>

#include "test.h"

#define MEASURED_VERSION "Mesa 22.3.6"

enum { SIZE = 256, PIXELS = SIZE * SIZE };

/* Rows run upwards, as in OpenGL's window coordinates. */
struct canvas {
    float colour[PIXELS][4];        /* OSMesa's buffer */
    uint32_t depth_stencil[PIXELS]; /* from the last shaded(): 24 bits above 8 */
    uint64_t random;
    const char *driver, *version;
    bool llvmpipe; /* softpipe otherwise */
};

/* Checks a fact about the version that was measured; skips it in another version that differs. */
static void known(const struct canvas *canvas, bool holds, const char *fact)
{
    if (holds || strstr(canvas->version, MEASURED_VERSION))
        CHECK(holds, "%s: %s", canvas->driver, fact);
    else
        printf("ok %d # SKIP not so in %s: %s %s\n", ++test_count, canvas->version, canvas->driver,
               fact);
}

/* Checks what the cross-check relies on in every version. */
static void needed(const struct canvas *canvas, bool holds, const char *fact)
{
    CHECK(holds, "%s: %s", canvas->driver, fact);
}

/* ---- the canvas ---- */

static double random_in(struct canvas *canvas, double low, double high)
{
    return test_random(&canvas->random, low, high);
}

static int random_below(struct canvas *canvas, int n)
{
    return (int)random_in(canvas, 0, n);
}

static bool open_context(struct canvas *canvas)
{
    const int attributes[][2] = {{OSMESA_FORMAT, OSMESA_RGBA},
                                 {OSMESA_DEPTH_BITS, 24},
                                 {OSMESA_STENCIL_BITS, 8},
                                 {OSMESA_PROFILE, OSMESA_COMPAT_PROFILE},
                                 {0, 0}};
    OSMesaContext context = OSMesaCreateContextAttribs(attributes[0], NULL);
    return context && OSMesaMakeCurrent(context, canvas->colour, GL_FLOAT, SIZE, SIZE);
}

/* Sets the state: coordinates are window coordinates, window z = z, and the stencil counts every
 * fragment. */
static void set_state(void)
{
    glClampColorARB(GL_CLAMP_VERTEX_COLOR_ARB, GL_FALSE);
    glClampColorARB(GL_CLAMP_FRAGMENT_COLOR_ARB, GL_FALSE);
    glDisable(GL_DITHER);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glOrtho(0, SIZE, 0, SIZE, 0, -1);
    glMatrixMode(GL_MODELVIEW);
    glLoadIdentity();
    glClearColor(0, 0, 0, 0);
    glColor3f(1, 1, 1);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, 0, 0xff);
    glStencilOp(GL_INCR, GL_INCR, GL_INCR);
}

static void clear(void)
{
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
}

static void shaded(struct canvas *canvas)
{
    glFinish();
    glReadPixels(0, 0, SIZE, SIZE, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, canvas->depth_stencil);
}

static int fragments_at(const struct canvas *canvas, int pixel)
{
    return (int)(canvas->depth_stencil[pixel] & 0xff);
}

static void draw_triangle(double corner[3][3])
{
    glBegin(GL_TRIANGLES);
    for (int i = 0; i < 3; i++)
        glVertex3dv(corner[i]);
    glEnd();
}

/* ---- depth ---- */

/* Draws a triangle red, then green with the depth function given; counts the pixels that show the
 * second. */
static long second_shows(struct canvas *canvas, double corner[3][3], GLenum function, long *pixels)
{
    long second = 0;
    clear();
    glDepthFunc(GL_LESS);
    glColor3f(1, 0, 0);
    draw_triangle(corner);
    glDepthFunc(function);
    glColor3f(0, 1, 0);
    draw_triangle(corner);
    glFinish();
    for (int i = 0; i < PIXELS; i++) {
        second += canvas->colour[i][1] > 0;
        *pixels += canvas->colour[i][0] > 0 || canvas->colour[i][1] > 0;
    }
    return second;
}

static void ties(struct canvas *canvas)
{
    long pixels = 0, less_second = 0, lequal_first = 0;
    glEnable(GL_DEPTH_TEST);
    for (int i = 0; i < 200; i++) {
        double corner[3][3];
        long again = 0;
        for (int c = 0; c < 3; c++)
            for (int j = 0; j < 3; j++)
                corner[c][j] = random_in(canvas, 0, j < 2 ? SIZE : 1);
        less_second += second_shows(canvas, corner, GL_LESS, &pixels);
        long shown = second_shows(canvas, corner, GL_LEQUAL, &again);
        lequal_first += again - shown;
    }
    printf("# ties: %ld pixels, LESS %ld, LEQUAL %ld\n", pixels, less_second, lequal_first);
    needed(canvas, pixels > 0 && less_second == 0 && lequal_first == 0,
           "a triangle drawn twice is a tie everywhere");
}

/* Draws a triangle with an edge on the far plane; the edge runs through pixel centres. */
static void random_far_triangle(struct canvas *canvas, double corner[3][3])
{
    for (int j = 0; j < 2; j++) {
        double step = random_below(canvas, 3) - 1.0;
        corner[0][j] = random_below(canvas, 20) + 210.5;
        corner[1][j] = corner[0][j] + 12 * step;
        corner[2][j] = corner[0][j] + random_in(canvas, -8, 8);
    }
    for (int i = 0; i < 3; i++)
        corner[i][2] = i < 2 ? 1 : 0.75;
}

/* A fragment whose depth runs over changes the stencil. */
static void far_plane(struct canvas *canvas)
{
    long pixels = 0, carried = 0;
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDisable(GL_STENCIL_TEST);
    for (int i = 0; i < 2000; i++) {
        double corner[3][3];
        random_far_triangle(canvas, corner);
        clear();
        draw_triangle(corner);
        shaded(canvas);
        for (int k = 0; k < PIXELS; k++) {
            pixels += canvas->colour[k][0] > 0;
            carried += fragments_at(canvas, k) != 0;
        }
    }
    printf("# far plane: %ld pixels, %ld carried\n", pixels, carried);
    needed(canvas, pixels > 0 && carried == 0, "under GL_LESS no depth runs over into the stencil");
}

/* ---- buffers ---- */

static bool first_is(const struct canvas *canvas, double red, double green)
{
    glFinish();
    return (double)canvas->colour[0][0] == red && (double)canvas->colour[0][1] == green;
}

static void buffers(struct canvas *canvas)
{
    glClearColor(2, -1, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    needed(canvas, first_is(canvas, 2, -1), "without clamps clear colours keep their value");
    glColor3f(2, -1, 0);
    glClampColorARB(GL_CLAMP_VERTEX_COLOR_ARB, GL_FALSE);
    glRectf(-1, -1, 1, 1);
    needed(canvas, first_is(canvas, 2, -1), "without clamps colours keep their value");
}

/* ---- one triangle a pixel, named by its colour ---- */

enum { TRIANGLES = 1000, CORNERS = 3 * TRIANGLES };

struct soup {
    float position[CORNERS][3], name[CORNERS][3];
};

/* Makes triangles of several sizes; some cross the near plane. */
static void random_soup(struct canvas *canvas, struct soup *soup)
{
    for (int t = 0; t < TRIANGLES; t++) {
        double middle[3], size = t % 10 == 0 ? 4 : 0.3;
        for (int j = 0; j < 3; j++)
            middle[j] = random_in(canvas, j < 2 ? -4 : -12, j < 2 ? 4 : 1);
        for (int i = 3 * t; i < 3 * t + 3; i++) {
            for (int j = 0; j < 3; j++)
                soup->position[i][j] = (float)(middle[j] + random_in(canvas, -size, size));
            soup->name[i][0] = (float)(t + 1);
            soup->name[i][1] = (float)(16777216 - t);
            soup->name[i][2] = (float)(random_below(canvas, 16777217));
        }
    }
}

static void draw_names(const struct soup *soup, int first, int corners)
{
    clear();
    glShadeModel(GL_FLAT);
    glEnableClientState(GL_COLOR_ARRAY);
    glVertexPointer(3, GL_FLOAT, 0, soup->position);
    glColorPointer(3, GL_FLOAT, 0, soup->name);
    glDrawArrays(GL_TRIANGLES, first, corners);
    glDisableClientState(GL_COLOR_ARRAY);
    glShadeModel(GL_SMOOTH);
}

struct identity_counts {
    long pixels, colours;
};

static void check_names(const struct canvas *canvas, const struct soup *soup,
                        struct identity_counts *counts)
{
    for (int i = 0; i < PIXELS; i++) {
        const float *colour = canvas->colour[i];
        if (!fragments_at(canvas, i))
            continue;
        int triangle = (int)colour[0] - 1;
        counts->pixels++;
        counts->colours += triangle < 0 || triangle >= TRIANGLES ||
                           memcmp(colour, soup->name[3 * triangle + 2], sizeof soup->name[0]) != 0;
    }
}

/* Compares the stencil of all triangles at once with the sum of the stencils of each alone. */
static void check_counts(struct canvas *canvas, const struct soup *soup)
{
    static const int some = TRIANGLES / 2;
    static long sum[PIXELS];
    long fragments = 0, wrong = 0;
    for (int i = 0; i < some; i++) {
        draw_names(soup, 3 * i, 3);
        shaded(canvas);
        for (int k = 0; k < PIXELS; k++)
            sum[k] += fragments_at(canvas, k);
    }
    draw_names(soup, 0, 3 * some);
    shaded(canvas);
    for (int k = 0; k < PIXELS; k++) {
        fragments += sum[k];
        wrong += sum[k] != fragments_at(canvas, k);
    }
    printf("# %ld fragments\n", fragments);
    needed(canvas, fragments > 10000 && wrong == 0, "the stencil counts fragments");
}

static void identity(struct canvas *canvas)
{
    static struct soup soup;
    struct identity_counts n = {0};
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glFrustum(-0.5, 0.5, -0.5, 0.5, 1, 20);
    glMatrixMode(GL_MODELVIEW);
    glRotated(33, 1, 0.3, 0.2);
    glScaled(1.1, 0.9, 1.05);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glEnableClientState(GL_VERTEX_ARRAY);
    for (int i = 0; i < 6; i++) {
        random_soup(canvas, &soup);
        if (i == 0)
            check_counts(canvas, &soup);
        draw_names(&soup, 0, CORNERS);
        shaded(canvas);
        check_names(canvas, &soup, &n);
    }
    printf("# names: %ld pixels\n", n.pixels);
    needed(canvas, n.pixels > 100000 && n.colours == 0,
           "flat colours up to 2^24 arrive to the bit");
}

/* ---- the program ---- */

/* Returns the exit status of the program on a scene of test/cases/mesa/. */
static int spectral_exit(const char *driver, const char *scene, const char *option)
{
    const char *program = getenv("SPECTRAL");
    char command[512];
    snprintf(
        command, sizeof command,
        "GALLIUM_DRIVER=%s %s render test/cases/mesa/%s.scene -o /dev/null --quiet %s 2>/dev/null",
        driver, program ? program : "build/spectral", scene, option);
    int status = system(command);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void check_program(const struct canvas *canvas)
{
    const char *driver = canvas->driver;
    needed(canvas, spectral_exit(driver, "seam", "") == 0, "the program passes edge holes");
    known(canvas, spectral_exit(driver, "seam", "--strict") == !canvas->llvmpipe,
          "--strict finds softpipe's holes in seam.scene, and none of llvmpipe");
    needed(canvas, spectral_exit(driver, "sliver", "--unchecked 1") == 0,
           "slivers without a bound are no difference");
    known(canvas, spectral_exit(driver, "sliver", "") == canvas->llvmpipe,
          "a picture of slivers is not verified where they are drawn");
    known(canvas, spectral_exit(driver, "blocks", "") == !canvas->llvmpipe,
          "the program finds softpipe's wrong texels in blocks.scene, and none of llvmpipe");
}

/* ---- measuring ---- */

/* Each measurement finds the state of set_state. */
static void measure(const char *driver)
{
    static void (*const measurements[])(struct canvas *) = {ties, far_plane, identity};
    static struct canvas canvas = {.random = 1};
    if (!CHECK(open_context(&canvas), "%s: there is a context", driver))
        return;
    const char *renderer = (const char *)glGetString(GL_RENDERER);
    canvas.driver = driver;
    canvas.version = (const char *)glGetString(GL_VERSION);
    canvas.llvmpipe = strcmp(driver, "llvmpipe") == 0;
    printf("# %s, %s\n", renderer, canvas.version);
    if (strncmp(renderer, driver, strlen(driver)) != 0) { /* Mesa was built without this driver */
        printf("ok %d # SKIP OSMesa gives %s for %s\n", ++test_count, renderer, driver);
        return;
    }
    buffers(&canvas);
    set_state();
    for (size_t i = 0; i < sizeof measurements / sizeof measurements[0]; i++) {
        glPushAttrib(GL_ALL_ATTRIB_BITS);
        measurements[i](&canvas);
        glPopAttrib();
    }
    needed(&canvas, glGetError() == GL_NO_ERROR, "OpenGL reports no error");
    check_program(&canvas);
}

/* A process can choose its driver only once, so each driver is measured in a process of its own,
 * which prints its truths and returns how many there are, and how many failed. */
static void measure_alone(const char *driver)
{
    int ends[2], counts[2] = {0, 0}, status = 1;
    fflush(stdout);
    const pid_t child = pipe(ends) == 0 ? fork() : -1;
    if (child == 0) {
        setenv("GALLIUM_DRIVER", driver, 1);
        setenv("LP_NUM_THREADS", "1", 1);
        measure(driver);
        fflush(stdout);
        counts[0] = test_count, counts[1] = test_failures;
        _exit(write(ends[1], counts, sizeof counts) != sizeof counts);
    }
    if (waitpid(child, &status, 0) == child && status == 0 &&
        read(ends[0], counts, sizeof counts) == sizeof counts)
        test_count = counts[0], test_failures = counts[1];
    CHECK(counts[0] > 0, "%s was measured", driver);
}

int main(void)
{
    measure_alone("llvmpipe");
    measure_alone("softpipe");
    return test_end();
}
