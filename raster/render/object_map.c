/* SPDX-License-Identifier: MIT */
/* The objects that the pixels of the stack show. */
#include "raster/render/inside.h"

/* Returns the number, from 1, of the object at a position of the tile. The renderer of the stored
 * pixels decides: the reference's picture, or OpenGL's last identification. An unknown surface
 * number counts as background. */
static int object_at(const struct rendering *of, const struct tile *tile, int x, int y)
{
    const struct picture *picture = &tile->chunks[y / CHUNK_ROWS].picture;
    const size_t pixel = (size_t)(y % CHUNK_ROWS) * (size_t)tile->at.width + (size_t)x;
    const int surface = of->plan->options.store_raster
                            ? picture->surface[pixel]
                            : of->renderer->kind->shown(of->renderer, x, y).surface;
    return surface < of->plan->n_instances ? surface + 1 : 0;
}

/* Returns the object that most positions of a pixel show; of equally many the one that comes first.
 */
static int pixel_object(const struct rendering *of, const struct tile *tile, int x, int y)
{
    const int side = of->plan->scene->positions, n = side * side;
    int objects[MOST_POSITIONS * MOST_POSITIONS], best = 0, most = 0;
    for (int i = 0; i < n; i++)
        objects[i] = object_at(of, tile, x * side + i % side, y * side + i / side);
    for (int i = 0; i < n && most <= n / 2; i++) {
        int count = 0;
        for (int k = 0; k < n; k++)
            count += objects[k] == objects[i];
        best = count > most ? objects[i] : best;
        most = count > most ? count : most;
    }
    return best;
}

void map_objects(const struct rendering *of, const struct tile *tile, const struct rectangle *at,
                 unsigned char *out)
{
    for (int y = 0; y < at->height; y++)
        for (int x = 0; x < at->width; x++) {
            const int object = pixel_object(of, tile, x, y);
            *out++ = (unsigned char)(object % 256);
            if (of->plan->map_bytes > 1)
                *out++ = (unsigned char)(object / 256);
        }
}
