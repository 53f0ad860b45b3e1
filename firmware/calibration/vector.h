/* SPDX-License-Identifier: Apache-2.0 */

/* Declares complex numbers and their operations, without the checks for infinity that C's own multiplication makes. */

#ifndef ARCTRUE_VECTOR_H
#define ARCTRUE_VECTOR_H

#include <math.h>

struct vector {
    double re;
    double im;
};

static inline struct vector vector_product(struct vector a, struct vector b) {
    return (struct vector){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static inline struct vector vector_sum(struct vector a, struct vector b) {
    return (struct vector){a.re + b.re, a.im + b.im};
}

static inline struct vector vector_difference(struct vector a, struct vector b) {
    return (struct vector){a.re - b.re, a.im - b.im};
}

static inline struct vector vector_conjugate(struct vector a) {
    return (struct vector){a.re, -a.im};
}

static inline struct vector vector_scaled(struct vector a, double factor) {
    return (struct vector){a.re * factor, a.im * factor};
}

/* Returns e^{j angle}. */
static inline struct vector vector_unit(double angle_rad) {
    return (struct vector){cos(angle_rad), sin(angle_rad)};
}

static inline double vector_square(struct vector a) {
    return a.re * a.re + a.im * a.im;
}

/* Returns |a|. It replaces hypot(), which protects against overflow and takes half a kilobyte. */
static inline double vector_length(struct vector a) {
    return sqrt(vector_square(a));
}

#endif
