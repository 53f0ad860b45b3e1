/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_MEMORY_MAPPED_H
#define ARCTRUE_MEMORY_MAPPED_H

#include <stdint.h>

static inline volatile uint32_t *register_at(uint32_t address) {
    return (volatile uint32_t *)(uintptr_t)address;
}

static inline void register_write(uint32_t address, uint32_t word) {
    *register_at(address) = word;
}

/* Reads like register_read(), but returns 0 if the bus answers with an error, which otherwise causes a fault. */
uint32_t register_probe(uint32_t address);

/* Waits until all earlier accesses to devices have ended, so that later accesses find their effects, also in other
   devices. */
static inline void registers_settle(void) {
    __asm__ volatile("dsb" ::: "memory");
}

static inline uint32_t register_read(uint32_t address) {
    return *register_at(address);
}

#endif
