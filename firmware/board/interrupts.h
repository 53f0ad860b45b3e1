/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_INTERRUPTS_H
#define ARCTRUE_INTERRUPTS_H

#include <stdbool.h>
#include <stdint.h>

/* Sets up the interrupts of timer, UART and fabric, and enables them. */
void interrupts_set_up(void);

/* These functions disable and enable the fabric's interrupt. The core's interrupt signal stays high until an access to
   the core lowers it. Therefore the interrupt handler disables the interrupt, so that a signal that stays high does not
   block the processor, and the main program enables it again after it has served the core. */
void interrupts_fabric_off(void);
void interrupts_fabric_on(void);

/* Sleeps until an interrupt, unless work waits already. Interrupts are disabled while `work_waits` is called, so
   that none can come between its answer and the sleep. */
void interrupts_sleep_unless(bool (*work_waits)(void));

#endif
