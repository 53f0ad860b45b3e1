/* SPDX-License-Identifier: Apache-2.0 */

#include "timer.h"

#include "clocks.h"
#include "memory_mapped.h"
#include "registers.h"

#define TICKS_AN_INTERRUPT (CLOCKS_TIMER_HZ / 1000U * TIMER_INTERRUPT_MS)
#define CONTROL_RUN 0x01U
#define CONTROL_COMPARE_INTERRUPT_REPEAT 0x0FU

uint64_t timer_ticks(void) {
    for (;;) {
        uint32_t high = register_read(TIMER_HIGH);
        uint32_t low = register_read(TIMER_LOW);
        if (register_read(TIMER_HIGH) == high) {
            return (uint64_t)high << 32 | low;
        }
    }
}

void timer_set_up(void) {
    register_write(TIMER_CONTROL, CONTROL_RUN);
    uint64_t first = timer_ticks() + TICKS_AN_INTERRUPT;
    register_write(TIMER_COMPARE_LOW, (uint32_t)first);
    register_write(TIMER_COMPARE_HIGH, (uint32_t)(first >> 32));
    register_write(TIMER_INCREMENT, TICKS_AN_INTERRUPT);
    register_write(TIMER_STATUS, 1);
    register_write(TIMER_CONTROL, CONTROL_COMPARE_INTERRUPT_REPEAT);
}

void timer_interrupt(void) {
    register_write(TIMER_STATUS, 1);
}
