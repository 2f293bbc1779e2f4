/* SPDX-License-Identifier: MIT */
/* level: full; packages: libosmesa6-dev */
/* Measures, through OSMesa, how Mesa's two software drivers differ from OpenGL and from each other,
 * and the behaviour of both that the program relies on. test/README.md explains each measurement.
 * Facts about Mesa must hold in 22.3.6; if another version behaves otherwise, the test says so and
 * skips the fact. Behaviour that the program relies on must hold in every version. */
#include <stdint.h>
#include <sys/wait.h>
#include <unistd.h>

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
/* after GL/gl.h, which osmesa.h includes */
#include <GL/glext.h>

#include "test.h"

#define MEASURED_VERSION "Mesa 22.3.6"

enum { SIZE = 256, SUBPIXELS = 256, DEPTH_MAX = 0xffffff };

/* Rows run upwards, as in OpenGL's window coordinates. */
struct canvas {
    float colour[SIZE][SIZE][4];        /* OSMesa's buffer */
    uint32_t depth_stencil[SIZE][SIZE]; /* from the last material(): 24 bits above 8 */
    uint64_t random;
};

enum { INSIDE, CLIPPED, MESHES };
enum { COLLINEAR, NEARLY_COLLINEAR, SLIVERS };
enum { ONE_SIDE_ZERO, BOTH_ZERO, POWERS };
enum { BYTE_TEXELS, FLOAT_TEXELS, TEXELS };
enum { SMALLEST, SMALL, LARGE, LARGEST, LENGTHS };

/* Measured facts about a driver. Counts are pixels unless noted. */
struct facts {
    char renderer[64], version[64];
    bool left, right, top, bottom; /* does a rectangle draw an edge that meets pixel centres? */
    long edge_centres, off_left_bottom, off_right_top, off_edges;
    struct {
        long pixels, holes, doubles;
    } mesh[MESHES];
    struct {
        long pixels, not_finite, depth_passed;
        double largest; /* colour, of 1 */
    } sliver[SLIVERS];
    long front_triangles, front_as_back;
    long depths, floored, rounded;
    long tie_pixels, less_second, lequal_first, turned_second;
    long far_pixels, far_lost, far_carried, far_carried_less;
    uint32_t far_example;
    double power[POWERS], power_error; /* relative */
    double normal[LENGTHS], singular;
    double clamped[2], unclamped[2];
    double before_finish, after_finish, cleared[2], bgra_first;
    double texture_error[TEXELS];
    long identity_pixels, identity_colours, identity_counts, identity_coverage, identity_depths;
    long fragments;
    unsigned gl_error;
};

/* ---- the canvas ---- */

/* Knuth's MMIX constants, so that every machine draws the same numbers. */
static uint32_t random_bits(struct canvas *canvas)
{
    canvas->random = canvas->random * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(canvas->random >> 33);
}

static double random_in(struct canvas *canvas, double low, double high)
{
    return low + (high - low) * random_bits(canvas) / 2147483648.0;
}

