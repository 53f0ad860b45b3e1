/* SPDX-License-Identifier: Apache-2.0 */

#include "average.h"

#include <math.h>
#include <string.h>

#include "assertion.h"

/* A turn without any noise must not weigh infinitely, arcsec^2. */
#define LEAST_VARIANCE 1e-18
/* An order that differs from its average by less than so many standard deviations of what the table's change
   within the turn can do is not a change of the order; 32 orders exceed it by chance in 1 % of the turns. */
#define CHANGE_SIGMAS 4.0

void average_clear(struct average *average) {
    memset(average, 0, sizeof *average);
}

/* x = (1 - s) x + s y has the variance (1 - s)^2 V + s^2 v for turns independent of each other. */
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

/* The turn's value of an order whose difference from the average the change of another order explains; an order
   that has no average yet differs from zero. */
static bool explained_by_change(const struct average_order *average, const struct harmonic *turn) {
    double noise = 0.5 * (turn->variance_cosine + turn->variance_sine);
    double change = turn->by_change * turn->by_change;
    double cosine = turn->cosine - average->cosine;
    double sine = turn->sine - average->sine;
    double limit = CHANGE_SIGMAS * CHANGE_SIGMAS * (noise + change);
    return change > noise && cosine * cosine + sine * sine < limit;
}

void average_add(struct average *average, const struct estimate *turn, double keep) {
    ASSERT(turn->orders <= ORDERS_MAX && keep >= 0.0 && keep <= 1.0);
    for (uint32_t place = 0; place < turn->orders; place++) {
        struct average_order *order = &average->order[place];
        const struct harmonic *harmonic = &turn->harmonic[place];
        if (harmonic->seen && !explained_by_change(order, harmonic)) {
            add_order(order, harmonic, keep);
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
            harmonic->by_change = 0.0;
        }
    }
}
