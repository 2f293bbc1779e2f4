/* SPDX-License-Identifier: MIT */
/* The minimal program contains none of the rooms in this folder. */
#include "raster/render/render.h"

const struct command *const commands[] = {&render_command, &plan_command, &info_command,
                                          &list_command,   &show_command, &join_command,
                                          &envi_command,   NULL};

const struct shading_judge *const shading_judge = NULL;
const struct map_maker *const map_makers[] = {NULL};
const struct option_list accuracy_options = {NULL, 0}, maps_options = {NULL, 0},
                         bounds_options = {NULL, 0};
