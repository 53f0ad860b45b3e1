/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the access of the files core_*.c to single registers. */

#ifndef ARCTRUE_CORE_REGISTERS_H
#define ARCTRUE_CORE_REGISTERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "arctrue_registers.h"
#include "core_access.h"

#define AT(register) ((uint32_t)offsetof(arctrue_registers_t, register))
#define BIT(name) ((uint32_t)ARCTRUE_REGISTERS__##name##_bm)
#define FIELD(word, name) (((word) & BIT(name)) >> ARCTRUE_REGISTERS__##name##_bp)

/* `HEADS`: number of heads of every core. */
enum { WORD_BYTES = 4, HEADS = 2 };

uint32_t core_read(const struct core_access *core, uint32_t offset);
void core_write(const struct core_access *core, uint32_t offset, uint32_t word);
/* Reads a word of 64 bits; the read of the low word latches the high word. */
uint64_t core_read_wide(const struct core_access *core, uint32_t offset);
/* Returns the register `capability`. Gateware of an earlier minor version does not have this register; for it the
   function returns the configuration with two heads. */
uint32_t core_capability(const struct core_access *core);
/* Returns the number of heads whose capture the firmware can read. */
uint32_t core_heads(const struct core_access *core);
bool core_has_real_orders(const struct core_access *core);

#endif
