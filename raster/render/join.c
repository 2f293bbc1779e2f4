/* SPDX-License-Identifier: MIT */
/* spectral join: puts the parts of a picture together. The stack is that of one process, byte for
 * byte, and its verdict the sum of the parts'. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster/render/render.h"

/* The check is part of the facts: a stack of the reference's pixels does not record it. */
static bool join_options(const struct options *options, const struct parts *parts,
                         const struct record *record, char unchecked[32], struct options *out,
                         struct error *err)
{
    struct part_facts facts;
    if (!recorded_options(options, options->operand, record, out, err))
        return false;
    if (!facts_read(parts->list[0].text, &facts))
        return error_usage(err, "%s: records no facts", parts->list[0].path);
    snprintf(unchecked, 32, "%.17g", facts.unchecked);
    out->no_check = !facts.check;
    out->strict = facts.check && facts.strict;
    out->unchecked = facts.check ? unchecked : NULL;
    return true;
}

static bool join_parts(struct options *options, struct parts *parts, struct error *err)
{
    struct record record = {.text = NULL};
    struct options made = {.operand = NULL};
    char unchecked[32];
    const struct render_output output = {.path = options->operand,
                                         .keep = options->keep,
                                         .envi = options->envi,
                                         .outputs = &options->outputs,
                                         .join = parts};
    bool done = record_parse(parts->list[0].text, &record, err) ||
                error_usage(err, "%s: records no scene", parts->list[0].path);
    done = done && join_options(options, parts, &record, unchecked, &made, err) &&
           (options->trust || record_is_trusted(parts->list[0].path, &record, err)) &&
           render_with_options(&made, &output, NULL, err);
    options_free(&made);
    record_free(&record);
    return done;
}

bool command_join(struct options *options, struct error *err)
{
    struct parts parts;
    if (!options->operand)
        return error_usage(err, "join needs STACK, the name that the parts were drawn for");
    const bool done = parts_find(options->operand, &parts, err) && join_parts(options, &parts, err);
    parts_free(&parts);
    return done;
}
