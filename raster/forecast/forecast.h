/* SPDX-License-Identifier: MIT */
/* The room "forecast": how long a render is likely to take, as the last renders of this machine
 * were, and how much memory. */
#ifndef FORECAST_H
#define FORECAST_H

#include "raster/deal/deal.h"
#include "raster/plan/plan.h"

/* ---- forecast.c ---- */

/* The default render, with OpenGL and its check; and one by the reference alone. */
enum forecast_kind { FORECAST_CHECKED, FORECAST_REFERENCE, FORECAST_KINDS };
struct forecast {
    double planned; /* seconds that the plan took; the caller's */
    double seconds[FORECAST_KINDS], peak_bytes[FORECAST_KINDS];
    struct picture_part part;    /* that it is of; count 0: the whole picture */
    int n_tiles;                 /* of these */
    double disk_bytes;           /* of the samples */
    bool learnt[FORECAST_KINDS]; /* from a render of this machine; otherwise from another one */
};
/* Forecasts the render of a plan, or of a part, with smooth shading; seconds without those of the
 * plan. */
bool forecast_make(const struct plan *plan, const struct picture_part *part, struct forecast *out,
                   struct error *err);
/* Learns from a render that took so many seconds, without those of its plan. Nothing is learnt from
 * short ones, nor with options that change the seconds, nor where no folder for it can be found. */
void forecast_learn(const struct plan *plan, double seconds);

/* ---- inside this room ---- */

/* pace.c: seconds of this machine to one of the model, kept in XDG_CACHE_HOME/spectral or
 * HOME/.cache/spectral; 0: not known. A file that cannot be read or written is as good as none. */
void pace_read(double out[FORECAST_KINDS]);
void pace_write(const double pace[FORECAST_KINDS]);

#endif
