/* SPDX-License-Identifier: MIT */
/* Gaussian quadrature: of constant weight (Legendre), and of any discrete weight. */
#include "data/spectra/spectra.h"

/* ---- Legendre ---- */

/* Returns the polynomial of degree n at x, |x| < 1, and its derivative. */
static double legendre(int n, double x, double *derivative)
{
    double before = 0, p = 1;
    for (int k = 0; k < n; k++) {
        const double next = ((2 * k + 1) * x * p - k * before) / (k + 1);
        before = p;
        p = next;
    }
    *derivative = n * (before - x * p) / (1 - x * x);
    return p;
}

/* The estimate of a node has two right digits at least. Each step of Newton's doubles them. */
void quadrature_legendre(double first, double last, int n, struct quadrature *out)
{
    const double centre = (first + last) / 2, half = (last - first) / 2;
    out->n = n;
    for (int i = 0; i < (n + 1) / 2; i++) {
        double x, sine, derivative;
        sine_cosine(180 * (i + 0.75) / (n + 0.5), &sine, &x);
        for (int step = 0; step < 8; step++)
            x -= legendre(n, x, &derivative) / derivative;
        if (2 * i + 1 == n)
            x = 0;
        legendre(n, x, &derivative);
        out->node[i] = centre - half * x;
        out->node[n - 1 - i] = centre + half * x;
        out->weight[i] = 2 * half / ((1 - x * x) * derivative * derivative);
        out->weight[n - 1 - i] = out->weight[i];
    }
}

/* ---- discrete weights ---- */

/* Polynomials that are orthogonal over the points, scaled to a largest magnitude of 1 there:
 * size[k] p[k + 1] = (x - a[k]) p[k] - b[k] p[k - 1]; norm[k] is the sum of w p[k]^2. */
struct polynomials {
    const double *x, *w;
    int count;
    double centre, half; /* of the points, which are mapped to [-1, 1] */
    double *value;       /* [k * count + point]; owned */
    double a[LARGEST_QUADRATURE], b[LARGEST_QUADRATURE], size[LARGEST_QUADRATURE];
    double norm[LARGEST_QUADRATURE];
};

static double scaled(const struct polynomials *p, double x)
{
    return (x - p->centre) / p->half;
}

/* Returns the sum of w x^power_of_x f g. The power is 0 or 1. */
static double inner(const struct polynomials *p, int power_of_x, const double *f, const double *g)
{
    double sum = 0;
    for (int j = 0; j < p->count; j++)
        sum += p->w[j] * (power_of_x ? scaled(p, p->x[j]) : 1) * f[j] * g[j];
    return sum;
}

/* Makes polynomial k + 1 orthogonal to all before it. Rounding leaves a remainder the first time,
 * so that it is done twice. Gautschi, 2.2.3.1, explains why the plain recurrence fails if n is not
 * small beside the number of points. */
static void orthogonalise(const struct polynomials *p, int k)
{
    double *next = p->value + (size_t)(k + 1) * (size_t)p->count;
    for (int i = 0; i < 2 * (k + 1); i++) {
        const int of = i % (k + 1);
        const double *other = p->value + (size_t)of * (size_t)p->count;
        const double part = inner(p, 0, next, other) / p->norm[of];
        for (int j = 0; j < p->count; j++)
            next[j] -= part * other[j];
    }
}

/* Divides polynomial k by its largest magnitude at points of weight. Returns that; 0: it is 0
 * there. */
static double normalise(const struct polynomials *p, int k)
{
    double *value = p->value + (size_t)k * (size_t)p->count, largest = 0;
    for (int j = 0; j < p->count; j++)
        largest = p->w[j] != 0 ? fmax(largest, fabs(value[j])) : largest;
    for (int j = 0; j < p->count && largest > 0; j++)
        value[j] /= largest;
    return largest;
}

/* A sum of positive and negative terms counts as 0 if it is below this part of the sum of their
 * magnitudes. There is no next polynomial then. */
static const double vanishing = 1e-13;

static bool set_norm(struct polynomials *p, int k)
{
    const double *value = p->value + (size_t)k * (size_t)p->count;
    double magnitude = 0;
    for (int j = 0; j < p->count; j++)
        magnitude += fabs(p->w[j]) * value[j] * value[j];
    p->norm[k] = inner(p, 0, value, value);
    return fabs(p->norm[k]) > vanishing * magnitude;
}

/* Computes polynomial k + 1 from polynomials k and k - 1. */
static void recur(struct polynomials *p, int k)
{
    const double *value = p->value + (size_t)k * (size_t)p->count;
    const double *before = k > 0 ? value - p->count : NULL;
    double *next = p->value + (size_t)(k + 1) * (size_t)p->count;
    p->a[k] = inner(p, 1, value, value) / p->norm[k];
    p->b[k] = k > 0 ? p->size[k - 1] * p->norm[k] / p->norm[k - 1] : 0;
    for (int j = 0; j < p->count; j++)
        next[j] = (scaled(p, p->x[j]) - p->a[k]) * value[j] - (k > 0 ? p->b[k] * before[j] : 0);
}

