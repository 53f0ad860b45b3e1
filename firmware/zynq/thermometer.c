/* SPDX-License-Identifier: Apache-2.0 */

#include "thermometer.h"

#include "i2c.h"

enum { FIRST_DEVICE = 0x48, DEVICES = 4 };
enum { ADT7420_TEMPERATURE = 0x00, ADT7420_CONFIGURATION = 0x03, ADT7420_ID = 0x0B };
/* Sixteen bits, continuous conversion. */
#define ADT7420_SIXTEEN_BITS 0x80U
#define ADT7420_ID_VALUE 0xCBU
enum { TMP117_TEMPERATURE = 0x00, TMP117_ID = 0x0F };
/* Mask that removes the revision, the four upper bits. */
#define TMP117_ID_MASK 0x0FFFU
#define TMP117_ID_VALUE 0x0117U
/* Value before the first conversion. */
#define TMP117_NOTHING_YET (-32768)
/* Both devices use two's complement with 1/128 K. */
#define STEPS_A_KELVIN 128.0

const char *thermometer_name(enum thermometer_kind kind) {
    static const char *const names[] = {"none", "adt7420", "tmp117"};
    return (unsigned)kind <= THERMOMETER_TMP117 ? names[kind] : "unknown";
}

static bool read_register(const struct thermometer *thermometer, uint8_t place, uint8_t *bytes,
                          uint32_t number) {
    return i2c_write(&thermometer->access, thermometer->device, &place, 1) &&
           i2c_read(&thermometer->access, thermometer->device, bytes, number);
}

static uint32_t thermometer_word(const uint8_t bytes[2]) {
    return (uint32_t)bytes[0] << 8 | bytes[1];
}

static enum thermometer_kind kind_of(const struct thermometer *thermometer) {
    static const uint8_t settings[2] = {ADT7420_CONFIGURATION, ADT7420_SIXTEEN_BITS};
    uint8_t bytes[2];
    /* A TMP117 has no register ADT7420_ID and would answer there with another register's bytes or none, so the TMP117
       is tested first. */
    if (read_register(thermometer, TMP117_ID, bytes, 2) &&
        (thermometer_word(bytes) & TMP117_ID_MASK) == TMP117_ID_VALUE) {
        return THERMOMETER_TMP117;
    }
    if (read_register(thermometer, ADT7420_ID, bytes, 1) && bytes[0] == ADT7420_ID_VALUE &&
        i2c_write(&thermometer->access, thermometer->device, settings, sizeof settings)) {
        return THERMOMETER_ADT7420;
    }
    return THERMOMETER_NONE;
}

void thermometer_find(struct thermometer *thermometer, const struct register_access *access) {
    *thermometer = (struct thermometer){.access = *access};
    for (uint32_t place = 0; place < DEVICES; place++) {
        thermometer->device = FIRST_DEVICE + place;
        thermometer->kind = kind_of(thermometer);
        if (thermometer->kind != THERMOMETER_NONE) {
            return;
        }
    }
}

bool thermometer_read(void *context, double *celsius) {
    struct thermometer *thermometer = context;
    uint8_t bytes[2];
    bool answers = thermometer->kind != THERMOMETER_NONE &&
                   read_register(thermometer, ADT7420_TEMPERATURE, bytes, 2);
    if (!answers) {
        thermometer->kind = kind_of(thermometer);
        return false;
    }
    int32_t steps = (int32_t)thermometer_word(bytes);
    steps -= steps >= 0x8000 ? 0x10000 : 0;
    if (thermometer->kind == THERMOMETER_TMP117 && steps == TMP117_NOTHING_YET) {
        return false;
    }
    *celsius = steps / STEPS_A_KELVIN;
    return true;
}
