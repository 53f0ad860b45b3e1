/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_INTERRUPTS_H
#define ARCTRUE_INTERRUPTS_H

#include <stdbool.h>
#include <stdint.h>

/* Timer, UART and the fabric's line to this processor; interrupts on. */
void interrupts_set_up(void);

/* The fabric's line is a level, which only an access to the core lowers: its interrupt switches
   itself off, so that a line that is stuck costs nothing, and is switched on again when the main
   program has looked at the core. */
void interrupts_fabric_off(void);
void interrupts_fabric_on(void);

/* Sleep until an interrupt, unless work waits already. It is asked with interrupts held back, so
   that none is taken between its answer and the sleep. */
void interrupts_sleep_unless(bool (*work_waits)(void));

#endif
