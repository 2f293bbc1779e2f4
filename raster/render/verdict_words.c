/* SPDX-License-Identifier: MIT */
/* The verdict in words: for the table, for the stack, and for the message of a render that failed.
 */
#include "raster/render/inside.h"

/* ---- the verdict ---- */

/* The reason why nothing was checked; empty if the user wished so. */
static const char *no_check(const struct plan *plan)
{
    return plan->scene->shading == SHADING_PHONG ? ": OpenGL has no phong shading"
           : gl_is_built()                       ? ""
                                                 : ": this program was built without OpenGL";
}

const char *verdict_word(const struct plan *plan, const struct check_verdict *verdict)
{
    static const char *const words[] = {[OUTCOME_AGREED] = "agreed",
                                        [OUTCOME_DIFFERS] = "differs",
                                        [OUTCOME_NOT_VERIFIED] = "not verified"};
    return plan->options.check ? words[check_outcome(verdict)] : "not checked";
}

/* A share of the object pixels, in percent. */
static double percent(const struct check_verdict *verdict, uint64_t n)
{
    return verdict->objects ? 100 * (double)n / (double)verdict->objects : 0;
}

/* The cause of a bound that is too wide, and the change that narrows it. */
static const char *const causes[BOUND_CAUSES] = {
    [CAUSE_LIGHT] = "a light grazes it, is at the edge of its spot, or is too near; move the light",
    [CAUSE_POSITION] = "its radiance changes too much within a pixel; render it larger",
    [CAUSE_TEXTURE] = "its texture changes too much within a rounding; repeat it less often",
    [CAUSE_THIN] =
        "its triangles are edge-on, too thin or too large to be placed; turn or split it",
    [CAUSE_DEPTH] = ("its depth rounds to that of the near or the far plane, and OpenGL does "
                     "not show it; move the near plane away, or the far plane near"),
    [CAUSE_SHADOW] = "a shadow may end there, or not; move the light away from what it shades",
    [CAUSE_EDGE] = "it lies along edges of shadows, texels or highlights, whose place a rounding "
                   "decides; render it larger",
    [CAUSE_UPON] = "several surfaces lie there at one depth; move them apart",
    [CAUSE_FAR] = "its triangles reach too far; split them, or move the near plane away",
};

/* Says how much was not checked, where most of it lies, and why. */
static void unchecked_text(const struct plan *plan, const struct check_verdict *verdict, char *out,
                           size_t capacity)
{
    const uint64_t n = check_unchecked(verdict);
    char object[256], edges[64] = "";
    object_text(plan, verdict->unchecked_surface, object, sizeof object);
    if (n < verdict->unchecked)
        snprintf(edges, sizeof edges, ", besides %.3g %% along edges",
                 percent(verdict, verdict->unchecked - n));
    snprintf(out, capacity,
             "%.3g %% of the object pixels could not be checked, at most %.3g %% may%s; most of "
             "them are on %s: %s",
             percent(verdict, n), 100 * verdict->most_unchecked, edges, object,
             causes[verdict->unchecked_cause]);
}

/* The verdict with its reason. */
static void reason_text(const struct plan *plan, const struct check_verdict *verdict, char *out,
                        size_t capacity)
{
    char open[96] = "";
    switch (check_outcome(verdict)) {
    case OUTCOME_AGREED:
        if (verdict->open > 0)
            snprintf(open, sizeof open, " (%.3g %%: OpenGL could as well show something else)",
                     percent(verdict, verdict->open));
        snprintf(out, capacity,
                 "every %s is what the scene's triangles call for; %.3g %% of the object pixels "
                 "could not be checked%s",
                 verdict->lacks.numbers || verdict->lacks.depths ? "colour" : "pixel",
                 percent(verdict, verdict->unchecked), open);
        break;
    case OUTCOME_DIFFERS:
        if (verdict->unexplained == 0)
            snprintf(out, capacity,
                     "OpenGL is off by %+.3g counts on average, and roundings leave at most %.3g",
                     mean_residual(&verdict->samples), verdict->mean_limit);
        else
            snprintf(out, capacity, "%llu of %llu pixels are not explained",
                     (unsigned long long)verdict->unexplained, (unsigned long long)verdict->pixels);
        break;
    case OUTCOME_NOT_VERIFIED:
        unchecked_text(plan, verdict, out, capacity);
        break;
    }
}

void print_verdict(const struct plan *plan, const struct check_verdict *verdict, struct printed *to)
{
    char reason[768];
    if (!plan->options.check) {
        print(to, "verdict           not checked%s\n", no_check(plan));
        return;
    }
    reason_text(plan, verdict, reason, sizeof reason);
    print(to, "verdict           %s: %s\n", verdict_word(plan, verdict), reason);
}

static void checked_text(const struct plan *plan, const struct check_verdict *verdict,
                         char out[STACK_VERDICT])
{
    struct stack_verdict numbers = {.samples = verdict->samples.n,
                                    .exact = verdict->samples.exact,
                                    .within_1 = verdict->samples.within_1,
                                    .largest = verdict->samples.largest,
                                    .unexplained = verdict->unexplained,
                                    .pixels = verdict->pixels,
                                    .unchecked = verdict->unchecked,
                                    .objects = verdict->objects,
                                    .edges = verdict->between};
    snprintf(numbers.word, sizeof numbers.word, "%s", verdict_word(plan, verdict));
    stack_verdict_text(&numbers, out);
}

