/* SPDX-License-Identifier: MIT */
/* What the two files that know OpenGL share: mesa.c draws colours, identify.c the numbers of
 * triangles. Nobody else includes this. */
#ifndef MESA_H
#define MESA_H

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
/* after GL/gl.h, which osmesa.h includes */
#include <GL/glext.h>

#include "raster/raster.h"

struct gl {
    const struct plan *plan;
    const struct surface *surfaces;
    OSMesaContext context;
    OSMesaContext numbers; /* that draws into floats where `context` draws into steps; NULL: the
                              same */
    float *pixels;         /* tile_height rows of tile_width pixels of 4 floats, from the top */
    void *steps; /* the same of 4 uint8_t or uint16_t, which colours are drawn into; NULL: pixels
                    are */
    const void *current; /* which of the two is drawn into */
    float *sum;          /* the same, of all passes; NULL where there is one */
    uint32_t
        *depths;     /* the same from the bottom: 24 bits of depth, 8 of stencil; NULL: unchecked */
    GLuint *buffers; /* BUFFERS of each mesh */
    GLuint *textures; /* of each texture */
    struct tile tile;
    struct gl_work work;
};

/* ---- raster/mesa.c ---- */

/* Draws into floats from now on, or into what colours are drawn into. */
bool gl_draw_into(struct gl *gl, bool floats, struct error *err);

/* Empties the aimed tile, and leaves lighting and textures switched off. */
void gl_blacken(void);
void gl_load_matrix(const struct matrix *m);
/* False after any error since the last call. */
bool gl_succeeded(struct error *err);

#endif
