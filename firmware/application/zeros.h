/* SPDX-License-Identifier: Apache-2.0 */

/* Finds lost counts from the heads' angles at their indices. */

#ifndef ARCTRUE_ZEROS_H
#define ARCTRUE_ZEROS_H

#include "state.h"

/* Returns the angle of a head at its last index if it differs from `known` by more than the repeatability of the index;
   otherwise `known`. */
int32_t zeros_look(const struct application *application, uint32_t head, int32_t known);

/* Forgets both heads' zeros; the next index of each head defines them again. */
void zeros_forget(struct application *application);

/* Raises an alarm if head 1's angle at its index is not 0: counts were lost, or the mark is false. The
   correction stays on, displaced by this angle, until the core has proven a mark and moves the zero. A mark
   far from the index is probably a false pulse. */
void zeros_watch_doubt(struct application *application);

/* Subtracts the counts that head 2 lost, if its index shows a loss, from head 2's words from the next turn on. The turn
   in which the loss changes has an index error and is refused, so that no turn uses the loss of another turn. */
void zeros_follow_head2(struct application *application);

/* Tells whether the core moved the zero of head 1, with the correction on, since the last call. */
bool zeros_moved(struct application *application);

/* Looks for lost counts between two turns: an index proves them at once, while the bank may become full only minutes
   later. */
void zeros_watch(struct application *application);

#endif