static bool open_context(struct canvas *canvas, int format)
{
    int attributes[] = {OSMESA_FORMAT,
                        format,
                        OSMESA_DEPTH_BITS,
                        24,
                        OSMESA_STENCIL_BITS,
                        8,
                        OSMESA_PROFILE,
                        OSMESA_COMPAT_PROFILE,
                        0};
    OSMesaContext context = OSMesaCreateContextAttribs(attributes, NULL);
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

static int fragments_at(const struct canvas *canvas, int x, int y)
{
    return (int)(canvas->depth_stencil[y][x] & 0xff);
}

static uint32_t depth_at(const struct canvas *canvas, int x, int y)
{
    return canvas->depth_stencil[y][x] >> 8;
}

static void draw_triangle(double corner[3][3], int first)
{
    glBegin(GL_TRIANGLES);
    for (int i = 0; i < 3; i++)
        glVertex3dv(corner[(first + i) % 3]);
    glEnd();
}

/* ---- coverage ---- */

static void rectangle_rule(struct canvas *canvas, struct facts *facts)
{
    clear();
    glRectf(2.5F, 2.5F, 6.5F, 6.5F);
    shaded(canvas);
    facts->left = fragments_at(canvas, 2, 4);
    facts->right = fragments_at(canvas, 6, 4);
    facts->bottom = fragments_at(canvas, 4, 2);
    facts->top = fragments_at(canvas, 4, 6);
}

/* Corners are in subpixels. The first edge runs through a pixel centre in a direction of small
 * integers, and so through many centres. */
static void random_corners(struct canvas *canvas, long corner[3][2])
{
    for (int j = 0; j < 2; j++) {
        long centre = SUBPIXELS / 2 + SUBPIXELS * (long)(40 + random_bits(canvas) % 48);
        long step = (long)(random_bits(canvas) % 17) - 8;
        corner[0][j] = centre;
        corner[1][j] = step;
        corner[2][j] = (long)(random_bits(canvas) % (128 * SUBPIXELS));
    }
    long back = (long)(random_bits(canvas) % 1000) + 1, ahead = (long)(random_bits(canvas) % 1000);
    for (int j = 0; j < 2; j++) {
        long centre = corner[0][j], step = corner[1][j];
        corner[0][j] = centre - back * step;
        corner[1][j] = centre + ahead * step;
    }
}

/* Says where a pixel's centre lies: on an edge that the rule for left and bottom edges draws, or on
 * one that the rule for right and top edges draws. At a corner neither rule may draw it. */
enum { OUT, IN, ON_LEFT_BOTTOM, ON_RIGHT_TOP, ON_CORNER };
static int exact_place(long corner[3][2], long x, long y)
{
    long area = (corner[1][0] - corner[0][0]) * (corner[2][1] - corner[0][1]) -
                (corner[2][0] - corner[0][0]) * (corner[1][1] - corner[0][1]);
    bool left_bottom = true, right_top = true, on_edge = false;
    if (area == 0)
        return OUT;
    for (int i = 0; i < 3; i++) {
        const long *a = corner[i], *b = corner[(i + 1) % 3];
        long dx = area > 0 ? b[0] - a[0] : a[0] - b[0], dy = area > 0 ? b[1] - a[1] : a[1] - b[1];
        long e = dx * (y - a[1]) - dy * (x - a[0]);
        if (e < 0)
            return OUT;
        if (e > 0)
            continue;
        /* anticlockwise: the inside lies to the left of (dx, dy) */
        bool drawn_first = dy != 0 ? dy < 0 : dx > 0;
        left_bottom = left_bottom && drawn_first;
        right_top = right_top && !drawn_first;
        on_edge = true;
    }
    if (!on_edge)
        return IN;
    return left_bottom ? ON_LEFT_BOTTOM : right_top ? ON_RIGHT_TOP : ON_CORNER;
}

static void compare_rules(const struct canvas *canvas, long corner[3][2], struct facts *facts)
{
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            bool drawn = fragments_at(canvas, x, y);
            int place =
                exact_place(corner, SUBPIXELS * x + SUBPIXELS / 2, SUBPIXELS * y + SUBPIXELS / 2);
            if (place == OUT || place == IN) {
                facts->off_edges += drawn != (place == IN);
                continue;
            }
            facts->edge_centres++;
            facts->off_left_bottom += drawn != (place == ON_LEFT_BOTTOM);
            facts->off_right_top += drawn != (place == ON_RIGHT_TOP);
        }
}

static void fill_rule(struct canvas *canvas, struct facts *facts)
{
    rectangle_rule(canvas, facts);
    for (int i = 0; i < 1000; i++) {
        long corner[3][2];
        random_corners(canvas, corner);
        clear();
        glBegin(GL_TRIANGLES);
        for (int c = 0; c < 3; c++)
            glVertex2d((double)corner[c][0] / SUBPIXELS, (double)corner[c][1] / SUBPIXELS);
        glEnd();
        shaded(canvas);
        compare_rules(canvas, corner, facts);
    }
}

enum { CELLS = 12 };

/* Makes a net of triangles around the middle of the canvas. All corners lie at pixel centres; the
 * inner ones are moved at random. */
static void random_net(struct canvas *canvas, double cell, double net[CELLS + 1][CELLS + 1][2])
{
    for (int i = 0; i <= CELLS; i++)
        for (int j = 0; j <= CELLS; j++)
            for (int k = 0; k < 2; k++) {
                int at = k ? j : i;
                double shake = at > 0 && at < CELLS ? random_in(canvas, -0.2, 0.2) : 0;
                net[i][j][k] = floor(SIZE / 2 + (at - CELLS / 2 + shake) * cell) + 0.5;
            }
}

static void draw_net(double net[CELLS + 1][CELLS + 1][2])
{
    glBegin(GL_TRIANGLES);
    for (int i = 0; i < CELLS; i++)
        for (int j = 0; j < CELLS; j++) {
            const double *quad[4] = {net[i][j], net[i + 1][j], net[i + 1][j + 1], net[i][j + 1]};
            int turn = (i + j) & 1;
            static const int order[6] = {0, 1, 2, 0, 2, 3};
            for (int k = 0; k < 6; k++)
                glVertex2dv(quad[(order[k] + turn) % 4]);
        }
    glEnd();
}

/* Counts holes and doubles: every pixel inside the net should be drawn once. A larger net is
 * clipped at the canvas. */
static void shared_edges(struct canvas *canvas, struct facts *facts)
{
    static const double cell[MESHES] = {20, 40};
    static const int border[MESHES] = {10, 0};
    for (int kind = 0; kind < MESHES; kind++)
        for (int i = 0; i < 100; i++) {
            double net[CELLS + 1][CELLS + 1][2];
            random_net(canvas, cell[kind], net);
            clear();
            draw_net(net);
            shaded(canvas);
            for (int y = border[kind]; y < SIZE - border[kind]; y++)
                for (int x = border[kind]; x < SIZE - border[kind]; x++) {
                    facts->mesh[kind].pixels++;
                    facts->mesh[kind].holes += fragments_at(canvas, x, y) == 0;
                    facts->mesh[kind].doubles += fragments_at(canvas, x, y) > 1;
                }
        }
}

