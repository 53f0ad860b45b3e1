/* SPDX-License-Identifier: Apache-2.0 */

/* The processor's I2C controller 0 as the master of a bus with few bytes (UG585, chapter 20).

   A device whose master was reset in the middle of a byte holds SDA low until it has had its clocks, which
   the controller cannot send then. Two general-purpose pins are wired to the same bus in the fabric: they
   send up to nine clocks and a STOP (UM10204, 3.1.16), and the controller is reset. */

#ifndef ARCTRUE_I2C_H
#define ARCTRUE_I2C_H

#include <stdbool.h>
#include <stdint.h>

#include "register_access.h"

/* Bytes of a transfer at most: the controller's queue. */
enum { I2C_BYTES_MOST = 16 };

/* Free the bus and switch the controller on at 100 kHz or a little less; `bus_hz` is the clock of the controller. */
void i2c_prepare(const struct register_access *access, uint32_t bus_hz);

/* To or from a device of seven bits of address. False: nobody answers, or the bus is stuck, and was
   freed as far as it can be; takes 5.2 ms at most. */
bool i2c_write(const struct register_access *access, uint32_t device, const uint8_t *bytes,
               uint32_t number);
bool i2c_read(const struct register_access *access, uint32_t device, uint8_t *bytes,
              uint32_t number);

#endif
