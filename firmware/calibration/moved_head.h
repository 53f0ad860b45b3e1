/* SPDX-License-Identifier: Apache-2.0 */

/* Finds the head that has moved along the scale since the offsets of a mean were set.
   sim/arctrue/calibration/moved_head.py contains the same calculation. */

#ifndef ARCTRUE_MOVED_HEAD_H
#define ARCTRUE_MOVED_HEAD_H

#include "heads.h"

struct moved_head {
    /* Number of the head, from 1 on; 0: no head, or more than one head could have moved. */
    uint32_t head;
    double moved_rad;
};

/* Finds the moved head. `geometry` comes from a turn of four heads; `offset_rad` holds the earlier offsets of their
   readings. A head counts as moved if its motion and a motion of the axis below 5 um explain the changes of all
   offsets, and neither the axis alone nor the motion of another head explains them. */
struct moved_head moved_head_find(const struct heads_geometry *geometry,
                                  const double offset_rad[HEADS_MOST]);

#endif
