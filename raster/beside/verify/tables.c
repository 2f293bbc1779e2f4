/* SPDX-License-Identifier: MIT */
/* The results as a table, as JSON and as JUnit's XML. */
#include "raster/beside/verify/inside.h"

/* ---- the table ---- */

/* Returns a part in percent. NaN: there is no whole. */
static double percent(uint64_t part, uint64_t whole)
{
    return whole ? 100 * (double)part / (double)whole : (double)NAN;
}

/* Returns the floor that a part of the object pixels do not exceed. NaN: there are none. */
static double floor_of(const struct check_verdict *check, double part)
{
    return check->floor.n ? floor_quantile(&check->floor, part) : (double)NAN;
}

static void print_floor(struct printed *to, double floor)
{
    if (isnan(floor))
        print(to, " %9s", "-");
    else
        print(to, " %9.3g", floor);
}

/* Cuts a share down, so that only a whole one is printed as 100. */
static void print_share(struct printed *to, uint64_t part, uint64_t whole)
{
    if (whole == 0)
        print(to, " %6s", "-");
    else
        print(to, " %6.2f", part < whole ? fmin(percent(part, whole), 99.99) : 100.0);
}

/* A picture that is not as an earlier report has it says so. */
void verify_line(const struct verification *of, int driver, int scene, struct printed *to)
{
    const struct verify_result *result = result_of(of, driver, scene);
    const struct check_verdict *check = &result->check;
    print(to, "  %-28s %-13s", of->scenes[scene].name, verify_words[result->outcome]);
    if (result->outcome != VERIFY_FAILED) {
        print_floor(to, floor_of(check, 0.5));
        print_floor(to, floor_of(check, 0.999));
        for (int i = 0; i < FLOOR_LEVELS; i++)
            print_share(to, check->floor.within[i], check->objects);
        print(to, " %9llu %8.2f", (unsigned long long)check->pixels, result->seconds);
    }
    print_text(to, "\n");
    if (result->text[0])
        print(to, "    %s\n", result->text);
    if (result->expected != result->outcome)
        print(to, "    expected: %s; this is %s\n", verify_words[result->expected],
              change_of(result) < 0 ? "worse" : "better");
}

void verify_head(const struct verification *of, int driver, struct printed *to)
{
    const struct listed_driver *by = &of->drivers[driver];
    char options[64];
    driver_options(by, options);
    print(to, "%s", options);
    if (by->is.names.renderer[0])
        print(to, ": %s, %s, by %s, bounds of %s", by->is.names.renderer, by->is.names.version,
              by->is.names.library, driver_profile(by));
    print(to, "\n  %-28s %-13s %9s %9s %6s %6s %6s %9s %8s\n", "scene", "verdict", "floor",
          "99.9 %", "% to 1", "8", "256", "pixels", "seconds");
}

void verify_sum(const struct verification *of, int driver, struct printed *to)
{
    const struct totals totals = totals_of(result_of(of, driver, 0), of->n_scenes);
    print(to, "  agreed %d, differ %d, not verified %d, died %d\n\n", totals.n[OUTCOME_AGREED],
          totals.n[OUTCOME_DIFFERS], totals.n[OUTCOME_NOT_VERIFIED], totals.n[VERIFY_FAILED]);
}

/* Prints a command for each failure, which repeats it. */
static void print_failures(const struct verification *of, const struct options *options,
                           struct printed *to)
{
    char by[64];
    bool any = false;
    for (int d = 0; d < of->n_drivers; d++)
        for (int s = 0; s < of->n_scenes; s++) {
            if (result_of(of, d, s)->outcome == OUTCOME_AGREED)
                continue;
            if (!any)
                print_text(to, "\nto repeat what failed:\n");
            any = true;
            driver_options(&of->drivers[d], by);
            print_text(to, "  spectral render");
            print_shell(to, of->scenes[s].path);
            print(to, " -o /dev/null %s", by);
            if (of->scenes[s].kind == VERIFIED_BUILTIN)
                print(to, " --wavelengths %s --size %s", usual_wavelengths, usual_size);
            for (int i = 0; i < options->n_recorded; i++) { /* all but those of the driver */
                const char *word = options->recorded[i];
                if (strncmp(word, "--gl=", 5) != 0 && strncmp(word, "--renderer=", 11) != 0)
                    print_shell(to, word);
            }
            print_text(to, "\n");
        }
}

void verify_end(const struct verification *of, const struct options *options, struct printed *to)
{
    print_text(to, "floor: the largest error in counts that could pass at half of the object "
                   "pixels, and at 99.9 %\nof them; % to 1, 8, 256: object pixels that were "
                   "checked within so many counts of 65535\n");
    print_text(to, of->differs);
    print_failures(of, options, to);
}

/* ---- JSON ---- */

void reported_of(const struct verification *of, int driver, struct reported out[REPORTED + 1])
{
    const struct listed_driver *by = &of->drivers[driver];
    const struct renderer_names *names = &by->is.names;
    const struct reported all[] = {{"program", PROGRAM},
                                   {"processor", of->processor},
                                   {"gl_library", names->library},
                                   {"gl_renderer", names->renderer},
                                   {"gl_version", names->version},
                                   {"driver_profile", driver_profile(by)},
                                   {NULL, NULL}};
    memcpy(out, all, sizeof all);
}

