/* SPDX-License-Identifier: Apache-2.0 */

/* Selects the orders that the gateware applies, and states why each other order is left out. */

#ifndef ARCTRUE_SELECTION_H
#define ARCTRUE_SELECTION_H

#include "estimate.h"

enum verdict {
    VERDICT_APPLIED,
    VERDICT_NOT_SEEN,
    VERDICT_GAIN,
    VERDICT_NOT_SIGNIFICANT,
    VERDICT_NO_LANE,
    /* The operator has loaded a lane of the order. */
    VERDICT_LOADED,
};

/* Limit of the noise gain: at a separation of 33 degrees it keeps n = 11 (gain 19) and leaves out n = 120, whose gain
   is infinite. */
#define GAIN_LIMIT_DEFAULT 50.0

const char *verdict_name(enum verdict verdict);

/* Returns the ratio of amplitude to standard uncertainty that noise alone exceeds in at least one of `orders` orders
   with a probability of 5 %. */
double significance_factor(uint32_t orders);

/* Sets one verdict per order, order n at place n - 1. If there are too few lanes, the orders with the largest
   amplitudes get the lanes. */
void select_orders(const struct estimate *estimate, uint32_t lanes, double gain_limit,
                   enum verdict *verdicts);

#endif
