/* SPDX-License-Identifier: Apache-2.0 */

#include "load.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "arctrue_number_formats.h"
#include "crc32.h"
#include "units.h"

#define AMPLITUDE_STEPS ((double)(1 << ARCTRUE_AMPLITUDE_FRACTION))
#define STEP_MASK ((1ULL << ARCTRUE_PHASE_STEP_WIDTH) - 1)
#define STEP_TURNS (1.0 / (double)(1ULL << ARCTRUE_PHASE_STEP_WIDTH))
/* Standard deviations of a variance of as many samples. */
#define NOISE_DEVIATIONS 3.0

const char *load_state_name(enum load_state state) {
    static const char *const names[] = {"none", "receiving", "waiting", "active", "refused"};
    return (unsigned)state <= LOAD_REFUSED ? names[state] : "unknown";
}

const char *load_answer_name(enum load_answer answer) {
    static const char *const names[LOAD_ANSWERS] = {
        [LOAD_TAKEN] = "taken",
        [LOAD_WRONG_CRC] = "wrong_crc",
        [LOAD_WRONG_FRAME] = "wrong_frame",
        [LOAD_TOO_MANY_LANES] = "too_many_lanes",
        [LOAD_OUT_OF_RANGE] = "out_of_range",
        [LOAD_ORDER_TWICE] = "order_twice",
        [LOAD_NOT_WHOLE] = "not_whole",
        [LOAD_ANOTHER_TABLE] = "another_table",
        [LOAD_TOO_STEEP] = "too_steep",
        [LOAD_WORSE] = "worse_prediction",
        [LOAD_NOT_READ_BACK] = "not_read_back",
    };
    return (unsigned)answer < LOAD_ANSWERS ? names[answer] : "unknown";
}

static uint32_t crc_of(uint32_t crc, const uint32_t *words, uint32_t number) {
    for (uint32_t word = 0; word < number; word++) {
        crc = crc32_add_word(crc, words[word]);
    }
    return crc;
}

static bool is_loaded(const struct load *load) {
    return coefficients_most_order(&load->loaded) > 0;
}

void load_refuse(struct load *load, enum load_answer reason) {
    load->state = LOAD_REFUSED;
    load->reason = reason;
}

static enum load_answer refused(struct load *load, enum load_answer reason) {
    load_refuse(load, reason);
    return reason;
}

void load_abort(struct load *load) {
    load->state = is_loaded(load) ? LOAD_ACTIVE : LOAD_NONE;
}

void load_take_over(struct load *load, const struct coefficients *set,
                    const struct thermal *thermal) {
    load->loaded = *set;
    load->thermal = *thermal;
    load->state = is_loaded(load) ? LOAD_ACTIVE : LOAD_NONE;
}

void load_forget(struct load *load) {
    memset(load, 0, sizeof *load);
}

void load_again(struct load *load, uint32_t counts_per_rev) {
    if (load->state == LOAD_RECEIVING || load->state == LOAD_WAITING || !is_loaded(load)) {
        return;
    }
    load->received = load->loaded;
    load->received_thermal = load->thermal;
    load->loaded = (struct coefficients){0};
    load->thermal = (struct thermal){0};
    if (load->received.counts_per_rev == counts_per_rev) {
        load->state = LOAD_WAITING;
    } else {
        load_refuse(load, LOAD_ANOTHER_TABLE);
    }
}

enum load_answer load_begin(struct load *load, uint32_t frames, uint32_t counts_per_rev,
                            uint32_t lanes, uint32_t crc) {
    const uint32_t words[] = {frames, counts_per_rev};
    if (crc_of(0, words, 2) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (frames > lanes || frames > LANES_LIMIT) {
        return refused(load, LOAD_TOO_MANY_LANES);
    }
    load->state = LOAD_RECEIVING;
    load->frames = frames;
    load->next = 0;
    load->crc = crc_of(0, words, 2);
    load->received = (struct coefficients){.lanes = lanes, .counts_per_rev = counts_per_rev};
    load->received_thermal = (struct thermal){0};
    return LOAD_TAKEN;
}

enum load_answer load_lane(struct load *load, uint32_t number, uint32_t order,
                           uint32_t phase_offset, int32_t amplitude, uint32_t crc) {
    const uint32_t words[] = {number, order, phase_offset, (uint32_t)amplitude};
    if (crc_of(0, words, 4) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || number != load->next || number >= load->frames) {
        return LOAD_WRONG_FRAME;
    }
    struct lane lane = {0, phase_offset, amplitude, order};
    if (!coefficients_lane_is_valid(&lane)) {
        return refused(load, LOAD_OUT_OF_RANGE);
    }
    if (coefficients_have(&load->received, order)) {
        return refused(load, LOAD_ORDER_TWICE);
    }
    lane.phase_step = coefficients_phase_step(order, load->received.counts_per_rev);
    load->received.lane[load->next++] = lane;
    load->crc = crc_of(load->crc, words, 4);
    return LOAD_TAKEN;
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
    if (crc_of(0, words, 6) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || number != thermal->lanes) {
        return LOAD_WRONG_FRAME;
    }
    if (number >= THERMAL_LANES_MAX || !coefficients_have(&load->received, lane->order)) {
        return refused(load, LOAD_OUT_OF_RANGE);
    }
    thermal->lane[thermal->lanes++] = *lane;
    load->crc = crc_of(load->crc, words, 6);
    return LOAD_TAKEN;
}

enum load_answer load_temperature(struct load *load, int32_t reference_mc,
                                  uint32_t time_constant_ms, uint32_t crc) {
    const uint32_t words[] = {(uint32_t)reference_mc, time_constant_ms};
    if (crc_of(0, words, 2) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING) {
        return LOAD_WRONG_FRAME;
    }
    load->received_thermal.reference_mc = reference_mc;
    load->received_thermal.time_constant_ms = time_constant_ms;
    if (!thermal_is_valid(&load->received_thermal)) {
        return refused(load, LOAD_OUT_OF_RANGE);
    }
    load->crc = crc_of(load->crc, words, 2);
    return LOAD_TAKEN;
}

/* |d eps / d R| at most: 1 and the corrected angle would no longer rise with the angle. */
static double steepest(const struct coefficients *coefficients) {
    double slope = 0.0;
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        const struct lane *word = &coefficients->lane[lane];
        slope += word->order * fabs((double)word->amplitude) / AMPLITUDE_STEPS;
    }
    return slope * 2.0 * PI / coefficients->counts_per_rev;
}

