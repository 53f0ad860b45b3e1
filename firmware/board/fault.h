/* SPDX-License-Identifier: Apache-2.0 */

/* Handles a fault of the program, or a program that hangs: writes a record, prints one line on the console, and
   restarts the firmware. The fabric is not touched and continues with the last coefficients. A reset of the system
   clears the on-chip memory with the record; only the name of the fault survives it, in REBOOT_STATUS. */

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
    /* The bus refused a write and reported it some instructions later. */
    FAULT_BUS_ERROR,
    /* An ASSERT() failed. */
    FAULT_ASSERTION,
    FAULTS,
};

/* Record in memory that no restart clears. */
struct fault_record {
    uint32_t mark;
    uint32_t code;
    uint32_t instruction;
    uint32_t address;
    uint32_t state;
    /* Check of the four words above, because memory that was never written has a random content. */
    uint32_t check;
};

/* Returns why the firmware restarted: FAULT_NONE at power-on; instruction 0 if it is not known. It clears the
   record, so that a later reset is not attributed to this fault. */
struct fault_record fault_last(void);

/* Returns the kept settings, which are in the same memory as the record; a reset of the system clears both. */
struct kept_settings *fault_kept_settings(void);
/* Writes the kept settings from the cache, which the next start invalidates, to memory. */
void fault_keep(void);

/* From now on every write that the bus refuses causes a fault; an earlier refusal that is still pending causes a fault
   at once. */
void fault_bus_errors_on(void);

/* Reports that the program hangs at `instruction`, and handles it like any other fault. It does not return. */
void fault_hang(uint32_t instruction) __attribute__((noreturn));

const char *fault_name(enum fault_code code);

#endif
