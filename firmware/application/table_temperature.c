/* SPDX-License-Identifier: Apache-2.0 */

#include "table_temperature.h"

#include <math.h>
#include <stddef.h>

#define READING_S 0.5
#define LEAST_C (-55.0)
#define MOST_C 150.0
/* So many in a row are no accident. */
enum { FAILURES_MOST = 3 };
/* The slope is that of the latest part of the time constant: a longer one smooths more, and is late where
   the slope itself changes. */
#define LAG_SHARE 32.0
/* The slope is known before a model comes that needs it. */
#define LEAST_FILTER_S 2.0

const char *temperature_source_name(enum temperature_source source) {
    static const char *const names[] = {"none", "host", "sensor"};
    return (unsigned)source <= TEMPERATURE_SENSOR ? names[source] : "unknown";
}

const char *temperature_state_name(enum temperature_state state) {
    static const char *const names[] = {"unknown", "good", "silent", "jumped", "unchanged"};
    return (unsigned)state <= TEMPERATURE_STANDS_STILL ? names[state] : "unknown";
}

bool table_temperature_is_known(const struct table_temperature *table) {
    return table->source != TEMPERATURE_NONE && table->state != TEMPERATURE_UNKNOWN;
}

bool table_temperature_is_held(const struct table_temperature *table) {
    return table_temperature_is_known(table) && table->state != TEMPERATURE_GOOD;
}

void table_temperature_choose(struct table_temperature *table, enum temperature_source source) {
    table->source = source;
    table->state = TEMPERATURE_UNKNOWN;
    table->failures = 0;
    table->tried_s = -READING_S;
}

void table_temperature_use(struct table_temperature *table, temperature_read *read,
                           void *context) {
    table->read = read;
    table->context = context;
    table_temperature_choose(table, read != NULL ? TEMPERATURE_SENSOR : TEMPERATURE_NONE);
}

static void begin_at(struct table_temperature *table, double celsius, double now_s) {
    table->state = TEMPERATURE_GOOD;
    table->shown_c = table->level_c = table->celsius = celsius;
    table->slope = 0.0;
    table->tried_s = table->read_s = table->changed_s = now_s;
    table->failures = 0;
}

void table_temperature_tell(struct table_temperature *table, double celsius, double now_s) {
    table->source = TEMPERATURE_HOST;
    begin_at(table, celsius, now_s);
}

static bool read_now(const struct table_temperature *table, double *celsius) {
    return table->read != NULL && table->read(table->context, celsius) && *celsius >= LEAST_C &&
           *celsius <= MOST_C;
}

/* T_s lags as T_s' = (T - T_s) / tau, so that T = T_s + tau T_s'. Level and slope of T_s by double
   exponential smoothing (Holt), which has no error of its own where T_s rises evenly. */
static void take(struct table_temperature *table, double celsius, double time_constant_s,
                 double now_s) {
    double passed = now_s - table->read_s;
    double decay = exp(-passed / fmax(time_constant_s / LAG_SHARE, LEAST_FILTER_S));
    double foretold = table->level_c + table->slope * passed;
    double off = celsius - foretold;
    table->level_c = foretold + (1.0 - decay * decay) * off;
    if (passed > 0.0) {
        table->slope += (1.0 - decay) * (1.0 - decay) * off / passed;
    }
    if (celsius != table->shown_c) {
        table->changed_s = now_s;
    }
    table->shown_c = celsius;
    table->read_s = now_s;
    table->failures = 0;
    table->state = TEMPERATURE_GOOD;
    table->celsius =
        time_constant_s > 0.0 ? table->level_c + time_constant_s * table->slope : celsius;
}

static void read_sensor(struct table_temperature *table, const struct temperature_limits *limits,
                        double time_constant_s, double now_s) {
    double celsius;
    table->tried_s = now_s;
    if (!read_now(table, &celsius)) {
        if (table->state != TEMPERATURE_UNKNOWN && ++table->failures >= FAILURES_MOST) {
            table->state = TEMPERATURE_SILENT;
        }
        return;
    }
    if (table->state == TEMPERATURE_UNKNOWN) {
        begin_at(table, celsius, now_s);
        return;
    }
    if (fabs(celsius - table->shown_c) > limits->jump_k) {
        /* One may be a bit that was changed on the way. What it says after so many is not believed
           before somebody has looked. */
        if (++table->failures >= FAILURES_MOST) {
            table->state = TEMPERATURE_JUMPED;
        }
        return;
    }
    take(table, celsius, time_constant_s, now_s);
}

void table_temperature_follow(struct table_temperature *table,
                              const struct temperature_limits *limits, double time_constant_s,
                              double now_s) {
    bool due = now_s - table->tried_s >= READING_S;
    if (table->source == TEMPERATURE_SENSOR && table->state != TEMPERATURE_JUMPED && due) {
        read_sensor(table, limits, time_constant_s, now_s);
    }
    bool good = table->source != TEMPERATURE_NONE && table->state == TEMPERATURE_GOOD;
    if (good && limits->still_s > 0.0 && now_s - table->changed_s > limits->still_s) {
        table->state = TEMPERATURE_STANDS_STILL;
    }
}
