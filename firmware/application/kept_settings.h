/* SPDX-License-Identifier: Apache-2.0 */

/* Keeps the operator's settings in memory that a restart after a fault does not clear.

   Two copies are written in turn, so that a fault during a write leaves the previous copy whole. */

#ifndef ARCTRUE_KEPT_SETTINGS_H
#define ARCTRUE_KEPT_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

#include "parameters.h"

/* The switches `frozen`, `bypassed` and `telemetry` are 0 or 1. */
struct settings {
    struct parameters parameters;
    uint32_t frozen;
    uint32_t bypassed;
    uint32_t telemetry;
    /* Number of restarts after faults in a row; it returns to 0 after 20 turns without a fault and by a re-arm. */
    uint32_t faults_in_a_row;
};

struct settings_copy {
    /* Size of this structure; a copy of another size is not read. */
    uint32_t size;
    /* Number of the copy; the later copy has the next number, modulo 2^32. */
    uint32_t sequence;
    struct settings settings;
    uint32_t unused;
    /* CRC-32 of all words above. */
    uint32_t check;
};

struct kept_settings {
    struct settings_copy copy[2];
};

/* Reads the later of the copies that are complete and whose values the console would accept. If there is no such copy,
   it returns false and leaves `settings` unchanged. */
bool kept_settings_read(const struct kept_settings *kept, struct settings *settings);

/* Writes the settings over the earlier copy, so that a fault during the write leaves the later copy whole. */
void kept_settings_write(struct kept_settings *kept, const struct settings *settings);

#endif
