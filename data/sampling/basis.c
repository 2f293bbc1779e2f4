/* SPDX-License-Identifier: MIT */
/* A linear model: the principal components of a scene's spectra. */
#include <math.h>
#include <stdlib.h>

#include "data/sampling/sampling.h"
#include "spectral.h"

static double dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += a[j] * b[j];
    return sum;
}

/* ---- Jacobi's method on one side ---- */

/* Rows that are orthogonal to this, or that are this small beside the longest, are left alone. */
static const double negligible = 1e-15;

/* Turns two rows until they are orthogonal; the longer becomes the first. (J. Demmel and K.
 * Veselic, Jacobi's method is more accurate than QR, SIAM J. Matrix Anal. Appl. 13, 1992.) */
static bool turn(double *p, double *q, int n, double smallest)
{
    const double pp = dot(p, p, n), qq = dot(q, q, n), pq = dot(p, q, n);
    const bool swapped = qq > pp;
    if (fmax(pp, qq) <= smallest || (fabs(pq) <= negligible * n * sqrt(pp) * sqrt(qq) && !swapped))
        return false;
    const double zeta = pq != 0 ? (qq - pp) / (2 * pq) : HUGE_VAL;
    double t = pq != 0 ? 1 / (fabs(zeta) + sqrt(1 + zeta * zeta)) : 0;
    t = zeta < 0 ? -t : t;
    const double cosine = 1 / sqrt(1 + t * t), sine = t * cosine;
    for (int j = 0; j < n; j++) {
        const double a = cosine * p[j] - sine * q[j], b = sine * p[j] + cosine * q[j];
        p[j] = swapped ? b : a;
        q[j] = swapped ? a : b;
    }
    return true;
}

/* Convergence is quadratic; the number of sweeps is a limit that is not reached. */
void orthogonal_rows(double *row, int rows, int n)
{
    double longest = 0;
    for (int i = 0; i < rows; i++)
        longest = fmax(longest, dot(row + (size_t)i * (size_t)n, row + (size_t)i * (size_t)n, n));
    const double smallest = longest * negligible * negligible;
    bool turned = longest > 0;
    for (int sweep = 0; sweep < 60 && turned; sweep++) {
        turned = false;
        for (int p = 0; p < rows; p++)
            for (int q = p + 1; q < rows; q++)
                turned |=
                    turn(row + (size_t)p * (size_t)n, row + (size_t)q * (size_t)n, n, smallest);
    }
}

/* ---- components ---- */

/* The first n directions of the products, of length 1, and the shear that leaves no product a
 * negative coordinate: c' = c + shear (axis . c). */
struct components {
    int n, rank, n_nm, n_products;
    const double *products;
    double *direction;   /* [component][nm]; of all products, as they were turned; owned */
    double *coordinates; /* [component] of one product; owned, as are: */
    double *axis, *shear;
};

static const double rank_limit = 1e-12;

/* Scaled to a largest value of 1, so that no square is too large or too small. */
static bool turn_products(struct components *out, struct error *err)
{
    const size_t count = (size_t)out->n_products * (size_t)out->n_nm;
    double largest = 0, longest = 0;
    out->direction = calloc(count > 0 ? count : 1, sizeof *out->direction);
    if (out->direction == NULL)
        return error_memory(err);
    for (size_t i = 0; i < count; i++)
        largest = fmax(largest, out->products[i]);
    for (size_t i = 0; i < count && largest > 0; i++)
        out->direction[i] = out->products[i] / largest;
    orthogonal_rows(out->direction, out->n_products, out->n_nm);
    for (int k = 0; k < out->n_products; k++) {
        double *row = out->direction + (size_t)k * (size_t)out->n_nm;
        const double length = sqrt(dot(row, row, out->n_nm));
        longest = fmax(longest, length);
        if (!(length > rank_limit * longest))
            break;
        out->rank++;
        for (int j = 0; j < out->n_nm; j++)
            row[j] /= length;
    }
    return true;
}

/* The coordinates of a product, as a unit vector; false: it has (nearly) none. */
static bool unit_coordinates(const struct components *c, int product)
{
    const double *row = c->products + (size_t)product * (size_t)c->n_nm;
    double largest = 0, length = 0;
    for (int j = 0; j < c->n_nm; j++)
        largest = fmax(largest, row[j]);
    for (int k = 0; k < c->n && largest > 0; k++) {
        double sum = 0;
        for (int j = 0; j < c->n_nm; j++)
            sum += row[j] / largest * c->direction[(size_t)k * (size_t)c->n_nm + (size_t)j];
        c->coordinates[k] = sum;
        length += sum * sum;
    }
    length = sqrt(length);
    for (int k = 0; k < c->n && length > rank_limit; k++)
        c->coordinates[k] /= length;
    return length > rank_limit;
}