/* ---- slivers ---- */

/* Three corners on one line on a grid of 1/1024 pixel, the middle one beside a pixel's centre, then
 * moved upwards. */
static void random_sliver(struct canvas *canvas, double off, double corner[3][3])
{
    double back = random_bits(canvas) % 4 + 1, ahead = random_bits(canvas) % 4 + 1;
    for (int j = 0; j < 2; j++) {
        double aside = (random_bits(canvas) % 5 - 2.0) / 1024;
        double middle = floor(random_in(canvas, 60, 190)) + 0.5 + aside;
        double step = floor(random_in(canvas, -8, 8) * 1024) / 1024;
        corner[0][j] = middle - back * step;
        corner[1][j] = middle + (j == 1 ? off : 0);
        corner[2][j] = middle + ahead * step;
    }
    for (int i = 0; i < 3; i++)
        corner[i][2] = 0.25 * (i + 1);
}

static void add_sliver_pixels(const struct canvas *canvas, int kind, struct facts *facts)
{
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            if (!fragments_at(canvas, x, y))
                continue;
            const float *colour = canvas->colour[y][x];
            bool finite = true;
            for (int c = 0; c < 3; c++) {
                finite = finite && isfinite(colour[c]);
                if (isfinite(colour[c]))
                    facts->sliver[kind].largest =
                        fmax(facts->sliver[kind].largest, fabs((double)colour[c]));
            }
            facts->sliver[kind].pixels++;
            facts->sliver[kind].not_finite += !finite;
            facts->sliver[kind].depth_passed += depth_at(canvas, x, y) < DEPTH_MAX;
        }
}

static void slivers(struct canvas *canvas, struct facts *facts)
{
    static const double off[SLIVERS] = {0, 1.0 / 16384};
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    for (int kind = 0; kind < SLIVERS; kind++)
        for (int i = 0; i < 3000; i++) {
            double corner[3][3];
            random_sliver(canvas, off[kind], corner);
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
            add_sliver_pixels(canvas, kind, facts);
        }
    glDisable(GL_DEPTH_TEST);
    glColor3f(1, 1, 1);
}

/* Draws slivers that run only just anticlockwise, with front faces culled. */
static void facing(struct canvas *canvas, struct facts *facts)
{
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
        for (int y = 0; y < SIZE; y++)
            for (int x = 0; x < SIZE; x++)
                drawn += fragments_at(canvas, x, y);
        facts->front_triangles++;
        facts->front_as_back += drawn > 0;
    }
    glDisable(GL_CULL_FACE);
}

/* ---- depth ---- */

static void depth_rounding(struct canvas *canvas, struct facts *facts)
{
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_ALWAYS);
    for (int row = 0; row < 16; row++) {
        double z[SIZE];
        clear();
        for (int x = 0; x < SIZE; x++) {
            z[x] = (random_bits(canvas) % 65537) / 65536.0;
            glBegin(GL_QUADS);
            glVertex3d(x, 0, z[x]);
            glVertex3d(x + 1, 0, z[x]);
            glVertex3d(x + 1, 1, z[x]);
            glVertex3d(x, 1, z[x]);
            glEnd();
        }
        shaded(canvas);
        for (int x = 0; x < SIZE; x++) {
            facts->depths++;
            facts->floored += depth_at(canvas, x, 0) == floor(z[x] * DEPTH_MAX);
            facts->rounded += depth_at(canvas, x, 0) == floor(z[x] * DEPTH_MAX + 0.5);
        }
    }
    glDisable(GL_DEPTH_TEST);
}

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
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            second += canvas->colour[y][x][1] > 0;
            *pixels += canvas->colour[y][x][0] > 0 || canvas->colour[y][x][1] > 0;
        }
    return second;
}

static void ties(struct canvas *canvas, struct facts *facts)
{
    glEnable(GL_DEPTH_TEST);
    for (int i = 0; i < 200; i++) {
        double corner[3][3];
        long pixels = 0, other = 0;
        for (int c = 0; c < 3; c++)
            for (int j = 0; j < 3; j++)
                corner[c][j] = random_in(canvas, 0, j < 2 ? SIZE : 1);
        facts->less_second += second_shows(canvas, corner, GL_LESS, 0, &facts->tie_pixels);
        long shown = second_shows(canvas, corner, GL_LEQUAL, 0, &pixels);
        facts->lequal_first += pixels - shown;
        facts->turned_second += second_shows(canvas, corner, GL_LESS, 1, &other);
    }
    glDisable(GL_DEPTH_TEST);
    glColor3f(1, 1, 1);
}

