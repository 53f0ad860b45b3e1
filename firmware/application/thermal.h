/* SPDX-License-Identifier: Apache-2.0 */

/* Computes loaded lanes that follow the temperature of the table: cosine and sine of an order are c0 + c1 (T - T0) + c2
   (T - T0)^2, where c0 is the loaded value of the lane. */

#ifndef ARCTRUE_THERMAL_H
#define ARCTRUE_THERMAL_H

#include <stdbool.h>
#include <stdint.h>

#include "coefficients.h"

enum { THERMAL_LANES_MAX = 16, THERMAL_FRACTION = 20 };

/* c1 (`cosine`, `sine`) of an order in 2^-20 count per kelvin, and c2 (`cosine_squared`, `sine_squared`) in 2^-20 count
   per kelvin squared. */
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
    /* T0 in 0.001 degC, and the time constant of the thermometer's first-order lag in ms. */
    int32_t reference_mc;
    uint32_t time_constant_ms;
    /* Range of temperature, in 0.001 degC; outside the range the lanes keep the values that they have at its ends. */
    int32_t least_mc;
    int32_t most_mc;
};

/* Largest |d eps / d R| and largest amplitude of a lane, counts, over the range of temperature. */
struct thermal_extent {
    double steepest;
    double largest_counts;
};

/* Tells whether the range lies within -273.15 to 1000 degC, T0 within the range, and the time constant is at most an
   hour. */
bool thermal_is_valid(const struct thermal *thermal);

/* Sets the preset range, which holds for a coefficient file that states no range. */
void thermal_preset_range(struct thermal *thermal);
bool thermal_has_preset_range(const struct thermal *thermal);

/* Returns upper bounds of slope and amplitudes: their maxima over 33 evenly spaced temperatures with spacing h. For
   each lane that follows the temperature, |c2| h^2/4 is added to the amplitude, because the amplitude between two of
   these temperatures is larger by at most this value. The slope is the sum of n |c_n|; it ignores the phases. */
struct thermal_extent thermal_extent(const struct thermal *thermal,
                                     const struct coefficients *coefficients);

/* Tells whether the order depends on the temperature. */
bool thermal_follows(const struct thermal *thermal, uint32_t order);

/* Returns `lane` at a temperature. If the order does not depend on the temperature, returns the lane unchanged. */
struct lane thermal_lane_at(const struct thermal *thermal, const struct lane *lane, double celsius);

/* Returns the sum of the amplitudes by which lanes change from one temperature to another, counts. */
double thermal_change_counts(const struct thermal *thermal, const struct coefficients *lanes,
                             double from_celsius, double to_celsius);

/* Returns the sum of the amplitudes by which the lanes with the same number in two banks differ, counts. It is an upper
   bound of the difference between the two corrections. A lane that one bank alone uses counts with its whole
   amplitude. */
double thermal_apart_counts(const struct coefficients *first, const struct coefficients *second);

#endif