static bool make_polynomials(struct polynomials *p, int n)
{
    for (int j = 0; j < p->count; j++)
        p->value[j] = 1;
    for (int k = 0; k < n; k++) {
        if (!set_norm(p, k))
            return false;
        recur(p, k);
        if (k < n - 1)
            orthogonalise(p, k);
        p->size[k] = k < n - 1 ? normalise(p, k + 1) : 1;
        if (!(p->size[k] > 0))
            return false;
    }
    return true;
}

/* Returns polynomial n at x, and stores those before it in value[k]. */
static double evaluate(const struct polynomials *p, int n, double x, double *value)
{
    const double at = scaled(p, x);
    double last = 0;
    value[0] = 1;
    for (int k = 0; k < n; k++) {
        last = ((at - p->a[k]) * value[k] - (k > 0 ? p->b[k] * value[k - 1] : 0)) / p->size[k];
        if (k + 1 < n)
            value[k + 1] = last;
    }
    return last;
}

/* Computes the polynomials at a node, all times the same factor, by the recurrence downwards from
 * polynomial n, which is 0 there. */
static void evaluate_down(const struct polynomials *p, int n, double x, double *value)
{
    const double at = scaled(p, x);
    value[n - 1] = 1;
    for (int k = n - 1; k > 0; k--)
        value[k - 1] =
            ((at - p->a[k]) * value[k] - (k + 1 < n ? p->size[k] * value[k + 1] : 0)) / p->b[k];
}

/* Returns Christoffel's number of a node. Each recurrence loses all digits where its values fall,
 * as at the ends if there are nearly as many nodes as points. So they meet where they agree best:
 * where the equation between them leaves the smallest rest (I. S. Dhillon's twisted factorisation,
 * 1997). */
static double christoffel(const struct polynomials *p, int n, double x)
{
    double up[LARGEST_QUADRATURE], down[LARGEST_QUADRATURE], least = HUGE_VAL, sum = 0;
    int meet = 0;
    evaluate(p, n, x, up);
    evaluate_down(p, n, x, down);
    for (int k = 0; k < n; k++) {
        const double left = k > 0 ? p->b[k] * up[k - 1] / up[k] : 0;
        const double right = k + 1 < n ? p->size[k] * down[k + 1] / down[k] : 0;
        const double rest = fabs(scaled(p, x) - p->a[k] - left - right);
        if (rest < least) {
            least = rest;
            meet = k;
        }
    }
    for (int k = 0; k < n; k++) {
        const double value = k <= meet ? up[k] : up[meet] / down[meet] * down[k];
        sum += value * value / p->norm[k];
    }
    return 1 / sum;
}

/* Finds where polynomial n changes its sign, to the last bit. */
static double bisect(const struct polynomials *p, int n, double low, double high)
{
    double value[LARGEST_QUADRATURE];
    const bool negative = evaluate(p, n, low, value) < 0;
    for (;;) {
        const double middle = low + (high - low) / 2;
        if (!(middle > low && middle < high))
            return high;
        if ((evaluate(p, n, middle, value) < 0) == negative)
            low = middle;
        else
            high = middle;
    }
}

/* Finds the nodes. If all weights are positive, a point lies between any two nodes. With weights of
 * both signs nodes may be closer: so each gap is searched in parts. Rounding may put a node on an
 * end point beyond it. */
enum { PARTS = 16 };
static void find_nodes(const struct polynomials *p, int n, struct quadrature *out)
{
    const double first = p->x[0], last = p->x[p->count - 1], beyond = 1e-9 * p->half;
    double value[LARGEST_QUADRATURE], low = first - beyond;
    bool negative = evaluate(p, n, low, value) < 0;
    out->n = 0;
    for (int i = 0; i <= (p->count - 1) * PARTS; i++) {
        const int j = i / PARTS, part = i % PARTS;
        const double gap = j + 1 < p->count ? p->x[j + 1] - p->x[j] : 0;
        const double high = j + 1 < p->count ? p->x[j] + gap * part / PARTS : last + beyond;
        const bool now = evaluate(p, n, high, value) < 0;
        if (now != negative && out->n < n)
            out->node[out->n++] = fmin(fmax(bisect(p, n, low, high), first), last);
        negative = now;
        low = high;
    }
}

bool quadrature_discrete(const double *x, const double *w, int count, int n, struct quadrature *out)
{
    struct polynomials p = {.x = x, .w = w, .count = count};
    int points = 0;
    for (int j = 0; j < count; j++)
        points += w[j] != 0;
    if (n < 1 || n > LARGEST_QUADRATURE || points < n)
        return false;
    p.centre = (x[0] + x[count - 1]) / 2;
    p.half = count > 1 ? (x[count - 1] - x[0]) / 2 : 1;
    p.value = malloc((size_t)(n + 1) * (size_t)count * sizeof *p.value);
    bool good = p.value != NULL && make_polynomials(&p, n);
    free(p.value); /* nodes and weights need the recurrence alone */
    if (good)
        find_nodes(&p, n, out);
    good = good && out->n == n;
    for (int i = 0; i < n && good; i++) {
        out->weight[i] = christoffel(&p, n, out->node[i]);
        good = isfinite(out->weight[i]) && (i == 0 || out->node[i] > out->node[i - 1]);
    }
    return good;
}

double quadrature_lagrange(const double *node, int n, int i, double x)
{
    double product = 1;
    for (int j = 0; j < n; j++)
        if (j != i)
            product *= (x - node[j]) / (node[i] - node[j]);
    return product;
}
