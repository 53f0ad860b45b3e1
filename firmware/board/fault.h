/* SPDX-License-Identifier: Apache-2.0 */

/* A fault of the program, or a program that hangs: a record is kept; one line goes to the console; the
   firmware begins anew. The fabric is left as it is: it goes on with the last coefficients. A reset of
   the system clears the on-chip memory and the record with it; the fault's name alone outlives it, in
   REBOOT_STATUS. */

#ifndef ARCTRUE_FAULT_H
#define ARCTRUE_FAULT_H

#include <stdint.h>

#include "kept_settings.h"

enum fault_code {
    FAULT_NONE,
    FAULT_UNDEFINED_INSTRUCTION,
    FAULT_SUPERVISOR_CALL,
    FAULT_PREFETCH_ABORT,
    FAULT_DATA_ABORT,
    FAULT_STACK_OVERFLOW,
    FAULT_WATCHDOG,
    FAULT_HANG,
    /* A write that the bus refused, told some instructions later. */
    FAULT_BUS_ERROR,
    /* ASSERT() of what must never be otherwise. */
    FAULT_ASSERTION,
    FAULTS,
};

/* Kept in memory that no new start clears. */
struct fault_record {
    uint32_t mark;
    uint32_t code;
    uint32_t instruction;
    uint32_t address;
    uint32_t state;
    /* Of the four words above: memory that was never written holds anything. */
    uint32_t check;
};

/* Why the firmware began; FAULT_NONE at power-on, instruction 0 where it is not known. Forgets it,
   so that a later reset is not taken for this one. */
struct fault_record fault_last(void);

/* In the same memory as the record; a reset of the system clears them. */
struct kept_settings *fault_kept_settings(void);
/* What was written there is no longer in a cache that the next start invalidates. */
void fault_keep(void);

/* From now on a write that the bus refuses is a fault. One from before comes at once. */
void fault_bus_errors_on(void);

/* The program is stuck at `instruction`: as any other fault. Does not come back. */
void fault_hang(uint32_t instruction) __attribute__((noreturn));

const char *fault_name(enum fault_code code);

#endif
