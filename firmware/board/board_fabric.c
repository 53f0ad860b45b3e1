/* SPDX-License-Identifier: Apache-2.0 */

#include "board_fabric.h"

#include <stddef.h>

#include "clocks.h"
#include "memory_mapped.h"
#include "timer.h"
#include "watchdog.h"

#define TICKS_A_MICROSECOND (CLOCKS_TIMER_HZ / 1000000U)

static struct fabric fabric;

static uint32_t read_word(void *context, uint32_t address) {
    (void)context;
    return register_read(address);
}

static void write_word(void *context, uint32_t address, uint32_t word) {
    (void)context;
    register_write(address, word);
    /* Waits for the write to end, because it may set a pin, clock, reset or level shifter on which the next access to
       another device depends. */
    registers_settle();
}

static uint32_t microseconds(void *context) {
    (void)context;
    return (uint32_t)(timer_ticks() / TICKS_A_MICROSECOND);
}

const struct register_access *board_registers(void) {
    static const struct register_access access = {read_word, write_word, microseconds, NULL};
    return &access;
}

enum fabric_state board_fabric_start(void) {
    fabric_prepare(&fabric, board_registers());
    while (fabric_step(&fabric)) {
        watchdog_feed();
    }
    return fabric.state;
}

enum fabric_state board_fabric_state(void) {
    return fabric.state;
}

enum fabric_state board_fabric_look_again(void) {
    fabric_look_again(&fabric);
    return fabric.state;
}

bool board_fabric_usable(void) {
    return fabric_usable(&fabric);
}

bool board_fabric_emulated(void) {
    return fabric.emulated;
}
