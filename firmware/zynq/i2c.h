/* SPDX-License-Identifier: Apache-2.0 */

/* Uses the processor's I2C controller 0 as the master of a bus, for transfers of at most 16 bytes (UG585, chapter 20).

   If a master was reset in the middle of a byte, the device holds SDA low until it gets the remaining clocks of the
   byte, which the controller cannot send while SDA is low. Two general-purpose pins are wired to the same bus in the
   fabric: they send up to nine clocks and a STOP (UM10204, 3.1.16), and the controller is reset. */

#ifndef ARCTRUE_I2C_H
#define ARCTRUE_I2C_H

#include <stdbool.h>
#include <stdint.h>

#include "register_access.h"

/* Largest number of bytes per transfer: the queue of the controller. */
enum { I2C_BYTES_MOST = 16 };

/* Frees the bus and enables the controller at 100 kHz or a little less; `bus_hz` is the clock of the controller. */
void i2c_prepare(const struct register_access *access, uint32_t bus_hz);

/* Writes to, or reads from, a device with a 7-bit address. Returns false if no device answers, or if the bus is stuck
   and was freed as far as possible. A call takes 5.2 ms at most. */
bool i2c_write(const struct register_access *access, uint32_t device, const uint8_t *bytes,
               uint32_t number);
bool i2c_read(const struct register_access *access, uint32_t device, uint8_t *bytes,
              uint32_t number);

#endif
