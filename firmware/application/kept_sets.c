/* SPDX-License-Identifier: Apache-2.0 */

#include "kept_sets.h"

#include "assertion.h"

enum { LANES_AT = 8, USED_AT = 4, BYTE = 0xFF, ORDER_AT = 24, WORD_24 = 0xFFFFFF };

static uint32_t *kept_sets_put(uint32_t *to, uint32_t word) {
    *to = word;
    return to + 1;
}

bool kept_sets_add(struct kept_sets *kept, uint32_t head, const struct coefficients *set) {
    uint32_t lanes = 0;
    ASSERT(set->lanes <= LANES_LIMIT && head >= 1 && head <= HEADS_MOST);
    for (uint32_t lane = 0; lane < set->lanes; lane++) {
        lanes += set->lane[lane].order != 0;
    }
    uint32_t words = KEPT_HEAD_WORDS + lanes * KEPT_LANE_WORDS;
    if (lanes > KEPT_LANES_MOST || kept->number + words > KEPT_SETS_WORDS) {
        return false;
    }
    uint32_t *to = kept->word + kept->number;
    to = kept_sets_put(to, head | lanes << LANES_AT);
    to = kept_sets_put(to, (uint32_t)set->mean.error_offset);
    to = kept_sets_put(to, set->mean.carrier | set->mean.used << USED_AT);
    for (uint32_t place = 0; place < HEADS_MOST; place++) {
        to[place] = (uint32_t)set->mean.weight[place];
        to[place + HEADS_MOST] = set->mean.offset[place];
    }
    to += 2 * HEADS_MOST;
    for (uint32_t lane = 0; lane < set->lanes; lane++) {
        const struct lane *word = &set->lane[lane];
        if (word->order != 0) {
            to = kept_sets_put(to, (word->phase_offset & WORD_24) | (word->order & BYTE)
                                                                        << ORDER_AT);
            to = kept_sets_put(to, ((uint32_t)word->amplitude & WORD_24) | (word->order >> LANES_AT)
                                                                               << ORDER_AT);
        }
    }
    kept->number += words;
    return true;
}

static struct lane kept_sets_lane(const uint32_t *words) {
    /* The shift to the left and the division extend the sign of the 24-bit word. */
    int32_t amplitude = (int32_t)(words[1] << LANES_AT) / (1 << LANES_AT);
    return (struct lane){.phase_offset = words[0] & WORD_24,
                         .amplitude = amplitude,
                         .order = words[0] >> ORDER_AT | (words[1] >> ORDER_AT) << LANES_AT};
}

uint32_t kept_sets_next(const struct kept_sets *kept, uint32_t *place, uint32_t heads,
                        uint32_t counts_per_rev, struct coefficients *set) {
    ASSERT(kept->number <= KEPT_SETS_WORDS && *place <= kept->number);
    const uint32_t *from = kept->word + *place;
    uint32_t left = kept->number - *place;
    uint32_t head = left >= KEPT_HEAD_WORDS ? from[0] & BYTE : 0;
    uint32_t lanes = head != 0 ? from[0] >> LANES_AT : 0;
    if (head == 0 || head > heads || heads > HEADS_MOST || lanes > KEPT_LANES_MOST ||
        left < KEPT_HEAD_WORDS + lanes * KEPT_LANE_WORDS) {
        return 0;
    }
    *set = (struct coefficients){.lanes = lanes, .counts_per_rev = counts_per_rev};
    set->mean = (struct mean_set){.heads = heads,
                                  .carrier = from[2] & (BYTE >> USED_AT),
                                  .used = from[2] >> USED_AT,
                                  .error_offset = (int32_t)from[1]};
    from += 3;
    for (uint32_t other = 0; other < HEADS_MOST; other++) {
        set->mean.weight[other] = (int32_t)from[other];
        set->mean.offset[other] = from[other + HEADS_MOST];
    }
    from += 2 * HEADS_MOST;
    bool valid = mean_set_is_valid(&set->mean, heads, counts_per_rev) &&
                 set->mean.used == (((1U << heads) - 1U) & ~(1U << (head - 1)));
    for (uint32_t lane = 0; lane < lanes; lane++, from += KEPT_LANE_WORDS) {
        set->lane[lane] = kept_sets_lane(from);
        valid = valid && coefficients_lane_is_valid(&set->lane[lane]);
    }
    *place = (uint32_t)(from - kept->word);
    return valid ? head : 0;
}

bool kept_sets_are_valid(const struct kept_sets *kept, uint32_t heads, uint32_t counts_per_rev) {
    struct coefficients set;
    uint32_t place = 0;
    uint32_t seen = 0;
    while (place < kept->number) {
        uint32_t head = kept_sets_next(kept, &place, heads, counts_per_rev, &set);
        if (head == 0 || (seen >> head & 1U) != 0) {
            return false;
        }
        seen |= 1U << head;
    }
    return true;
}