/* Draws a triangle with an edge on the far plane; the edge runs through pixel centres. */
static void random_far_triangle(struct canvas *canvas, double corner[3][3])
{
    for (int j = 0; j < 2; j++) {
        double step = random_bits(canvas) % 3 - 1.0;
        corner[0][j] = random_bits(canvas) % 20 + 210.5;
        corner[1][j] = corner[0][j] + 12 * step;
        corner[2][j] = corner[0][j] + random_in(canvas, -8, 8);
    }
    for (int i = 0; i < 3; i++)
        corner[i][2] = i < 2 ? 1 : 0.75;
}

/* Every drawn fragment must have a depth of at least 0.75 and leave the stencil as it was. */
static void far_plane(struct canvas *canvas, struct facts *facts)
{
    glEnable(GL_DEPTH_TEST);
    glDisable(GL_STENCIL_TEST);
    for (int i = 0; i < 4000; i++) {
        double corner[3][3];
        random_far_triangle(canvas, corner);
        clear();
        glDepthFunc(i % 2 == 0 ? GL_ALWAYS : GL_LESS);
        draw_triangle(corner, 0);
        shaded(canvas);
        for (int y = 0; y < SIZE; y++)
            for (int x = 0; x < SIZE; x++) {
                bool carried = fragments_at(canvas, x, y) != 0;
                facts->far_pixels += canvas->colour[y][x][0] > 0;
                facts->far_lost += depth_at(canvas, x, y) < DEPTH_MAX / 2;
                facts->far_carried += carried;
                facts->far_carried_less += carried && i % 2 == 1;
                if (carried)
                    facts->far_example = canvas->depth_stencil[y][x];
            }
    }
    glEnable(GL_STENCIL_TEST);
    glDisable(GL_DEPTH_TEST);
}

/* ---- lighting ---- */

static const GLfloat white[4] = {1, 1, 1, 1}, black[4] = {0, 0, 0, 1};

/* Returns the red of a rectangle with this normal. */
static double lit(const struct canvas *canvas, double x, double y, double z)
{
    glNormal3d(x, y, z);
    glRectf(0, 0, 2, 2);
    glFinish();
    return (double)canvas->colour[0][0][0];
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
static void zero_power(struct canvas *canvas, struct facts *facts)
{
    set_material(black, white);
    direct_light(1, 0, 0);
    glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, 1);
    for (int kind = 0; kind < POWERS; kind++) {
        glMaterialf(GL_FRONT, GL_SHININESS, 0);
        glMaterialf(GL_BACK, GL_SHININESS, kind == ONE_SIDE_ZERO ? 20 : 0);
        facts->power[kind] = lit(canvas, 1, 0, -1);
    }
    glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, 0);
}

/* Without GL_NORMALIZE a normal (0, 0, h) gives the highlight h^128. */
static void power_accuracy(struct canvas *canvas, struct facts *facts)
{
    glDisable(GL_NORMALIZE);
    direct_light(0, 0, 1);
    glMaterialf(GL_FRONT_AND_BACK, GL_SHININESS, 128);
    for (int i = 0; i < 500; i++) {
        double h = (double)(float)random_in(canvas, 0.52, 1), expected = pow(h, 128);
        double error = fabs(lit(canvas, 0, 0, h) - expected) / expected;
        facts->power_error = fmax(facts->power_error, error);
    }
    glEnable(GL_NORMALIZE);
}

static void normals(struct canvas *canvas, struct facts *facts)
{
    static const double length[LENGTHS] = {1e-19, 2e-19, 1e19, 1e20};
    set_material(white, black);
    for (int i = 0; i < LENGTHS; i++)
        facts->normal[i] = lit(canvas, 0, 0, length[i]);
    glScalef(1, 1, 0);
    facts->singular = lit(canvas, 0.6, 0, 0.8);
    glLoadIdentity();
}

static void lighting(struct canvas *canvas, struct facts *facts)
{
    glEnable(GL_LIGHTING);
    glEnable(GL_LIGHT0);
    glEnable(GL_NORMALIZE);
    glLightModelfv(GL_LIGHT_MODEL_AMBIENT, black);
    zero_power(canvas, facts);
    power_accuracy(canvas, facts);
    normals(canvas, facts);
    glDisable(GL_LIGHTING);
}

/* ---- buffers and textures ---- */

