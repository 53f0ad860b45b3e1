/* SPDX-License-Identifier: Apache-2.0 */

/* A fault of the program: the correction goes to bypass, which the fabric ramps; a record is kept
   beyond the reset; one line goes to the console; the firmware begins anew. */

#ifndef ARCTRUE_FAULT_H
#define ARCTRUE_FAULT_H

#include <stdint.h>

enum fault_code {
    FAULT_NONE,
    FAULT_UNDEFINED_INSTRUCTION,
    FAULT_SUPERVISOR_CALL,
    FAULT_PREFETCH_ABORT,
    FAULT_DATA_ABORT,
    FAULT_STACK_OVERFLOW,
    FAULT_WATCHDOG,
    FAULTS,
};

/* Why the firmware began; FAULT_NONE at power-on. Forgets it. */
enum fault_code fault_last(void);
const char *fault_name(enum fault_code code);

#endif
