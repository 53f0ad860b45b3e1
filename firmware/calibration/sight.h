/* SPDX-License-Identifier: Apache-2.0 */

/* Declares a sight, which is one turn's result for one order of head 1's error, and computes how strongly this result
   supports a value. */

#ifndef ARCTRUE_SIGHT_H
#define ARCTRUE_SIGHT_H

#include "vector.h"

enum sight_state {
    SIGHT_CLEAR,
    /* This turn cannot show the order, because its samples cannot separate the order from other orders. */
    SIGHT_BLURRED,
    /* No turn can show the order, because its error is the same under both heads, or differs so little that the noise
       gain exceeds the limit. */
    SIGHT_UNSEEN,
};

struct sight {
    enum sight_state state;
    /* Cosine and sine, arcsec; x in the formulas below. */
    struct vector value;
    /* Variance of a component, arcsec^2: due to the noise of the turn; due to the uncertainty of the separation, whose
       error is the same in every turn; and due to changes within the turn. */
    double variance;
    double by_separation;
    double by_change;
};

/* Returns the logarithm of the likelihood ratio of the applied value a to no correction of the order: (|x|^2 - |x -
   a|^2) / 2u^2. The values of several turns are added (Wald's sequential test). */
double sight_evidence(const struct sight *sight, struct vector applied);

/* Returns |x - a|, arcsec. */
double sight_left(const struct sight *sight, struct vector applied);

/* Returns the variance of a component due to all three causes, arcsec^2. */
double sight_variance(const struct sight *sight);

#endif