/* Pixels of the reference get the same words with and without a check that agrees. */
void report_verdict(const struct plan *plan, const struct check_verdict *verdict,
                    char out[STACK_VERDICT])
{
    const size_t capacity = STACK_VERDICT;
    const bool agreed = !plan->options.check || check_outcome(verdict) == OUTCOME_AGREED;
    if (plan->scene->shading == SHADING_PHONG)
        snprintf(out, capacity, "pixels of the reference, not checked%s", no_check(plan));
    else if (plan->options.store_raster && agreed)
        snprintf(out, capacity, "pixels of the reference");
    else if (!plan->options.check)
        snprintf(out, capacity, "not checked");
    else
        checked_text(plan, verdict, out);
}

/* ---- disagreement ---- */

/* Describes a pixel whose bands do not fit together. */
static void bands_text(const struct plan *plan, const struct check_failure *failure, char *out,
                       size_t capacity)
{
    char at[MOST_ODD][3 * BAND_NAME] = {"", ""}, first[BAND_NAME], last[BAND_NAME];
    for (int i = 0; i < failure->n_odd; i++) {
        const struct odd_bands *odd = &failure->odd[i];
        band_name(plan, odd->first, first);
        band_name(plan, odd->last, last);
        snprintf(at[i], sizeof at[i], "at %s%s%s by %+.3g counts", first,
                 odd->last > odd->first ? " to " : "", odd->last > odd->first ? last : "",
                 odd->off);
    }
    band_name(plan, failure->band, first);
    if (failure->n_odd == 0)
        snprintf(out, capacity,
                 "at %s OpenGL %.6g, where the other bands call for %.6g, bound %.3g counts", first,
                 failure->seen, failure->expected, failure->bound);
    else
        snprintf(out, capacity, "OpenGL is off %s%s%s; all other bands fit together", at[0],
                 failure->n_odd > 1 ? ", or " : "", at[1]);
}

/* Describes a failure in words. */
static void failure_text(const struct plan *plan, const struct check_failure *failure, char *out,
                         size_t capacity)
{
    char page[BAND_NAME];
    switch (failure->kind) {
    case FAILURE_RADIANCE:
        band_name(plan, failure->band, page);
        snprintf(out, capacity, "at %s OpenGL %.6g, reference %.6g, bound %.3g counts", page,
                 failure->seen, failure->expected, failure->bound);
        break;
    case FAILURE_BANDS:
        bands_text(plan, failure, out, capacity);
        break;
    case FAILURE_TRIANGLE:
        if (failure->shown.surface >= plan->n_instances)
            snprintf(out, capacity, "OpenGL drew a triangle number that does not exist");
        else if (failure->shown.surface < 0)
            snprintf(out, capacity, "OpenGL shows the background");
        else
            snprintf(out, capacity, "OpenGL shows triangle %d of %s, which cannot be visible there",
                     failure->shown.triangle + 1, object_name(plan, failure->shown.surface));
        break;
    case FAILURE_DEPTH:
        snprintf(out, capacity, "OpenGL's depth %.8g, reference %.8g, bound %.3g", failure->seen,
                 failure->expected, failure->bound);
        break;
    case FAILURE_FRAGMENTS:
        snprintf(out, capacity, "OpenGL draws %.0f fragments, reference %.0f (modulo 256)",
                 failure->seen, failure->expected);
        break;
    }
}

bool report_disagreement(const struct plan *plan, const struct check_verdict *verdict,
                         const char *then, struct error *err)
{
    const struct check_failure *first = &verdict->first;
    const int side = plan->scene->positions;
    char reason[768], where[256], what[320], position[64] = "";
    if (verdict->unexplained == 0) {
        reason_text(plan, verdict, reason, sizeof reason);
        return error_different(
            err, "%s: %s%s",
            is_biased(verdict) ? "the pictures differ" : verdict_word(plan, verdict), reason, then);
    }
    object_text(plan, first->surface, where, sizeof where);
    if (side > 1)
        snprintf(position, sizeof position, " (its position %d,%d)", first->x % side,
                 first->y % side);
    failure_text(plan, first, what, sizeof what);
    return error_different(
        err, "the pictures differ at %llu of %llu pixels, first at %d,%d%s on %s: %s%s",
        (unsigned long long)verdict->unexplained, (unsigned long long)verdict->pixels,
        first->x / side, first->y / side, position, where, what, then);
}

/* Tries the reasons in the order of their certainty. */
bool report_not_again(const struct plan *plan, const struct render_result *result, const char *path,
                      const struct record *made, const char *then, struct error *err)
{
    const struct stack_difference *first = &result->difference;
    const char *renderer = render_stored(plan, result);
    static const char changed[] = "the stack, or a file that the scene names, has changed";
    char what[256], page[BAND_NAME];
    if (strcmp(made->program, PROGRAM) != 0)
        snprintf(what, sizeof what, "it was made by %.80s, this is " PROGRAM, made->program);
    else if (strcmp(made->renderer, renderer) != 0)
        snprintf(what, sizeof what, "it was drawn by %.80s, this one by %.80s", made->renderer,
                 renderer);
    else if (first->in_map)
        snprintf(what, sizeof what, "first at %d,%d of the object map; %s", first->x, first->y,
                 changed);
    else if (first->page < 0)
        snprintf(what, sizeof what, "in the tags of its pages; %s", changed);
    else {
        band_name(plan, first->page, page);
        snprintf(what, sizeof what, "first at %d,%d of page %d (%s); %s", first->x, first->y,
                 first->page + 1, page, changed);
    }
    return error_different(err, "the stack is not the same as %s: %s%s", path, what, then);
}
