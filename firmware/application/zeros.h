/* SPDX-License-Identifier: Apache-2.0 */

/* Finds lost counts from the heads' angles at their indices. */

#ifndef ARCTRUE_ZEROS_H
#define ARCTRUE_ZEROS_H

#include "state.h"

/* Evaluates the angle of a head, 0 or 1, at its last index, counts. Returns 0 if the angle is within the parameter
   `index_tolerance` of 0, `known` if it is within this tolerance of `known`, and otherwise the angle. */
int32_t zeros_look(const struct application *application, uint32_t head, int32_t known);

/* Clears the lost counts of head 2 and the doubt about the zero of head 1. It does not change the zeros of the core. */
void zeros_forget(struct application *application);

/* Checks head 1's angle at its index after an index error. If the angle is not 0, counts were lost or the mark is
   false; the correction stays on, displaced by this angle, until the core has proven a mark and moves the zero. If the
   core proves no mark within four turns, the function re-arms the core, so that the zeros are searched again, and
   raises an alarm. A mark further than 1/1024 turn from the zero is ignored, because it is probably a false pulse. */
void zeros_watch_doubt(struct application *application);

/* Stores head 2's angle at its index, which is subtracted from head 2's words from the next turn on, and reports the
   alarm zero_lost if it has changed. The turn in which it changes has an index error and is refused, so that no turn
   uses the angle of another turn. */
void zeros_follow_head2(struct application *application);

/* Tells whether the core moved the zero of head 1 since the last call. If so, reports the alarm zero_lost and arms an
   armed compare again. */
bool zeros_moved(struct application *application);

/* Looks for lost counts between two turns: an index proves them at once, while the bank may become full only minutes
   later. */
void zeros_watch(struct application *application);

#endif
