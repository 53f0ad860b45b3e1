/* SPDX-License-Identifier: Apache-2.0 */

/* Reads the memory bank that holds a captured turn, copies it for the console, or detects that no bank becomes
   ready. */

#ifndef ARCTRUE_BANK_H
#define ARCTRUE_BANK_H

#include "state.h"

/* If the table has made more than four turns while no bank became ready, raises an alarm, switches the correction off
   and restarts the capture; call it while no bank is ready. It does not watch a capture that an external signal
   triggers, because the signal may be absent. */
void bank_watch(struct application *application);

/* Fills `header` and `capture` from the bank that is ready. */
void bank_take(struct application *application);

/* Copies the capture that bank_take() has filled, because the console needs seconds to print a capture. The copy
   contains the present temperature of the die. Sets `dump` to DUMP_COPIED, or to DUMP_NOT_COPIED if the copy is
   impossible. */
void bank_copy(struct application *application);

#endif
