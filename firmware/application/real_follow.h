/* SPDX-License-Identifier: Apache-2.0 */

/* Determines the phases of the active lanes whose order is not an integer (real orders), and updates them: from the
   difference of the heads in every turn, or from the edges of the drive's index pulse at the input probe_in. */

#ifndef ARCTRUE_REAL_FOLLOW_H
#define ARCTRUE_REAL_FOLLOW_H

#include "state.h"

/* Adds a verified, aligned and estimated turn to the line finder of each lane whose phase comes from the heads. Lanes
   of a mean get no phase from the heads. */
void real_follow_turn(struct application *application, const struct turn *turn);
/* Computes the phases from the last edge at probe_in. It ignores the edge if the angle has not risen since then: in
   falling motion the rising edge is the opposite end of the index pulse. */
void real_follow_probe(struct application *application);

#endif
