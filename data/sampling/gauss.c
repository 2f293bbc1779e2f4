/* SPDX-License-Identifier: MIT */
/* Samplings by Gaussian quadrature: with one rule, or with one for each of three functions. */
#include "data/sampling/inside.h"

/* ---- one rule ---- */

/* Makes pages of the nodes of one rule, of one segment that is the whole range. */
bool sample_gauss(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    const bool open = out->method.kind == SAMPLING_GAUSS_OPEN;
    const double first_nm = out->pages.first_nm - 0.5,
                 last_nm = out->pages.first_nm + out->fine.n - 0.5;
    struct quadrature rule;
    double *weight;
    int points = 0;
    if (!sampling_numbers(&weight, (size_t)out->fine.n, err))
        return false;
    for (int j = 0; j < out->fine.n; j++) {
        weight[j] = open ? 1 : sampling_seen(out, j);
        points += weight[j] != 0;
    }
    const bool found =
        open || quadrature_discrete(out->fine.nm, weight, out->fine.n, task->count, &rule);
    free(weight);
    if (task->count > points)
        return sampling_refuse(task, points, err);
    if (!found)
        return error_usage(err, "%s has no solution; take fewer samples", task->name);
    if (open)
        quadrature_legendre(first_nm, last_nm, task->count, &rule);
    if (!sampling_room(out, rule.n, SEGMENTS, err))
        return false;
    for (int i = 0; i < rule.n; i++) {
        out->pages.wavelength_nm[i] = rule.node[i];
        out->segment_nm[i][0] = first_nm;
        out->segment_nm[i][1] = last_nm;
    }
    return true;
}

/* ---- a rule for each of three functions ---- */

/* Functions on the grid, and the matrix that makes the detector's channels of their integrals. */
struct functions {
    const struct sampling *sampling;
    double *row; /* [function * n + j]; owned */
    double back[3][3];
    struct quadrature rule[3];
};

/* Finds the matrix that makes the channels of the orthogonal rows. */
static void project(const double *channels, const double *rows, int n, double out[3][3])
{
    for (int channel = 0; channel < 3; channel++)
        for (int i = 0; i < 3; i++) {
            const double part = sampling_dot(channels + channel * n, rows + i * n, n);
            const double whole = sampling_dot(rows + i * n, rows + i * n, n);
            out[channel][i] = whole > 0 ? part / whole : 0;
        }
}

/* A, C1 and C2 are the principal axes of the cone responses to spectra without structure: those in
 * which responses do not correlate (G. Buchsbaum and A. Gottschalk, Trichromacy, opponent colours
 * coding and optimum colour information transmission in the retina, Proc. R. Soc. Lond. B 220,
 * 89-113, 1983), which is what Meyer's are for. */
static void find_functions(struct functions *out)
{
    const struct fine_detector *fine = &out->sampling->fine;
    const enum sampling_kind kind = out->sampling->method.kind;
    double matrix[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (kind != SAMPLING_GAUSS_XYZ)
        tristimulus_to_cones(matrix);
    memcpy(out->row, fine->weights, 3 * (size_t)fine->n * sizeof *out->row);
    tristimulus_apply_all(matrix, fine->n, out->row);
    tristimulus_inverse(matrix, out->back);
    if (kind == SAMPLING_GAUSS_ACC) {
        orthogonal_rows(out->row, 3, fine->n);
        project(fine->weights, out->row, fine->n, out->back);
    }
}

/* Finds rules of n nodes in all. The nodes that remain of thirds are all A's, or one a function. */
static bool solve(struct functions *of, int n)
{
    const struct fine_detector *fine = &of->sampling->fine;
    const bool acc = of->sampling->method.kind == SAMPLING_GAUSS_ACC;
    bool found = n >= 3;
    for (int i = 0; i < 3 && found; i++) {
        const int more = acc ? (i == 0) * (n % 3) : i < n % 3;
        found = quadrature_discrete(fine->nm, of->row + i * fine->n, fine->n, n / 3 + more,
                                    &of->rule[i]);
    }
    return found;
}

/* Returns the nearest number, up to 6 away, that has a solution; 0: none has. */
static int solvable(struct functions *of, int n)
{
    for (int away = 1; away <= 6; away++)
        for (int sign = 1; sign >= -1; sign -= 2) {
            const int other = n + sign * away;
            if (other <= LARGEST_QUADRATURE && other <= of->sampling->fine.n && solve(of, other))
                return other;
        }
    return 0;
}

static bool refuse_unsolvable(const struct sampling_task *task, struct functions *of,
                              struct error *err)
{
    const int other = solvable(of, task->count);
    if (task->count < 3 && other > 0)
        return error_usage(err, "%s: three functions need at least 3 samples; %d have a solution",
                           task->name, other);
    if (other > 0)
        return error_usage(err,
                           "%s has no solution for functions such as %s's; %d samples have one",
                           task->name, task->out->detector, other);
    return error_usage(
        err, "%s has no solution for functions such as %s's, and numbers near it have none",
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

/* Makes pages of the nodes of all functions; equal ones share a page. */
static bool union_of_nodes(const struct functions *of, struct sampling *out, struct error *err)
{
    struct node nodes[LARGEST_QUADRATURE];
    int count = 0, n = 0, page = -1;
    for (int f = 0; f < 3; f++)
        for (int i = 0; i < of->rule[f].n; i++)
            nodes[count++] = (struct node){of->rule[f].node[i], of->rule[f].weight[i], f};
    qsort(nodes, (size_t)count, sizeof nodes[0], compare_nodes);
    for (int i = 0; i < count; i++)
        n += i == 0 || nodes[i].nm > nodes[i - 1].nm;
    if (!sampling_room(out, n, 0, err))
        return false;
    for (int i = 0; i < count; i++) {
        page += i == 0 || nodes[i].nm > nodes[i - 1].nm;
        out->pages.wavelength_nm[page] = nodes[i].nm;
        for (int channel = 0; channel < 3; channel++)
            out->weights[channel * n + page] +=
                of->back[channel][nodes[i].function] * nodes[i].weight;
    }
    return true;
}

bool sample_gauss_functions(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    struct functions functions = {.sampling = out};
    if (task->count > out->fine.n)
        return sampling_refuse(task, out->fine.n, err);
    if (!sampling_numbers(&functions.row, 3 * (size_t)out->fine.n, err))
        return false;
    find_functions(&functions);
    const bool done = solve(&functions, task->count) ? union_of_nodes(&functions, out, err)
                                                     : refuse_unsolvable(task, &functions, err);
    free(functions.row);
    return done;
}
