/* SPDX-License-Identifier: MIT */
/* A program without OpenGL has all commands but those on drivers. */
#include "raster/beside/accuracy/accuracy.h"
#include "raster/beside/cost/cost.h"
#include "raster/beside/see/see.h"
#include "raster/beside/verify/verify.h"
#include "raster/beside/view/view.h"

const struct command *const commands[] = {
    &render_command, &develop_command, &probe_command,  &compare_command, &view_command,
    &plan_command,   &cost_command,    &info_command,   &list_command,    &curves_command,
    &join_command,   &envi_command,    &export_command, &judge_command,   NULL};

const struct shading_judge *const shading_judge = &accuracy_judge;
const struct map_maker *const map_makers[] = {&reference_maps, &interval_maker, NULL};
