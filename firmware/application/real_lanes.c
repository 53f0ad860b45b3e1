/* SPDX-License-Identifier: Apache-2.0 */

#include "real_lanes.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"

#define TURN_STEPS (1ULL << ARCTRUE_PHASE_STEP_WIDTH)
#define PHASES (1U << ARCTRUE_PHASE_WIDTH)

enum {
    ORDERS = 1 << ARCTRUE_ORDER_WIDTH,
    CUT_OFF = ARCTRUE_PHASE_STEP_WIDTH - ARCTRUE_PHASE_WIDTH
};

bool real_lane_is_valid(const struct real_lane *lane) {
    const int32_t limit = 1 << (ARCTRUE_AMPLITUDE_WIDTH - 1);
    return lane->order < ORDERS && lane->turn_step > 0 && lane->turn_step < TURN_STEPS &&
           lane->phase_offset < PHASES && lane->amplitude >= -limit && lane->amplitude < limit &&
           lane->source < PHASE_SOURCES && lane->probe_phase < PHASES;
}

double real_lane_order(const struct real_lane *lane) {
    return (double)lane->order + (double)lane->turn_step / (double)TURN_STEPS;
}

uint64_t real_lane_phase_step(const struct real_lane *lane, uint32_t counts_per_rev) {
    ASSERT(counts_per_rev > 0 && lane->order < ORDERS);
    /* The order has 16 bits above its 48 bits of fraction and fills the word. Adding half of counts_per_rev for the
       rounding could therefore overflow, so the remainder is compared instead. */
    uint64_t order = (uint64_t)lane->order << ARCTRUE_PHASE_STEP_WIDTH | lane->turn_step;
    uint64_t step = order / counts_per_rev;
    uint64_t over = order % counts_per_rev;
    return (step + (2 * over >= counts_per_rev ? 1U : 0U)) % TURN_STEPS;
}

double real_lane_steepest(const struct real_lane *lane, uint32_t counts_per_rev) {
    double counts = fabs((double)lane->amplitude) / (1 << ARCTRUE_AMPLITUDE_FRACTION);
    ASSERT(counts_per_rev > 0);
    return 2.0 * PI * real_lane_order(lane) * counts / counts_per_rev;
}

void real_lane_set_phase(struct real_lane *lane, uint32_t phase, int32_t turn) {
    /* The product modulo 2^64 is enough, because the 48 bits of a turn are its low bits. The result is rounded as in
       the core. */
    uint64_t fraction = (uint64_t)(int64_t)turn * lane->turn_step;
    uint64_t half = 1ULL << (CUT_OFF - 1);
    uint32_t gone_on = (uint32_t)((fraction + half) >> CUT_OFF) % PHASES;
    lane->phase_offset = (phase + PHASES - gone_on) % PHASES;
    lane->phase_known = true;
}

bool real_lane_move_phase(struct real_lane *lane, double phase_turns, double angle_turns,
                          int32_t turn, double least_counts) {
    struct real_lane moved = *lane;
    double turns = phase_turns - real_lane_order(lane) * angle_turns;
    uint32_t phase = (uint32_t)rint((turns - floor(turns)) * PHASES) % PHASES;
    real_lane_set_phase(&moved, phase, turn);
    /* Phase words are modulo one turn. */
    uint32_t apart = (moved.phase_offset - lane->phase_offset) % PHASES;
    double apart_turns = (double)(apart < PHASES / 2 ? apart : PHASES - apart) / PHASES;
    double counts = fabs((double)lane->amplitude) / (1 << ARCTRUE_AMPLITUDE_FRACTION);
    if (lane->phase_known && 2.0 * PI * apart_turns * counts <= least_counts) {
        return false;
    }
    *lane = moved;
    return true;
}

bool real_lanes_counts_suffice(uint32_t lanes, uint32_t counts_per_rev) {
    return counts_per_rev >=
           ARCTRUE_REAL_ORDER_COUNTS_A_LANE * lanes + ARCTRUE_REAL_ORDER_COUNTS_FURTHER;
}
