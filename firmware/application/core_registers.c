/* SPDX-License-Identifier: Apache-2.0 */

#include "core_registers.h"

#include "capture.h"

uint32_t core_read(const struct core_access *core, uint32_t offset) {
    return core->read(core->context, offset);
}

void core_write(const struct core_access *core, uint32_t offset, uint32_t word) {
    core->write(core->context, offset, word);
}

uint64_t core_read_wide(const struct core_access *core, uint32_t offset) {
    uint32_t low = core_read(core, offset);
    return (uint64_t)core_read(core, offset + WORD_BYTES) << 32 | low;
}

uint32_t core_capability(const struct core_access *core) {
    uint32_t version = core_read(core, AT(version));
    return FIELD(version, VERSION__MINOR) >= 8U ? core_read(core, AT(capability)) : HEADS;
}

uint32_t core_heads(const struct core_access *core) {
    uint32_t heads = FIELD(core_capability(core), CAPABILITY__HEADS);
    return core->further_capture != NULL && heads > HEADS && heads <= HEADS_MOST ? heads : HEADS;
}

bool core_has_real_orders(const struct core_access *core) {
    return FIELD(core_capability(core), CAPABILITY__REAL_ORDERS) != 0;
}
