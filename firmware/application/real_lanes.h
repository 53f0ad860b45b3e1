/* SPDX-License-Identifier: Apache-2.0 */

/* Lanes whose order is not whole (generic REAL_ORDERS): in turn m of the core the phase of a lane is its phase offset and
   m times its turn step. The operator loads them. Two heads cannot judge them. Nobody knows the phase of such a
   line after power-up: a lane has amplitude 0 until the operator gives its phase. */

#ifndef ARCTRUE_REAL_LANES_H
#define ARCTRUE_REAL_LANES_H

#include <stdbool.h>
#include <stdint.h>

enum { REAL_LANES_MAX = 8 };

struct real_lane {
    /* Whole part of the order, and its fraction in 2^-48: the turn step. */
    uint32_t order;
    uint64_t turn_step;
    /* Phase in turn 0 of the core, u0.24 turn, if it is known. */
    uint32_t phase_offset;
    int32_t amplitude;
    bool phase_known;
};

bool real_lane_is_valid(const struct real_lane *lane);
double real_lane_order(const struct real_lane *lane);
/* Phase step, u0.48 turn per count. */
uint64_t real_lane_phase_step(const struct real_lane *lane, uint32_t counts_per_rev);
/* Upper bound of the lane's |d eps / d R|. */
double real_lane_steepest(const struct real_lane *lane, uint32_t counts_per_rev);
/* Sets the phase so that it is `phase`, u0.24 turn, at angle 0 of turn `turn` of the core. */
void real_lane_set_phase(struct real_lane *lane, uint32_t phase, int32_t turn);
/* True if a core with this many lanes prepares the phases in time. */
bool real_lanes_counts_suffice(uint32_t lanes, uint32_t counts_per_rev);

#endif
