/* SPDX-License-Identifier: Apache-2.0 */

/* Symmetric positive definite equations. The lower triangle lies packed row by row: element
   (row, column) at row (row + 1)/2 + column. Everything happens in place. */

#ifndef ARCTRUE_CHOLESKY_H
#define ARCTRUE_CHOLESKY_H

#include <stdbool.h>
#include <stdint.h>

static inline uint32_t packed_place(uint32_t row, uint32_t column) {
    return row * (row + 1) / 2 + column;
}

/* A = L L^T; false where a pivot is lost in rounding: the unknown cannot be told from others. */
bool cholesky_factor(double *packed, uint32_t size);

/* Solve A x = right with the factor. */
void cholesky_solve(const double *factor, uint32_t size, double *right);

/* Replace L by its inverse. */
void cholesky_invert_factor(double *factor, uint32_t size);

/* Element of A^-1 from L^-1; row >= column. */
double cholesky_inverse_element(const double *inverse_factor, uint32_t size, uint32_t row,
                                uint32_t column);

#endif
