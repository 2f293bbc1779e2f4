/* SPDX-License-Identifier: MIT */
/* Compares quadrature with published tables, with closed forms, and with the sums of polynomials
 * that define a Gaussian rule. */
#include "data/maths/maths.h"
#include "data/spectra/spectra.h"
#include "test.h"

enum { MOST_POINTS = 512 };

/* ---- Legendre ---- */

/* M. Abramowitz and I. A. Stegun, Handbook of Mathematical Functions (National Bureau of Standards,
 * 1964), table 25.4: positive nodes and their weights. */
static const double node_64[] = {
    0.024350292663424432509, 0.072993121787799039450, 0.121462819296120554470,
    0.169644420423992818037, 0.217423643740007084150, 0.264687162208767416374,
    0.311322871990210956158, 0.357220158337668115950, 0.402270157963991603696,
    0.446366017253464087985, 0.489403145707052957479, 0.531279464019894545658,
    0.571895646202634034284, 0.611155355172393250249, 0.648965471254657339858,
    0.685236313054233242564, 0.719881850171610826849, 0.752819907260531896612,
    0.783972358943341407610, 0.813265315122797559742, 0.840629296252580362752,
    0.865999398154092819761, 0.889315445995114105853, 0.910522137078502805756,
    0.929569172131939575821, 0.946411374858402816062, 0.961008799652053718919,
    0.973326827789910963742, 0.983336253884625956931, 0.991013371476744320739,
    0.996340116771955279347, 0.999305041735772139457};
static const double weight_64[] = {
    0.048690957009139720383,  0.048575467441503426935,  0.048344762234802957170,
    0.047999388596458307728,  0.047540165714830308662,  0.046968182816210017325,
    0.046284796581314417296,  0.045491627927418144480,  0.044590558163756563060,
    0.043583724529323453377,  0.042473515123653589007,  0.041262563242623528610,
    0.039953741132720341387,  0.038550153178615629129,  0.037055128540240046040,
    0.035472213256882383811,  0.033805161837141609392,  0.032057928354851553585,
    0.030234657072402478868,  0.028339672614259483228,  0.026377469715054658672,
    0.024352702568710873338,  0.022270173808383254159,  0.020134823153530209372,
    0.017951715775697343085,  0.015726030476024719322,  0.013463047896718642598,
    0.011168139460131128819,  0.0088467598263639477231, 0.0065044579689783628561,
    0.0041470332605624676353, 0.0017832807216964329473};

static void test_legendre_sums(void)
{
    double worst = 0, asymmetry = 0, least = 1;
    bool inside = true;
    for (int n = 1; n <= LARGEST_QUADRATURE; n++) {
        struct quadrature rule;
        quadrature_legendre(-1, 1, n, &rule);
        for (int degree = 0; degree < 2 * n; degree++) {
            double sum = 0;
            for (int i = 0; i < n; i++)
                sum += rule.weight[i] * power(fabs(rule.node[i]), degree) *
                       (degree % 2 == 1 && rule.node[i] < 0 ? -1 : 1);
            worst = fmax(worst, fabs(sum - (degree % 2 == 1 ? 0 : 2.0 / (degree + 1))));
        }
        for (int i = 0; i < n; i++) {
            asymmetry = fmax(asymmetry, fabs(rule.node[i] + rule.node[n - 1 - i]));
            least = fmin(least, rule.weight[i]);
            inside =
                inside && fabs(rule.node[i]) < 1 && (i == 0 || rule.node[i] > rule.node[i - 1]);
        }
    }
    CHECK_NEAR(worst, 0, 1e-13, "x^k is integrated exactly up to 2n - 1, for every n to 64");
    CHECK_NEAR(asymmetry, 0, 0, "nodes are symmetric");
    CHECK(least > 0 && inside, "weights are positive, nodes inside and increasing");
}

static void test_published(double first, double last)
{
    struct quadrature rule;
    const double centre = (first + last) / 2, half = (last - first) / 2;
    double node = 0, weight = 0;
    quadrature_legendre(first, last, 64, &rule);
    for (int i = 0; i < 64; i++) {
        const int at = i < 32 ? 31 - i : i - 32;
        node = fmax(node, fabs(rule.node[i] - (centre + (i < 32 ? -half : half) * node_64[at])));
        weight = fmax(weight, fabs(rule.weight[i] - half * weight_64[at]));
    }
    CHECK_NEAR(node, 0, 1e-14 * half, "64 nodes from %g to %g are the published ones", first, last);
    CHECK_NEAR(weight, 0, 1e-14 * half, "64 weights from %g to %g are the published ones", first,
               last);
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
    double x[MOST_POINTS], bump[MOST_POINTS], equal[MOST_POINTS], binomial[MOST_POINTS];
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

/* Each weight has full relative accuracy, even if it is much smaller than the others. */
static void test_small_weights(void)
{
    double x[LARGEST_QUADRATURE], w[LARGEST_QUADRATURE], worst = 0;
    struct quadrature rule;
    const int count = 41;
    for (int j = 0; j < count; j++) {
        x[j] = j;
        w[j] = j == 0 ? 1 : w[j - 1] * (count - j) / j;
    }
    const bool found = quadrature_discrete(x, w, count, count, &rule);
    for (int j = 0; j < count && found; j++)
        worst = fmax(worst, fabs(rule.weight[j] / w[j] - 1));
    CHECK(found && worst < 1e-11, "binomial weights from 1 to 1e11 are each right to 1e-11");
    printf("# %.3g\n", worst);
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
    test_published(-1, 1);
    test_published(379.5, 780.5);
    test_legendre_sums();
    test_exactness();
    test_all_points();
    test_small_weights();
    test_signs();
    test_few_points();
    return test_end();
}
