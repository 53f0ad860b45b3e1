/* SPDX-License-Identifier: Apache-2.0 */

/* Averages estimates over turns: each turn is weighted by its inverse variance, and each turn multiplies the weight of
   the earlier turns by a forgetting factor. */

#ifndef ARCTRUE_AVERAGE_H
#define ARCTRUE_AVERAGE_H

#include "estimate.h"

struct average_order {
    double cosine;
    double sine;
    /* Variances of the average, arcsec^2. */
    double variance_cosine;
    double variance_sine;
    double covariance;
    /* Sum of the weights after forgetting, 1/arcsec^2; 0: no turn yet. */
    double weight;
};

struct average {
    struct average_order order[ORDERS_MAX];
    uint32_t turns;
};

void average_clear(struct average *average);

/* Adds a turn. `keep`: factor, 0 to 1, by which this turn multiplies the weight of the earlier turns. */
void average_add(struct average *average, const struct estimate *turn, double keep);

/* Replaces the turn's own values and covariances by the values and covariances of the average. */
void average_apply(const struct average *average, struct estimate *turn);

#endif
