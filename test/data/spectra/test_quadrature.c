/* SPDX-License-Identifier: MIT */
/* Compares quadrature with closed forms, and with the sums of polynomials that define a Gaussian
 * rule. */
#include "data/maths/maths.h"
#include "data/spectra/spectra.h"
#include "test.h"

enum { MOST_POINTS = 512 };

/* ---- Legendre ---- */

/* Returns Legendre's polynomial of degree n and its slope, by the recurrence. */
static long double legendre(int n, long double x, long double *slope)
{
    long double before = 0, value = 1;
    for (int k = 0; k < n; k++) {
        const long double next = ((2 * k + 1) * x * value - k * before) / (k + 1);
        before = value;
        value = next;
    }
    *slope = n * (x * value - before) / (x * x - 1);
    return value;
}

/* The nodes are the roots of Legendre's polynomial P, and the weights 2 / ((1 - x^2) P'(x)^2): then
 * x^k is integrated exactly up to 2n - 1. */
static void test_legendre(void)
{
    double node = 0, weight = 0, asymmetry = 0, least = 1, moved = 0;
    bool inside = true;
    for (int n = 1; n <= LARGEST_QUADRATURE; n++) {
        struct quadrature rule, wide;
        quadrature_legendre(-1, 1, n, &rule);
        quadrature_legendre(379.5, 780.5, n, &wide);
        for (int i = 0; i < n; i++) {
            const long double x = (long double)rule.node[i];
            long double slope, value = legendre(n, x, &slope);
            node = fmax(node, fabs((double)(value / slope)));
            weight =
                fmax(weight, fabs(rule.weight[i] - (double)(2 / ((1 - x * x) * slope * slope))));
            moved = fmax(moved, fabs(wide.node[i] - (580 + 200.5 * rule.node[i])));
            moved = fmax(moved, fabs(wide.weight[i] - 200.5 * rule.weight[i]));
            asymmetry = fmax(asymmetry, fabs(rule.node[i] + rule.node[n - 1 - i]));
            least = fmin(least, rule.weight[i]);
            inside =
                inside && fabs(rule.node[i]) < 1 && (i == 0 || rule.node[i] > rule.node[i - 1]);
        }
    }
    CHECK_NEAR(node, 0, 1e-14,
               "for every n to 64 the nodes are the roots of Legendre's polynomial");
    CHECK_NEAR(weight, 0, 1e-14, "and the weights are those of Gauss");
    CHECK_NEAR(moved, 0, 200.5e-14, "from 379.5 to 780.5 they are moved and scaled");
    CHECK_NEAR(asymmetry, 0, 0, "nodes are symmetric");
    CHECK(least > 0 && inside, "weights are positive, nodes inside and increasing");
}

/* ---- discrete weights ---- */

/* Returns the largest error of the sums of Chebyshev's polynomials up to degree 2n - 1, relative to
 * the sum of the weights' magnitudes. */
static double worst_sum(const double *x, const double *w, int count, const struct quadrature *rule)
{
    const double centre = (x[0] + x[count - 1]) / 2, half = (x[count - 1] - x[0]) / 2;
    double sum[2 * LARGEST_QUADRATURE] = {0}, whole = 0, worst = 0;
    for (int i = 0; i < count + rule->n; i++) {
        const double factor = i < count ? w[i] : -rule->weight[i - count];
        const double at = ((i < count ? x[i] : rule->node[i - count]) - centre) / half;
        double before = at, value = 1;
        for (int degree = 0; degree < 2 * rule->n; degree++) {
            const double next = 2 * at * value - before;
            sum[degree] += factor * value;
            before = value;
            value = next;
        }
        whole += i < count ? fabs(w[i]) : 0;
    }
    for (int degree = 0; degree < 2 * rule->n; degree++)
        worst = fmax(worst, fabs(sum[degree]) / whole);
    return worst;
}

static void check_exact(const char *name, const double *x, const double *w, int count, int most)
{
    double worst = 0, least = 1;
    bool found = true;
    for (int n = 1; n <= most; n++) {
        struct quadrature rule;
        found = found && quadrature_discrete(x, w, count, n, &rule);
        worst = fmax(worst, found ? worst_sum(x, w, count, &rule) : HUGE_VAL);
        for (int i = 0; i < n && found; i++)
            least = fmin(least, rule.weight[i]);
    }
    CHECK(found, "%s: a positive weight has a rule for every n", name);
    CHECK_NEAR(worst, 0, 1e-12, "%s: the rule is exact for polynomials up to degree 2n - 1", name);
    CHECK(least > 0, "%s: the rule's weights are positive", name);
}

