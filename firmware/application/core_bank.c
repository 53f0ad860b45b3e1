/* SPDX-License-Identifier: Apache-2.0 */

/* Writes the idle coefficient bank, reads it back, and swaps the banks. */

#include <math.h>

#include "assertion.h"
#include "core.h"
#include "core_registers.h"
#include "core_words.h"

/* Value 1 in the format s1.16 of the words that lanes follow. */
#define WORD_ONE ((double)(1 << ARCTRUE_MODULATOR_FRACTION))

static uint32_t core_lane_offset(uint32_t lane, uint32_t word) {
    return AT(coefficients) + (lane * WORDS_A_LANE + word) * WORD_BYTES;
}

static void core_write_lane(const struct core_access *core, uint32_t lane,
                            const uint32_t words[WORDS_A_LANE]) {
    for (uint32_t word = 0; word < WORDS_A_LANE; word++) {
        core_write(core, core_lane_offset(lane, word), words[word]);
    }
}

static bool core_lane_holds(const struct core_access *core, uint32_t lane,
                            const uint32_t words[WORDS_A_LANE]) {
    bool equal = true;
    for (uint32_t word = 0; equal && word < WORDS_A_LANE; word++) {
        equal = core_read(core, core_lane_offset(lane, word)) == words[word];
    }
    return equal;
}

void core_write_coefficients(const struct core_access *core,
                             const struct coefficients *coefficients) {
    ASSERT(coefficients->lanes <= LANES_LIMIT);
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        uint32_t words[WORDS_A_LANE];
        core_lane_words(&coefficients->lane[lane], coefficients->counts_per_rev, MODULATOR_ONE,
                        words);
        core_write_lane(core, lane, words);
    }
    core_write(core, AT(coefficient_offset), (uint32_t)coefficients->mean.error_offset);
    if (FIELD(core_capability(core), CAPABILITY__MEAN) != 0) {
        (void)core_write_mean(core, &coefficients->mean, AT(mean));
    }
}

void core_use_head1(const struct core_access *core) {
    const struct mean_set head1 = {.heads = 0};
    if (FIELD(core_capability(core), CAPABILITY__MEAN) != 0 && (core_left_out(core) & 1U) == 0) {
        (void)core_write_mean(core, &head1, AT(mean));
        core_swap(core);
    }
}

bool core_verify_coefficients(const struct core_access *core,
                              const struct coefficients *coefficients) {
    ASSERT(coefficients->lanes <= LANES_LIMIT);
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        uint32_t words[WORDS_A_LANE];
        core_lane_words(&coefficients->lane[lane], coefficients->counts_per_rev, MODULATOR_ONE,
                        words);
        if (!core_lane_holds(core, lane, words)) {
            return false;
        }
    }
    bool equal =
        core_read(core, AT(coefficient_offset)) == (uint32_t)coefficients->mean.error_offset;
    bool has_mean = FIELD(core_capability(core), CAPABILITY__MEAN) != 0;
    for (uint32_t place = 0; has_mean && place < MEAN_WORDS; place++) {
        equal = equal && (!core_mean_word_is_built(core, place) ||
                          core_read(core, AT(mean) + place * WORD_BYTES) ==
                              core_mean_word(&coefficients->mean, place));
    }
    return equal;
}

void core_write_followed(const struct core_access *core, const struct followed *followed,
                         uint32_t counts_per_rev, uint32_t lanes) {
    ASSERT(followed->lanes <= FOLLOWED_LANES_MAX && followed->lanes <= lanes);
    for (uint32_t place = 0; place < followed->lanes; place++) {
        uint32_t words[WORDS_A_LANE];
        const struct followed_lane *lane = &followed->lane[place];
        core_lane_words(&lane->lane, counts_per_rev, lane->modulator, words);
        core_write_lane(core, lanes - followed->lanes + place, words);
    }
    if (followed->lanes != 0) {
        core_write(core, AT(conditions.width), followed->width);
        core_write(core, AT(conditions.dead_zone), followed->dead_zone);
        core_write(core, AT(conditions.nominal_speed), followed->nominal_speed);
    }
}

bool core_verify_followed(const struct core_access *core, const struct followed *followed,
                          uint32_t counts_per_rev, uint32_t lanes) {
    ASSERT(followed->lanes <= FOLLOWED_LANES_MAX && followed->lanes <= lanes);
    for (uint32_t place = 0; place < followed->lanes; place++) {
        uint32_t words[WORDS_A_LANE];
        const struct followed_lane *lane = &followed->lane[place];
        core_lane_words(&lane->lane, counts_per_rev, lane->modulator, words);
        if (!core_lane_holds(core, lanes - followed->lanes + place, words)) {
            return false;
        }
    }
    return followed->lanes == 0 ||
           (core_read(core, AT(conditions.width)) == followed->width &&
            core_read(core, AT(conditions.dead_zone)) == followed->dead_zone &&
            core_read(core, AT(conditions.nominal_speed)) == followed->nominal_speed);
}

enum { TURN_STEP_WORDS = 2 };

