/* SPDX-License-Identifier: Apache-2.0 */

/* The running average over turns: each weighted by its variance, older ones by a power of the
   forgetting factor. */

#ifndef ARCTRUE_AVERAGE_H
#define ARCTRUE_AVERAGE_H

#include "estimate.h"

struct average_order {
    double cosine;
    double sine;
    /* Of the average, arcsec^2. */
    double variance_cosine;
    double variance_sine;
    double covariance;
    /* Sum of the forgotten weights, 1/arcsec^2; 0: nothing yet. */
    double weight;
};

struct average {
    struct average_order order[ORDERS_MAX];
    uint32_t turns;
};

void average_clear(struct average *average);

/* Take in a turn. `keep`: what one turn leaves of the weight of those before, 0 to 1. */
void average_add(struct average *average, const struct estimate *turn, double keep);

/* The average in place of the turn's own values and covariances. */
void average_apply(const struct average *average, struct estimate *turn);

#endif
