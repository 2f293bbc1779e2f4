/* SPDX-License-Identifier: MIT */
/* How spectral works, on one page. OpenGL draws a sphere under a lamp, three wavelengths a pass. A
 * rasterizer in double precision, the reference, says what each sample must be. The samples become
 * a TIFF stack: a page of 16 bits for each wavelength. `spectral render` makes the same samples,
 * within 1 count of 65535, from this scene:
 *
 *     size 128 128
 *     wavelengths 400 700 10
 *     camera ortho 2
 *     light blackbody:3000 1 direction 0 1 1
 *     material paint { diffuse gaussian:560,150 }
 *     object sphere 1 28 16 material paint
 *
 *     gcc one-page.c -o one-page -lOSMesa -ltiff -lm && ./one-page stack.tif */
#include <GL/osmesa.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <tiffio.h>

enum { SIZE = 128, PIXELS = SIZE * SIZE, BANDS = 31, SLICES = 28, STACKS = 16 };
enum { CORNERS = 3 * 2 * SLICES * STACKS }; /* each cell of the sphere is cut into two triangles */
static const double pi = 3.14159265358979323846, full_count = 65535;

struct vertex {                 /* of a sphere of radius 1, whose normals are its positions */
    double position[3], cosine; /* cosine: between the normal and the direction of the lamp */
};

/* Radiance is spectrum x cosine, and the cosine is the same at all wavelengths: the reference is
 * drawn once. spectral adds up such terms of ambient, diffuse, specular and fluorescent light of
 * many lamps, and multiplies by textures. */
static double spectrum(int band)
{
    const double nm = 400 + 10 * band, c = 1.4387768775e7 / 3000; /* h c / k / 3000 K, in nm */
    const double lamp = pow(560 / nm, 5) * expm1(c / 560) / expm1(c / nm);
    const double reflectance = exp2(-4 * pow((nm - 560) / 150, 2));
    return lamp * reflectance;
}

/* Returns a corner of the triangles, which run counter-clockwise seen from outside. */
static struct vertex vertex_at(int corner)
{
    static const int right[] = {0, 1, 1, 0, 1, 0}, up[] = {0, 0, 1, 0, 1, 1};
    const int cell = corner / 6, slice = cell % SLICES + right[corner % 6],
              stack = cell / SLICES + up[corner % 6];
    const double longitude = 2 * pi * (slice % SLICES) / SLICES, polar = pi * stack / STACKS;
    const double x = sin(polar) * cos(longitude), y = sin(polar) * sin(longitude), z = -cos(polar);
    return (struct vertex){{x, y, z}, fmax(0, (y + z) / sqrt(2))};
}

/* Opens OpenGL, which will light the vertices itself, and draw into a frame of floats. */
static int open_opengl(const struct vertex *corners, float frame[PIXELS][4])
{
    const float towards_lamp[4] = {0, 1, 1, 0}, black[4] = {0, 0, 0, 1};
    OSMesaContext context = OSMesaCreateContextExt(OSMESA_RGBA, 24, 0, 0, NULL);
    if (!context || !OSMesaMakeCurrent(context, frame, GL_FLOAT, SIZE, SIZE))
        return 0;
    OSMesaPixelStore(OSMESA_Y_UP, 0); /* the first row is on top */
    glMatrixMode(GL_PROJECTION);
    glOrtho(-1, 1, -1, 1, -10, 10);
    glLightfv(GL_LIGHT0, GL_POSITION, towards_lamp);
    glLightModelfv(GL_LIGHT_MODEL_AMBIENT, black);
    glEnable(GL_LIGHTING);
    glEnable(GL_LIGHT0);
    glEnable(GL_DEPTH_TEST);
    glEnableClientState(GL_VERTEX_ARRAY);
    glEnableClientState(GL_NORMAL_ARRAY);
    glVertexPointer(3, GL_DOUBLE, sizeof *corners, corners->position);
    glNormalPointer(GL_DOUBLE, sizeof *corners, corners->position);
    return 1;
}

