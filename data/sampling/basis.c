/* SPDX-License-Identifier: MIT */
/* Sampling by a linear model: the principal components of a scene's spectra. */
#include "data/sampling/inside.h"

double sampling_dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += a[j] * b[j];
    return sum;
}

/* ---- Jacobi's method on one side ---- */

/* Two rows stay as they are if their cosine is at most n times this, or if both are no longer than
 * this part of the longest row. */
static const double negligible = 1e-15;

/* Turns two rows until they are orthogonal; the longer becomes the first. (J. Demmel and K.
 * Veselic, Jacobi's method is more accurate than QR, SIAM J. Matrix Anal. Appl. 13, 1992.) */
static bool turn(double *p, double *q, int n, double smallest)
{
    const double pp = sampling_dot(p, p, n), qq = sampling_dot(q, q, n), pq = sampling_dot(p, q, n);
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

/* Convergence is quadratic: sixty sweeps are never needed. */
void orthogonal_rows(double *row, int rows, int n)
{
    double longest = 0;
    for (int i = 0; i < rows; i++)
        longest = fmax(longest,
                       sampling_dot(row + (size_t)i * (size_t)n, row + (size_t)i * (size_t)n, n));
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
    const struct fine_spectra *spectra;
    int n, rank, n_units;
    double *direction; /* [component][nm]; of all products, as they were turned; owned */
    double *axis;      /* [component]; owned, with shear and units behind it */
    double *shear;
    double *units; /* [unit][component]: coordinates of products, as unit vectors */
};

static double *direction_row(const struct components *c, int component)
{
    return c->direction + (size_t)component * (size_t)c->spectra->n_nm;
}

static double *unit_row(const struct components *c, int unit)
{
    return c->units + (size_t)unit * (size_t)c->n;
}

static const double rank_limit = 1e-12;

static double largest_of(const double *values, size_t n)
{
    double largest = 0;
    for (size_t i = 0; i < n; i++)
        largest = fmax(largest, values[i]);
    return largest;
}

/* Turns the products, scaled to a largest value of 1: no square is too large or too small. */
static bool turn_products(struct components *out, struct error *err)
{
    const int n = out->spectra->n_products, n_nm = out->spectra->n_nm;
    const size_t count = (size_t)n * (size_t)n_nm;
    const double largest = largest_of(out->spectra->products, count);
    double longest = 0;
    if (!sampling_numbers(&out->direction, count, err))
        return false;
    for (size_t i = 0; i < count && largest > 0; i++)
        out->direction[i] = out->spectra->products[i] / largest;
    orthogonal_rows(out->direction, n, n_nm);
    for (; out->rank < n; out->rank++) {
        double *row = direction_row(out, out->rank);
        const double length = sqrt(sampling_dot(row, row, n_nm));
        longest = fmax(longest, length);
        if (!(length > rank_limit * longest))
            break;
        for (int j = 0; j < n_nm; j++)
            row[j] /= length;
    }
    return true;
}

/* Adds the coordinates of a product, as a unit vector, unless it has (nearly) none. */
static void add_unit(struct components *c, const double *product)
{
    const int n_nm = c->spectra->n_nm;
    const double largest = largest_of(product, (size_t)n_nm);
    double *unit = unit_row(c, c->n_units), length = 0;
    for (int k = 0; k < c->n && largest > 0; k++) {
        const double *direction = direction_row(c, k);
        unit[k] = 0;
        for (int j = 0; j < n_nm; j++)
            unit[k] += product[j] / largest * direction[j];
        length += unit[k] * unit[k];
    }
    length = sqrt(length);
    if (!(length > rank_limit))
        return;
    for (int k = 0; k < c->n; k++)
        unit[k] /= length;
    c->n_units++;
}

static void add_to_axis(struct components *c, const double *unit)
{
    for (int k = 0; k < c->n; k++)
        c->axis[k] += unit[k];
}

/* Adds to the axis the products whose cosine with it is too small, until there are none: the
 * perceptron, which ends if such an axis exists. */
static bool lean_axis(struct components *c, double cosine)
{
    enum { MOST = 100 };
    bool good = false;
    for (int round = 0; round < MOST && !good; round++) {
        good = true;
        for (int i = 0; i < c->n_units; i++) {
            const double least = cosine * sqrt(sampling_dot(c->axis, c->axis, c->n));
            if (!(sampling_dot(c->axis, unit_row(c, i), c->n) > least)) {
                good = false;
                add_to_axis(c, unit_row(c, i));
            }
        }
    }
    return good;
}

/* Finds an axis with all products on its positive side: their mean direction, as a rule. Products
 * far from the axis are sheared far, which magnifies rounding errors: so the axis is drawn near
 * them. */
static bool find_axis(struct components *c)
{
    for (int i = 0; i < c->n_units; i++)
        add_to_axis(c, unit_row(c, i));
    for (double cosine = 0.125; cosine > 1e-6; cosine /= 2)
        if (lean_axis(c, cosine))
            return true;
    return false;
}

/* Turns component k round, so that the axis is not negative. */
static void turn_round(struct components *c, int k)
{
    c->axis[k] = -c->axis[k];
    for (int j = 0; j < c->spectra->n_nm; j++)
        direction_row(c, k)[j] *= -1;
    for (int i = 0; i < c->n_units; i++)
        unit_row(c, i)[k] *= -1;
}

static void find_shear(struct components *c)
{
    for (int k = 0; k < c->n; k++)
        if (c->axis[k] < 0)
            turn_round(c, k);
    for (int i = 0; i < c->n_units; i++) {
        const double *unit = unit_row(c, i), y = sampling_dot(c->axis, unit, c->n);
        for (int k = 0; k < c->n; k++)
            c->shear[k] = fmax(c->shear[k], -unit[k] / y);
    }
}

static bool find_components(const struct sampling_task *task, struct components *c,
                            struct error *err)
{
    const struct fine_spectra *spectra = c->spectra;
    if (!turn_products(c, err))
        return false;
    c->n = task->count < c->rank ? task->count : c->rank;
    if (!sampling_numbers(&c->axis, (2 + (size_t)spectra->n_products) * (size_t)c->n, err))
        return false;
    c->shear = c->axis + c->n;
    c->units = c->shear + c->n;
    for (int i = 0; i < spectra->n_products; i++)
        add_unit(c, spectra->products + (size_t)i * (size_t)spectra->n_nm);
    if (!find_axis(c))
        return error_usage(err, "%s would have negative coordinates; take more components",
                           task->name);
    find_shear(c);
    return true;
}

/* Sets analysis and synthesis. The inverse is c = c' - shear (axis . c') / (1 + axis . shear). */
static void set_matrices(const struct components *c, struct sampling *out)
{
    const int n_nm = c->spectra->n_nm;
    const double divisor = 1 + sampling_dot(c->axis, c->shear, c->n);
    for (int j = 0; j < n_nm; j++) {
        double along = 0, sheared = 0;
        for (int k = 0; k < c->n; k++) {
            along += c->axis[k] * direction_row(c, k)[j];
            sheared += c->shear[k] * direction_row(c, k)[j];
        }
        for (int k = 0; k < c->n; k++) {
            const double direction = direction_row(c, k)[j];
            out->pages.analysis[(size_t)k * (size_t)n_nm + (size_t)j] =
                direction + c->shear[k] * along;
            out->synthesis[(size_t)j * (size_t)c->n + (size_t)k] =
                direction - c->axis[k] * sheared / divisor;
        }
    }
}

/* Sets the detector's response to each component. */
static void set_weights(struct sampling *out)
{
    const int n = out->pages.n, n_nm = out->fine.n;
    for (int channel = 0; channel < 3; channel++)
        for (int page = 0; page < n; page++)
            for (int j = 0; j < n_nm; j++)
                out->weights[channel * n + page] +=
                    out->fine.weights[channel * n_nm + j] *
                    out->synthesis[(size_t)j * (size_t)n + (size_t)page];
}

/* A black scene has one page of zeros. */
static bool set_pages(const struct components *c, struct sampling *out, struct error *err)
{
    if (!sampling_room(out, c->n > 0 ? c->n : 1, ANALYSIS | SYNTHESIS, err))
        return false;
    set_matrices(c, out);
    set_weights(out);
    out->pages.of_products = true;
    out->rank = c->rank;
    return true;
}

bool sample_basis(const struct sampling_task *task, struct error *err)
{
    struct components c = {.spectra = task->spectra};
    const bool done = find_components(task, &c, err) && set_pages(&c, task->out, err);
    FREE_ALL(c.direction, c.axis);
    return done;
}
