/* SPDX-License-Identifier: Apache-2.0 */

/* Solves symmetric positive definite equations. The lower triangle is packed row by row: element (row, column) has
   the place row (row + 1)/2 + column. All functions work in place. */

#ifndef ARCTRUE_CHOLESKY_H
#define ARCTRUE_CHOLESKY_H

#include <stdbool.h>
#include <stdint.h>

static inline uint32_t packed_place(uint32_t row, uint32_t column) {
    return row * (row + 1) / 2 + column;
}

/* Computes L of A = L L^T. Returns false if a pivot is lost in rounding: an unknown then cannot be separated from the
   others. */
bool cholesky_factor(double *packed, uint32_t size);

/* Solves A x = right with the factor. */
void cholesky_solve(const double *factor, uint32_t size, double *right);

/* Replaces L by its inverse. */
void cholesky_invert_factor(double *factor, uint32_t size);

/* Returns an element of A^-1, computed from L^-1; row >= column. */
double cholesky_inverse_element(const double *inverse_factor, uint32_t size, uint32_t row,
                                uint32_t column);

#endif
