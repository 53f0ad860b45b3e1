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

/* As register_read, but 0 where the bus answers with an error, which is a fault else. */
uint32_t register_probe(uint32_t address);

/* All accesses to devices made so far have ended: what follows meets what they brought about, in
   other devices too. */
static inline void registers_settle(void) {
    __asm__ volatile("dsb" ::: "memory");
}

static inline uint32_t register_read(uint32_t address) {
    return *register_at(address);
}

#endif
