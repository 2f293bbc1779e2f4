/* SPDX-License-Identifier: MIT */
/* Samplings by Gaussian quadrature: with one rule, or with one for each of three functions. */
#include <stdlib.h>
#include <string.h>

#include "data/colour/colour.h"
#include "data/method/method.h"
#include "data/sampling/sampling.h"
#include "data/spectra/spectra.h"
#include "spectral.h"

/* ---- one rule ---- */

/* The rule's nodes as pages of a segment that is the whole range. */
static bool one_segment(const struct sampling_task *task, const struct quadrature *rule,
                        struct error *err)
{
    struct sampling *out = task->out;
    if (!sampling_room(out, rule->n, true, true, err))
        return false;
    for (int i = 0; i < rule->n; i++) {
        out->wavelength_nm[i] = rule->node[i];
        out->segment_nm[i][0] = sampling_grid(out, 0) - 0.5;
        out->segment_nm[i][1] = sampling_grid(out, out->n_nm) - 0.5;
    }
    sampling_weights(task->detector, out->wavelength_nm, out->segment_nm, out->n, out->weights);
    sampling_linear(out);
    out->spectral = true;
    return true;
}

static bool gauss_open(const struct sampling_task *task, struct error *err)
{
    const struct sampling *out = task->out;
    struct quadrature rule;
    if (task->method->count > out->n_nm)
        return sampling_refuse(task, out->n_nm, err);
    quadrature_legendre(out->first_nm - 0.5, sampling_grid(out, out->n_nm) - 0.5,
                        task->method->count, &rule);
    return one_segment(task, &rule, err);
}

/* The grid, and behind it room for functions on it. NULL: no memory. */
static double *grid_of(const struct sampling *out, int functions)
{
    double *grid = calloc((size_t)(1 + functions) * (size_t)out->n_nm, sizeof *grid);
    for (int j = 0; j < out->n_nm && grid != NULL; j++)
        grid[j] = sampling_grid(out, j);
    return grid;
}

static bool gauss_detector(const struct sampling_task *task, struct error *err)
{
    const struct sampling *out = task->out;
    struct quadrature rule;
    double *grid = grid_of(out, 1);
    int points = 0;
    if (grid == NULL)
        return error_memory(err);
    double *seen = grid + out->n_nm;
    for (int j = 0; j < out->n_nm; j++) {
        seen[j] = sampling_seen(out, j);
        points += seen[j] != 0;
    }
    const bool found = quadrature_discrete(grid, seen, out->n_nm, task->method->count, &rule);
    free(grid);
    if (task->method->count > points)
        return sampling_refuse(task, points, err);
    return found ? one_segment(task, &rule, err)
                 : error_usage(err, "%s has no solution; take fewer samples", task->name);
}

/* ---- a rule for each of three functions ---- */

/* Functions on the grid, and what makes the detector's channels of their integrals. */
struct functions {
    double *grid, *row; /* grid is owned */
    int n_nm;
    bool first_is_best; /* takes all nodes that remain, not one more than the others */
    double back[3][3];
    struct quadrature rule[3];
};

/* Finds by how much of each orthogonal row the rows add up to the channels. */
static void project(const double *channels, const double *rows, int n, double out[3][3])
{
    for (int channel = 0; channel < 3; channel++)
        for (int i = 0; i < 3; i++) {
            double part = 0, whole = 0;
            for (int j = 0; j < n; j++) {
                part += channels[channel * n + j] * rows[i * n + j];
                whole += rows[i * n + j] * rows[i * n + j];
            }
            out[channel][i] = whole > 0 ? part / whole : 0;
        }
}

/* A, C1 and C2 are the principal axes of the cone responses to spectra without structure: those in
 * which responses do not correlate (G. Buchsbaum and A. Gottschalk, Trichromacy, opponent colours
 * coding and optimum colour information transmission in the retina, Proc. R. Soc. Lond. B 220,
 * 89-113, 1983), which is what Meyer's are for. */
static bool find_functions(const struct sampling_task *task, struct functions *out,
                           struct error *err)
{
    const struct sampling *sampling = task->out;
    double cones[3][3];
    out->n_nm = sampling->n_nm;
    out->grid = grid_of(sampling, 3);
    if (out->grid == NULL)
        return error_memory(err);
    out->row = out->grid + out->n_nm;
    adaptation_cones(ADAPTATION_VON_KRIES, cones);
    if (task->method->functions == FUNCTIONS_XYZ)
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                cones[i][j] = i == j;
    sampling_transform(cones, sampling->detector_weights, out->n_nm, out->row);
    colour_inverse(cones, out->back);
    if (task->method->functions == FUNCTIONS_ACC) {
        out->first_is_best = true;
        orthogonal_rows(out->row, 3, out->n_nm);
        project(sampling->detector_weights, out->row, out->n_nm, out->back);
    }
    return true;
}