/* Computes the words of a lane of a real order; while its phase is not known, the words switch the lane off. */
static void core_real_words(const struct real_lane *lane, uint32_t counts_per_rev,
                            uint32_t words[WORDS_A_LANE]) {
    uint64_t step = real_lane_phase_step(lane, counts_per_rev);
    words[0] = (uint32_t)step;
    words[1] = (uint32_t)(step >> 32);
    words[2] = lane->phase_known ? lane->phase_offset : 0U;
    words[3] = lane->phase_known ? (uint32_t)lane->amplitude : 0U;
}

static uint32_t core_turn_step_offset(uint32_t lane, uint32_t word) {
    return AT(turn_steps) + (lane * TURN_STEP_WORDS + word) * WORD_BYTES;
}

/* Returns the turn step of a lane; 0 unless the lane has a real order. */
static uint64_t core_turn_step(const struct followed *followed, uint32_t lanes, uint32_t lane) {
    uint32_t first = lanes - followed_all_lanes(followed);
    bool is_real = lane >= first && lane < first + followed->real_lanes;
    return is_real ? followed->real[lane - first].turn_step : 0U;
}

void core_write_real(const struct core_access *core, const struct followed *followed,
                     uint32_t counts_per_rev, uint32_t lanes) {
    ASSERT(followed_all_lanes(followed) <= lanes && lanes <= LANES_LIMIT);
    if (!core_has_real_orders(core)) {
        return;
    }
    uint32_t first = lanes - followed_all_lanes(followed);
    for (uint32_t place = 0; place < followed->real_lanes; place++) {
        uint32_t words[WORDS_A_LANE];
        core_real_words(&followed->real[place], counts_per_rev, words);
        core_write_lane(core, first + place, words);
    }
    for (uint32_t lane = 0; lane < lanes; lane++) {
        uint64_t step = core_turn_step(followed, lanes, lane);
        core_write(core, core_turn_step_offset(lane, 0), (uint32_t)step);
        core_write(core, core_turn_step_offset(lane, 1), (uint32_t)(step >> 32));
    }
}

bool core_verify_real(const struct core_access *core, const struct followed *followed,
                      uint32_t counts_per_rev, uint32_t lanes) {
    ASSERT(followed_all_lanes(followed) <= lanes && lanes <= LANES_LIMIT);
    if (!core_has_real_orders(core)) {
        return followed->real_lanes == 0;
    }
    bool equal = true;
    uint32_t first = lanes - followed_all_lanes(followed);
    for (uint32_t place = 0; place < followed->real_lanes; place++) {
        uint32_t words[WORDS_A_LANE];
        core_real_words(&followed->real[place], counts_per_rev, words);
        equal = equal && core_lane_holds(core, first + place, words);
    }
    for (uint32_t lane = 0; lane < lanes; lane++) {
        uint64_t step = core_turn_step(followed, lanes, lane);
        equal = equal && core_read(core, core_turn_step_offset(lane, 0)) == (uint32_t)step &&
                core_read(core, core_turn_step_offset(lane, 1)) == (uint32_t)(step >> 32);
    }
    return equal;
}

void core_write_table_point(const struct core_access *core, uint32_t number, int32_t point) {
    ASSERT(number < TABLE_POINTS);
    core_write(core, AT(local_points) + number * WORD_BYTES, (uint32_t)point);
}

int32_t core_table_point(const struct core_access *core, uint32_t number) {
    ASSERT(number < TABLE_POINTS);
    return (int32_t)core_read(core, AT(local_points) + number * WORD_BYTES);
}

void core_write_table_place(const struct core_access *core, const struct table_place *place,
                            uint32_t counts_per_rev) {
    /* Windows per count, u0.48: computed like the phase step of an order. */
    const struct real_lane window = {.order = 1U
                                              << FIELD(place->choice, LOCAL_PLACE__CHOICE__WIDTH)};
    uint64_t step = real_lane_phase_step(&window, counts_per_rev);
    for (uint32_t number = 0; number < TABLE_WINDOWS; number++) {
        core_write(core, AT(local_place.start1) + number * WORD_BYTES, place->start[number]);
    }
    core_write(core, AT(local_place.step_low), (uint32_t)step);
    core_write(core, AT(local_place.step_high), (uint32_t)(step >> 32));
    core_write(core, AT(local_place.choice), place->choice);
}

struct table_place core_table_place(const struct core_access *core) {
    struct table_place place = {.choice = core_read(core, AT(local_place.choice))};
    for (uint32_t number = 0; number < TABLE_WINDOWS; number++) {
        place.start[number] = core_read(core, AT(local_place.start1) + number * WORD_BYTES);
    }
    return place;
}

void core_set_word(const struct core_access *core, enum modulator word, double value) {
    ASSERT(word == MODULATOR_WORD_A || word == MODULATOR_WORD_B);
    ASSERT(value >= -1.0 && value <= 1.0);
    uint32_t place = word == MODULATOR_WORD_A ? AT(conditions.word_a) : AT(conditions.word_b);
    core_write(core, place, (uint32_t)(int32_t)rint(value * WORD_ONE));
}

void core_swap(const struct core_access *core) {
    core_write(core, AT(command), BIT(COMMAND__SWAP));
}

uint32_t core_swap_count(const struct core_access *core) {
    return core_read(core, AT(swap_count));
}
