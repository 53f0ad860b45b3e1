/* SPDX-License-Identifier: Apache-2.0 */

/* Prepares the judgement of coefficients by a turn of two heads. */

#ifndef ARCTRUE_TURN_JUDGE_H
#define ARCTRUE_TURN_JUDGE_H

#include "judge.h"
#include "state.h"

/* Returns the active coefficients if their lanes correct head 1, otherwise NULL: lanes of a mean do not describe head
   1's error. */
const struct coefficients *turn_judge_active_of_head1(const struct application *application);
/* Returns the judge with this turn's motion, estimate and change of the error; the caller adds the followed lanes. */
struct judge turn_judge(struct application *application, const struct turn *turn);

#endif
