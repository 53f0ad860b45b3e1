/* SPDX-License-Identifier: Apache-2.0 */

#include "thermal.h"

#include <math.h>
#include <stddef.h>

#include "arctrue_number_formats.h"
#include "units.h"

#define AMPLITUDE_STEPS ((double)(1 << ARCTRUE_AMPLITUDE_FRACTION))
#define AMPLITUDE_WORD_MAX ((double)((1 << (ARCTRUE_AMPLITUDE_WIDTH - 1)) - 1))
#define PHASE_STEPS ((double)(1 << ARCTRUE_PHASE_WIDTH))
#define SLOPE_STEPS ((double)(1 << THERMAL_FRACTION))
#define LEAST_MC (-273150)
#define MOST_MC 1000000
#define TIME_CONSTANT_MOST_MS 3600000U

bool thermal_is_valid(const struct thermal *thermal) {
    return thermal->lanes <= THERMAL_LANES_MAX && thermal->reference_mc >= LEAST_MC &&
           thermal->reference_mc <= MOST_MC && thermal->time_constant_ms <= TIME_CONSTANT_MOST_MS;
}

static const struct thermal_lane *slope_of(const struct thermal *thermal, uint32_t order) {
    for (uint32_t place = 0; thermal != NULL && place < thermal->lanes; place++) {
        if (thermal->lane[place].order == order) {
            return &thermal->lane[place];
        }
    }
    return NULL;
}

bool thermal_follows(const struct thermal *thermal, uint32_t order) {
    return slope_of(thermal, order) != NULL;
}

/* Counts: eps = re cos(n R) - im sin(n R), as equation (9) has it with Phi. */
static struct vector vector_of(const struct lane *lane) {
    struct vector unit = vector_unit(2.0 * PI * lane->phase_offset / PHASE_STEPS);
    double amplitude = lane->amplitude / AMPLITUDE_STEPS;
    return (struct vector){amplitude * unit.re, amplitude * unit.im};
}

struct lane thermal_lane_at(const struct thermal *thermal, const struct lane *lane,
                            double celsius) {
    const struct thermal_lane *slope = slope_of(thermal, lane->order);
    struct lane made = *lane;
    if (slope == NULL || lane->order == 0) {
        return made;
    }
    double warmth = celsius - thermal->reference_mc / 1000.0;
    struct vector value = vector_of(lane);
    value.re += (slope->cosine + slope->cosine_squared * warmth) * warmth / SLOPE_STEPS;
    value.im -= (slope->sine + slope->sine_squared * warmth) * warmth / SLOPE_STEPS;
    double turns = atan2(value.im, value.re) / (2.0 * PI);
    double amplitude = rint(vector_length(value) * AMPLITUDE_STEPS);
    made.phase_offset = (uint32_t)rint((turns - floor(turns)) * PHASE_STEPS) &
                        ((1U << ARCTRUE_PHASE_WIDTH) - 1U);
    /* What no lane holds stays at its limit, and is told as an error that is left. */
    made.amplitude = (int32_t)fmin(amplitude, AMPLITUDE_WORD_MAX);
    return made;
}

double thermal_apart_counts(const struct coefficients *first, const struct coefficients *second) {
    double apart = 0.0;
    for (uint32_t place = 0; place < first->lanes; place++) {
        if (first->lane[place].amplitude == second->lane[place].amplitude &&
            first->lane[place].phase_offset == second->lane[place].phase_offset) {
            continue;
        }
        struct vector one = vector_of(&first->lane[place]);
        struct vector other = vector_of(&second->lane[place]);
        struct vector difference = {one.re - other.re, one.im - other.im};
        apart += vector_length(difference);
    }
    return apart;
}