static void buffers(struct canvas *canvas, struct facts *facts)
{
    glClearColor(2, -1, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    facts->before_finish = (double)canvas->colour[0][0][0];
    glFinish();
    facts->after_finish = (double)canvas->colour[0][0][0];
    for (int i = 0; i < 2; i++)
        facts->cleared[i] = (double)canvas->colour[0][0][i];
    glColor3f(2, -1, 0);
    glRectf(-1, -1, 1, 1);
    glFinish();
    for (int i = 0; i < 2; i++)
        facts->clamped[i] = (double)canvas->colour[0][0][i];
    glClampColorARB(GL_CLAMP_VERTEX_COLOR_ARB, GL_FALSE);
    glRectf(-1, -1, 1, 1);
    glFinish();
    for (int i = 0; i < 2; i++)
        facts->unclamped[i] = (double)canvas->colour[0][0][i];
}

/* Returns the first number of a red pixel in a buffer that was requested as BGRA. */
static void buffer_order(struct canvas *canvas, struct facts *facts)
{
    if (!open_context(canvas, OSMESA_BGRA))
        return;
    glClearColor(1, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    glFinish();
    facts->bgra_first = (double)canvas->colour[0][0][0];
}

/* A texture of two texels, 0 and 1, over the whole width: linear filtering gives s. */
static void filtering(struct canvas *canvas, struct facts *facts)
{
    static const unsigned char bytes[2] = {0, 255};
    static const float floats[2] = {0, 1};
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glEnable(GL_TEXTURE_2D);
    for (int kind = 0; kind < TEXELS; kind++) {
        if (kind == BYTE_TEXELS)
            glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE8, 2, 1, 0, GL_LUMINANCE, GL_UNSIGNED_BYTE,
                         bytes);
        else
            glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE32F_ARB, 2, 1, 0, GL_LUMINANCE, GL_FLOAT,
                         floats);
        glBegin(GL_QUADS); /* s from the centre of one texel to the centre of the other */
        for (int i = 0; i < 4; i++) {
            bool right = i == 1 || i == 2;
            glTexCoord2d(right ? 0.75 : 0.25, 0.5);
            glVertex2i(right ? SIZE : 0, i < 2 ? 0 : SIZE);
        }
        glEnd();
        glFinish();
        for (int x = 0; x < SIZE; x++) {
            double error = fabs((double)canvas->colour[SIZE / 2][x][0] - (x + 0.5) / SIZE);
            facts->texture_error[kind] = fmax(facts->texture_error[kind], error);
        }
    }
    glDisable(GL_TEXTURE_2D);
}

/* ---- one triangle a pixel, named by its colour ---- */

enum { TRIANGLES = 1000, CORNERS = 3 * TRIANGLES };

struct soup {
    float position[CORNERS][3], normal[CORNERS][3], name[CORNERS][3];
    unsigned index[CORNERS];
};

/* Makes triangles of several sizes; some cross the near plane. */
static void random_soup(struct canvas *canvas, struct soup *soup)
{
    for (int t = 0; t < TRIANGLES; t++) {
        double middle[3], size = t % 10 == 0 ? 4 : 0.3;
        for (int j = 0; j < 3; j++)
            middle[j] = random_in(canvas, j < 2 ? -4 : -12, j < 2 ? 4 : 1);
        for (int i = 3 * t; i < 3 * t + 3; i++) {
            for (int j = 0; j < 3; j++) {
                soup->position[i][j] = (float)(middle[j] + random_in(canvas, -size, size));
                soup->normal[i][j] = (float)random_in(canvas, -1, 1);
            }
            soup->name[i][0] = (float)(t + 1);
            soup->name[i][1] = (float)(16777216 - t);
            soup->name[i][2] = (float)(random_bits(canvas) % 16777217);
            soup->index[i] = (unsigned)i;
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

static void draw_lit(const struct soup *soup, bool local)
{
    GLuint buffer[3];
    clear();
    glEnable(GL_LIGHTING);
    glDisable(GL_STENCIL_TEST);
    glLightModelfv(GL_LIGHT_MODEL_AMBIENT, white);
    glLightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, local);
    glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, !local);
    glLightfv(GL_LIGHT0, GL_POSITION, (GLfloat[4]){1, 2, 3, local ? 1 : 0});
    set_material(white, white);
    glGenBuffers(3, buffer);
    glBindBuffer(GL_ARRAY_BUFFER, buffer[0]);
    glBufferData(GL_ARRAY_BUFFER, sizeof soup->position, soup->position, GL_STATIC_DRAW);
    glVertexPointer(3, GL_FLOAT, 0, NULL);
    glBindBuffer(GL_ARRAY_BUFFER, buffer[1]);
    glBufferData(GL_ARRAY_BUFFER, sizeof soup->normal, soup->normal, GL_STATIC_DRAW);
    glNormalPointer(GL_FLOAT, 0, NULL);
    glEnableClientState(GL_NORMAL_ARRAY);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer[2]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof soup->index, soup->index, GL_STATIC_DRAW);
    glDrawElements(GL_TRIANGLES, CORNERS, GL_UNSIGNED_INT, NULL);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);
    glDeleteBuffers(3, buffer);
    glDisableClientState(GL_NORMAL_ARRAY);
    glEnable(GL_STENCIL_TEST);
    glDisable(GL_LIGHTING);
}

static void check_names(const struct canvas *canvas, const struct soup *soup, struct facts *facts)
{
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            const float *colour = canvas->colour[y][x];
            if (!fragments_at(canvas, x, y))
                continue;
            int triangle = (int)colour[0] - 1;
            facts->identity_pixels++;
            facts->identity_colours +=
                triangle < 0 || triangle >= TRIANGLES ||
                memcmp(colour, soup->name[3 * triangle + 2], sizeof soup->name[0]) != 0;
        }
}

