/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_TIMER_H
#define ARCTRUE_TIMER_H

#include <stdint.h>

/* Start the global timer and its interrupt every millisecond. */
void timer_set_up(void);
void timer_interrupt(void);
/* Ticks of CLOCKS_TIMER_HZ. */
uint64_t timer_ticks(void);

/* The watchdog resets the system when it is not fed for WATCHDOG_S. */
#define WATCHDOG_S 4U
void watchdog_start(void);
void watchdog_feed(void);

#endif
