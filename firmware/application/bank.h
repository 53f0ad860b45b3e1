/* SPDX-License-Identifier: Apache-2.0 */

/* Takes a bank of the capture, copies it for the console, or detects that no bank comes. */

#ifndef ARCTRUE_BANK_H
#define ARCTRUE_BANK_H

#include "state.h"

/* Runs while no bank is ready. If the table has made several turns without a ready bank, the capture is stuck and is
   restarted. A capture that an external signal triggers is not watched, because the signal may be absent. */
void bank_watch(struct application *application);

/* Fills `header` and `capture` from the bank that is ready. */
void bank_take(struct application *application);

/* Copies the taken bank for the console, which needs seconds to print it. The copy contains the present temperature
   of the die. */
void bank_copy(struct application *application);

#endif
