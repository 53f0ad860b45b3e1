/* SPDX-License-Identifier: Apache-2.0 */

/* Operates the failover of the mean: the check of the heads, and the prepared sets that lack one head. */

#include <math.h>

#include "assertion.h"
#include "core.h"
#include "core_registers.h"
#include "core_words.h"

/* Largest number of reads while a set is being loaded: the loading takes up to 6 us, and each read takes at least one
   bus access, 0.1 us. */
enum { FAILOVER_LOOKS_MOST = 1000 };

void core_failover_off(const struct core_access *core) {
    if (FIELD(core_capability(core), CAPABILITY__FAILOVER) == 0) {
        return;
    }
    core_write(core, AT(failover), 0);
    /* The parity's weights belong to the present mean; with other words its limit would raise a false alarm. */
    core_write(core, AT(parity.limit), 0);
    uint32_t looks = 0;
    while ((core_read(core, AT(heads_status)) & BIT(HEADS_STATUS__BUSY)) != 0 &&
           looks < FAILOVER_LOOKS_MOST) {
        looks++;
    }
}

/* Window of a prepared set: lanes from offset 0 on, then the words of the mean, and the coefficient offset as the
   last word. */
enum { SET_BYTES = 0x1000, SET_MEAN = 0x800, SET_OFFSET = SET_MEAN + 15 * WORD_BYTES };
#define SET_AT(set) (AT(prepared_sets) + (uint32_t)(set) * SET_BYTES)
/* Clocks in a unit of the register for the return of a head: 8 intervals of head_watch. */
#define RETURN_UNIT ((double)(8 << ARCTRUE_WATCH_INTERVAL_BITS))
#define RETURN_MOST 65535.0
enum { COMMAND_SET = 4, COMMAND_TAKE = 1 << 7, COMMAND_COME_BACK = 8 };

struct core_failover core_failover(const struct core_access *core) {
    uint32_t word = core_read(core, AT(heads_status));
    /* The read of the low word of the time latches the parity too. */
    (void)core_read_wide(core, AT(snapshot.time));
    return (struct core_failover){
        .left_out = FIELD(word, HEADS_STATUS__LEFT_OUT),
        .set = FIELD(word, HEADS_STATUS__SET),
        .causes = FIELD(word, HEADS_STATUS__CAUSE),
        .parity = (int32_t)core_read(core, AT(parity.value)),
        .parity_beyond = FIELD(word, HEADS_STATUS__PARITY_BEYOND) != 0,
    };
}

bool core_set_is_refused(const struct core_access *core) {
    return (core_read(core, AT(heads_status)) & BIT(HEADS_STATUS__SWAP_REFUSED)) != 0;
}

bool core_failover_is_on(const struct core_access *core) {
    return (core_read(core, AT(failover)) & BIT(FAILOVER__ENABLE)) != 0;
}

void core_failover_on(const struct core_access *core, const struct core_failover_setup *setup) {
    uint32_t heads = core_heads(core);
    double units = fmin(ceil(setup->return_after / RETURN_UNIT), RETURN_MOST);
    for (uint32_t head = 0; head < heads; head++) {
        core_write(core, AT(parity.weight1) + head * WORD_BYTES,
                   (uint32_t)setup->parity_weight[head]);
    }
    core_write(core, AT(parity.limit), setup->parity_limit);
    core_write(core, AT(missing_edges), setup->missing_counts);
    core_write(core, AT(parity.step_limit), setup->step_limit);
    core_write(core, AT(failover),
               BIT(FAILOVER__ENABLE) | setup->causes << ARCTRUE_REGISTERS__FAILOVER__ILLEGAL_bp |
                   (uint32_t)units << ARCTRUE_REGISTERS__FAILOVER__RETURN_AFTER_bp);
}