enum load_answer load_end(struct load *load, uint32_t counts_per_rev,
                          const struct coefficients *active, uint32_t crc) {
    struct coefficients own;
    struct coefficients all;
    if (load->state != LOAD_RECEIVING) {
        return LOAD_WRONG_FRAME;
    }
    if (load->crc != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->next != load->frames) {
        return refused(load, LOAD_NOT_WHOLE);
    }
    if (load->received.counts_per_rev != counts_per_rev) {
        return refused(load, LOAD_ANOTHER_TABLE);
    }
    load_own_lanes(load, active, &own);
    load_combine(&load->received, NULL, 0.0, &own, load->received.lanes, &all);
    if (steepest(&all) >= 1.0) {
        return refused(load, LOAD_TOO_STEEP);
    }
    load->state = LOAD_WAITING;
    return LOAD_TAKEN;
}

void load_own_lanes(const struct load *load, const struct coefficients *active,
                    struct coefficients *own) {
    *own = (struct coefficients){0};
    for (uint32_t lane = 0; active != NULL && lane < active->lanes; lane++) {
        if (!coefficients_have(&load->loaded, active->lane[lane].order)) {
            own->lane[own->lanes++] = active->lane[lane];
        }
    }
}

void load_combine(const struct coefficients *set, const struct thermal *thermal, double celsius,
                  const struct coefficients *own, uint32_t lanes, struct coefficients *candidate) {
    uint32_t used = 0;
    *candidate =
        (struct coefficients){.lanes = lanes, .counts_per_rev = set->counts_per_rev};
    for (uint32_t lane = 0; lane < set->lanes && used < lanes; lane++) {
        if (set->lane[lane].order != 0) {
            candidate->lane[used++] = thermal_lane_at(thermal, &set->lane[lane], celsius);
        }
    }
    for (uint32_t lane = 0; lane < own->lanes && used < lanes; lane++) {
        uint32_t order = own->lane[lane].order;
        if (order != 0 && !coefficients_have(set, order)) {
            candidate->lane[used++] = own->lane[lane];
        }
    }
}

/* Counts at a reading, with the gateware's own phase: K R + Phi modulo a turn. */
static double error_counts(const struct coefficients *coefficients, int32_t angle) {
    double sum = 0.0;
    for (uint32_t lane = 0; coefficients != NULL && lane < coefficients->lanes; lane++) {
        const struct lane *word = &coefficients->lane[lane];
        uint64_t offset = (uint64_t)word->phase_offset
                          << (ARCTRUE_PHASE_STEP_WIDTH - ARCTRUE_PHASE_WIDTH);
        uint64_t phase = (word->phase_step * (uint32_t)angle + offset) & STEP_MASK;
        if (word->amplitude != 0) {
            sum += word->amplitude * cos(2.0 * PI * STEP_TURNS * (double)phase);
        }
    }
    return sum / AMPLITUDE_STEPS;
}

struct spread {
    double sum;
    double squares;
};

static void add(struct spread *spread, double value) {
    spread->sum += value;
    spread->squares += value * value;
}

static double variance(const struct spread *spread, uint32_t samples) {
    double mean = spread->sum / samples;
    return fmax(spread->squares / samples - mean * mean, 0.0);
}

/* What is left of the variance of head 2 less head 1, of what there is now. */
static double share_left(const struct turn *turn, const struct coefficients *active,
                         const struct coefficients *candidate) {
    struct spread now = {0.0, 0.0};
    struct spread of_disc = {0.0, 0.0};
    struct spread of_head1 = {0.0, 0.0};
    int32_t first = turn_reading(turn, 0).difference;
    for (uint32_t sample = 0; sample < turn->samples; sample++) {
        struct reading reading = turn_reading(turn, sample);
        double difference = counts_apart(reading.difference, first);
        double active1 = error_counts(active, reading.angle1);
        double active2 = error_counts(active, reading.angle2);
        double candidate1 = error_counts(candidate, reading.angle1);
        double candidate2 = error_counts(candidate, reading.angle2);
        add(&now, difference - active2 + active1);
        add(&of_disc, difference - candidate2 + candidate1);
        add(&of_head1, difference - active2 + candidate1);
    }
    double least = fmin(variance(&of_disc, turn->samples), variance(&of_head1, turn->samples));
    double all = variance(&now, turn->samples);
    return all > 0.0 ? least / all : 1.0;
}

static double by_noise(const struct turn *turn) {
    return NOISE_DEVIATIONS * sqrt(2.0 / turn->samples);
}

bool load_is_no_worse(const struct turn *turn, const struct coefficients *active,
                      const struct coefficients *candidate) {
    return share_left(turn, active, candidate) <= 1.0 + by_noise(turn);
}

bool load_is_better(const struct turn *turn, const struct coefficients *active,
                    const struct coefficients *candidate) {
    return share_left(turn, active, candidate) < 1.0 - by_noise(turn);
}