/* Compares the stencil of all triangles at once with the sum of the stencils of each alone. */
static void check_counts(struct canvas *canvas, const struct soup *soup, struct facts *facts)
{
    static const int some = TRIANGLES / 2;
    long(*sum)[SIZE] = calloc(SIZE, sizeof *sum);
    for (int i = 0; i < some && sum; i++) {
        draw_names(soup, 3 * i, 3);
        shaded(canvas);
        for (int y = 0; y < SIZE; y++)
            for (int x = 0; x < SIZE; x++)
                sum[y][x] += fragments_at(canvas, x, y);
    }
    draw_names(soup, 0, 3 * some);
    shaded(canvas);
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            facts->fragments += sum ? sum[y][x] : 0;
            facts->identity_counts += !sum || sum[y][x] != fragments_at(canvas, x, y);
        }
    free(sum);
}

static void compare_passes(struct canvas *names, const struct canvas *colours, struct facts *facts)
{
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            facts->identity_coverage +=
                (fragments_at(names, x, y) > 0) != (colours->colour[y][x][3] > 0);
            facts->identity_depths += depth_at(names, x, y) != depth_at(colours, x, y);
        }
}

static void identity(struct canvas *canvas, struct facts *facts)
{
    struct soup *soup = malloc(sizeof *soup);
    struct canvas *names = malloc(sizeof *names);
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glFrustum(-0.5, 0.5, -0.5, 0.5, 1, 20);
    glMatrixMode(GL_MODELVIEW);
    glRotated(33, 1, 0.3, 0.2);
    glScaled(1.1, 0.9, 1.05);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glEnableClientState(GL_VERTEX_ARRAY);
    for (int i = 0; i < 6 && soup && names; i++) {
        random_soup(canvas, soup);
        if (i == 0)
            check_counts(canvas, soup, facts);
        draw_names(soup, 0, CORNERS);
        shaded(canvas);
        check_names(canvas, soup, facts);
        *names = *canvas;
        draw_lit(soup, i % 2);
        shaded(canvas);
        compare_passes(names, canvas, facts);
    }
    free(soup);
    free(names);
}

/* ---- measuring ---- */

static bool measure(struct facts *facts)
{
    struct canvas *canvas = calloc(1, sizeof *canvas);
    if (!canvas || !open_context(canvas, OSMESA_RGBA))
        return false;
    canvas->random = 1;
    snprintf(facts->renderer, sizeof facts->renderer, "%s", (const char *)glGetString(GL_RENDERER));
    snprintf(facts->version, sizeof facts->version, "%s", (const char *)glGetString(GL_VERSION));
    buffers(canvas, facts);
    set_state();
    fill_rule(canvas, facts);
    shared_edges(canvas, facts);
    slivers(canvas, facts);
    facing(canvas, facts);
    depth_rounding(canvas, facts);
    ties(canvas, facts);
    far_plane(canvas, facts);
    lighting(canvas, facts);
    filtering(canvas, facts);
    identity(canvas, facts);
    facts->gl_error = glGetError();
    buffer_order(canvas, facts);
    free(canvas);
    return true;
}

/* A process can choose its driver only once, so each driver is measured in its own process. Returns
 * the end of a pipe that delivers the facts. */
static int start_measuring(const char *driver, pid_t *child)
{
    int ends[2];
    if (pipe(ends) != 0)
        return -1;
    *child = fork();
    if (*child != 0) {
        close(ends[1]);
        return ends[0];
    }
    struct facts facts = {.gl_error = 0};
    setenv("GALLIUM_DRIVER", driver, 1);
    setenv("LP_NUM_THREADS", "1", 1);
    bool whole = measure(&facts) && write(ends[1], &facts, sizeof facts) == sizeof facts;
    _exit(whole ? 0 : 1);
}

static bool fetch_facts(int end, pid_t child, struct facts *out)
{
    int status = 1;
    bool whole = read(end, out, sizeof *out) == sizeof *out;
    close(end);
    return waitpid(child, &status, 0) == child && status == 0 && whole;
}

/* ---- facts ---- */

/* Checks a fact about the version that was measured; skips it in another version that differs. */
static void known(const struct facts *facts, bool holds, const char *standard)
{
    const char *driver = strncmp(facts->renderer, "llvmpipe", 8) == 0 ? "llvmpipe" : "softpipe";
    if (holds || strstr(facts->version, MEASURED_VERSION))
        CHECK(holds, "%s %s", driver, standard);
    else
        printf("ok %d # SKIP not so in %s: %s %s\n", ++test_count, facts->version, driver,
               standard);
}

