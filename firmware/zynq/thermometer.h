/* SPDX-License-Identifier: Apache-2.0 */

/* Reads the thermometer of the table on the I2C bus: an ADT7420 or a TMP117, whichever answers first. */

#ifndef ARCTRUE_THERMOMETER_H
#define ARCTRUE_THERMOMETER_H

#include <stdbool.h>
#include <stdint.h>

#include "register_access.h"

enum thermometer_kind { THERMOMETER_NONE, THERMOMETER_ADT7420, THERMOMETER_TMP117 };

struct thermometer {
    struct register_access access;
    enum thermometer_kind kind;
    uint32_t device;
};

const char *thermometer_name(enum thermometer_kind kind);

/* Searches for a thermometer at the addresses 0x48 to 0x4B; the bus must be prepared. */
void thermometer_find(struct thermometer *thermometer, const struct register_access *access);

/* Reads the temperature; the context is a struct thermometer. If the thermometer does not answer, the function returns
   false and identifies the device at the same address again, because a thermometer that was without supply has lost its
   settings. */
bool thermometer_read(void *context, double *celsius);

#endif
