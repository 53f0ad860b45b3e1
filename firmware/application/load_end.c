/* SPDX-License-Identifier: Apache-2.0 */

/* Ends the reception of a set, and checks that this device can apply the set. */

#include <stddef.h>

#include "load_frames.h"

/* Upper limit of the slope of the lanes that follow the direction, while their factor changes after a reversal. Below
   this limit, the corrected angle moves in the direction of the table. */
#define STEEPEST_REVERSAL 0.5
/* Limit of an amplitude in counts: magnitude of the most negative word. */
#define AMPLITUDE_LIMIT ((double)(1 << (ARCTRUE_AMPLITUDE_WIDTH - 1 - ARCTRUE_AMPLITUDE_FRACTION)))

static enum load_answer load_check_real(const struct load *load, const struct load_place *place) {
    if (load->received_followed.real_lanes == 0) {
        return LOAD_TAKEN;
    }
    if (!place->has_real_orders) {
        return LOAD_NO_REAL_ORDERS;
    }
    if (!real_lanes_counts_suffice(place->lanes, place->counts_per_rev)) {
        return LOAD_TOO_FEW_COUNTS;
    }
    bool seen = true;
    for (uint32_t lane = 0; lane < load->received_followed.real_lanes; lane++) {
        seen = seen && load->received_followed.real[lane].source == PHASE_BY_HEADS;
    }
    return seen || load_takes_unseen(load) ? LOAD_TAKEN : LOAD_UNSEEN;
}

/* Checks the lanes that follow a condition. A lane that no turn of two heads can show is accepted only if the set
   contains the frame `load force`. */
static enum load_answer load_check_followed(const struct load *load, bool has_modulators) {
    const struct followed *followed = &load->received_followed;
    if (load->frames + followed_all_lanes(followed) > load->received.lanes) {
        return LOAD_TOO_MANY_LANES;
    }
    if (followed->lanes == 0) {
        return LOAD_TAKEN;
    }
    if (!has_modulators) {
        return LOAD_NO_MODULATORS;
    }
    if (followed->width == 0) {
        return LOAD_NOT_WHOLE;
    }
    if (followed_reversal_slope(followed) >= STEEPEST_REVERSAL) {
        return LOAD_TOO_STEEP;
    }
    if (!followed_speed_is_stable(followed)) {
        return LOAD_UNSTABLE_SPEED;
    }
    for (uint32_t place = 0; place < followed->lanes && !load_takes_unseen(load); place++) {
        if (!followed_lane_is_seen(&followed->lane[place])) {
            return LOAD_UNSEEN;
        }
    }
    return LOAD_TAKEN;
}

static enum load_answer load_look_at_mean(const struct mean_set *mean,
                                          const struct load_place *place) {
    if (mean->heads == 0) {
        return LOAD_TAKEN;
    }
    if (!place->has_mean || mean->heads != place->heads) {
        return LOAD_OTHER_HEADS;
    }
    if (!mean_set_is_valid(mean, place->heads, place->counts_per_rev)) {
        return LOAD_OUT_OF_RANGE;
    }
    return mean->delays == place->delays ? LOAD_TAKEN : LOAD_OTHER_DELAYS;
}

enum load_answer load_end(struct load *load, const struct load_place *place,
                          const struct coefficients *active, uint32_t crc) {
    struct coefficients own;
    struct coefficients all;
    if (load->state != LOAD_RECEIVING) {
        return LOAD_WRONG_FRAME;
    }
    if (load->crc != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->next != load->frames || !load_without_is_whole(load)) {
        return load_frame_refused(load, LOAD_NOT_WHOLE);
    }
    /* A prepared set can neither follow temperature, direction or speed nor contain real orders. */
    bool follows =
        load->received_thermal.lanes != 0 || followed_all_lanes(&load->received_followed) != 0;
    if (load->without.whole != 0 && (follows || !place->has_failover)) {
        return load_frame_refused(load, follows ? LOAD_OUT_OF_RANGE : LOAD_NO_FAILOVER);
    }
    if (load->received.counts_per_rev != place->counts_per_rev) {
        return load_frame_refused(load, LOAD_ANOTHER_TABLE);
    }
    if (load->received_table.place.choice != 0 && !place->has_local_table) {
        return load_frame_refused(load, LOAD_NO_LOCAL_TABLE);
    }
    enum load_answer checked = load_check_followed(load, place->has_modulators);
    if (checked != LOAD_TAKEN) {
        return load_frame_refused(load, checked);
    }
    enum load_answer of_real = load_check_real(load, place);
    if (of_real != LOAD_TAKEN) {
        return load_frame_refused(load, of_real);
    }
    enum load_answer of_mean = load_look_at_mean(&load->received.mean, place);
    if (of_mean != LOAD_TAKEN) {
        return load_frame_refused(load, of_mean);
    }
    load_own_lanes(load, active, &own);
    load_combine(&load->received, NULL, 0.0, &own,
                 load->received.lanes - followed_all_lanes(&load->received_followed), &all);
    const struct thermal_extent extent = thermal_extent(&load->received_thermal, &all);
    const struct followed *followed = &load->received_followed;
    /* The table stays active when a set for a missing head replaces the lanes. */
    double lanes = extent.steepest + followed_steepest(followed, place->counts_per_rev);
    double steepest = lanes > load->without.steepest ? lanes : load->without.steepest;
    if (steepest + load_table_steepest(&load->received_table, place->counts_per_rev) >=
        LOAD_STEEPEST) {
        return load_frame_refused(load, LOAD_TOO_STEEP);
    }
    if (extent.largest_counts > AMPLITUDE_LIMIT) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    load->state = LOAD_WAITING;
    load->whole = true;
    return LOAD_TAKEN;
}