static void print_coverage(const struct facts *f)
{
    static const char *const net[MESHES] = {"net", "clipped net"};
    static const char *const sliver[SLIVERS] = {"collinear", "nearly collinear"};
    printf("# %s, %s\n", f->renderer, f->version);
    printf("# fill rule: %ld centres on edges; %ld off left+bottom, %ld off right+top; %ld off "
           "edges\n",
           f->edge_centres, f->off_left_bottom, f->off_right_top, f->off_edges);
    for (int i = 0; i < MESHES; i++)
        printf("# %s: %ld pixels, %ld holes, %ld doubles\n", net[i], f->mesh[i].pixels,
               f->mesh[i].holes, f->mesh[i].doubles);
    for (int i = 0; i < SLIVERS; i++)
        printf("# %s: %ld fragments, %ld not finite, %ld passed, largest colour %g\n", sliver[i],
               f->sliver[i].pixels, f->sliver[i].not_finite, f->sliver[i].depth_passed,
               f->sliver[i].largest);
    printf("# facing: %ld of %ld front faces drawn as back\n", f->front_as_back,
           f->front_triangles);
}

static void print_values(const struct facts *f)
{
    printf("# depth: %ld values, %ld floored, %ld rounded\n", f->depths, f->floored, f->rounded);
    printf("# ties: %ld pixels, LESS %ld, LEQUAL %ld, turned %ld\n", f->tie_pixels, f->less_second,
           f->lequal_first, f->turned_second);
    printf("# far plane: %ld pixels, %ld lost, %ld carried (0x%08x)\n", f->far_pixels, f->far_lost,
           f->far_carried, (unsigned)f->far_example);
    printf("# 0^0 beside 20: %g, beside 0: %g; h^128: relative error %.3g\n",
           f->power[ONE_SIDE_ZERO], f->power[BOTH_ZERO], f->power_error);
    printf("# normals: %g %g %g %g, singular %g\n", f->normal[SMALLEST], f->normal[SMALL],
           f->normal[LARGE], f->normal[LARGEST], f->singular);
    printf("# filtering: %.3g of bytes, %.3g of floats\n", f->texture_error[BYTE_TEXELS],
           f->texture_error[FLOAT_TEXELS]);
    printf("# names: %ld pixels, %ld fragments\n", f->identity_pixels, f->fragments);
}

static void check_llvmpipe(const struct facts *f)
{
    known(f, f->left && f->bottom && !f->right && !f->top, "draws left and bottom edges");
    known(f, f->edge_centres > 5000 && f->off_left_bottom == 0 && f->off_edges == 0,
          "follows that rule on edges of any slope");
    known(f, f->mesh[INSIDE].holes + f->mesh[INSIDE].doubles == 0, "draws shared edges once");
    known(f, f->mesh[CLIPPED].holes + f->mesh[CLIPPED].doubles == 0,
          "draws shared edges of clipped triangles once");
    known(f, f->sliver[COLLINEAR].pixels > 0, "draws fragments of triangles without area");
    known(f, f->sliver[COLLINEAR].not_finite == f->sliver[COLLINEAR].pixels,
          "gives triangles without area no finite colour");
    known(f, f->sliver[COLLINEAR].depth_passed == 0, "lets no fragment of them pass a depth test");
    known(f, f->sliver[NEARLY_COLLINEAR].largest > 10,
          "extrapolates on slivers to more than ten times the largest colour");
    known(f, f->front_as_back > 0, "takes slivers' front faces for back faces");
    known(f, f->rounded == f->depths && f->floored < f->depths, "rounds depth to nearest");
    known(f, f->turned_second > 0, "breaks ties of triangles that begin at another corner");
    known(f, f->far_lost == 0 && f->far_carried == 0, "clamps depth at the far plane");
    known(f, f->power[ONE_SIDE_ZERO] == 0, "gives 0^0 = 0 where only one side has shininess 0");
    known(f, f->power_error > 1e-6 && f->power_error < 2e-5, "has five digits of h^128");
    known(f, f->texture_error[BYTE_TEXELS] > 1.0 / 520, "filters bytes with weights of 8 bits");
}

static void check_softpipe(const struct facts *f)
{
    known(f, f->right && f->top && !f->left && !f->bottom, "draws right and top edges");
    known(f, f->off_right_top > 0 && f->off_right_top * 100 < f->edge_centres && f->off_edges == 0,
          "breaks that rule at less than one in a hundred centres on edges");
    known(f, f->mesh[INSIDE].holes > 0 && f->mesh[INSIDE].doubles > 0,
          "leaves holes and doubles on shared edges");
    known(f, f->mesh[CLIPPED].holes > 0 && f->mesh[CLIPPED].doubles > 0,
          "leaves holes and doubles on shared edges of clipped triangles");
    known(f, f->sliver[COLLINEAR].pixels == 0, "draws no triangles without area");
    known(f, f->front_as_back == 0, "takes no front faces for back faces");
    known(f, f->floored == f->depths && f->rounded < f->depths, "rounds depth down");
    known(f, f->turned_second == 0, "keeps ties of triangles that begin at another corner");
    known(f, f->far_lost > 0 && f->far_carried == f->far_lost,
          "makes pixels of the far plane the nearest and changes their stencil");
    known(f, f->power[ONE_SIDE_ZERO] == 1, "gives 0^0 = 1");
    known(f, f->power_error < 1e-6, "has six digits of h^128");
    known(f, f->texture_error[BYTE_TEXELS] < 1e-6, "filters bytes in single precision");
}

