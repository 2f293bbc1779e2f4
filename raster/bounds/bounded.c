/* SPDX-License-Identifier: MIT */
/* Arithmetic of values with bounds on their errors: how far off the result of an operation is, made
 * exactly from operands that are off by at most their errors. */
#include <math.h>

#include "raster/bounds/inside.h"

/* (a + e)(b + f) - ab = a f + e (b + f) */
struct bounded bounded_product(struct bounded a, struct bounded b)
{
    return (struct bounded){a.value * b.value,
                            fabs(a.value) * b.error + a.error * (fabs(b.value) + b.error)};
}

/* (a + e) / (b + f) - q = (e - q f) / (b + f), where q = a / b */
struct bounded bounded_quotient(struct bounded a, struct bounded b)
{
    double quotient = a.value / b.value;
    return (struct bounded){quotient, (a.error + fabs(quotient) * b.error) / fabs(b.value)};
}