static void json_result(const char *name, const struct verify_result *result, struct json *json)
{
    const struct check_verdict *check = &result->check;
    const double ratio = check->samples.worst_ratio; /* -1: there is none */
    json_open(json, NULL, '{');
    json_string(json, "scene", name);
    json_string(json, "verdict", verify_words[result->outcome]);
    json_string(json, "message", result->text[0] ? result->text : NULL);
    json_number(json, "seconds", result->seconds);
    if (result->outcome != VERIFY_FAILED) {
        json_count(json, "pixels", check->pixels);
        json_count(json, "object_pixels", check->objects);
        json_count(json, "samples", check->samples.n);
        json_count(json, "ambiguous_pixels", check->ambiguous);
        json_count(json, "unexplained_pixels", check->unexplained);
        json_count(json, "unchecked_pixels", check->unchecked);
        json_number(json, "max_counts", check->samples.largest);
        json_number(json, "worst_error_over_bound", ratio < 0 ? (double)NAN : ratio);
        json_number(json, "floor_median", floor_of(check, 0.5));
        json_number(json, "floor_99_9", floor_of(check, 0.999));
        json_number(json, "checked_within_1", percent(check->floor.within[0], check->objects));
        json_number(json, "checked_within_8", percent(check->floor.within[1], check->objects));
        json_number(json, "checked_within_256", percent(check->floor.within[2], check->objects));
    }
    json_close(json, '}');
}

void verify_json(const struct verification *of, struct json *json)
{
    json_begin(json);
    json_open(json, "drivers", '[');
    for (int d = 0; d < of->n_drivers; d++) {
        const struct listed_driver *by = &of->drivers[d];
        struct reported reported[REPORTED + 1];
        reported_of(of, d, reported);
        json_open(json, NULL, '{');
        json_string(json, "gl", by->library);
        json_string(json, "renderer", by->renderer);
        for (int i = 0; reported[i].key; i++)
            json_string(json, reported[i].key, reported[i].value);
        json_count(json, "agreed",
                   (uint64_t)totals_of(result_of(of, d, 0), of->n_scenes).n[OUTCOME_AGREED]);
        json_open(json, "scenes", '[');
        for (int s = 0; s < of->n_scenes; s++)
            json_result(of->scenes[s].name, result_of(of, d, s), json);
        json_close(json, ']');
        json_close(json, '}');
    }
    json_close(json, ']');
    json_number(json, "seconds", of->seconds);
}

/* ---- JUnit ---- */

/* Prints an attribute of XML. */
static void print_attribute(struct printed *to, const char *name, const char *value)
{
    print(to, " %s=\"", name);
    print_xml(to, value);
    print_text(to, "\"");
}

static void print_case(const struct listed_driver *by, const char *scene,
                       const struct verify_result *result, struct printed *to)
{
    print_text(to, "    <testcase");
    print_attribute(to, "name", scene);
    print_attribute(to, "classname",
                    by->is.names.renderer[0] ? by->is.names.renderer : by->library);
    print(to, " time=\"%.3f\"", result->seconds);
    if (result->outcome == OUTCOME_AGREED) {
        print_text(to, "/>\n");
        return;
    }
    print(to, ">\n      <%s",
          change_of(result) >= 0             ? "skipped" /* it is known */
          : result->outcome == VERIFY_FAILED ? "error"
                                             : "failure");
    print_attribute(to, "type", verify_words[result->outcome]);
    print_attribute(to, "message", result->text);
    print_text(to, "/>\n    </testcase>\n");
}

/* Prints the numbers of a suite, or of all of them. */
static void print_counts(const struct verify_result *results, int n, struct printed *to)
{
    const struct totals totals = totals_of(results, n);
    int errors = 0;
    for (int i = 0; i < n; i++)
        errors += results[i].outcome == VERIFY_FAILED && change_of(&results[i]) < 0;
    print(to, " tests=\"%d\" failures=\"%d\" errors=\"%d\" skipped=\"%d\" time=\"%.3f\">\n", n,
          totals.worse - errors, errors, n - totals.n[OUTCOME_AGREED] - totals.worse,
          totals.seconds);
}

static void print_suite(const struct verification *of, int driver, struct printed *to)
{
    const struct listed_driver *by = &of->drivers[driver];
    char options[64];
    driver_options(by, options);
    print_text(to, "  <testsuite");
    print_attribute(to, "name", options);
    print_counts(result_of(of, driver, 0), of->n_scenes, to);
    print_text(to, "    <properties>\n");
    struct reported reported[REPORTED + 1];
    reported_of(of, driver, reported);
    for (int i = 0; reported[i].key; i++) {
        print_text(to, "      <property");
        print_attribute(to, "name", reported[i].key);
        print_attribute(to, "value", reported[i].value);
        print_text(to, "/>\n");
    }
    print_text(to, "    </properties>\n");
    for (int s = 0; s < of->n_scenes; s++)
        print_case(by, of->scenes[s].name, result_of(of, driver, s), to);
    print_text(to, "  </testsuite>\n");
}

void verify_junit(const struct verification *of, struct printed *to)
{
    print_text(to,
               "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"spectral verify\"");
    print_counts(of->results, of->n_drivers * of->n_scenes, to);
    for (int d = 0; d < of->n_drivers; d++)
        print_suite(of, d, to);
    print_text(to, "</testsuites>\n");
}
