/* SPDX-License-Identifier: Apache-2.0 */

#include "average.h"

#include <math.h>
#include <string.h>

#include "assertion.h"

/* Least variance, arcsec^2: it limits the weight of a turn without noise. */
#define LEAST_VARIANCE 1e-18

void average_clear(struct average *average) {
    memset(average, 0, sizeof *average);
}

/* Adds the turn's value y with the share s to the average x of an order: x = (1 - s) x + s y has the variance (1 - s)^2
   V + s^2 v if the turns are independent. */
static void add_order(struct average_order *average, const struct harmonic *turn, double keep) {
    double own = 0.5 * (turn->variance_cosine + turn->variance_sine);
    double weight = 1.0 / fmax(own, LEAST_VARIANCE);
    double total = keep * average->weight + weight;
    double share = weight / total;
    double old = (1.0 - share) * (1.0 - share);
    double new = share * share;
    average->cosine += share * (turn->cosine - average->cosine);
    average->sine += share * (turn->sine - average->sine);
    average->variance_cosine = old * average->variance_cosine + new * turn->variance_cosine;
    average->variance_sine = old * average->variance_sine + new * turn->variance_sine;
    average->covariance = old * average->covariance + new * turn->covariance;
    average->weight = total;
}

void average_add(struct average *average, const struct estimate *turn, double keep) {
    ASSERT(turn->orders <= ORDERS_MAX && keep >= 0.0 && keep <= 1.0);
    for (uint32_t place = 0; place < turn->orders; place++) {
        if (turn->harmonic[place].seen) {
            add_order(&average->order[place], &turn->harmonic[place], keep);
        }
    }
    average->turns++;
}

void average_apply(const struct average *average, struct estimate *turn) {
    ASSERT(turn->orders <= ORDERS_MAX);
    for (uint32_t place = 0; place < turn->orders; place++) {
        const struct average_order *order = &average->order[place];
        struct harmonic *harmonic = &turn->harmonic[place];
        if (harmonic->seen && order->weight > 0.0) {
            harmonic->cosine = order->cosine;
            harmonic->sine = order->sine;
            harmonic->variance_cosine = order->variance_cosine;
            harmonic->variance_sine = order->variance_sine;
            harmonic->covariance = order->covariance;
        }
    }
}
