/* SPDX-License-Identifier: Apache-2.0 */

/* Declares lanes whose amplitude the gateware multiplies by a condition (generic MODULATORS), and the settings from
   which the gateware calculates direction and speed. The operator loads these lanes and settings. The firmware judges a
   lane of an order of 1 or more by turns with two different values of its condition. It cannot judge lanes of order 0
   and lanes that follow a word of the processor. */

#ifndef ARCTRUE_FOLLOWED_H
#define ARCTRUE_FOLLOWED_H

#include "coefficients.h"
#include "real_lanes.h"
#include "vector.h"

enum { FOLLOWED_LANES_MAX = 8 };

/* Conditions whose value multiplies the amplitude of a lane; the number is in bits 18 to 16 of word 1 of the lane. */
enum modulator {
    MODULATOR_ONE,
    MODULATOR_DIRECTION,
    MODULATOR_SPEED,
    MODULATOR_SPEED_SQUARED,
    MODULATOR_WORD_A,
    MODULATOR_WORD_B,
    MODULATORS
};

struct followed_lane {
    /* Lane without the condition; its order may be 0. */
    struct lane lane;
    uint32_t modulator;
};

struct followed {
    struct followed_lane lane[FOLLOWED_LANES_MAX];
    uint32_t lanes;
    /* Lanes of real orders, that is, of orders that are not whole (real_lanes.h); in the bank they precede the lanes
       above. */
    struct real_lane real[REAL_LANES_MAX];
    uint32_t real_lanes;
    /* Words of the registers `conditions`: width in u20.4 counts, dead zone in counts, nominal speed in u0.32 counts
       per clock. */
    uint32_t width;
    uint32_t dead_zone;
    uint32_t nominal_speed;
};

/* Motion of the table in a turn: counts per clock, negative if the angle decreases. */
struct motion {
    double speed;
};

/* Measurement of a lane in one turn, arcsec at modulator 1, along the lane's phase: value, standard uncertainty, and
   loaded value. The measurement assumes that all other lanes of the order are correct as loaded. */
struct followed_measured {
    uint32_t order;
    uint32_t modulator;
    double measured_arcsec;
    double u_arcsec;
    double loaded_arcsec;
};

/* Returns the number of lanes of both kinds. */
uint32_t followed_all_lanes(const struct followed *followed);

/* Returns the name of the modulator in the coefficient file. */
const char *followed_modulator_name(uint32_t modulator);

/* Returns the factor of the lane, -1 to 1; 0 for a word of the processor. */
double followed_modulator(const struct followed *followed, uint32_t place,
                          const struct motion *motion);
/* Returns the sum of all lanes of an order, each multiplied by its condition at this motion, arcsec. */
struct vector followed_components(const struct followed *followed, uint32_t order,
                                  uint32_t counts_per_rev, const struct motion *motion);
/* Tells whether turns of two heads can show the lane. */
bool followed_lane_is_seen(const struct followed_lane *lane);

bool followed_lane_is_valid(const struct followed_lane *lane);
bool followed_conditions_are_valid(uint32_t width, uint32_t dead_zone, uint32_t nominal_speed);

/* Returns an upper bound of |d eps / d R|, the sum of the steepest slopes of all lanes plus
   followed_reversal_slope(). */
double followed_steepest(const struct followed *followed, uint32_t counts_per_rev);
/* Tells whether the measurement of the speed stays stable: it uses the corrected angle, which the lanes that follow the
   speed move. */
bool followed_speed_is_stable(const struct followed *followed);
/* Returns the part of followed_steepest() that arises while the gateware changes from one direction to the other; 1/2
   or more is too steep. */
double followed_reversal_slope(const struct followed *followed);

#endif
