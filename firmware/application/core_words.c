/* SPDX-License-Identifier: Apache-2.0 */

#include "core_words.h"

#include "arctrue_number_formats.h"
#include "core_registers.h"
#include "crc32.h"

enum { MODULATOR_PLACE = 16, USED_SHIFT = 4 };
#define WEIGHT_ONE (1 << ARCTRUE_HEAD_WEIGHT_FRACTION)

void core_lane_words(const struct lane *lane, uint32_t counts_per_rev, uint32_t modulator,
                     uint32_t words[WORDS_A_LANE]) {
    uint64_t step = coefficients_phase_step(lane->order, counts_per_rev);
    words[0] = (uint32_t)step;
    words[1] = (uint32_t)(step >> 32) | modulator << MODULATOR_PLACE;
    words[2] = lane->phase_offset;
    words[3] = (uint32_t)lane->amplitude;
}

uint32_t core_mean_word(const struct mean_set *mean, uint32_t place) {
    if (place == MEAN_CHOICE) {
        return mean->heads != 0 ? mean->carrier | mean->used << USED_SHIFT : 1U << USED_SHIFT;
    }
    if (place < MEAN_WEIGHTS) {
        return mean->offset[place];
    }
    bool alone = mean->heads == 0 && place == MEAN_WEIGHTS;
    return alone ? (uint32_t)WEIGHT_ONE : (uint32_t)mean->weight[place - MEAN_WEIGHTS];
}

bool core_mean_word_is_built(const struct core_access *core, uint32_t place) {
    return place == MEAN_CHOICE ||
           place % MEAN_WEIGHTS < FIELD(core_capability(core), CAPABILITY__HEADS);
}

uint32_t core_summand(uint32_t offset, uint32_t word) {
    return word != 0 ? crc32_add_word(offset, word) : 0U;
}

uint32_t core_write_summed(const struct core_access *core, uint32_t offset, uint32_t word) {
    core_write(core, offset, word);
    return core_summand(offset, word);
}

uint32_t core_write_mean(const struct core_access *core, const struct mean_set *mean,
                         uint32_t first) {
    uint32_t sum = 0;
    for (uint32_t place = 0; place < MEAN_WORDS; place++) {
        if (core_mean_word_is_built(core, place)) {
            sum += core_write_summed(core, first + place * WORD_BYTES, core_mean_word(mean, place));
        }
    }
    return sum;
}
