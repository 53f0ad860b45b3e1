/* SPDX-License-Identifier: Apache-2.0 */

/* Lanes whose amplitude the gateware multiplies with a condition (generic MODULATORS), and what direction
   and speed are worked out with. The operator loads them. Turns of two heads judge those of an order of the
   turn under two conditions; order 0 and the processor's words no turn shows. */

#ifndef ARCTRUE_FOLLOWED_H
#define ARCTRUE_FOLLOWED_H

#include "coefficients.h"
#include "vector.h"

enum { FOLLOWED_LANES_MAX = 8 };

/* As bits 18 to 16 of word 1 of a lane. */
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
    /* Its order may be 0. */
    struct lane lane;
    uint32_t modulator;
};

struct followed {
    struct followed_lane lane[FOLLOWED_LANES_MAX];
    uint32_t lanes;
    /* Words of the registers `conditions`: u20.4 counts, counts, u0.32 counts a clock. */
    uint32_t width;
    uint32_t dead_zone;
    uint32_t nominal_speed;
};

/* How the table moved in a turn: counts a clock, negative while the angle falls. */
struct motion {
    double speed;
};

/* What one turn says of a lane, arcsec at modulator 1, along the lane's phase: the value and its standard
   uncertainty, and the loaded value. All other lanes of the order are taken as they are loaded. */
struct followed_measured {
    uint32_t order;
    uint32_t modulator;
    double measured_arcsec;
    double u_arcsec;
    double loaded_arcsec;
};

/* As the coefficient file names it. */
const char *followed_modulator_name(uint32_t modulator);

/* What the lane is multiplied with, -1 to 1; 0 for a word of the processor. */
double followed_modulator(const struct followed *followed, uint32_t place,
                          const struct motion *motion);
/* What all lanes of an order add to its components, arcsec. */
struct vector followed_components(const struct followed *followed, uint32_t order,
                                  uint32_t counts_per_rev, const struct motion *motion);
/* Turns of two heads may show the lane. */
bool followed_lane_is_seen(const struct followed_lane *lane);

bool followed_lane_is_valid(const struct followed_lane *lane);
bool followed_conditions_are_valid(uint32_t width, uint32_t dead_zone, uint32_t nominal_speed);

/* |d eps / d R| at most: of the orders, and of the direction while it goes over within its width. */
double followed_steepest(const struct followed *followed, uint32_t counts_per_rev);
/* The part of it that the direction has; from 1/2 on it is too steep. */
double followed_reversal_slope(const struct followed *followed);

#endif
