/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the words of the weighted mean of two to four heads: theta = r_s + sum of w_i (r_i - r_s) - E(r_s) with r_i
   = R_i - o_i. R_i is the reading of head i, o_i its offset, w_i its weight; E is the error that the lanes and a
   constant correct. */

#ifndef ARCTRUE_MEAN_SET_H
#define ARCTRUE_MEAN_SET_H

#include <stdbool.h>
#include <stdint.h>

#include "arctrue_number_formats.h"

enum { HEADS_MOST = ARCTRUE_HEADS_MAX };

struct mean_set {
    /* Number of heads; 0: no mean is formed, head 1 alone is corrected. */
    uint32_t heads;
    /* Head that the mean follows (index s of the equation), counted from 0. */
    uint32_t carrier;
    /* One bit per head: the mean includes this head and waits for its index. */
    uint32_t used;
    /* Constant term of E, s13.11 counts. */
    int32_t error_offset;
    /* Clocks by which the gateware delays the levels of a head, one byte per head, head 1 in the lowest byte. */
    uint32_t delays;
    /* Weights, s1.16; their sum is 65536. */
    int32_t weight[HEADS_MOST];
    /* Offsets, u24.4 counts. */
    uint32_t offset[HEADS_MOST];
};

/* Tells whether the gateware can hold every word and the words form a mean of `heads` heads. */
bool mean_set_is_valid(const struct mean_set *set, uint32_t heads, uint32_t counts_per_rev);

/* Returns the largest distance, in counts, between the measured place of a used head and the place that its offset
   states, both relative to the carrier. `place`: mean over a turn of each head's reading minus head 1's, counts. */
double mean_set_off(const struct mean_set *set, const double place[HEADS_MOST],
                    uint32_t counts_per_rev);

#endif
