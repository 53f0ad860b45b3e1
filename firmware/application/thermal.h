/* SPDX-License-Identifier: Apache-2.0 */

/* Loaded lanes that follow the temperature of the table: cosine and sine of an order are
   c0 + c1 (T - T0) + c2 (T - T0)^2, c0 being what the lane itself holds. */

#ifndef ARCTRUE_THERMAL_H
#define ARCTRUE_THERMAL_H

#include <stdbool.h>
#include <stdint.h>

#include "coefficients.h"

enum { THERMAL_LANES_MAX = 16, THERMAL_FRACTION = 20 };

/* Each in 2^-20 count a kelvin, and a kelvin squared. */
struct thermal_lane {
    uint32_t order;
    int32_t cosine;
    int32_t sine;
    int32_t cosine_squared;
    int32_t sine_squared;
};

struct thermal {
    struct thermal_lane lane[THERMAL_LANES_MAX];
    uint32_t lanes;
    /* T0, and the time constant of first order by which the thermometer lags; thousandths. */
    int32_t reference_mc;
    uint32_t time_constant_ms;
};

/* The limits of the two last: -273.15 to 1000 degrees; up to an hour. */
bool thermal_is_valid(const struct thermal *thermal);

/* The order has a slope. */
bool thermal_follows(const struct thermal *thermal, uint32_t order);

/* `lane` at a temperature; itself where its order does not follow it. */
struct lane thermal_lane_at(const struct thermal *thermal, const struct lane *lane, double celsius);

/* The most by which the corrections of two banks of lanes at the same places can differ, counts.
   A lane that only one of them uses counts whole. */
double thermal_apart_counts(const struct coefficients *first, const struct coefficients *second);

#endif
