/* SPDX-License-Identifier: MIT */
/* level: full; packages: libosmesa6-dev */
/* Measures, through OSMesa, how Mesa's two software drivers differ from OpenGL and from each other,
 * and the behaviour of both that the program relies on. data/doc/mesa.md explains each measurement.
 * Facts about Mesa must hold in 22.3.6; if another version behaves otherwise, the test says so and
 * skips the fact. Behaviour that the program relies on must hold in every version. */
#include <sys/wait.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
/* after GL/gl.h, which osmesa.h includes */
#include <GL/glext.h>

#include "test.h"

#define MEASURED_VERSION "Mesa 22.3.6"

enum { SIZE = 256, PIXELS = SIZE * SIZE, DEPTH_MAX = 0xffffff };

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
        CHECK(holds, "%s %s", canvas->driver, fact);
    else
        printf("ok %d # SKIP not so in %s: %s %s\n", ++test_count, canvas->version, canvas->driver,
               fact);
}

/* Checks a fact in which the drivers differ. */
static void differ(const struct canvas *canvas, bool llvmpipe_holds, const char *llvmpipe_fact,
                   bool softpipe_holds, const char *softpipe_fact)
{
    known(canvas, canvas->llvmpipe ? llvmpipe_holds : softpipe_holds,
          canvas->llvmpipe ? llvmpipe_fact : softpipe_fact);
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

static bool open_context(struct canvas *canvas, int format)
{
    const int attributes[][2] = {{OSMESA_FORMAT, format},
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

static uint32_t depth_at(const struct canvas *canvas, int pixel)
{
    return canvas->depth_stencil[pixel] >> 8;
}

static void draw_triangle(double corner[3][3], int first)
{
    glBegin(GL_TRIANGLES);
    for (int i = 0; i < 3; i++)
        glVertex3dv(corner[(first + i) % 3]);
    glEnd();
}

/* ---- slivers ---- */

/* Three corners on one line on a grid of 1/1024 pixel, the middle one beside a pixel's centre, then
 * moved upwards. */
static void random_sliver(struct canvas *canvas, double off, double corner[3][3])
{
    double back = random_below(canvas, 4) + 1, ahead = random_below(canvas, 4) + 1;
    for (int j = 0; j < 2; j++) {
        double aside = (random_below(canvas, 5) - 2.0) / 1024;
        double middle = floor(random_in(canvas, 60, 190)) + 0.5 + aside;
        double step = floor(random_in(canvas, -8, 8) * 1024) / 1024;
        corner[0][j] = middle - back * step;
        corner[1][j] = middle + (j == 1 ? off : 0);
        corner[2][j] = middle + ahead * step;
    }
    for (int i = 0; i < 3; i++)
        corner[i][2] = 0.25 * (i + 1);
}

/* Draws slivers. Returns the largest colour of a pixel; corners have 1. */
static double draw_slivers(struct canvas *canvas)
{
    double largest = 0;
    for (int i = 0; i < 3000; i++) {
        double corner[3][3];
        random_sliver(canvas, 1.0 / 16384, corner);
        if (i % 10 == 0)
            clear();
        glBegin(GL_TRIANGLES);
        for (int c = 0; c < 3; c++) {
            glColor3d(c == 0, c == 1, c == 2);
            glVertex3dv(corner[c]);
        }
        glEnd();
        if (i % 10 < 9)
            continue;
        shaded(canvas);
        for (int k = 0; k < 3 * PIXELS; k++) {
            const double colour = (double)canvas->colour[k / 3][k % 3];
            if (fragments_at(canvas, k / 3) > 0 && isfinite(colour))
                largest = fmax(largest, fabs(colour));
        }
    }
    return largest;
}

static void slivers(struct canvas *canvas)
{
    const double largest = draw_slivers(canvas);
    printf("# slivers: largest colour %g\n", largest);
    differ(canvas, largest > 10,
           "extrapolates on slivers to more than ten times the largest colour", largest < 2,
           "has no colour on slivers that is twice the largest");
}

/* Draws slivers that run only just anticlockwise, with front faces culled. */
static void facing(struct canvas *canvas)
{
    long front = 0, as_back = 0;
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
    for (int i = 0; i < 1000; i++) {
        double c[3][3];
        random_sliver(canvas, 1.0 / 1024, c);
        double area =
            (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[2][0] - c[0][0]) * (c[1][1] - c[0][1]);
        if (area <= 0)
            continue;
        clear();
        draw_triangle(c, 0);
        shaded(canvas);
        long drawn = 0;
        for (int k = 0; k < PIXELS; k++)
            drawn += fragments_at(canvas, k);
        front++;
        as_back += drawn > 0;
    }
    printf("# facing: %ld of %ld front faces drawn as back\n", as_back, front);
    differ(canvas, as_back > 0, "takes slivers' front faces for back faces", as_back == 0,
           "takes no front faces for back faces");
}

/* ---- depth ---- */

/* Draws a triangle red, then green with the depth function and first corner given; counts the
 * pixels that show the second. */
static long second_shows(struct canvas *canvas, double corner[3][3], GLenum function, int first,
                         long *pixels)
{
    long second = 0;
    clear();
    glDepthFunc(GL_LESS);
    glColor3f(1, 0, 0);
    draw_triangle(corner, 0);
    glDepthFunc(function);
    glColor3f(0, 1, 0);
    draw_triangle(corner, first);
    glFinish();
    for (int i = 0; i < PIXELS; i++) {
        second += canvas->colour[i][1] > 0;
        *pixels += canvas->colour[i][0] > 0 || canvas->colour[i][1] > 0;
    }
    return second;
}

static void ties(struct canvas *canvas)
{
    long pixels = 0, less_second = 0, lequal_first = 0, turned_second = 0;
    glEnable(GL_DEPTH_TEST);
    for (int i = 0; i < 200; i++) {
        double corner[3][3];
        long again = 0, other = 0;
        for (int c = 0; c < 3; c++)
            for (int j = 0; j < 3; j++)
                corner[c][j] = random_in(canvas, 0, j < 2 ? SIZE : 1);
        less_second += second_shows(canvas, corner, GL_LESS, 0, &pixels);
        long shown = second_shows(canvas, corner, GL_LEQUAL, 0, &again);
        lequal_first += again - shown;
        turned_second += second_shows(canvas, corner, GL_LESS, 1, &other);
    }
    printf("# ties: %ld pixels, LESS %ld, LEQUAL %ld, turned %ld\n", pixels, less_second,
           lequal_first, turned_second);
    needed(canvas, pixels > 0 && less_second == 0 && lequal_first == 0,
           "a triangle drawn twice is a tie everywhere");
    differ(canvas, turned_second > 0, "breaks ties of triangles that begin at another corner",
           turned_second == 0, "keeps ties of triangles that begin at another corner");
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

/* Every drawn fragment must have a depth of at least 0.75 and leave the stencil as it was. */
static void far_plane(struct canvas *canvas)
{
    long pixels = 0, lost = 0, n_carried = 0, carried_less = 0;
    uint32_t example = 0;
    glEnable(GL_DEPTH_TEST);
    glDisable(GL_STENCIL_TEST);
    for (int i = 0; i < 4000; i++) {
        double corner[3][3];
        random_far_triangle(canvas, corner);
        clear();
        glDepthFunc(i % 2 == 0 ? GL_ALWAYS : GL_LESS);
        draw_triangle(corner, 0);
        shaded(canvas);
        for (int k = 0; k < PIXELS; k++) {
            bool carried = fragments_at(canvas, k) != 0;
            pixels += canvas->colour[k][0] > 0;
            lost += depth_at(canvas, k) < DEPTH_MAX / 2;
            n_carried += carried;
            carried_less += carried && i % 2 == 1;
            if (carried)
                example = canvas->depth_stencil[k];
        }
    }
    printf("# far plane: %ld pixels, %ld lost, %ld carried (0x%08x)\n", pixels, lost, n_carried,
           (unsigned)example);
    needed(canvas, pixels > 0 && carried_less == 0,
           "under GL_LESS no depth runs over into the stencil");
    differ(canvas, lost == 0 && n_carried == 0, "clamps depth at the far plane",
           lost > 0 && n_carried == lost,
           "makes pixels of the far plane the nearest and changes their stencil");
}

/* ---- lighting ---- */

static const GLfloat white[4] = {1, 1, 1, 1}, black[4] = {0, 0, 0, 1};

/* Returns the red of a rectangle with this normal. */
static double lit(const struct canvas *canvas, double x, double y, double z)
{
    glNormal3d(x, y, z);
    glRectf(0, 0, 2, 2);
    glFinish();
    return (double)canvas->colour[0][0];
}

static void set_material(const GLfloat *diffuse, const GLfloat *specular)
{
    glMaterialfv(GL_FRONT_AND_BACK, GL_DIFFUSE, diffuse);
    glMaterialfv(GL_FRONT_AND_BACK, GL_SPECULAR, specular);
}

static void direct_light(GLfloat x, GLfloat y, GLfloat z)
{
    GLfloat direction[4] = {x, y, z, 0};
    glLightfv(GL_LIGHT0, GL_POSITION, direction);
}

/* The normal is at right angles to the half vector, but the surface is lit: the highlight is
 * 0^shininess. The visible front has shininess 0. */
static void zero_power(struct canvas *canvas)
{
    double power[2]; /* where the back has shininess 20, and 0 */
    set_material(black, white);
    direct_light(1, 0, 0);
    glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, 1);
    for (int i = 0; i < 2; i++) {
        glMaterialf(GL_FRONT, GL_SHININESS, 0);
        glMaterialf(GL_BACK, GL_SHININESS, i == 0 ? 20 : 0);
        power[i] = lit(canvas, 1, 0, -1);
    }
    glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, 0);
    printf("# 0^0 beside 20: %g, beside 0: %g\n", power[0], power[1]);
    known(canvas, power[1] == 1, "gives 0^0 = 1 where both sides have shininess 0");
    differ(canvas, power[0] == 0, "gives 0^0 = 0 where only one side has shininess 0",
           power[0] == 1, "gives 0^0 = 1");
}

static void normals(struct canvas *canvas)
{
    static const double length[] = {1e-19, 2e-19, 1e19, 1e20};
    double seen[4];
    set_material(white, black);
    direct_light(0, 0, 1);
    for (int i = 0; i < 4; i++)
        seen[i] = lit(canvas, 0, 0, length[i]);
    glScalef(1, 1, 0);
    const double singular = lit(canvas, 0.6, 0, 0.8);
    glLoadIdentity();
    printf("# normals: %g %g %g %g, singular %g\n", seen[0], seen[1], seen[2], seen[3], singular);
    known(canvas, seen[0] == 0 && seen[3] == 0,
          "makes normals of length 1e-19 and 1e20 black under GL_NORMALIZE");
    known(canvas, fabs(seen[1] - 1) < 1e-6 && fabs(seen[2] - 1) < 1e-6,
          "normalizes normals of length 2e-19 and 1e19");
    known(canvas, fabs(singular - 0.8) < 1e-6,
          "treats the inverse of a singular matrix as the identity");
}

static void lighting(struct canvas *canvas)
{
    glEnable(GL_LIGHTING);
    glEnable(GL_LIGHT0);
    glEnable(GL_NORMALIZE);
    glLightModelfv(GL_LIGHT_MODEL_AMBIENT, black);
    zero_power(canvas);
    normals(canvas);
}

/* ---- buffers and textures ---- */

static bool first_is(const struct canvas *canvas, double red, double green)
{
    glFinish();
    return (double)canvas->colour[0][0] == red && (double)canvas->colour[0][1] == green;
}

static void buffers(struct canvas *canvas)
{
    glClearColor(2, -1, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    const double before_finish = (double)canvas->colour[0][0];
    const bool cleared = first_is(canvas, 2, -1);
    known(canvas, before_finish == 0 && cleared, "fills the buffer at glFinish");
    needed(canvas, cleared, "without clamps clear colours keep their value");
    glColor3f(2, -1, 0);
    glRectf(-1, -1, 1, 1);
    known(canvas, first_is(canvas, 1, 0), "clamps vertex colours by default in a float buffer");
    glClampColorARB(GL_CLAMP_VERTEX_COLOR_ARB, GL_FALSE);
    glRectf(-1, -1, 1, 1);
    needed(canvas, first_is(canvas, 2, -1), "without clamps colours keep their value");
}

/* Draws a red pixel into a buffer that is requested as BGRA. */
static void buffer_order(struct canvas *canvas)
{
    if (!open_context(canvas, OSMESA_BGRA))
        return;
    glClearColor(1, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    glFinish();
    known(canvas, (double)canvas->colour[0][0] == 1,
          "stores RGBA in a float buffer that was requested as BGRA");
}

/* A texture of two texels, 0 and 1, over the whole width: linear filtering gives s. Returns the
 * largest error. */
static double filter_error(const struct canvas *canvas)
{
    double worst = 0;
    glBegin(GL_QUADS); /* s from the centre of one texel to the centre of the other */
    for (int i = 0; i < 4; i++) {
        bool right = i == 1 || i == 2;
        glTexCoord2d(right ? 0.75 : 0.25, 0.5);
        glVertex2i(right ? SIZE : 0, i < 2 ? 0 : SIZE);
    }
    glEnd();
    glFinish();
    for (int x = 0; x < SIZE; x++)
        worst = fmax(worst, fabs((double)canvas->colour[PIXELS / 2 + x][0] - (x + 0.5) / SIZE));
    return worst;
}

static void filtering(struct canvas *canvas)
{
    static const unsigned char bytes[2] = {0, 255};
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glEnable(GL_TEXTURE_2D);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE8, 2, 1, 0, GL_LUMINANCE, GL_UNSIGNED_BYTE, bytes);
    const double of_bytes = filter_error(canvas);
    printf("# filtering: %.3g of bytes\n", of_bytes);
    differ(canvas, of_bytes > 1.0 / 520, "filters bytes with weights of 8 bits", of_bytes < 1e-6,
           "filters bytes in single precision");
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
    const int strict = spectral_exit(driver, "seam", "--strict");
    differ(canvas, strict == 0, "has no holes in seam.scene", strict == 1,
           "has holes in seam.scene that --strict finds");
    needed(canvas, spectral_exit(driver, "sliver", "--unchecked 1") == 0,
           "slivers without a bound are no difference");
    known(canvas, spectral_exit(driver, "sliver", "") == canvas->llvmpipe,
          "a picture of slivers is not verified where they are drawn");
    const int blocks = spectral_exit(driver, "blocks", "");
    differ(canvas, blocks == 0, "takes the right texels in blocks.scene", blocks == 1,
           "takes wrong texels in blocks.scene, which the program finds");
}

/* ---- measuring ---- */

/* Each measurement finds the state of set_state. */
static void measure(const char *driver)
{
    static void (*const measurements[])(struct canvas *) = {slivers,  facing,    ties,    far_plane,
                                                            lighting, filtering, identity};
    static struct canvas canvas = {.random = 1};
    if (!CHECK(open_context(&canvas, OSMESA_RGBA), "%s: there is a context", driver))
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
    buffer_order(&canvas);
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
