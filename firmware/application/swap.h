/* SPDX-License-Identifier: Apache-2.0 */

/* A candidate goes into the idle bank, and the banks are swapped. */

#ifndef ARCTRUE_SWAP_H
#define ARCTRUE_SWAP_H

#include "state.h"

/* Writes the candidate into the idle bank, reads it back and swaps. False: the idle bank does not hold what was written. */
bool swap_candidate(struct application *application, const struct followed *followed);

/* Looks whether the core has swapped; a swap that does not come is an alarm. */
void swap_wait(struct application *application);

#endif
