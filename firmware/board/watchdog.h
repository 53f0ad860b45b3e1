/* SPDX-License-Identifier: Apache-2.0 */

/* Restarts a firmware that hangs, by two watchdogs. If the main program does not feed the watchdogs for
   WATCHDOG_HANG_S, the timer's interrupt records the instruction at which it hangs and restarts the firmware. If the
   processor takes no interrupts either, its own watchdog resets only the processor after WATCHDOG_S: the fabric, its
   clock and its reset are not affected, and the memory is kept. */

#ifndef ARCTRUE_WATCHDOG_H
#define ARCTRUE_WATCHDOG_H

#include <stdbool.h>

#define WATCHDOG_S 4U
/* Time after which the main program counts as hung, much longer than the longest calibration. */
#define WATCHDOG_HANG_S 2U

void watchdog_start(void);
void watchdog_feed(void);
/* Tells whether the watchdog has reset the processor; the call clears this. */
bool watchdog_has_reset(void);

/* Tells whether the main program hangs, that is, has not fed the watchdog for WATCHDOG_HANG_S. */
bool watchdog_is_overdue(void);

#endif
