/* SPDX-License-Identifier: Apache-2.0 */

/* What one turn says of one order of head 1's error, and how far that speaks for a value. */

#ifndef ARCTRUE_SIGHT_H
#define ARCTRUE_SIGHT_H

#include "vector.h"

enum sight_state {
    SIGHT_CLEAR,
    /* Not in this turn: its samples cannot separate the order from others. */
    SIGHT_BLURRED,
    /* In no turn: both heads see the same of it. */
    SIGHT_UNSEEN,
};

struct sight {
    enum sight_state state;
    /* Cosine and sine, arcsec; x below. */
    struct vector value;
    /* Of a component, arcsec^2: by the noise of the turn; by the separation, which is the same in
       every turn; and by what has changed within the turn. */
    double variance;
    double by_separation;
    double by_change;
};

/* Logarithm of the likelihood ratio of the applied value a to no correction of the order:
   (|x|^2 - |x - a|^2) / 2u^2. Those of turns are added (Wald's sequential test). */
double sight_evidence(const struct sight *sight, struct vector applied);

/* |x - a|, arcsec. */
double sight_left(const struct sight *sight, struct vector applied);

/* Variance of a component by all three, arcsec^2. */
double sight_variance(const struct sight *sight);

#endif
