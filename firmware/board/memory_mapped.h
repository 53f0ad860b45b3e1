/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_MEMORY_MAPPED_H
#define ARCTRUE_MEMORY_MAPPED_H

#include <stdint.h>

/* Returns the address at which the program sees a device. The translation table in start.S covers the first 256 MB
   only, and shows the device at `address` in this range: the first hexadecimal digit becomes 0, and the second digit
   becomes the exclusive or of the first two. */
static inline uintptr_t seen_at(uint32_t address) {
    return (address ^ (address >> 4 & 0x0F000000U)) & 0x0FFFFFFFU;
}

static inline volatile uint32_t *register_at(uint32_t address) {
    return (volatile uint32_t *)seen_at(address);
}

static inline void register_write(uint32_t address, uint32_t word) {
    *register_at(address) = word;
}

/* Reads the register that the program sees at `seen`. Returns 0 if the bus answers with an error, which causes a fault
   in register_read(). */
uint32_t register_probe(uintptr_t seen);

/* Waits until all earlier accesses to devices have ended, so that later accesses find their effects, also in other
   devices. */
static inline void registers_settle(void) {
    __asm__ volatile("dsb" ::: "memory");
}

static inline uint32_t register_read(uint32_t address) {
    return *register_at(address);
}

#endif
