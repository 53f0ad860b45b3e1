/* SPDX-License-Identifier: Apache-2.0 */

#include "cholesky.h"

#include <math.h>

#include "assertion.h"
#include "limits.h"

/* Least pivot, relative to its diagonal element. */
#define LEAST_PIVOT 1e-11

static double product(const double *a, const double *b, uint32_t number) {
    double sum = 0.0;
    for (uint32_t place = 0; place < number; place++) {
        sum += a[place] * b[place];
    }
    return sum;
}

bool cholesky_factor(double *packed, uint32_t size) {
    ASSERT(size > 0 && size <= UNKNOWNS_MAX);
    for (uint32_t row = 0; row < size; row++) {
        double *own = packed + packed_place(row, 0);
        for (uint32_t column = 0; column < row; column++) {
            const double *other = packed + packed_place(column, 0);
            own[column] = (own[column] - product(own, other, column)) / other[column];
        }
        double pivot = own[row] - product(own, own, row);
        /* The negated comparison also refuses an element that is not a number. */
        if (!(pivot > LEAST_PIVOT * own[row])) {
            return false;
        }
        own[row] = sqrt(pivot);
    }
    return true;
}

void cholesky_solve(const double *factor, uint32_t size, double *right) {
    ASSERT(size > 0 && size <= UNKNOWNS_MAX);
    for (uint32_t row = 0; row < size; row++) {
        const double *own = factor + packed_place(row, 0);
        right[row] = (right[row] - product(own, right, row)) / own[row];
    }
    for (uint32_t row = size; row-- > 0;) {
        const double *own = factor + packed_place(row, 0);
        right[row] /= own[row];
        for (uint32_t column = 0; column < row; column++) {
            right[column] -= own[column] * right[row];
        }
    }
}

void cholesky_invert_factor(double *factor, uint32_t size) {
    ASSERT(size > 0 && size <= UNKNOWNS_MAX);
    for (uint32_t row = 0; row < size; row++) {
        double *own = factor + packed_place(row, 0);
        double pivot = own[row];
        for (uint32_t column = 0; column < row; column++) {
            double sum = 0.0;
            for (uint32_t inner = column; inner < row; inner++) {
                sum += own[inner] * factor[packed_place(inner, column)];
            }
            /* The elements of this row to the right still hold the factor. */
            own[column] = -sum / pivot;
        }
        own[row] = 1.0 / pivot;
    }
}

double cholesky_inverse_element(const double *inverse_factor, uint32_t size, uint32_t row,
                                uint32_t column) {
    ASSERT(size <= UNKNOWNS_MAX && row < size && column < size);
    double sum = 0.0;
    for (uint32_t inner = row; inner < size; inner++) {
        sum +=
            inverse_factor[packed_place(inner, row)] * inverse_factor[packed_place(inner, column)];
    }
    return sum;
}
