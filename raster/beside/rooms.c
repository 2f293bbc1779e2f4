/* SPDX-License-Identifier: MIT */
/* What this program has: its commands, its ways of drawing, and its judge of shading. rooms_no_gl.c
 * and rooms_minimal.c are the tables of smaller programs. */
#include "data/scene/scene.h"
#include "data/stack/stack.h"
#include "raster/beside/accuracy/accuracy.h"
#include "raster/beside/cost/cost.h"
#include "raster/beside/measure/measure.h"
#include "raster/beside/see/see.h"
#include "raster/beside/shader/shader.h"
#include "raster/beside/verify/verify.h"
#include "raster/beside/view/view.h"
#include "raster/gl/gl.h"
#include "raster/render/render.h"
#include "raster/renderers/renderers.h"
#include "spectral.h"

const struct command *const commands[] = {
    &render_command, &develop_command, &probe_command,  &compare_command, &view_command,
    &plan_command,   &cost_command,    &verify_command, &info_command,    &list_command,
    &show_command,   &join_command,    &envi_command,   &drivers_command, &export_command,
    &judge_command,  NULL};

const struct drawing_ways drawing_ways = {
    .open = {[GL_WITHOUT_SHADERS] = gl_open, [GL_CORE] = shader_open, [GL_ES] = shader_open},
    .measure = driver_measure,
    .library = gl_library,
};

const struct shading_judge *const shading_judge = &accuracy_judge;
