/* SPDX-License-Identifier: MIT */
/* The room "volumes": the shadows of objects as closed meshes, which OpenGL counts in its stencil
 * buffer and bounds follow (Crow 1977; counted behind the surface: Everitt and Kilgard 2002). A
 * volume begins with the triangles of an object, ends with the same ones beyond all that is in
 * view, scaled from the light or shifted, and has sides along the edges where they end. */
#ifndef RASTER_VOLUMES_VOLUMES_H
#define RASTER_VOLUMES_VOLUMES_H

#include "raster/bounds/bounds.h"

/* The volume of an object and a light. Triangles go round counter-clockwise, seen from outside; but
 * from n_outward on clockwise, as the object has them. */
struct volume {
    int shadowed;     /* the number of the light: see light_group */
    int instance;     /* one that throws it; its matrix places the volume */
    int n, n_outward; /* triangles */
    int n_caps;       /* the first ones, and those from n_outward on, repeat triangles: they are
                         cut in depth as those are. Depths of the others are clamped */
    int first_beyond; /* these and the following ones are what of cut caps lies beyond the far
                         plane */
    int first_far;    /* these and the following ones up to n_outward are the far end, and what
                         of the object lies beyond the far plane as a whole */
    struct occluder *caps;   /* the triangle that this one repeats; surface -1: none; owned */
    bool is_doubtful;        /* the light is so near that the far end may lie too near */
    struct vertex *vertices; /* as of the mesh; this and the next one are owned */
    int32_t (*triangles)[3];
    int n_vertices;
};
struct volumes {
    struct volume *list; /* owned */
    int n;
    struct placed_instance *instances; /* the same volumes, placed; owned */
    struct lit_scene lit;              /* of these */
};
/* Makes the volumes of all shadows that a scene throws into view. The scene must outlive *out.
 * volumes_free accepts what a failure left. */
bool volumes_make(const struct lit_scene *lit, struct volumes *out, struct error *err);
void volumes_free(struct volumes *volumes);
/* Writes the corners of some triangles of a volume, one behind the other: the place of each, and
 * then `step` - 3 numbers that stay as they are. */
void volume_corners(const struct volume *volume, int first, int n, size_t step, float *out);

#endif
