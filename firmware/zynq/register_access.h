/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the functions through which the drivers access the processor's own registers and memory, so that the drivers
   can be tested without the hardware. */

#ifndef ARCTRUE_REGISTER_ACCESS_H
#define ARCTRUE_REGISTER_ACCESS_H

#include <stdint.h>

typedef uint32_t register_access_read(void *context, uint32_t address);
typedef void register_access_write(void *context, uint32_t address, uint32_t word);
/* Returns the time of a clock that never stops; modulo 2^32. */
typedef uint32_t register_access_microseconds(void *context);

struct register_access {
    register_access_read *read;
    register_access_write *write;
    register_access_microseconds *microseconds;
    void *context;
};

#endif
