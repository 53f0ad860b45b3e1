/* SPDX-License-Identifier: Apache-2.0 */

/* The temperature of the die by the converter of the fabric (XADC), which the processor reaches
   over a serial port of its own (UG480, chapter 2; UG585, chapter 30). */

#ifndef ARCTRUE_DIE_TEMPERATURE_H
#define ARCTRUE_DIE_TEMPERATURE_H

#include <stdbool.h>
#include <stdint.h>

#include "register_access.h"

/* Switch the port on; needed once. */
void die_temperature_prepare(const struct register_access *access);

/* False where the converter does not answer or says what no working die has; `celsius` then
   stays as it was. Takes some microseconds, at most DIE_TEMPERATURE_TIMEOUT_US an answer. */
bool die_temperature_read(const struct register_access *access, double *celsius);

/* From the status register, whose upper 12 bits are the code. UG480: T = code 503.975 K / 4096
   less 273.15. False below -55 or above 150 degrees: a stuck line reads as one of the ends. */
bool die_temperature_of(uint32_t status, double *celsius);

#define DIE_TEMPERATURE_TIMEOUT_US 1000U

#endif
