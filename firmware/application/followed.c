/* SPDX-License-Identifier: Apache-2.0 */

#include "followed.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"

#define WIDTH_COUNTS(word) ((word) / 16.0)
#define AMPLITUDE_COUNTS(word) (fabs((double)(word)) / (1 << ARCTRUE_AMPLITUDE_FRACTION))

enum { WIDTH_WORDS = 1 << 24, DEAD_ZONE_MOST = 255, ORDERS = 1 << 16 };

bool followed_lane_is_valid(const struct followed_lane *lane) {
    const int32_t limit = 1 << (ARCTRUE_AMPLITUDE_WIDTH - 1);
    return lane->modulator > MODULATOR_ONE && lane->modulator < MODULATORS &&
           lane->lane.order < ORDERS && lane->lane.phase_offset >> ARCTRUE_PHASE_WIDTH == 0 &&
           lane->lane.amplitude >= -limit && lane->lane.amplitude < limit;
}

bool followed_conditions_are_valid(uint32_t width, uint32_t dead_zone, uint32_t nominal_speed) {
    return width > 0 && width < WIDTH_WORDS && dead_zone <= DEAD_ZONE_MOST && nominal_speed > 0;
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
    return steepest;
}
