/* SPDX-License-Identifier: Apache-2.0 */

#include "table_temperature.h"

#include <math.h>
#include <stddef.h>

#define READING_S 0.5
#define LEAST_C (-55.0)
#define MOST_C 150.0
/* Number of successive failures or jumps after which the state is no longer good, and number of successive agreeing
   readings after which the temperature is known. */
enum { FAILURES_MOST = 3, AGREE_LEAST = 3 };
/* Largest rate at which the table may have changed while its thermometer was silent: 3 K per minute. */
#define SILENT_K_S 0.05
/* Number of time constants after which the observer's state has no influence any more; its gains would then divide by
   0. */
#define FORGOTTEN_LAGS 30.0
/* Ratio of the thermometer's time constant to the observer's time constant. A smaller time constant of the observer
   reduces the delay after a change of slope, and amplifies the thermometer's steps. */
#define LAG_SHARE 16.0
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
    table->failures = table->in_a_row = 0;
    table->tried_s = -READING_S;
}

void table_temperature_use(struct table_temperature *table, temperature_read *read, void *context) {
    table->read = read;
    table->context = context;
    table_temperature_choose(table, read != NULL ? TEMPERATURE_SENSOR : TEMPERATURE_NONE);
}

static void table_temperature_begin(struct table_temperature *table, double celsius, double now_s) {
    table->state = TEMPERATURE_GOOD;
    table->shown_c = table->followed_c = table->celsius = celsius;
    table->behind_k = table->slope = 0.0;
    table->time_constant_s = LEAST_FILTER_S;
    table->tried_s = table->read_s = table->changed_s = now_s;
    table->failures = table->in_a_row = 0;
}

void table_temperature_tell(struct table_temperature *table, double celsius, double now_s) {
    table->source = TEMPERATURE_HOST;
    table_temperature_begin(table, celsius, now_s);
}

static bool table_temperature_read(const struct table_temperature *table, double *celsius) {
    return table->read != NULL && table->read(table->context, celsius) && *celsius >= LEAST_C &&
           *celsius <= MOST_C;
}

/* Returns exp(-times), from expm1(), which is linked already; exp() would add a table of 2 KB. */
static double table_temperature_decay(double times) {
    return 1.0 + expm1(-times);
}

/* The thermometer lags as T_s' = (T - T_s) / tau. An observer of T_s, T - T_s and the slope of T, with three equal
   poles q, has no lasting error while T changes at a constant rate. Over dt, with a = exp(-dt / tau): T_s goes to T_s +
   (1 - a) (T - T_s) + (dt - tau (1 - a)) T'; T - T_s goes to a (T - T_s) + tau (1 - a) T'. F is the matrix of this
   step; H selects T_s. With the gains K the determinant of z I - (I - K H) F is (z - q)^3; K follows from this at z =
   0, 1 and a. */
static void table_temperature_observe(struct table_temperature *table, double celsius,
                                      double passed) {
    double tau = table->time_constant_s;
    double a = table_temperature_decay(passed / tau);
    double rest = 1.0 - a;
    double q = table_temperature_decay(passed / fmax(tau / LAG_SHARE, LEAST_FILTER_S));
    double apart = a - q;
    double slope_gain = (1.0 - q) * (1.0 - q) * (1.0 - q) / (rest * passed);
    double behind_gain = tau * slope_gain - apart * apart * apart / (a * rest * rest);
    table->followed_c += rest * table->behind_k + (passed - tau * rest) * table->slope;
    table->behind_k = a * table->behind_k + tau * rest * table->slope;
    double off = celsius - table->followed_c;
    table->followed_c += (1.0 - q * q * q / a) * off;
    table->behind_k += behind_gain * off;
    table->slope += slope_gain * off;
}

/* Sets the observer's lag to that of the thermometer, at least LEAST_FILTER_S. So the observer also runs without a
   stated lag, and can correct a lag as soon as a loaded set states one. */
