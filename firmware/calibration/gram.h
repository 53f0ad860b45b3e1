/* SPDX-License-Identifier: Apache-2.0 */

/* Builds the normal matrix of the fit from sums of e^{jkR1}, k <= 2N, where R1 is the reading of head 1 and N the
   highest order.

   The columns of the design matrix are the real and imaginary parts of d_n = e^{jnR2} - e^{jnR1} and a column of
   ones. With R2 = R1 + beta + delta, beta constant and delta of a few hundred arcseconds, every element is a sum of
   e^{jkR1} e^{jq delta}, and the second factor is expanded to the second power of delta. The truncation error is
   below (2N delta)^3/6; the refinement of the fit removes it. */

#ifndef ARCTRUE_GRAM_H
#define ARCTRUE_GRAM_H

#include "capture.h"
#include "limits.h"
#include "unit_circle.h"

enum { DELTA_POWERS = 3 };

struct gram_sums {
    /* Sum of delta^p e^{jkR1}. */
    struct vector moment[DELTA_POWERS][2 * ORDERS_MAX + 1];
    double beta_rad;
    double samples;
    uint32_t orders;
};

/* The orders that have unknowns: `order[i]` is the order of the cosine in row i and of the sine in row i + number.
   The constant is the last unknown. */
struct gram_layout {
    uint32_t order[ORDERS_MAX];
    uint32_t number;
};

/* Computes the sums over the turn in one pass; `shift_rad` is subtracted from head 2's readings. */
void gram_accumulate(struct gram_sums *sums, const struct unit_circle *circle,
                     const struct turn *turn, uint32_t orders, double shift_rad);

/* Builds the packed lower triangle, of size 2 number + 1. */
void gram_build(const struct gram_sums *sums, const struct gram_layout *layout, double *packed);

#endif
