/* SPDX-License-Identifier: Apache-2.0 */

/* The heads' angles at their indices: counts that were lost show there. */

#ifndef ARCTRUE_ZEROS_H
#define ARCTRUE_ZEROS_H

#include "state.h"

/* The angle of a head at its last index where it is not the one that is known, within the
   repeatability of the index; `known` otherwise. */
int32_t zeros_look(const struct application *application, uint32_t head, int32_t known);

/* Forgets both heads' zeros: they are made anew by the next index of each head. */
void zeros_forget(struct application *application);

/* Head 1's angle at its index is not 0: counts were lost, or the mark is false. The correction stays
   on, beside its place by that: the core moves the zero when a mark is proven. A mark far from
   the index is rather a pulse that is none. */
void zeros_watch_doubt(struct application *application);

/* Where an index says that head 2 lost counts: what its zero is off by is taken off its words from
   the next turn on. Every change of it is an index error of the turn in which it came, so that no
   turn is taken with another's. */
void zeros_follow_head2(struct application *application);

/* The core has moved the zero of head 1, with the correction on, since it was looked at. */
bool zeros_moved(struct application *application);

/* Between two turns: looks for lost counts at the index that proves it, not with the bank: that may be full minutes later. */
void zeros_watch(struct application *application);

#endif
