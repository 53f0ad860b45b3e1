/* SPDX-License-Identifier: Apache-2.0 */

/* Words of the weighted mean of two to four heads: theta = r_s + sum of w_i (r_i - r_s) - E(r_s) with r_i = R_i - o_i. */

#ifndef ARCTRUE_MEAN_SET_H
#define ARCTRUE_MEAN_SET_H

#include <stdbool.h>
#include <stdint.h>

enum { HEADS_MOST = 4 };

struct mean_set {
    /* 0: no mean is formed, head 1 alone is corrected. */
    uint32_t heads;
    /* s, from 0 on. */
    uint32_t carrier;
    /* A bit a head: its index is waited for. */
    uint32_t used;
    /* E's own constant, s13.11 counts. */
    int32_t error_offset;
    /* A byte a head, head 1 in the lowest: clocks by which its levels are delayed. */
    uint32_t delays;
    /* s1.16; their sum is 65536. */
    int32_t weight[HEADS_MOST];
    /* u24.4 counts. */
    uint32_t offset[HEADS_MOST];
};

/* The gateware can hold every word, and together they are a mean of `heads` heads. */
bool mean_set_is_valid(const struct mean_set *set, uint32_t heads, uint32_t counts_per_rev);

/* The largest distance, counts, of a used head's place from where its offset says, against the carrier. `place`: of
   each head's reading against head 1's, counts, as the mean over a turn. */
double mean_set_off(const struct mean_set *set, const double place[HEADS_MOST],
                    uint32_t counts_per_rev);

#endif