/* Draws three bands as red, green and blue, in parts of full scale. */
static void draw_pass(int first_band, double full_scale)
{
    float colour[4] = {0, 0, 0, 1};
    for (int i = 0; i < 3 && first_band + i < BANDS; i++)
        colour[i] = (float)(spectrum(first_band + i) / full_scale);
    glMaterialfv(GL_FRONT, GL_DIFFUSE, colour);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glDrawArrays(GL_TRIANGLES, 0, CORNERS);
    glFinish(); /* only now OSMesa fills the frame */
}

/* Returns the cosine of the nearest fragment at a pixel's centre; 0: background. A triangle has a
 * fragment there if none of its barycentric coordinates a, b, c is negative. spectral clips,
 * divides by w, and decides without error which of two triangles has a centre on their edge. */
static double cosine_at(const struct vertex *v, int pixel)
{
    const double x = 2 * (pixel % SIZE + 0.5) / SIZE - 1, y = 1 - 2 * (pixel / SIZE + 0.5) / SIZE;
    double nearest = -10, cosine = 0;
    for (int n = 0; n < CORNERS; n += 3, v += 3) {
        const double *p = v[0].position, *q = v[1].position, *r = v[2].position;
        const double area = (p[0] - r[0]) * (q[1] - r[1]) - (p[1] - r[1]) * (q[0] - r[0]);
        const double a = ((x - r[0]) * (q[1] - r[1]) - (y - r[1]) * (q[0] - r[0])) / area;
        const double b = ((p[0] - r[0]) * (y - r[1]) - (p[1] - r[1]) * (x - r[0])) / area;
        const double c = 1 - a - b, z = a * p[2] + b * q[2] + c * r[2];
        if (a >= 0 && b >= 0 && c >= 0 && z > nearest) {
            nearest = z;
            cosine = a * v[0].cosine + b * v[1].cosine + c * v[2].cosine;
        }
    }
    return cosine;
}

static void write_page(TIFF *stack, uint16_t counts[PIXELS])
{
    TIFFSetField(stack, TIFFTAG_IMAGEWIDTH, SIZE);
    TIFFSetField(stack, TIFFTAG_IMAGELENGTH, SIZE);
    TIFFSetField(stack, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(stack, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFWriteEncodedStrip(stack, 0, counts, PIXELS * sizeof *counts);
    TIFFWriteDirectory(stack);
}

/* A sample may be off by 1 count here. spectral derives a bound for each one, from all triangles
 * that OpenGL may show there, and writes a stack only if no sample exceeds its bound. */
int main(int argc, char **argv)
{
    static struct vertex corners[CORNERS];
    static float frame[PIXELS][4];
    static double cosines[PIXELS];
    static uint16_t counts[PIXELS];
    double full_scale = 0;
    int n_wrong = 0;
    for (int n = 0; n < CORNERS; n++)
        corners[n] = vertex_at(n);
    for (int p = 0; p < PIXELS; p++)
        cosines[p] = cosine_at(corners, p);
    for (int band = 0; band < BANDS; band++) /* the largest radiance: one vertex faces the lamp */
        full_scale = fmax(full_scale, spectrum(band));
    TIFF *stack = argc == 2 && open_opengl(corners, frame) ? TIFFOpen(argv[1], "w") : NULL;
    if (!stack)
        return 2;
    for (int band = 0; band < BANDS; band++) {
        if (band % 3 == 0)
            draw_pass(band, full_scale);
        for (int p = 0; p < PIXELS; p++) {
            const double drawn = full_count * frame[p][band % 3],
                         expected = full_count * cosines[p] * spectrum(band) / full_scale;
            n_wrong += fabs(drawn - expected) > 1;
            counts[p] = (uint16_t)lrint(drawn);
        }
        write_page(stack, counts);
    }
    TIFFClose(stack);
    printf("%d of %d samples differ\n", n_wrong, BANDS * PIXELS);
    return n_wrong > 0;
}