/* Rules of n nodes in all. */
static bool solve(struct functions *of, int n)
{
    bool found = n >= 3;
    for (int i = 0; i < 3 && found; i++) {
        const int more = of->first_is_best ? (i == 0) * (n % 3) : i < n % 3;
        found = quadrature_discrete(of->grid, of->row + i * of->n_nm, of->n_nm, n / 3 + more,
                                    &of->rule[i]);
    }
    return found;
}

/* The nearest number, up to 6 away, that has a solution; 0: none. */
static int solvable(struct functions *of, int n)
{
    for (int away = 1; away <= 6; away++)
        for (int sign = 1; sign >= -1; sign -= 2) {
            const int other = n + sign * away;
            if (other <= LARGEST_QUADRATURE && other <= of->n_nm && solve(of, other))
                return other;
        }
    return 0;
}

static bool refuse_unsolvable(const struct sampling_task *task, struct functions *of,
                              struct error *err)
{
    const int other = solvable(of, task->method->count);
    if (task->method->count < 3 && other > 0)
        return error_usage(err, "%s: three functions need at least 3 samples; %d have a solution",
                           task->name, other);
    if (other > 0)
        return error_usage(err,
                           "%s has no solution for functions such as %s's; %d samples have one",
                           task->name, task->out->detector, other);
    return error_usage(err, "%s has no solution for functions such as %s's, nor have numbers near",
                       task->name, task->out->detector);
}

/* A node and its function. */
struct node {
    double nm, weight;
    int function;
};
static int compare_nodes(const void *a, const void *b)
{
    const double x = ((const struct node *)a)->nm, y = ((const struct node *)b)->nm;
    return (x > y) - (x < y);
}

/* The pages are the nodes of all functions; those that are the same are one page. */
static bool union_of_nodes(const struct functions *of, struct sampling *out, struct error *err)
{
    struct node nodes[LARGEST_QUADRATURE];
    double weights[3][LARGEST_QUADRATURE];
    double nm[LARGEST_QUADRATURE];
    int count = 0, n = 0;
    for (int f = 0; f < 3; f++)
        for (int i = 0; i < of->rule[f].n; i++)
            nodes[count++] = (struct node){of->rule[f].node[i], of->rule[f].weight[i], f};
    qsort(nodes, (size_t)count, sizeof nodes[0], compare_nodes);
    memset(weights, 0, sizeof weights);
    for (int i = 0; i < count; i++) {
        n += i == 0 || nodes[i].nm > nodes[i - 1].nm;
        nm[n - 1] = nodes[i].nm;
        for (int channel = 0; channel < 3; channel++)
            weights[channel][n - 1] += of->back[channel][nodes[i].function] * nodes[i].weight;
    }
    if (!sampling_room(out, n, false, true, err))
        return false;
    memcpy(out->wavelength_nm, nm, (size_t)n * sizeof nm[0]);
    for (int channel = 0; channel < 3; channel++)
        memcpy(out->weights + channel * n, weights[channel], (size_t)n * sizeof nm[0]);
    return true;
}

static bool gauss_functions(const struct sampling_task *task, struct error *err)
{
    struct functions functions = {.grid = NULL};
    if (task->method->count > task->out->n_nm)
        return sampling_refuse(task, task->out->n_nm, err);
    bool done = find_functions(task, &functions, err);
    if (done)
        done = solve(&functions, task->method->count) ? union_of_nodes(&functions, task->out, err)
                                                      : refuse_unsolvable(task, &functions, err);
    free(functions.grid);
    if (!done)
        return false;
    sampling_linear(task->out);
    task->out->spectral = task->out->fixed = true;
    return true;
}

bool sample_gauss(const struct sampling_task *task, struct error *err)
{
    switch (task->method->functions) {
    case FUNCTIONS_DETECTOR:
        return gauss_detector(task, err);
    case FUNCTIONS_OPEN:
        return gauss_open(task, err);
    default:
        return gauss_functions(task, err);
    }
}
