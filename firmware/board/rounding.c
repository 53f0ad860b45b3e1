/* SPDX-License-Identifier: Apache-2.0 */

/* Provides rint(), floor() and ceil(). The library's versions take 0.9 KB, because they treat the halves of a double
   separately. */

#include <math.h>

/* From 2^52 on a double has no fraction. */
#define WHOLE_FROM 4503599627370496.0

/* The sum with 2^52 has no place for a fraction, so the processor rounds it to the nearest whole number, halves to
   even. */
double rint(double x) {
    double whole = copysign(WHOLE_FROM, x);
    return fabs(x) < WHOLE_FROM ? copysign(x + whole - whole, x) : x;
}

double floor(double x) {
    double near = rint(x);
    return near > x ? near - 1.0 : near;
}

double ceil(double x) {
    return -floor(-x);
}