static void test_exactness(void)
{
    double x[MOST_POINTS], bump[MOST_POINTS], equal[MOST_POINTS], binomial[MOST_POINTS], worst = 0;
    struct quadrature rule;
    const int m = 41, count = 401;
    for (int j = 0; j < count; j++) {
        x[j] = 380 + j;
        bump[j] = exponential(-power(fabs(x[j] - 450) / 30, 2)) +
                  exponential(-power(fabs(x[j] - 580) / 60, 2));
        equal[j] = 0.25;
        binomial[j] = j == 0 ? 1 : binomial[j - 1] * (m - j) / j;
    }
    check_exact("two bumps", x, bump, count, LARGEST_QUADRATURE);
    check_exact("equal weights", x, equal, m, m);
    check_exact("binomial weights", x, binomial, m, m);
    /* each has full relative accuracy, even if it is much smaller than the others */
    const bool found = quadrature_discrete(x, binomial, m, m, &rule);
    for (int j = 0; j < m && found; j++)
        worst = fmax(worst, fabs(rule.weight[j] / binomial[j] - 1));
    CHECK(found && worst < 1e-11, "binomial weights from 1 to 1e11 are each right to 1e-11");
}

/* If there are as many nodes as points, the nodes are the points. */
static void check_all_points(const char *name, const double *x, const double *w, int count)
{
    struct quadrature rule;
    const bool found = quadrature_discrete(x, w, count, count, &rule);
    double node = found ? 0 : HUGE_VAL, weight = node;
    for (int i = 0; i < count && found; i++) {
        node = fmax(node, fabs(rule.node[i] - x[i]));
        weight = fmax(weight, fabs(rule.weight[i] - w[i]));
    }
    CHECK_NEAR(node, 0, 1e-11, "%s: as many nodes as points are the points", name);
    CHECK_NEAR(weight, 0, 1e-11, "%s: the nodes have the weights of the points", name);
}

static void test_all_points(void)
{
    double x[LARGEST_QUADRATURE], w[LARGEST_QUADRATURE];
    for (int j = 0; j < LARGEST_QUADRATURE; j++) {
        x[j] = 500 + j;
        w[j] = 1 + j % 3;
    }
    check_all_points("1 point", x, w, 1);
    check_all_points("2 points", x, w, 2);
    check_all_points("20 points", x, w, 20);
    check_all_points("64 points", x, w, 64);
}

static void test_signs(void)
{
    const double x[] = {-2, -1, 0, 1, 2}, w[] = {1, -0.2, 1, -0.2, 1};
    struct quadrature rule;
    CHECK(quadrature_discrete(x, w, 5, 2, &rule), "a weight of both signs has 2 nodes");
    CHECK_NEAR(rule.node[1], sqrt(7.6 / 2.6), 1e-14, "its moments determine the nodes");
    CHECK_NEAR(rule.weight[0], 1.3, 1e-14, "each node has half of the sum");
    CHECK(!quadrature_discrete(x, w, 5, 3, &rule), "it has no 3 nodes within its ends");
    check_all_points("both signs", x, w, 5);
    CHECK(!quadrature_discrete(x, (double[]){1, 0, 0, 0, -1}, 5, 1, &rule),
          "a weight whose sum is 0 has no node");
    CHECK(!quadrature_discrete(x, (double[]){2, 0, 0, 0, -1}, 5, 1, &rule),
          "a weight whose mean lies outside its points has no node");
}

static void test_few_points(void)
{
    const double x[] = {400, 500, 600}, w[] = {0, 2, 0}, none[] = {0, 0, 0};
    struct quadrature rule;
    CHECK(quadrature_discrete(x, w, 3, 1, &rule) && rule.node[0] == 500 && rule.weight[0] == 2,
          "the only point with weight is the node");
    CHECK(!quadrature_discrete(x, w, 3, 2, &rule),
          "more nodes than points with weight are refused");
    CHECK(!quadrature_discrete(x, none, 3, 1, &rule), "weights of 0 alone are refused");
    CHECK(quadrature_discrete(x, (double[]){0, 0, 1}, 3, 1, &rule) && rule.node[0] == 600,
          "a node may be the last point");
}

int main(void)
{
    test_legendre();
    test_exactness();
    test_all_points();
    test_signs();
    test_few_points();
    return test_end();
}
