/* SPDX-License-Identifier: Apache-2.0 */

/* Reads the temperature of the die from the analogue-to-digital converter of the fabric (XADC), which the processor
   reaches through a serial port (UG480, chapter 2; UG585, chapter 30). */

#ifndef ARCTRUE_DIE_TEMPERATURE_H
#define ARCTRUE_DIE_TEMPERATURE_H

#include <stdbool.h>
#include <stdint.h>

#include "register_access.h"

/* Enables the port; needed once. */
void die_temperature_prepare(const struct register_access *access);

/* Reads the temperature. Returns false if the converter does not answer or returns a value that no working die has;
   `celsius` then stays unchanged. The read takes some microseconds, at most DIE_TEMPERATURE_TIMEOUT_US per answer. */
bool die_temperature_read(const struct register_access *access, double *celsius);

/* Converts the converter's status register; the upper 12 of its 16 bits are the code. UG480: T = code 503.975 K / 4096
   - 273.15. Returns false below -55 or above 150 degC, because a data line that is stuck gives the lowest or the
   highest code. */
bool die_temperature_of(uint32_t status, double *celsius);

#define DIE_TEMPERATURE_TIMEOUT_US 1000U

#endif
