/* SPDX-License-Identifier: Apache-2.0 */

#include "i2c.h"

#include "registers.h"

#define SCL_HZ 100000U
/* A period of SCL has 22 of the divided clock. */
#define CLOCKS_A_PERIOD 22U
#define DIVISOR_B_MOST 64U
#define TIMEOUT_US 5000U

static uint32_t read_at(const struct register_access *access, uint32_t address) {
    return access->read(access->context, address);
}

static void write_at(const struct register_access *access, uint32_t address, uint32_t word) {
    access->write(access->context, address, word);
}

static uint32_t control_word(const struct register_access *access) {
    return (read_at(access, I2C_CONTROL) & I2C_CONTROL_DIVISORS) | I2C_CONTROL_ACKNOWLEDGE |
           I2C_CONTROL_SEVEN_BITS | I2C_CONTROL_MASTER;
}

void i2c_prepare(const struct register_access *access, uint32_t bus_hz) {
    uint32_t divisor = (bus_hz + CLOCKS_A_PERIOD * SCL_HZ - 1U) / (CLOCKS_A_PERIOD * SCL_HZ);
    uint32_t first = (divisor + DIVISOR_B_MOST - 1U) / DIVISOR_B_MOST;
    uint32_t second = (divisor + first - 1U) / first;
    write_at(access, I2C_CONTROL, (first - 1U) << 14 | (second - 1U) << 8);
    write_at(access, I2C_INTERRUPTS_OFF, I2C_HAPPENED_ALL);
    write_at(access, I2C_TIME_OUT, 0xFFU);
}

/* Whatever a transfer before has left. */
static void begin(const struct register_access *access, uint32_t direction) {
    write_at(access, I2C_CONTROL, control_word(access) | I2C_CONTROL_CLEAR_QUEUE | direction);
    write_at(access, I2C_HAPPENED, I2C_HAPPENED_ALL);
}

static bool wait_until_done(const struct register_access *access) {
    uint32_t start = access->microseconds(access->context);
    for (;;) {
        uint32_t happened = read_at(access, I2C_HAPPENED);
        if (happened & I2C_HAPPENED_ERRORS) {
            return false;
        }
        if (happened & I2C_HAPPENED_DONE) {
            return true;
        }
        if (access->microseconds(access->context) - start > TIMEOUT_US) {
            return false;
        }
    }
}

bool i2c_write(const struct register_access *access, uint32_t device, const uint8_t *bytes,
               uint32_t number) {
    begin(access, 0);
    for (uint32_t place = 0; place < number && place < I2C_BYTES_MOST; place++) {
        write_at(access, I2C_DATA, bytes[place]);
    }
    /* This write starts it. */
    write_at(access, I2C_ADDRESS, device);
    return wait_until_done(access);
}

bool i2c_read(const struct register_access *access, uint32_t device, uint8_t *bytes,
              uint32_t number) {
    if (number == 0 || number > I2C_BYTES_MOST) {
        return false;
    }
    begin(access, I2C_CONTROL_READ);
    write_at(access, I2C_SIZE, number);
    write_at(access, I2C_ADDRESS, device);
    if (!wait_until_done(access)) {
        return false;
    }
    for (uint32_t place = 0; place < number; place++) {
        if ((read_at(access, I2C_STATUS) & I2C_STATUS_RECEIVED) == 0) {
            return false;
        }
        bytes[place] = (uint8_t)read_at(access, I2C_DATA);
    }
    return true;
}