/* Both drivers behave alike here. */
static void check_both(const struct facts *f)
{
    known(f, f->power[BOTH_ZERO] == 1, "gives 0^0 = 1 where both sides have shininess 0");
    known(f, f->normal[SMALLEST] == 0 && f->normal[LARGEST] == 0,
          "makes normals of length 1e-19 and 1e20 black under GL_NORMALIZE");
    known(f, fabs(f->normal[SMALL] - 1) < 1e-6 && fabs(f->normal[LARGE] - 1) < 1e-6,
          "normalizes normals of length 2e-19 and 1e19");
    known(f, fabs(f->singular - 0.8) < 1e-6,
          "treats the inverse of a singular matrix as the identity");
    known(f, f->clamped[0] == 1 && f->clamped[1] == 0,
          "clamps vertex colours by default in a float buffer");
    known(f, f->before_finish == 0 && f->after_finish == 2, "fills the buffer at glFinish");
    known(f, f->bgra_first == 1, "stores RGBA in a float buffer that was requested as BGRA");
}

/* The cross-check relies on these in every version. */
static void check_needed(const struct facts *f)
{
    CHECK(f->gl_error == GL_NO_ERROR, "%s: OpenGL reports no error", f->renderer);
    CHECK(f->unclamped[0] == 2 && f->unclamped[1] == -1,
          "%s: without clamps colours keep their value", f->renderer);
    CHECK(f->cleared[0] == 2 && f->cleared[1] == -1,
          "%s: without clamps clear colours keep their value", f->renderer);
    CHECK(f->texture_error[FLOAT_TEXELS] < 1e-6, "%s: floats are filtered in single precision",
          f->renderer);
    CHECK(f->tie_pixels > 0 && f->less_second == 0 && f->lequal_first == 0,
          "%s: a triangle drawn twice is a tie everywhere", f->renderer);
    CHECK(f->far_pixels > 0 && f->far_carried_less == 0,
          "%s: under GL_LESS no depth runs over into the stencil", f->renderer);
    CHECK(f->identity_pixels > 100000 && f->identity_colours == 0,
          "%s: flat colours up to 2^24 arrive to the bit", f->renderer);
    CHECK(f->fragments > 10000 && f->identity_counts == 0, "%s: the stencil counts fragments",
          f->renderer);
    CHECK(f->identity_coverage == 0 && f->identity_depths == 0,
          "%s: flat and lit drawings cover the same pixels at the same depths", f->renderer);
}

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

static void check_program(const struct facts *f, const char *driver)
{
    bool watertight = f->mesh[INSIDE].holes == 0;
    CHECK(spectral_exit(driver, "seam", "") == 0, "%s: the program passes edge holes", driver);
    known(f, spectral_exit(driver, "seam", "--strict") == (watertight ? 0 : 1),
          watertight ? "has no holes in seam.scene"
                     : "has holes in seam.scene that --strict finds");
    CHECK(spectral_exit(driver, "sliver", "--unchecked 1") == 0,
          "%s: slivers without a bound are no difference", driver);
    known(f, spectral_exit(driver, "sliver", "") == (strcmp(driver, "llvmpipe") == 0),
          "a picture of slivers is not verified where they are drawn");
}

int main(void)
{
    enum { LLVMPIPE, SOFTPIPE, DRIVERS };
    static const char *const names[DRIVERS] = {"llvmpipe", "softpipe"};
    struct facts facts[DRIVERS] = {{.gl_error = 0}};
    pid_t child[DRIVERS];
    int end[DRIVERS];
    for (int i = 0; i < DRIVERS; i++)
        end[i] = start_measuring(names[i], &child[i]);
    for (int i = 0; i < DRIVERS; i++) {
        bool whole = end[i] >= 0 && fetch_facts(end[i], child[i], &facts[i]);
        bool right = strncmp(facts[i].renderer, names[i], strlen(names[i])) == 0;
        if (!CHECK(whole, "%s was measured", names[i]))
            continue;
        if (!right) { /* Mesa was built without this driver */
            printf("ok %d # SKIP OSMesa gives %s for %s\n", ++test_count, facts[i].renderer,
                   names[i]);
            continue;
        }
        print_coverage(&facts[i]);
        print_values(&facts[i]);
        if (i == LLVMPIPE)
            check_llvmpipe(&facts[i]);
        else
            check_softpipe(&facts[i]);
        check_both(&facts[i]);
        check_needed(&facts[i]);
        check_program(&facts[i], names[i]);
    }
    return test_end();
}
