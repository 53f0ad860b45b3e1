/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_TIMER_H
#define ARCTRUE_TIMER_H

#include <stdint.h>

/* Interval of the timer's interrupt. The firmware detects an event without an interrupt of its own after this time at
   the latest. */
#define TIMER_INTERRUPT_MS 5U

/* Starts the global timer and its interrupt. */
void timer_set_up(void);
void timer_interrupt(void);
/* Returns the time in ticks of CLOCKS_TIMER_HZ. */
uint64_t timer_ticks(void);

#endif
