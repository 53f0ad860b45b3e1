/* SPDX-License-Identifier: Apache-2.0 */

/* Restarts a firmware that hangs, in one of two ways. If the main program has not fed the processor's watchdog for
   WATCHDOG_HANG_S, the interrupt handler of the global timer records the instruction at which the program hangs and
   restarts the firmware. If the processor takes no interrupts either, the watchdog resets the processor WATCHDOG_S
   after the last feeding. The watchdog resets nothing else: the fabric, its clock and its reset are not affected, and
   the memory is kept. */

#ifndef ARCTRUE_WATCHDOG_H
#define ARCTRUE_WATCHDOG_H

#include <stdbool.h>

#define WATCHDOG_S 4U
/* Time without a feeding after which the main program counts as hung, at least twice the longest calibration. */
#define WATCHDOG_HANG_S 2U

void watchdog_start(void);
void watchdog_feed(void);
/* Tells whether the watchdog has reset the processor; the call clears the flag. */
bool watchdog_has_reset(void);

/* Tells whether the main program hangs, that is, has not fed the watchdog for WATCHDOG_HANG_S. */
bool watchdog_is_overdue(void);

#endif
