/* SPDX-License-Identifier: Apache-2.0 */

/* Judges the sets that wait for a turn: the saved set, the received set, and the set that was loaded before a start. */

#ifndef ARCTRUE_JUDGE_SETS_H
#define ARCTRUE_JUDGE_SETS_H

#include "judge.h"
#include "state.h"

/* Returns the number of used lanes; 0 for NULL. */
uint32_t judge_sets_lanes_used(const struct coefficients *coefficients);
/* Judges a mean only by the places of its heads: a turn shows whether the heads are at the places that the mean's
   offsets give. The lanes of a mean are not judged, because they do not describe head 1's error. */
enum judgement judge_sets_mean(struct application *application, const struct turn *turn,
                               const struct mean_set *set);
/* Judges each set that waits, until one becomes the candidate. */
void judge_sets(struct application *application, const struct turn *turn);

#endif
