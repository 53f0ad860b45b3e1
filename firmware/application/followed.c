/* SPDX-License-Identifier: Apache-2.0 */

#include "followed.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"

#define NOMINAL_STEPS 4294967296.0
#define WIDTH_COUNTS(word) ((word) / (double)(1 << ARCTRUE_STOP_FRACTION))
#define AMPLITUDE_COUNTS(word) (fabs((double)(word)) / (1 << ARCTRUE_AMPLITUDE_FRACTION))

enum {
    WIDTH_WORDS = 1 << ARCTRUE_STOP_WIDTH,
    DEAD_ZONE_MOST = (1 << ARCTRUE_DEAD_ZONE_WIDTH) - 1,
    ORDERS = 1 << ARCTRUE_ORDER_WIDTH
};

const char *followed_modulator_name(uint32_t modulator) {
    static const char *const names[MODULATORS] = {
        [MODULATOR_ONE] = "one",       [MODULATOR_DIRECTION] = "direction",
        [MODULATOR_SPEED] = "speed",   [MODULATOR_SPEED_SQUARED] = "speed_squared",
        [MODULATOR_WORD_A] = "word_a", [MODULATOR_WORD_B] = "word_b",
    };
    return modulator < MODULATORS ? names[modulator] : "unknown";
}

uint32_t followed_all_lanes(const struct followed *followed) {
    ASSERT(followed->lanes <= FOLLOWED_LANES_MAX && followed->real_lanes <= REAL_LANES_MAX);
    return followed->lanes + followed->real_lanes;
}

bool followed_lane_is_seen(const struct followed_lane *lane) {
    return lane->lane.order != 0 && lane->modulator < MODULATOR_WORD_A;
}

double followed_modulator(const struct followed *followed, uint32_t place,
                          const struct motion *motion) {
    ASSERT(place < followed->lanes && followed->lanes <= FOLLOWED_LANES_MAX);
    double nominal = followed->nominal_speed / NOMINAL_STEPS;
    double size = nominal > 0.0 ? fmin(fabs(motion->speed) / nominal, 1.0) : 0.0;
    double side = motion->speed < 0.0 ? -1.0 : 1.0;
    switch (followed->lane[place].modulator) {
    case MODULATOR_DIRECTION:
        return side;
    case MODULATOR_SPEED:
        return side * size;
    case MODULATOR_SPEED_SQUARED:
        return size * size;
    default:
        return 0.0;
    }
}

struct vector followed_components(const struct followed *followed, uint32_t order,
                                  uint32_t counts_per_rev, const struct motion *motion) {
    struct vector total = {0.0, 0.0};
    ASSERT(followed->lanes <= FOLLOWED_LANES_MAX);
    for (uint32_t place = 0; place < followed->lanes; place++) {
        const struct lane *lane = &followed->lane[place].lane;
        if (lane->order == order) {
            const struct vector full = coefficients_lane_components(lane, counts_per_rev);
            double share = followed_modulator(followed, place, motion);
            total.re += share * full.re;
            total.im += share * full.im;
        }
    }
    return total;
}

bool followed_lane_is_valid(const struct followed_lane *lane) {
    const int32_t limit = 1 << (ARCTRUE_AMPLITUDE_WIDTH - 1);
    return lane->modulator > MODULATOR_ONE && lane->modulator < MODULATORS &&
           lane->lane.order < ORDERS && lane->lane.phase_offset >> ARCTRUE_PHASE_WIDTH == 0 &&
           lane->lane.amplitude >= -limit && lane->lane.amplitude < limit;
}

bool followed_conditions_are_valid(uint32_t width, uint32_t dead_zone, uint32_t nominal_speed) {
    return width > 0 && width < WIDTH_WORDS && dead_zone <= DEAD_ZONE_MOST && nominal_speed > 0;
}

bool followed_speed_is_stable(const struct followed *followed) {
    double counts = 0.0;
    ASSERT(followed->lanes <= FOLLOWED_LANES_MAX);
    for (uint32_t place = 0; place < followed->lanes; place++) {
        const struct followed_lane *lane = &followed->lane[place];
        double size = AMPLITUDE_COUNTS(lane->lane.amplitude);
        if (lane->modulator == MODULATOR_SPEED) {
            counts += size;
        } else if (lane->modulator == MODULATOR_SPEED_SQUARED) {
            /* The square changes by at most twice the change of the ratio. */
            counts += 2.0 * size;
        }
    }
    /* Travel at the nominal speed in a window, which lasts at least a period of A and B. */
    double travel = followed->nominal_speed / NOMINAL_STEPS * (1 << ARCTRUE_SPEED_WINDOW_BITS);
    return counts <= ARCTRUE_SPEED_FEEDBACK_EIGHTHS / 8.0 * fmax(travel, ARCTRUE_COUNTS_PER_PERIOD);
}

double followed_reversal_slope(const struct followed *followed) {
    double slope = 0.0;
    ASSERT(followed->lanes <= FOLLOWED_LANES_MAX);
    for (uint32_t place = 0; place < followed->lanes; place++) {
        const struct followed_lane *lane = &followed->lane[place];
        if (lane->modulator == MODULATOR_DIRECTION && followed->width > 0) {
            slope += AMPLITUDE_COUNTS(lane->lane.amplitude) / WIDTH_COUNTS(followed->width);
        }
    }
    return slope;
}

double followed_steepest(const struct followed *followed, uint32_t counts_per_rev) {
    double steepest = followed_reversal_slope(followed);
    ASSERT(counts_per_rev > 0);
    for (uint32_t place = 0; place < followed->lanes; place++) {
        const struct lane *lane = &followed->lane[place].lane;
        steepest += 2.0 * PI * lane->order * AMPLITUDE_COUNTS(lane->amplitude) / counts_per_rev;
    }
    for (uint32_t place = 0; place < followed->real_lanes; place++) {
        steepest += real_lane_steepest(&followed->real[place], counts_per_rev);
    }
    return steepest;
}
