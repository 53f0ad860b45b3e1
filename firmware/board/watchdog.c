/* SPDX-License-Identifier: Apache-2.0 */

#include "watchdog.h"

#include <stdint.h>

#include "clocks.h"
#include "memory_mapped.h"
#include "registers.h"

/* Watchdog mode, enabled, without a prescaler. */
#define WATCHDOG_RUN 0x09U

_Static_assert((uint64_t)CLOCKS_TIMER_HZ *WATCHDOG_S <= UINT32_MAX, "the load has 32 bits");

void watchdog_start(void) {
    register_write(SLCR_RS_AWDT_CTRL, SLCR_RS_AWDT_PROCESSOR0);
    watchdog_feed();
    register_write(WATCHDOG_CONTROL, WATCHDOG_RUN);
}

void watchdog_feed(void) {
    register_write(WATCHDOG_LOAD, CLOCKS_TIMER_HZ * WATCHDOG_S);
}

bool watchdog_has_reset(void) {
    bool has = (register_read(WATCHDOG_RESET_STATUS) & WATCHDOG_RESET_TAKEN) != 0;
    register_write(WATCHDOG_RESET_STATUS, WATCHDOG_RESET_TAKEN);
    return has;
}

/* Tells whether the watchdog was last fed more than WATCHDOG_HANG_S seconds ago. */
bool watchdog_is_overdue(void) {
    uint32_t spent = CLOCKS_TIMER_HZ * WATCHDOG_S - register_read(WATCHDOG_COUNTER);
    return spent > CLOCKS_TIMER_HZ * WATCHDOG_HANG_S;
}