uint32_t core_write_prepared_lane(const struct core_access *core, uint32_t set, uint32_t place,
                                  const struct lane *lane, uint32_t counts_per_rev) {
    uint32_t words[WORDS_A_LANE];
    uint32_t offset = SET_AT(set) + place * WORDS_A_LANE * WORD_BYTES;
    uint32_t sum = 0;
    core_lane_words(lane, counts_per_rev, MODULATOR_ONE, words);
    for (uint32_t word = 0; word < WORDS_A_LANE; word++) {
        sum += core_write_summed(core, offset + word * WORD_BYTES, words[word]);
    }
    return sum;
}

uint32_t core_write_prepared(const struct core_access *core, uint32_t set,
                             const struct coefficients *coefficients) {
    ASSERT(set <= HEADS_MOST && coefficients->lanes <= LANES_LIMIT);
    uint32_t sum = 0;
    /* A 0 as the choice of heads makes the set invalid. core_write_mean() writes this word last, which makes the set
       valid again. */
    core_write(core, SET_AT(set) + SET_MEAN + MEAN_CHOICE * WORD_BYTES, 0);
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        sum += core_write_prepared_lane(core, set, lane, &coefficients->lane[lane],
                                        coefficients->counts_per_rev);
    }
    sum += core_write_summed(core, SET_AT(set) + SET_OFFSET,
                             (uint32_t)coefficients->mean.error_offset);
    return sum + core_write_mean(core, &coefficients->mean, SET_AT(set) + SET_MEAN);
}

void core_read_prepared(const struct core_access *core, uint32_t number, struct coefficients *set) {
    ASSERT(number <= HEADS_MOST && set->lanes <= LANES_LIMIT);
    for (uint32_t place = 0; place < set->lanes; place++) {
        uint32_t first = SET_AT(number) + place * WORDS_A_LANE * WORD_BYTES;
        uint64_t step = core_read(core, first);
        step |= (uint64_t)(core_read(core, first + WORD_BYTES) & 0xFFFFU) << 32;
        set->lane[place] = (struct lane){
            .phase_offset = core_read(core, first + 2 * WORD_BYTES),
            .amplitude = (int32_t)core_read(core, first + 3 * WORD_BYTES),
            .order = (uint32_t)rint((double)step * 0x1p-48 * set->counts_per_rev),
        };
    }
    uint32_t choice = core_read(core, SET_AT(number) + SET_MEAN + MEAN_CHOICE * WORD_BYTES);
    set->mean = (struct mean_set){
        .heads = core_heads(core), .carrier = choice & 3U, .used = choice >> 4 & 0xFU};
    set->mean.error_offset = (int32_t)core_read(core, SET_AT(number) + SET_OFFSET);
    for (uint32_t head = 0; head < HEADS_MOST && core_mean_word_is_built(core, head); head++) {
        uint32_t at = SET_AT(number) + SET_MEAN + head * WORD_BYTES;
        set->mean.offset[head] = core_read(core, at);
        set->mean.weight[head] = (int32_t)core_read(core, at + MEAN_WEIGHTS * WORD_BYTES);
    }
}

static uint32_t core_read_summed(const struct core_access *core, uint32_t offset) {
    return core_summand(offset, core_read(core, offset));
}

uint32_t core_prepared_sum(const struct core_access *core, uint32_t lanes) {
    uint32_t sum = 0;
    uint32_t sets = core_heads(core);
    ASSERT(lanes <= LANES_LIMIT);
    for (uint32_t set = 0; set <= sets; set++) {
        for (uint32_t place = 0; place < lanes * WORDS_A_LANE; place++) {
            sum += core_read_summed(core, SET_AT(set) + place * WORD_BYTES);
        }
        for (uint32_t place = 0; place < MEAN_WORDS; place++) {
            if (core_mean_word_is_built(core, place)) {
                sum += core_read_summed(core, SET_AT(set) + SET_MEAN + place * WORD_BYTES);
            }
        }
        sum += core_read_summed(core, SET_AT(set) + SET_OFFSET);
    }
    return sum;
}

void core_take_set(const struct core_access *core, uint32_t set) {
    core_write(core, AT(heads_command), COMMAND_TAKE | set << COMMAND_SET);
}

void core_come_back(const struct core_access *core, uint32_t heads) {
    core_write(core, AT(heads_command), heads << COMMAND_COME_BACK);
}
