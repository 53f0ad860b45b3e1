/* SPDX-License-Identifier: Apache-2.0 */

/* Which orders the gateware is to apply, and why not the others. */

#ifndef ARCTRUE_SELECTION_H
#define ARCTRUE_SELECTION_H

#include "estimate.h"

enum verdict {
    VERDICT_APPLIED,
    VERDICT_NOT_SEEN,
    VERDICT_GAIN,
    VERDICT_NOT_SIGNIFICANT,
    VERDICT_NO_LANE,
    /* The order has a lane that the operator has loaded. */
    VERDICT_LOADED,
};

/* At 33 degrees this keeps n = 11 (19 times) and leaves out what is next to n = 120. */
#define GAIN_LIMIT_DEFAULT 50.0

const char *verdict_name(enum verdict verdict);

/* Least amplitude over its standard uncertainty that noise passes with chance 5 % in all of
   `orders` orders together. */
double significance_factor(uint32_t orders);

/* One verdict an order, order n at place n - 1. Where lanes are short the largest have them. */
void select_orders(const struct estimate *estimate, uint32_t lanes, double gain_limit,
                   enum verdict *verdicts);

#endif