static void table_temperature_use_lag(struct table_temperature *table, double time_constant_s) {
    double tau = fmax(time_constant_s, LEAST_FILTER_S);
    table->behind_k *= tau / table->time_constant_s;
    table->time_constant_s = tau;
}

static void table_temperature_take(struct table_temperature *table, double celsius,
                                   double time_constant_s, double now_s) {
    double passed = now_s - table->read_s;
    table_temperature_use_lag(table, time_constant_s);
    if (passed > FORGOTTEN_LAGS * table->time_constant_s) {
        table_temperature_begin(table, celsius, now_s);
        return;
    }
    if (passed > 0.0) {
        table_temperature_observe(table, celsius, passed);
    }
    if (celsius != table->shown_c) {
        table->changed_s = now_s;
    }
    table->shown_c = celsius;
    table->read_s = now_s;
    table->failures = table->in_a_row = 0;
    table->state = TEMPERATURE_GOOD;
    table->celsius = time_constant_s > 0.0 ? table->followed_c + table->behind_k : celsius;
}

/* Confirms the first reading by the next readings, because a thermometer reads 0 before its first conversion. The
   observer begins with the first reading. */
static void table_temperature_confirm(struct table_temperature *table, double celsius,
                                      double jump_k, double time_constant_s, double now_s) {
    uint32_t agree = 1;
    if (table->in_a_row > 0 && fabs(celsius - table->shown_c) <= jump_k) {
        agree += table->in_a_row;
        table_temperature_take(table, celsius, time_constant_s, now_s);
    } else {
        table_temperature_begin(table, celsius, now_s);
    }
    if (agree < AGREE_LEAST) {
        table->in_a_row = agree;
        table->state = TEMPERATURE_UNKNOWN;
    }
}

static void table_temperature_read_sensor(struct table_temperature *table,
                                          const struct temperature_limits *limits,
                                          double time_constant_s, double now_s) {
    double celsius;
    table->tried_s = now_s;
    if (!table_temperature_read(table, &celsius)) {
        table->in_a_row = 0;
        if (table->state != TEMPERATURE_UNKNOWN && ++table->failures >= FAILURES_MOST) {
            table->state = TEMPERATURE_SILENT;
        }
        return;
    }
    if (table->state == TEMPERATURE_UNKNOWN) {
        table_temperature_confirm(table, celsius, limits->jump_k, time_constant_s, now_s);
        return;
    }
    double most_k = limits->jump_k + SILENT_K_S * (now_s - table->read_s);
    if (fabs(celsius - table->shown_c) > most_k) {
        /* A single jump may be a bit error on the bus. After FAILURES_MOST jumps the thermometer is not read until the
           operator has selected it again. */
        if (++table->in_a_row >= FAILURES_MOST) {
            table->state = TEMPERATURE_JUMPED;
        }
        return;
    }
    table_temperature_take(table, celsius, time_constant_s, now_s);
}

/* Restarts all times after the clock restarted with a new bitstream or a reset of the fabric: the age of earlier
   readings is unknown. */
static void table_temperature_time_again(struct table_temperature *table, double now_s) {
    table->tried_s = now_s - READING_S;
    table->read_s = table->changed_s = now_s;
}

void table_temperature_follow(struct table_temperature *table,
                              const struct temperature_limits *limits, double time_constant_s,
                              double now_s) {
    if (now_s < table->tried_s) {
        table_temperature_time_again(table, now_s);
    }
    bool due = now_s - table->tried_s >= READING_S;
    if (table->source == TEMPERATURE_SENSOR && table->state != TEMPERATURE_JUMPED && due) {
        table_temperature_read_sensor(table, limits, time_constant_s, now_s);
    }
    bool good = table->source != TEMPERATURE_NONE && table->state == TEMPERATURE_GOOD;
    if (good && limits->still_s > 0.0 && now_s - table->changed_s > limits->still_s) {
        table->state = TEMPERATURE_STANDS_STILL;
    }
}
