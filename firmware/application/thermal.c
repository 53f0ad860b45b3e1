/* SPDX-License-Identifier: Apache-2.0 */

#include "thermal.h"

#include <math.h>
#include <stddef.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"

#define AMPLITUDE_STEPS ((double)(1 << ARCTRUE_AMPLITUDE_FRACTION))
#define AMPLITUDE_WORD_MAX ((double)((1 << (ARCTRUE_AMPLITUDE_WIDTH - 1)) - 1))
#define PHASE_STEPS ((double)(1 << ARCTRUE_PHASE_WIDTH))
#define SLOPE_STEPS ((double)(1 << THERMAL_FRACTION))
#define LEAST_MC (-273150)
#define MOST_MC 1000000
#define TIME_CONSTANT_MOST_MS 3600000U
#define RANGE_MC (1000 * ARCTRUE_THERMAL_RANGE_K)
enum { RANGE_STEPS = 32 };

bool thermal_is_valid(const struct thermal *thermal) {
    return thermal->lanes <= THERMAL_LANES_MAX && thermal->least_mc >= LEAST_MC &&
           thermal->least_mc <= thermal->reference_mc &&
           thermal->reference_mc <= thermal->most_mc && thermal->most_mc <= MOST_MC &&
           thermal->time_constant_ms <= TIME_CONSTANT_MOST_MS;
}

static int32_t thermal_between(int64_t value) {
    return (int32_t)(value < LEAST_MC ? LEAST_MC : (value > MOST_MC ? MOST_MC : value));
}

void thermal_preset_range(struct thermal *thermal) {
    thermal->least_mc = thermal_between((int64_t)thermal->reference_mc - RANGE_MC);
    thermal->most_mc = thermal_between((int64_t)thermal->reference_mc + RANGE_MC);
}

bool thermal_has_preset_range(const struct thermal *thermal) {
    struct thermal preset = {.reference_mc = thermal->reference_mc};
    thermal_preset_range(&preset);
    return thermal->least_mc == preset.least_mc && thermal->most_mc == preset.most_mc;
}

static const struct thermal_lane *thermal_slope_of(const struct thermal *thermal, uint32_t order) {
    ASSERT(thermal == NULL || thermal->lanes <= THERMAL_LANES_MAX);
    for (uint32_t place = 0; thermal != NULL && place < thermal->lanes; place++) {
        if (thermal->lane[place].order == order) {
            return &thermal->lane[place];
        }
    }
    return NULL;
}

bool thermal_follows(const struct thermal *thermal, uint32_t order) {
    return thermal_slope_of(thermal, order) != NULL;
}

/* Returns the vector in counts: eps = re cos(n R) - im sin(n R), as in equation (9) with Phi. */
static struct vector thermal_vector_of(const struct lane *lane) {
    struct vector unit = vector_unit(2.0 * PI * lane->phase_offset / PHASE_STEPS);
    double amplitude = lane->amplitude / AMPLITUDE_STEPS;
    return (struct vector){amplitude * unit.re, amplitude * unit.im};
}

/* Returns the vector of a lane, counts, at the temperature that is `warmth` (K) above the model's reference
   temperature. */
static struct vector thermal_vector_at(const struct lane *lane, const struct thermal_lane *slope,
                                       double warmth) {
    struct vector value = thermal_vector_of(lane);
    if (slope != NULL) {
        value.re += (slope->cosine + slope->cosine_squared * warmth) * warmth / SLOPE_STEPS;
        value.im -= (slope->sine + slope->sine_squared * warmth) * warmth / SLOPE_STEPS;
    }
    return value;
}

struct lane thermal_lane_at(const struct thermal *thermal, const struct lane *lane,
                            double celsius) {
    const struct thermal_lane *slope = thermal_slope_of(thermal, lane->order);
    struct lane made = *lane;
    if (slope == NULL || lane->order == 0) {
        return made;
    }
    double within = fmin(fmax(celsius, thermal->least_mc / 1000.0), thermal->most_mc / 1000.0);
    struct vector value = thermal_vector_at(lane, slope, within - thermal->reference_mc / 1000.0);
    double turns = atan2(value.im, value.re) / (2.0 * PI);
    double amplitude = rint(vector_length(value) * AMPLITUDE_STEPS);
    made.phase_offset =
        (uint32_t)rint((turns - floor(turns)) * PHASE_STEPS) & ((1U << ARCTRUE_PHASE_WIDTH) - 1U);
    /* load_end() has refused every set whose amplitudes exceed the range of a lane's word within the model's range. */
    made.amplitude = (int32_t)fmin(amplitude, AMPLITUDE_WORD_MAX);
    return made;
}

struct thermal_extent thermal_extent(const struct thermal *thermal,
                                     const struct coefficients *coefficients) {
    double step_k = (thermal->most_mc - thermal->least_mc) / 1000.0 / RANGE_STEPS;
    struct thermal_extent extent = {0.0, 0.0};
    for (uint32_t step = 0; step <= RANGE_STEPS; step++) {
        double warmth = (thermal->least_mc - thermal->reference_mc) / 1000.0 + step * step_k;
        double slope = 0.0;
        for (uint32_t place = 0; place < coefficients->lanes; place++) {
            const struct lane *lane = &coefficients->lane[place];
            const struct thermal_lane *follows = thermal_slope_of(thermal, lane->order);
            double size = vector_length(thermal_vector_at(lane, follows, warmth));
            if (follows != NULL) {
                const struct vector curve = {follows->cosine_squared, follows->sine_squared};
                size += vector_length(curve) / SLOPE_STEPS * step_k * step_k / 4.0;
            }
            slope += lane->order * size;
            extent.largest_counts = fmax(extent.largest_counts, size);
        }
        extent.steepest = fmax(extent.steepest, slope * 2.0 * PI / coefficients->counts_per_rev);
    }
    return extent;
}

double thermal_apart_counts(const struct coefficients *first, const struct coefficients *second) {
    ASSERT(first->lanes <= LANES_LIMIT && second->lanes == first->lanes);
    double apart = 0.0;
    for (uint32_t place = 0; place < first->lanes; place++) {
        if (first->lane[place].amplitude == second->lane[place].amplitude &&
            first->lane[place].phase_offset == second->lane[place].phase_offset) {
            continue;
        }
        struct vector one = thermal_vector_of(&first->lane[place]);
        struct vector other = thermal_vector_of(&second->lane[place]);
        struct vector difference = {one.re - other.re, one.im - other.im};
        apart += vector_length(difference);
    }
    return apart;
}

double thermal_change_counts(const struct thermal *thermal, const struct coefficients *lanes,
                             double from_celsius, double to_celsius) {
    ASSERT(lanes->lanes <= LANES_LIMIT);
    double change = 0.0;
    for (uint32_t place = 0; place < lanes->lanes; place++) {
        const struct lane from = thermal_lane_at(thermal, &lanes->lane[place], from_celsius);
        const struct lane to = thermal_lane_at(thermal, &lanes->lane[place], to_celsius);
        change +=
            vector_length(vector_difference(thermal_vector_of(&to), thermal_vector_of(&from)));
    }
    return change;
}
