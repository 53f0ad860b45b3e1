/* SPDX-License-Identifier: Apache-2.0 */

#include "die_temperature.h"

#include "registers.h"

#define KELVIN_FULL_SCALE 503.975
#define CODES 4096.0
#define KELVIN_AT_ZERO_CELSIUS 273.15
#define LEAST_CELSIUS (-55.0)
#define MOST_CELSIUS 150.0
#define CODE_SHIFT 4U
#define CODE_MASK 0xFFFU
/* Enables the port, with commands and answers at the clock edges that UG585 states, a clock at a quarter of the bus
   clock (at most 50 MHz), and a gap of 20 clocks between commands. */
#define PORT_SETTINGS 0x80001114U
#define COMMAND_READ_TEMPERATURE 0x04000000U
#define COMMAND_NOTHING 0x00000000U
enum { QUEUE_MOST = 16 };

static uint32_t read_converter(const struct register_access *access, uint32_t address) {
    return access->read(access->context, address);
}

static void write_converter(const struct register_access *access, uint32_t address, uint32_t word) {
    access->write(access->context, address, word);
}

void die_temperature_prepare(const struct register_access *access) {
    write_converter(access, XADC_CFG, PORT_SETTINGS);
    /* Ends the reset of the port. */
    write_converter(access, XADC_MCTL, 0);
}

static bool has_answer(const struct register_access *access) {
    return (read_converter(access, XADC_MSTS) & XADC_MSTS_DATA_EMPTY) == 0;
}

/* Drops answers of an earlier read that timed out. */
static void drop_answers(const struct register_access *access) {
    for (unsigned taken = 0; taken < QUEUE_MOST && has_answer(access); taken++) {
        (void)read_converter(access, XADC_RDFIFO);
    }
}

static bool take_answer(const struct register_access *access, uint32_t *answer) {
    uint32_t start = access->microseconds(access->context);
    while (!has_answer(access)) {
        if (access->microseconds(access->context) - start > DIE_TEMPERATURE_TIMEOUT_US) {
            return false;
        }
    }
    *answer = read_converter(access, XADC_RDFIFO);
    return true;
}

/* Sends the command to read and then an empty command, because each command returns the answer to the previous
   command. */
bool die_temperature_read(const struct register_access *access, double *celsius) {
    uint32_t before;
    uint32_t status;
    drop_answers(access);
    write_converter(access, XADC_CMDFIFO, COMMAND_READ_TEMPERATURE);
    write_converter(access, XADC_CMDFIFO, COMMAND_NOTHING);
    return take_answer(access, &before) && take_answer(access, &status) &&
           die_temperature_of(status, celsius);
}

bool die_temperature_of(uint32_t status, double *celsius) {
    uint32_t code = status >> CODE_SHIFT & CODE_MASK;
    double value = code * KELVIN_FULL_SCALE / CODES - KELVIN_AT_ZERO_CELSIUS;
    if (value < LEAST_CELSIUS || value > MOST_CELSIUS) {
        return false;
    }
    *celsius = value;
    return true;
}
