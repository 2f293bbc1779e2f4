/* SPDX-License-Identifier: MIT */
/* The room "deal": which tiles of a picture a part has. */
#ifndef DEAL_H
#define DEAL_H

#include "raster/plan/plan.h"
#include "spectral.h"

struct picture_part {
    int number, count; /* from 1; count 0: the whole picture */
};
enum { MOST_PARTS = 100000 };
/* Reads "3/7". Messages name `option`. */
bool part_read(const char *option, const char *value, struct picture_part *out, struct error *err);
bool part_accepts(const char *option, const char *value, struct error *err);
/* Lists the tiles of a part, in the order of the picture. They are dealt like cards, row by row,
 * one to each part; where whole rounds end at the right border, the next part begins. So each part
 * has as many tiles as any other, but for one, and they lie all over the picture. The caller frees
 * *tiles. */
bool part_deal(const struct plan *plan, const struct picture_part *part, int **tiles, int *n,
               struct error *err);

#endif
