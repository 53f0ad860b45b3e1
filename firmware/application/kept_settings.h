/* SPDX-License-Identifier: Apache-2.0 */

/* What the operator has ordered, in memory that a new start after a fault does not clear.

   Two copies, written in turn: a fault in the middle of a write leaves the one before. */

#ifndef ARCTRUE_KEPT_SETTINGS_H
#define ARCTRUE_KEPT_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>

#include "parameters.h"

/* Switches are 0 or 1. */
struct settings {
    struct parameters parameters;
    uint32_t frozen;
    uint32_t bypassed;
    uint32_t telemetry;
    /* New starts after a fault since the firmware last worked for a while. */
    uint32_t faults_in_a_row;
};

struct settings_copy {
    /* Of this structure: another layout is not read. */
    uint32_t size;
    /* The later copy has one more, modulo 2^32. */
    uint32_t sequence;
    struct settings settings;
    uint32_t unused;
    /* CRC-32 of all words above. */
    uint32_t check;
};

struct kept_settings {
    struct settings_copy copy[2];
};

/* The later of the copies that are whole and hold values that the console would take; false, and
   `settings` as it was, where there is none. */
bool kept_settings_read(const struct kept_settings *kept, struct settings *settings);

/* Into the copy that is not the later whole one. */
void kept_settings_write(struct kept_settings *kept, const struct settings *settings);

#endif
