/* SPDX-License-Identifier: MIT */
/* The stack of a render: its record, and whether it is stored. */
#include <stdlib.h>

#include "data/sampling/sampling.h"
#include "raster/render/inside.h"

/* Lists the names of the objects in the order of their numbers; none if there is no object map. */
static bool list_objects(const struct plan *plan, struct record *record, struct error *err)
{
    const char **names;
    if (!MAKE_ARRAY(names, plan->n_instances, err, "the names of objects"))
        return false;
    record->objects = (struct texts){names, plan->map_bytes > 0 ? plan->n_instances : 0};
    for (int i = 0; i < record->objects.n; i++)
        names[i] = object_name(plan, i);
    return true;
}

/* Returns the record of the stack as text, allocated; NULL on failure. */
static char *make_provenance(const struct plan *plan, const struct render_output *output,
                             const struct render_result *result, struct error *err)
{
    const struct part_rows *rows = &result->rows;
    const int n = plan->sampling && !plan->sampling->spectral ? 0 : plan->n_bands;
    struct record record;
    char *text = NULL;
    if (!record_scene(plan->scene, plan->sampling, output->detector, &record, err))
        return NULL;
    record.program = PROGRAM;
    record.renderer = render_stored(plan, result);
    record.n_options = output->n_recorded;
    for (int i = 0; i < record.n_options; i++)
        record.options[i] = output->recorded[i];
    if (list_objects(plan, &record, err) &&
        (rows->count == 0 ||
         record_part(&record, rows, plan->scene->height, plan->scene->wavelengths_nm, n, err)))
        text = record_text(&record, err);
    record_free(&record);
    return text;
}

bool stack_file_open(struct stack_writer *writer, const struct plan *plan,
                     const struct render_output *output, const struct render_result *result,
                     struct error *err)
{
    const struct sampling *sampling = plan->sampling;
    const struct part_rows *rows = &result->rows;
    const bool labelled = sampling && !sampling->spectral;
    char *provenance = make_provenance(plan, output, result, err);
    const struct stack_options options = {.width = plan->scene->width,
                                          .height =
                                              rows->count > 0 ? rows->count : plan->scene->height,
                                          .n_wavelengths = plan->n_bands,
                                          .wavelengths_nm = plan->scene->wavelengths_nm,
                                          .full_scale = result->full_scale,
                                          .bits = plan->options.bits,
                                          .scene = plan->scene->path,
                                          .provenance = provenance,
                                          .map_bytes = plan->map_bytes,
                                          .components = labelled ? &sampling->method : NULL};
    const bool done = provenance && stack_open(writer, output->path, &options, err);
    free(provenance);
    return done;
}

/* Refuses samples that no page can hold. */
static bool are_finite(const struct render_result *result, struct error *err)
{
    return result->odd.undefined == 0 ||
           error_failed(err,
                        "%llu samples are not finite (or too large for a float page); "
                        "nothing was written",
                        (unsigned long long)result->odd.undefined);
}

bool stack_file_finish(struct stack_writer *writer, const struct plan *plan,
                       const struct render_output *output, struct render_result *result,
                       struct error *err)
{
    const char *again = result->odd.undefined == 0 ? output->again : NULL;
    char verdict[STACK_VERDICT];
    if (!output->keep && !again && !render_agreed(plan, result))
        return true;
    if (!are_finite(result, err))
        return false;
    report_verdict(plan, &result->check, verdict);
    if (!stack_finish(writer, verdict, err) ||
        (again && !stack_compare(writer, again, &result->difference, err)))
        return false;
    if (output->discard || !(output->keep || render_agreed(plan, result)))
        return true;
    return stack_commit(writer, output->envi ? output->path : NULL, output->outputs, err);
}
