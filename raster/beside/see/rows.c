/* SPDX-License-Identifier: MIT */
/* Reads a stack in chunks of rows. */
#include <stdlib.h>

#include "data/images/images.h"
#include "raster/beside/see/see.h"

bool rows_allocate(struct stack_rows *rows, size_t most_samples, struct error *err)
{
    const size_t n_pages = (size_t)rows->cube.image.n_pages;
    const size_t width = (size_t)rows->cube.image.width, height = (size_t)rows->cube.image.height;
    const size_t fitting = most_samples / (n_pages * width);
    const size_t n = fitting < 1 ? 1 : fitting < height ? fitting : height;
    rows->most = (int)n;
    rows->stride = n * width;
    return MAKE_ARRAY(rows->samples, n_pages * rows->stride, err, "rows of %s",
                      rows->cube.image.path);
}

bool rows_read(struct stack_rows *rows, int first, struct error *err)
{
    const int left = rows->cube.image.height - first;
    rows->first = first;
    rows->n = left < rows->most ? left : rows->most;
    for (int page = 0; page < rows->cube.image.n_pages; page++)
        if (!image_read(&rows->cube.image, page, first, rows->n,
                        rows->samples + (size_t)page * rows->stride, err))
            return false;
    return true;
}

void rows_close(struct stack_rows *rows)
{
    cube_close(&rows->cube);
    free(rows->samples);
    rows->samples = NULL;
}
