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
    /* Below and above, the lanes stay as they are there; thousandths. */
    int32_t least_mc;
    int32_t most_mc;
};

/* Over the range of temperature: |d eps / d R| at most, and the largest amplitude of a lane, counts. */
struct thermal_extent {
    double steepest;
    double largest_counts;
};

/* -273.15 to 1000 degrees, T0 within the range; up to an hour. */
bool thermal_is_valid(const struct thermal *thermal);

/* The range of a file that states none. */
void thermal_preset_range(struct thermal *thermal);
bool thermal_has_preset_range(const struct thermal *thermal);

/* Bounds: the largest value at 33 temperatures of the range, and what a lane can be above the chord
   between two of them, c2 h^2/4. Phases are not used: sum of n |c_n|. */
struct thermal_extent thermal_extent(const struct thermal *thermal,
                                     const struct coefficients *coefficients);

/* The order has a slope. */
bool thermal_follows(const struct thermal *thermal, uint32_t order);

/* `lane` at a temperature; itself where its order does not follow it. */
struct lane thermal_lane_at(const struct thermal *thermal, const struct lane *lane, double celsius);

/* The sum of the amplitudes by which lanes change from one temperature to another, counts. */
double thermal_change_counts(const struct thermal *thermal, const struct coefficients *lanes,
                             double from_celsius, double to_celsius);

/* The most by which the corrections of two banks of lanes at the same places can differ, counts.
   A lane that only one of them uses counts whole. */
double thermal_apart_counts(const struct coefficients *first, const struct coefficients *second);

#endif
