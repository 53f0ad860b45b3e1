/* SPDX-License-Identifier: Apache-2.0 */

/* Receives the sets for a missing head, which the gateware holds as prepared sets. */

#include "load_frames.h"

bool load_without_is_whole(const struct load *load) {
    const struct load_without *set = &load->without;
    return set->head == 0 || (set->whole >> (set->head - 1) & 1U) != 0;
}

/* If all frames of the prepared set have arrived, checks that its words form a mean without the missing head, and marks
   the set as complete. */
static enum load_answer load_close_without(struct load *load) {
    struct load_without *set = &load->without;
    const struct mean_set *all = &load->received.mean;
    if (set->mean.heads != all->heads || set->next_lane != set->lanes) {
        return LOAD_TAKEN;
    }
    uint32_t others = ((1U << all->heads) - 1U) & ~(1U << (set->head - 1));
    if (set->mean.used != others ||
        !mean_set_is_valid(&set->mean, all->heads, load->received.counts_per_rev)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    if (set->steepness >= LOAD_STEEPEST) {
        return load_frame_refused(load, LOAD_TOO_STEEP);
    }
    set->whole |= 1U << (set->head - 1);
    set->steepest = set->steepness > set->steepest ? set->steepness : set->steepest;
    return LOAD_TAKEN;
}

enum load_answer load_without(struct load *load, uint32_t head, uint32_t lanes,
                              const struct mean_set *mean, uint32_t crc) {
    const uint32_t words[] = {head, lanes, mean->carrier, mean->used, (uint32_t)mean->error_offset};
    struct load_without *set = &load->without;
    enum load_answer arrived = load_arrived(load, words, 5, crc, load_without_is_whole(load));
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    if (lanes > load->received.lanes) {
        return load_frame_refused(load, LOAD_TOO_MANY_LANES);
    }
    uint32_t heads = load->received.mean.heads;
    if (heads < 3 || head == 0 || head > heads || (set->whole >> (head - 1) & 1U) != 0) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    *set = (struct load_without){.head = head,
                                 .lanes = lanes,
                                 .mean = *mean,
                                 .steepest = set->steepest,
                                 .whole = set->whole};
    return load_frame_taken(load, words, 5);
}

enum load_answer load_without_head(struct load *load, uint32_t number, int32_t weight,
                                   uint32_t offset, uint32_t crc) {
    const uint32_t words[] = {number, (uint32_t)weight, offset};
    struct load_without *set = &load->without;
    enum load_answer arrived =
        load_arrived(load, words, 3, crc,
                     !load_without_is_whole(load) && number == set->mean.heads &&
                         number < load->received.mean.heads);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    set->mean.weight[number] = weight;
    set->mean.offset[number] = offset;
    set->mean.heads++;
    (void)load_frame_taken(load, words, 3);
    return load_close_without(load);
}

enum load_answer load_without_lane(struct load *load, uint32_t number, const struct lane *lane,
                                   uint32_t crc) {
    const uint32_t words[] = {number, lane->order, lane->phase_offset, (uint32_t)lane->amplitude};
    struct load_without *set = &load->without;
    enum load_answer arrived = load_arrived(load, words, 4, crc,
                                            !load_without_is_whole(load) &&
                                                number == set->next_lane && number < set->lanes);
    if (arrived != LOAD_TAKEN) {
        return arrived;
    }
    if (!coefficients_lane_is_valid(lane)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    if (lane->order <= set->order) {
        return load_frame_refused(load, LOAD_ORDER_TWICE);
    }
    const struct coefficients alone = {
        .lane = {*lane}, .lanes = 1, .counts_per_rev = load->received.counts_per_rev};
    set->steepness += thermal_extent(&(struct thermal){0}, &alone).steepest;
    set->order = lane->order;
    set->next_lane++;
    (void)load_frame_taken(load, words, 4);
    return load_close_without(load);
}
