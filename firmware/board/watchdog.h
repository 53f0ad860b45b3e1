/* SPDX-License-Identifier: Apache-2.0 */

/* Two of them. Where the main program does not feed for WATCHDOG_HANG_S, the timer's interrupt
   notes where it hangs and begins anew. Where not even interrupts are taken, the processor's own
   watchdog resets the processor after WATCHDOG_S, and nothing but it: the fabric, its clock and its
   reset go on, and the memory is kept. */

#ifndef ARCTRUE_WATCHDOG_H
#define ARCTRUE_WATCHDOG_H

#include <stdbool.h>

#define WATCHDOG_S 4U
/* More than the longest calibration by far. */
#define WATCHDOG_HANG_S 2U

void watchdog_start(void);
void watchdog_feed(void);
/* The processor began because the watchdog reset it; asked once. */
bool watchdog_has_reset(void);

/* The main program has not fed it for WATCHDOG_HANG_S: it hangs. */
bool watchdog_is_overdue(void);

#endif
