/* SPDX-License-Identifier: Apache-2.0 */

/* The temperature of the table: from a thermometer, from the host, or not known. What cannot be
   believed is held back, and the model stays at the last temperature that could. */

#ifndef ARCTRUE_TABLE_TEMPERATURE_H
#define ARCTRUE_TABLE_TEMPERATURE_H

#include <stdbool.h>
#include <stdint.h>

/* False: no temperature is known; the value then stays as it was. */
typedef bool temperature_read(void *context, double *celsius);

enum temperature_source { TEMPERATURE_NONE, TEMPERATURE_HOST, TEMPERATURE_SENSOR };

enum temperature_state {
    /* Nothing was read yet, or nothing that another reading has confirmed. */
    TEMPERATURE_UNKNOWN,
    TEMPERATURE_GOOD,
    /* Held at the last good value: the thermometer does not answer, it said what the table cannot
       have become, or it has said the same for too long; the host has been silent as long. */
    TEMPERATURE_SILENT,
    TEMPERATURE_JUMPED,
    TEMPERATURE_STANDS_STILL,
};

struct temperature_limits {
    /* Kelvin from one reading to the next; after a silence more. */
    double jump_k;
    /* Seconds; 0: as long as it likes. */
    double still_s;
};

struct table_temperature {
    enum temperature_source source;
    enum temperature_state state;
    /* NULL: there is no thermometer. */
    temperature_read *read;
    void *context;
    /* As it was read. */
    double shown_c;
    /* What follows it with this time constant; how far that is behind the table; slope, K/s. */
    double time_constant_s;
    double followed_c;
    double behind_k;
    double slope;
    /* Of the table, without the thermometer's lag. */
    double celsius;
    double tried_s;
    double read_s;
    double changed_s;
    /* In a row: times without an answer; readings too far from the good one, or, before there is one,
       readings that agree. */
    uint32_t failures;
    uint32_t in_a_row;
};

void table_temperature_use(struct table_temperature *table, temperature_read *read, void *context);

/* The operator's choice; forgets what was wrong. */
void table_temperature_choose(struct table_temperature *table, enum temperature_source source);
/* From the host, at a time in seconds of a clock that never stops. */
void table_temperature_tell(struct table_temperature *table, double celsius, double now_s);

/* Read where it is time to; `time_constant_s` of the lag that is taken off. */
void table_temperature_follow(struct table_temperature *table,
                              const struct temperature_limits *limits, double time_constant_s,
                              double now_s);

/* True: `celsius` has a value, be it held. */
bool table_temperature_is_known(const struct table_temperature *table);
/* True: it is held at the last good value. */
bool table_temperature_is_held(const struct table_temperature *table);

const char *temperature_source_name(enum temperature_source source);
const char *temperature_state_name(enum temperature_state state);

#endif
