/* SPDX-License-Identifier: MIT */
/* The least that a program with OSMesa does: it clears 64 x 64 pixels, draws one lit triangle and
 * reads it back. ratios.py compares its seconds, from start to exit, with those of a small scene.
 */
#include <stdio.h>
#include <stdlib.h>

#include <GL/osmesa.h>

enum { SIZE = 64 };
static float drawn[SIZE * SIZE * 4], read_back[SIZE * SIZE * 4];

int main(void)
{
    OSMesaContext context = OSMesaCreateContextExt(OSMESA_RGBA, 24, 8, 0, NULL);
    if (!context || !OSMesaMakeCurrent(context, drawn, GL_FLOAT, SIZE, SIZE))
        return 3;
    glEnable(GL_LIGHTING);
    glEnable(GL_LIGHT0);
    glEnable(GL_DEPTH_TEST);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glBegin(GL_TRIANGLES);
    glNormal3f(0, 0, 1);
    glVertex3f(-0.5f, -0.5f, 0);
    glVertex3f(0.5f, -0.5f, 0);
    glVertex3f(0, 0.5f, 0);
    glEnd();
    glFinish();
    glReadPixels(0, 0, SIZE, SIZE, GL_RGBA, GL_FLOAT, read_back);
    const float middle = read_back[4 * (SIZE * SIZE / 2 + SIZE / 2)];
    printf("%g\n", (double)middle);
    OSMesaDestroyContext(context);
    return middle > 0 ? 0 : 1;
}
