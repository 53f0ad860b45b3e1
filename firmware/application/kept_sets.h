/* SPDX-License-Identifier: Apache-2.0 */

/* Converts the sets for a missing head (coefficients that apply while one head is left out of the mean) to and from the
   words in which `save` keeps them.

   Words of a set:
     0      missing head, counted from 1, in bits 7 to 0; number of lanes in bits 15 to 8
     1      constant part of the error
     2      carrier in bits 1 to 0, used heads in bits 7 to 4
     3..10  four weights, four offsets; mean_set.h
     then two words a lane: phase offset, amplitude; bits 31 to 24 of them hold the order, its low byte first */

#ifndef ARCTRUE_KEPT_SETS_H
#define ARCTRUE_KEPT_SETS_H

#include <stdbool.h>
#include <stdint.h>

#include "coefficients.h"

enum {
    KEPT_HEAD_WORDS = 3 + 2 * HEADS_MOST,
    KEPT_LANE_WORDS = 2,
    /* Largest number of lanes of a kept set: the gateware's block RAM holds all sets if they have at most 32 lanes. */
    KEPT_LANES_MOST = 32,
    KEPT_SETS_WORDS = HEADS_MOST * (KEPT_HEAD_WORDS + KEPT_LANES_MOST * KEPT_LANE_WORDS),
};

struct kept_sets {
    uint32_t number;
    uint32_t word[KEPT_SETS_WORDS];
};

/* Appends the set without head `head`, counted from 1. Returns false if the set has too many lanes or does not fit
   behind the other sets. */
bool kept_sets_add(struct kept_sets *kept, uint32_t head, const struct coefficients *set);

/* Reads the set that begins at word `*place`, and moves `*place` behind it. Returns the missing head; 0 if there is no
   further set, or if the words are invalid for `heads` heads and `counts_per_rev`. */
uint32_t kept_sets_next(const struct kept_sets *kept, uint32_t *place, uint32_t heads,
                        uint32_t counts_per_rev, struct coefficients *set);

/* Tells whether the words consist of valid sets, each for another missing head, of a mean of `heads` heads. */
bool kept_sets_are_valid(const struct kept_sets *kept, uint32_t heads, uint32_t counts_per_rev);

#endif
