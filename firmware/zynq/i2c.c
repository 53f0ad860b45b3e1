/* SPDX-License-Identifier: Apache-2.0 */

#include "i2c.h"

#include "registers.h"

#define SCL_HZ 100000U
/* Number of periods of the divided clock in a period of SCL. */
#define CLOCKS_A_PERIOD 22U
#define DIVISOR_B_MOST 64U
#define TIMEOUT_US 5000U
/* Bits of the general-purpose pins on the same wires. */
#define SCL 1U
#define SDA 2U
enum { CLOCKS_OF_A_BYTE = 9 };
/* Time of at least half a period of 100 kHz; the clock for waiting has steps of 1 us. */
#define HALF_PERIOD_US 6U

static uint32_t read_i2c_register(const struct register_access *access, uint32_t address) {
    return access->read(access->context, address);
}

static void write_i2c_register(const struct register_access *access, uint32_t address,
                               uint32_t word) {
    access->write(access->context, address, word);
}

static uint32_t control_word(const struct register_access *access) {
    return (read_i2c_register(access, I2C_CONTROL) & I2C_CONTROL_DIVISORS) |
           I2C_CONTROL_ACKNOWLEDGE | I2C_CONTROL_SEVEN_BITS | I2C_CONTROL_MASTER;
}

/* Pulls these wires low for at least half a period and releases all others. A wire is never driven high. */
static void pull_low(const struct register_access *access, uint32_t wires) {
    write_i2c_register(access, GPIO_DIRM_2, wires);
    uint32_t start = access->microseconds(access->context);
    while (access->microseconds(access->context) - start < HALF_PERIOD_US) {
    }
}

/* Frees the bus with up to nine clocks and a STOP: a device in the middle of a byte releases SDA within nine clocks,
   and STOP then ends the transfer for the device. */
static void clock_the_bus_free(const struct register_access *access) {
    write_i2c_register(access, GPIO_DATA_2, 0);
    write_i2c_register(access, GPIO_DIRM_2, 0);
    write_i2c_register(access, GPIO_OEN_2, SCL | SDA);
    for (uint32_t clock = 0;
         clock < CLOCKS_OF_A_BYTE && (read_i2c_register(access, GPIO_DATA_2_RO) & SDA) == 0;
         clock++) {
        pull_low(access, SCL);
        pull_low(access, 0);
    }
    pull_low(access, SCL);
    pull_low(access, SCL | SDA);
    pull_low(access, SDA);
    pull_low(access, 0);
    write_i2c_register(access, GPIO_OEN_2, 0);
}

static void begin_anew(const struct register_access *access, uint32_t divisors) {
    write_i2c_register(access, SLCR_UNLOCK, SLCR_UNLOCK_KEY);
    write_i2c_register(access, SLCR_I2C_RST_CTRL, SLCR_I2C_RST_0);
    clock_the_bus_free(access);
    write_i2c_register(access, SLCR_I2C_RST_CTRL, 0);
    write_i2c_register(access, I2C_CONTROL, divisors);
    write_i2c_register(access, I2C_INTERRUPTS_OFF, I2C_HAPPENED_ALL);
    write_i2c_register(access, I2C_TIME_OUT, 0xFFU);
}

void i2c_prepare(const struct register_access *access, uint32_t bus_hz) {
    uint32_t divisor = (bus_hz + CLOCKS_A_PERIOD * SCL_HZ - 1U) / (CLOCKS_A_PERIOD * SCL_HZ);
    uint32_t first = (divisor + DIVISOR_B_MOST - 1U) / DIVISOR_B_MOST;
    uint32_t second = (divisor + first - 1U) / first;
    begin_anew(access, (first - 1U) << 14 | (second - 1U) << 8);
}

/* Clears data and flags of an earlier transfer. */
static void begin_i2c_transfer(const struct register_access *access, uint32_t direction) {
    write_i2c_register(access, I2C_CONTROL,
                       control_word(access) | I2C_CONTROL_CLEAR_QUEUE | direction);
    write_i2c_register(access, I2C_HAPPENED, I2C_HAPPENED_ALL);
}

/* Returns the events, or 0 if none came within TIMEOUT_US. */
static uint32_t wait_until_it_ends(const struct register_access *access) {
    uint32_t start = access->microseconds(access->context);
    for (;;) {
        uint32_t happened = read_i2c_register(access, I2C_HAPPENED);
        if (happened & (I2C_HAPPENED_ERRORS | I2C_HAPPENED_DONE)) {
            return happened;
        }
        if (access->microseconds(access->context) - start > TIMEOUT_US) {
            return 0;
        }
    }
}

/* Waits for the end of a transfer and tells whether it succeeded. After a fault it restarts the bus; a missing
   acknowledge is not a fault of the bus. */
static bool is_done(const struct register_access *access) {
    uint32_t happened = wait_until_it_ends(access);
    bool done = (happened & I2C_HAPPENED_DONE) != 0 && (happened & I2C_HAPPENED_ERRORS) == 0;
    if (!done && (happened & I2C_HAPPENED_NO_ACKNOWLEDGE) == 0) {
        begin_anew(access, read_i2c_register(access, I2C_CONTROL) & I2C_CONTROL_DIVISORS);
    }
    return done;
}

bool i2c_write(const struct register_access *access, uint32_t device, const uint8_t *bytes,
               uint32_t number) {
    begin_i2c_transfer(access, 0);
    for (uint32_t place = 0; place < number && place < I2C_BYTES_MOST; place++) {
        write_i2c_register(access, I2C_DATA, bytes[place]);
    }
    /* This write starts the transfer. */
    write_i2c_register(access, I2C_ADDRESS, device);
    return is_done(access);
}

bool i2c_read(const struct register_access *access, uint32_t device, uint8_t *bytes,
              uint32_t number) {
    if (number == 0 || number > I2C_BYTES_MOST) {
        return false;
    }
    begin_i2c_transfer(access, I2C_CONTROL_READ);
    write_i2c_register(access, I2C_SIZE, number);
    write_i2c_register(access, I2C_ADDRESS, device);
    if (!is_done(access)) {
        return false;
    }
    for (uint32_t place = 0; place < number; place++) {
        if ((read_i2c_register(access, I2C_STATUS) & I2C_STATUS_RECEIVED) == 0) {
            return false;
        }
        bytes[place] = (uint8_t)read_i2c_register(access, I2C_DATA);
    }
    return true;
}
