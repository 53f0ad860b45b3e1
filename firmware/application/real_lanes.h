/* SPDX-License-Identifier: Apache-2.0 */

/* Declares lanes whose order is not whole (generic REAL_ORDERS): in turn m of the core the phase of a lane is its phase
   offset plus m times its turn step. The operator loads these lanes. Their phases are unknown after power-up. A lane
   has amplitude 0 until the heads or an index of the drive at probe_in show its phase, or the operator states the
   phase. */

#ifndef ARCTRUE_REAL_LANES_H
#define ARCTRUE_REAL_LANES_H

#include <stdbool.h>
#include <stdint.h>

enum { REAL_LANES_MAX = 8 };

/* Origin of the phase of a lane. */
enum phase_source { PHASE_BY_OPERATOR, PHASE_BY_HEADS, PHASE_BY_PROBE, PHASE_SOURCES };

struct real_lane {
    /* Whole part of the order, and its fraction in 2^-48: the turn step. */
    uint32_t order;
    uint64_t turn_step;
    /* Phase in turn 0 of the core, u0.24 turn, if it is known. */
    uint32_t phase_offset;
    int32_t amplitude;
    bool phase_known;
    uint32_t source;
    /* At every rising edge of the drive's index, the error that the lane corrects has the phase `probe_phase`, u0.24
       turn, plus `side` times the angle of the table. `side` is 0 for an order of the drive itself, and 1 or -1 for the
       two orders next to it that an eccentric gear adds. */
    int32_t side;
    uint32_t probe_phase;
};

bool real_lane_is_valid(const struct real_lane *lane);
double real_lane_order(const struct real_lane *lane);
/* Returns the phase step, u0.48 turn per count. */
uint64_t real_lane_phase_step(const struct real_lane *lane, uint32_t counts_per_rev);
/* Returns an upper bound of the lane's |d eps / d R|. */
double real_lane_steepest(const struct real_lane *lane, uint32_t counts_per_rev);
/* Sets the phase so that it is `phase`, u0.24 turn, at angle 0 of turn `turn` of the core. */
void real_lane_set_phase(struct real_lane *lane, uint32_t phase, int32_t turn);
/* Sets the phase so that it is `phase_turns` at the corrected angle `angle_turns`, 0 to 1, of turn `turn`. If the phase
   is known already and the lane's value would change by `least_counts` or less, leaves the lane unchanged and returns
   false. */
bool real_lane_move_phase(struct real_lane *lane, double phase_turns, double angle_turns,
                          int32_t turn, double least_counts);
/* Tells whether a turn has enough counts for a core with this many lanes to prepare the phases of the next turn. */
bool real_lanes_counts_suffice(uint32_t lanes, uint32_t counts_per_rev);

#endif
