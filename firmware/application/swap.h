/* SPDX-License-Identifier: Apache-2.0 */

/* Writes a candidate, that is, new coefficients, into the idle coefficient bank and swaps the banks. The failover is
   off meanwhile: a head's fault that begins and ends in this time is detected only at the head's next index. */

#ifndef ARCTRUE_SWAP_H
#define ARCTRUE_SWAP_H

#include "state.h"

enum swap_answer {
    SWAP_ASKED,
    /* The content of the idle bank differs from the written words. */
    SWAP_NOT_READ_BACK,
    /* The candidate uses a head that the gateware has left out, and there is no prepared set without that head. */
    SWAP_HEAD_LEFT_OUT,
};

/* Writes the candidate and the lanes that follow a condition into the idle bank, reads them back and requests the swap.
   If the gateware has left out a head of the candidate's mean, the prepared set without that head becomes active
   instead. */
enum swap_answer swap_candidate(struct application *application, const struct followed *followed);

/* Checks whether the core has swapped; raises an alarm if the swap does not come. */
void swap_wait(struct application *application);

#endif
