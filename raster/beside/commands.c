/* SPDX-License-Identifier: MIT */
/* The commands of this program, and its judge of shading. build.sh takes one of these tables, and
 * one of the ways of drawing. */
#include "raster/beside/accuracy/accuracy.h"
#include "raster/beside/cost/cost.h"
#include "raster/beside/measure/measure.h"
#include "raster/beside/see/see.h"
#include "raster/beside/verify/verify.h"
#include "raster/beside/view/view.h"

const struct command *const commands[] = {&render_command,
                                          &develop_command,
                                          &probe_command,
                                          &compare_command,
                                          &view_command,
                                          &plan_command,
                                          &cost_command,
                                          &verify_command,
                                          &info_command,
                                          &list_command,
                                          &curves_command,
                                          &join_command,
                                          &envi_command,
                                          &drivers_command,
                                          &export_command,
                                          &judge_command,
                                          NULL};

const struct shading_judge *const shading_judge = &accuracy_judge;
const struct map_maker *const map_makers[] = {&reference_maps, &interval_maker, NULL};
