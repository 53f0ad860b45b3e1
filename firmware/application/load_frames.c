/* SPDX-License-Identifier: Apache-2.0 */

#include "load_frames.h"

#include "crc32.h"

static uint32_t load_crc_of(uint32_t crc, const uint32_t *words, uint32_t number) {
    for (uint32_t word = 0; word < number; word++) {
        crc = crc32_add_word(crc, words[word]);
    }
    return crc;
}

enum load_answer load_arrived(const struct load *load, const uint32_t *words, uint32_t number,
                              uint32_t crc, bool expected) {
    if (load_crc_of(0, words, number) != crc) {
        return LOAD_WRONG_CRC;
    }
    return load->state == LOAD_RECEIVING && expected ? LOAD_TAKEN : LOAD_WRONG_FRAME;
}

enum load_answer load_frame_taken(struct load *load, const uint32_t *words, uint32_t number) {
    load->crc = load_crc_of(load->crc, words, number);
    return LOAD_TAKEN;
}

enum load_answer load_frame_refused(struct load *load, enum load_answer reason) {
    load_refuse(load, reason);
    return reason;
}

enum load_answer load_begin(struct load *load, uint32_t frames, uint32_t counts_per_rev,
                            uint32_t lanes, uint32_t crc) {
    const uint32_t words[] = {frames, counts_per_rev};
    if (load_crc_of(0, words, 2) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (frames > lanes || frames > LANES_LIMIT) {
        return load_frame_refused(load, LOAD_TOO_MANY_LANES);
    }
    load->state = LOAD_RECEIVING;
    load->frames = frames;
    load->next = 0;
    load->crc = crc;
    load->received = (struct coefficients){.lanes = lanes, .counts_per_rev = counts_per_rev};
    load->received_thermal = (struct thermal){0};
    load->received_followed = (struct followed){0};
    load->received_table = (struct load_table){.next = 0};
    load->without = (struct load_without){.head = 0};
    load->whole = false;
    load->forced = false;
    load->unseen_taken = false;
    load_begin_evidence(load);
    return LOAD_TAKEN;
}

enum load_answer load_lane(struct load *load, uint32_t number, uint32_t order,
                           uint32_t phase_offset, int32_t amplitude, uint32_t crc) {
    const uint32_t words[] = {number, order, phase_offset, (uint32_t)amplitude};
    enum load_answer arrived =
        load_arrived(load, words, 4, crc, number == load->next && number < load->frames);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    const struct lane lane = {phase_offset, amplitude, order};
    if (!coefficients_lane_is_valid(&lane)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    if (coefficients_have(&load->received, order)) {
        return load_frame_refused(load, LOAD_ORDER_TWICE);
    }
    load->received.lane[load->next++] = lane;
    return load_frame_taken(load, words, 4);
}

enum load_answer load_slope(struct load *load, uint32_t number, const struct thermal_lane *lane,
                            uint32_t crc) {
    const uint32_t words[] = {
        number,
        lane->order,
        (uint32_t)lane->cosine,
        (uint32_t)lane->sine,
        (uint32_t)lane->cosine_squared,
        (uint32_t)lane->sine_squared,
    };
    struct thermal *thermal = &load->received_thermal;
    enum load_answer arrived = load_arrived(load, words, 6, crc, number == thermal->lanes);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    if (number >= THERMAL_LANES_MAX || !coefficients_have(&load->received, lane->order)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    thermal->lane[thermal->lanes++] = *lane;
    return load_frame_taken(load, words, 6);
}

enum load_answer load_temperature(struct load *load, int32_t reference_mc,
                                  uint32_t time_constant_ms, uint32_t crc) {
    const uint32_t words[] = {(uint32_t)reference_mc, time_constant_ms};
    enum load_answer arrived = load_arrived(load, words, 2, crc, true);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    load->received_thermal.reference_mc = reference_mc;
    load->received_thermal.time_constant_ms = time_constant_ms;
    thermal_preset_range(&load->received_thermal);
    if (!thermal_is_valid(&load->received_thermal)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    return load_frame_taken(load, words, 2);
}

enum load_answer load_range(struct load *load, int32_t least_mc, int32_t most_mc, uint32_t crc) {
    const uint32_t words[] = {(uint32_t)least_mc, (uint32_t)most_mc};
    enum load_answer arrived = load_arrived(load, words, 2, crc, true);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    load->received_thermal.least_mc = least_mc;
    load->received_thermal.most_mc = most_mc;
    if (!thermal_is_valid(&load->received_thermal)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    return load_frame_taken(load, words, 2);
}

enum load_answer load_followed(struct load *load, uint32_t number, const struct followed_lane *lane,
                               uint32_t crc) {
    const uint32_t words[] = {number, lane->modulator, lane->lane.order, lane->lane.phase_offset,
                              (uint32_t)lane->lane.amplitude};
    struct followed *followed = &load->received_followed;
    enum load_answer arrived = load_arrived(load, words, 5, crc, number == followed->lanes);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    if (number >= FOLLOWED_LANES_MAX) {
        return load_frame_refused(load, LOAD_TOO_MANY_LANES);
    }
    if (!followed_lane_is_valid(lane)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    followed->lane[followed->lanes++] = *lane;
    return load_frame_taken(load, words, 5);
}

enum load_answer load_real(struct load *load, uint32_t number, const struct real_lane *lane,
                           uint32_t crc) {
    const uint32_t words[] = {number, lane->order, (uint32_t)lane->turn_step,
                              (uint32_t)(lane->turn_step >> 32), (uint32_t)lane->amplitude};
    struct followed *followed = &load->received_followed;
    enum load_answer arrived = load_arrived(load, words, 5, crc, number == followed->real_lanes);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    if (number >= REAL_LANES_MAX) {
        return load_frame_refused(load, LOAD_TOO_MANY_LANES);
    }
    if (!real_lane_is_valid(lane)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    followed->real[followed->real_lanes++] = *lane;
    return load_frame_taken(load, words, 5);
}

enum load_answer load_phase_source(struct load *load, uint32_t number, const struct real_lane *lane,
                                   uint32_t crc) {
    const uint32_t words[] = {number, lane->source, (uint32_t)lane->side, lane->probe_phase};
    struct followed *followed = &load->received_followed;
    enum load_answer arrived = load_arrived(load, words, 4, crc, number < followed->real_lanes);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    struct real_lane *real = &followed->real[number];
    real->source = lane->source;
    real->side = lane->side;
    real->probe_phase = lane->probe_phase;
    if (!real_lane_is_valid(real)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    return load_frame_taken(load, words, 4);
}

enum load_answer load_conditions(struct load *load, uint32_t width, uint32_t dead_zone,
                                 uint32_t nominal_speed, uint32_t crc) {
    const uint32_t words[] = {width, dead_zone, nominal_speed};
    enum load_answer arrived = load_arrived(load, words, 3, crc, true);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    if (!followed_conditions_are_valid(width, dead_zone, nominal_speed)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    load->received_followed.width = width;
    load->received_followed.dead_zone = dead_zone;
    load->received_followed.nominal_speed = nominal_speed;
    return load_frame_taken(load, words, 3);
}

enum load_answer load_mean(struct load *load, const struct mean_set *mean, uint32_t crc) {
    const uint32_t words[] = {mean->carrier, mean->used, (uint32_t)mean->error_offset,
                              mean->delays};
    enum load_answer arrived = load_arrived(load, words, 4, crc, true);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    load->received.mean = *mean;
    return load_frame_taken(load, words, 4);
}

enum load_answer load_head(struct load *load, uint32_t number, int32_t weight, uint32_t offset,
                           uint32_t crc) {
    const uint32_t words[] = {number, (uint32_t)weight, offset};
    struct mean_set *mean = &load->received.mean;
    enum load_answer arrived =
        load_arrived(load, words, 3, crc, number == mean->heads && number < HEADS_MOST);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    mean->weight[number] = weight;
    mean->offset[number] = offset;
    mean->heads++;
    return load_frame_taken(load, words, 3);
}

enum load_answer load_force(struct load *load, uint32_t scope, uint32_t crc) {
    const uint32_t words[] = {scope};
    enum load_answer arrived = load_arrived(load, words, 1, crc, true);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    if (scope != LOAD_FORCES_ALL && scope != LOAD_FORCES_UNSEEN) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    load->forced = load->forced || scope == LOAD_FORCES_ALL;
    load->unseen_taken = load->unseen_taken || scope == LOAD_FORCES_UNSEEN;
    return load_frame_taken(load, words, 1);
}
