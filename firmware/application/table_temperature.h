/* SPDX-License-Identifier: Apache-2.0 */

/* Determines the temperature of the table from a thermometer or from the host; without either it is unknown. An
   implausible reading is ignored, and the last plausible temperature stays in use. */

#ifndef ARCTRUE_TABLE_TEMPERATURE_H
#define ARCTRUE_TABLE_TEMPERATURE_H

#include <stdbool.h>
#include <stdint.h>

/* Reads a temperature. If none is known, returns false and leaves `celsius` unchanged. */
typedef bool temperature_read(void *context, double *celsius);

enum temperature_source { TEMPERATURE_NONE, TEMPERATURE_HOST, TEMPERATURE_SENSOR };

enum temperature_state {
    /* No reading exists yet, or fewer than three successive readings have agreed. */
    TEMPERATURE_UNKNOWN,
    TEMPERATURE_GOOD,
    /* Held at the last good value, because the thermometer does not answer, has changed faster than the table can, or
       has not changed for too long; or because the host has been silent for too long. */
    TEMPERATURE_SILENT,
    TEMPERATURE_JUMPED,
    TEMPERATURE_STANDS_STILL,
};

struct temperature_limits {
    /* Largest change in kelvin from one reading to the next; after a silence a larger change is allowed. */
    double jump_k;
    /* Longest time without a change, s; 0: not limited. */
    double still_s;
};

struct table_temperature {
    enum temperature_source source;
    enum temperature_state state;
    /* NULL: there is no thermometer. */
    temperature_read *read;
    void *context;
    /* Last accepted reading of the thermometer, or temperature from the host. */
    double shown_c;
    /* Observer of the thermometer with this time constant. Its state: temperature of the thermometer; temperature of
       the table minus temperature of the thermometer; slope of the table's temperature, K/s. */
    double time_constant_s;
    double followed_c;
    double behind_k;
    double slope;
    /* Temperature of the table, without the thermometer's lag. */
    double celsius;
    double tried_s;
    double read_s;
    double changed_s;
    /* Counters of events in a row: readings without an answer; readings too far from the last good reading or, before
       the first good reading, readings that agree. */
    uint32_t failures;
    uint32_t in_a_row;
};

void table_temperature_use(struct table_temperature *table, temperature_read *read, void *context);

/* Selects the source that the operator wants, and clears earlier faults. */
void table_temperature_choose(struct table_temperature *table, enum temperature_source source);
/* Takes a temperature from the host, at a time in seconds of a clock that never stops. */
void table_temperature_tell(struct table_temperature *table, double celsius, double now_s);

/* Reads the thermometer when the interval between two readings has passed; `time_constant_s`: the lag to remove. */
void table_temperature_follow(struct table_temperature *table,
                              const struct temperature_limits *limits, double time_constant_s,
                              double now_s);

/* Tells whether `celsius` has a value; a held value counts too. */
bool table_temperature_is_known(const struct table_temperature *table);
/* Tells whether `celsius` is held at the last good value. */
bool table_temperature_is_held(const struct table_temperature *table);

const char *temperature_source_name(enum temperature_source source);
const char *temperature_state_name(enum temperature_state state);

#endif