static void add_to_axis(struct components *c)
{
    for (int k = 0; k < c->n; k++)
        c->axis[k] += c->coordinates[k];
}

/* Adds those that are not, by this cosine, on the positive side of the axis, until all are: the
 * perceptron, which ends where there is such an axis. */
static bool lean_axis(struct components *c, double cosine)
{
    enum { MOST = 100 };
    bool good = false;
    for (int round = 0; round < MOST && !good; round++) {
        good = true;
        for (int i = 0; i < c->n_products; i++) {
            const double least = cosine * sqrt(dot(c->axis, c->axis, c->n));
            if (unit_coordinates(c, i) && !(dot(c->axis, c->coordinates, c->n) > least)) {
                good = false;
                add_to_axis(c);
            }
        }
    }
    return good;
}

/* An axis that all products are on the positive side of: their mean direction, as a rule. Those far
 * from it are sheared far, which magnifies what is rounded off: so it is drawn near them. */
static bool find_axis(struct components *c)
{
    for (int i = 0; i < c->n_products; i++)
        if (unit_coordinates(c, i))
            add_to_axis(c);
    for (double cosine = 0.125; cosine > 1e-6; cosine /= 2)
        if (lean_axis(c, cosine))
            return true;
    return false;
}

static void find_shear(struct components *c)
{
    for (int k = 0; k < c->n; k++)
        if (c->axis[k] < 0) {
            c->axis[k] = -c->axis[k];
            for (int j = 0; j < c->n_nm; j++)
                c->direction[(size_t)k * (size_t)c->n_nm + (size_t)j] *= -1;
        }
    for (int i = 0; i < c->n_products; i++) {
        if (!unit_coordinates(c, i))
            continue;
        const double y = dot(c->axis, c->coordinates, c->n);
        for (int k = 0; k < c->n; k++)
            c->shear[k] = fmax(c->shear[k], -c->coordinates[k] / y);
    }
}

/* The inverse: c = c' - shear (axis . c') / (1 + axis . shear). */
static void set_matrices(const struct components *c, struct sampling *out)
{
    const double divisor = 1 + dot(c->axis, c->shear, c->n);
    for (int j = 0; j < c->n_nm; j++) {
        double along = 0, sheared = 0;
        for (int k = 0; k < c->n; k++) {
            const double direction = c->direction[(size_t)k * (size_t)c->n_nm + (size_t)j];
            along += c->axis[k] * direction;
            sheared += c->shear[k] * direction;
        }
        for (int k = 0; k < c->n; k++) {
            const size_t at = (size_t)k * (size_t)c->n_nm + (size_t)j;
            out->analysis[at] = c->direction[at] + c->shear[k] * along;
            out->synthesis[(size_t)j * (size_t)c->n + (size_t)k] =
                c->direction[at] - c->axis[k] * sheared / divisor;
        }
    }
}

static bool component_room(struct components *c, struct error *err)
{
    const size_t n = (size_t)c->n + 1;
    c->coordinates = calloc(n, sizeof *c->coordinates);
    c->axis = calloc(n, sizeof *c->axis);
    c->shear = calloc(n, sizeof *c->shear);
    return (c->coordinates != NULL && c->axis != NULL && c->shear != NULL) || error_memory(err);
}

static bool find_components(const struct sampling_task *task, struct components *c,
                            struct error *err)
{
    if (!turn_products(c, err))
        return false;
    c->n = task->method->count < c->rank ? task->method->count : c->rank;
    if (!component_room(c, err))
        return false;
    if (!find_axis(c))
        return error_usage(err, "%s leaves no coordinates that are not negative; take more",
                           task->name);
    find_shear(c);
    return true;
}

/* All black: one page of zeros. */
bool sample_basis(const struct sampling_task *task, struct error *err)
{
    struct sampling *out = task->out;
    struct components c = {.n_nm = out->n_nm,
                           .n_products = task->spectra->n_products,
                           .products = task->spectra->products};
    bool done =
        find_components(task, &c, err) && sampling_room(out, c.n > 0 ? c.n : 1, false, true, err);
    out->analysis = done ? calloc((size_t)out->n * (size_t)out->n_nm, sizeof *out->analysis) : NULL;
    done = done && (out->analysis != NULL || error_memory(err));
    if (done) {
        set_matrices(&c, out);
        sampling_respond(out);
        for (int page = 0; page < out->n; page++)
            out->wavelength_nm[page] = page + 1;
        out->rank = c.rank;
        out->fixed = true;
    }
    free(c.direction);
    free(c.coordinates);
    free(c.axis);
    free(c.shear);
    return done;
}
