/* SPDX-License-Identifier: Apache-2.0 */

/* Measures by how much the electronics of the heads delay their readings against each other.

   A head with the delay tau reads theta(t - tau), so its offset changes by -tau times a change of the speed. Two turns at
   different speeds show the delays. A displacement of the axis or of a head between these turns cannot be distinguished
   from a delay. */

#ifndef ARCTRUE_HEAD_SKEW_H
#define ARCTRUE_HEAD_SKEW_H

#include <stdbool.h>
#include <stdint.h>

#include "heads.h"

/* A turn, for the comparison with the next one. */
struct skew_turn {
    /* Speed, rad/s; 0: not known. */
    double speed;
    /* Variance of an offset due to the noise, rad^2. */
    double variance;
    /* Number of heads whose offsets are known; 0: no turn yet. */
    uint32_t heads;
    double offset_rad[HEADS_MOST];
};

struct head_skew {
    struct skew_turn last;
    /* Number of heads that were measured in both of the compared turns; 0: no turns have been compared yet. */
    uint32_t heads;
    /* Delay of each head relative to head 1, and its standard uncertainty. The delays that the core applies to the
       readings are included. */
    double late_ns[HEADS_MOST];
    double u_ns;
};

/* Compares the turn with the last one if their speeds differ enough, and keeps the turn. */
void head_skew_add(struct head_skew *skew, const struct skew_turn *turn);

#endif
