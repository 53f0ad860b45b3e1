/* SPDX-License-Identifier: Apache-2.0 */

#include "saved.h"

#include <string.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "crc32.h"

enum { MAGIC_WORD, VERSION_WORD, SEQUENCE_WORD, LENGTH_WORD };
enum {
    FROZEN = 1,
    BYPASSED = 2,
    TELEMETRY = 4,
    FOLLOWS = 8,
    SETS = 16,
    HAS_TABLE = 32,
    HAS_REAL = 64,
    SWITCHES = 127
};
enum { SAVED_RANGE_WORDS = 2 };
enum { OF_CALIBRATION = 0, OF_OPERATOR = 1, OF_OPERATOR_UNJUDGED = 2 };
#define ERASED 0xFFFFFFFFU

struct words {
    uint32_t *word;
    uint32_t place;
};

/* Words to read: beyond the end they read as 0, and `place` shows that the end was passed. */
struct source {
    const uint32_t *word;
    uint32_t place;
    uint32_t end;
};

const char *saved_answer_name(enum saved_answer answer) {
    static const char *const names[SAVED_ANSWERS] = {
        [SAVED_READ] = "read",
        [SAVED_EMPTY] = "none",
        [SAVED_DAMAGED] = "damaged",
        [SAVED_OTHER_VERSION] = "other_version",
        [SAVED_OUT_OF_RANGE] = "out_of_range",
        [SAVED_UNREAD] = "unread",
    };
    return (unsigned)answer < SAVED_ANSWERS ? names[answer] : "unknown";
}

static void saved_put(struct words *words, uint32_t word) {
    ASSERT(words->place < SAVED_WORDS_MOST);
    words->word[words->place++] = word;
}

static uint32_t saved_take(struct source *source) {
    uint32_t place = source->place++;
    return place < source->end ? source->word[place] : 0U;
}

static uint32_t saved_crc_of(const uint32_t *words, uint32_t number) {
    uint32_t crc = 0;
    for (uint32_t word = 0; word < number; word++) {
        crc = crc32_add_word(crc, words[word]);
    }
    return crc;
}

static uint32_t saved_name_sum(const char *name) {
    uint32_t crc = 0;
    for (; *name != '\0'; name++) {
        crc = crc32_add_word(crc, (uint32_t)(unsigned char)*name);
    }
    return crc;
}

static void saved_put_parameters(struct words *words, const struct parameters *parameters) {
    saved_put(words, parameters_number());
    for (uint32_t place = 0; place < parameters_number(); place++) {
        double value = parameters_value(parameters, place);
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        saved_put(words, saved_name_sum(parameters_description(place)->name));
        saved_put(words, (uint32_t)bits);
        saved_put(words, (uint32_t)(bits >> 32));
    }
}

/* Writes the used lanes with their owner, calibration or operator. `unjudged`: lanes that no turn has judged, one bit
   per lane. */
static void saved_put_lanes(struct words *words, const struct coefficients *coefficients,
                            uint32_t owner, uint64_t unjudged) {
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        const struct lane *word = &coefficients->lane[lane];
        if (word->order != 0) {
            saved_put(words, word->order);
            saved_put(words, word->phase_offset);
            saved_put(words, (uint32_t)word->amplitude);
            saved_put(words, (unjudged >> lane & 1U) != 0 ? OF_OPERATOR_UNJUDGED : owner);
        }
    }
}

static void saved_put_sets(struct words *words, const struct kept_sets *sets) {
    if (sets->number != 0) {
        saved_put(words, sets->number);
    }
    for (uint32_t word = 0; word < sets->number; word++) {
        saved_put(words, sets->word[word]);
    }
}

static void saved_put_followed(struct words *words, const struct followed *followed) {
    if (followed->lanes == 0) {
        return;
    }
    saved_put(words, followed->lanes);
    saved_put(words, followed->width);
    saved_put(words, followed->dead_zone);
    saved_put(words, followed->nominal_speed);
    for (uint32_t place = 0; place < followed->lanes; place++) {
        const struct followed_lane *lane = &followed->lane[place];
        saved_put(words, lane->modulator);
        saved_put(words, lane->lane.order);
        saved_put(words, lane->lane.phase_offset);
        saved_put(words, (uint32_t)lane->lane.amplitude);
    }
}

/* Writes the lanes of real orders without their phase, because it belongs to the core's count of turns, which restarts
   at power-on. */
static void saved_put_real(struct words *words, const struct followed *followed) {
    if (followed->real_lanes == 0) {
        return;
    }
    saved_put(words, followed->real_lanes);
    for (uint32_t place = 0; place < followed->real_lanes; place++) {
        const struct real_lane *lane = &followed->real[place];
        saved_put(words, lane->order);
        saved_put(words, (uint32_t)lane->turn_step);
        saved_put(words, (uint32_t)(lane->turn_step >> 32));
        saved_put(words, (uint32_t)lane->amplitude);
        saved_put(words, lane->source);
        saved_put(words, (uint32_t)lane->side);
        saved_put(words, lane->probe_phase);
    }
}

static void saved_put_table(struct words *words, const struct load_table *table) {
    if (table->place.choice == 0) {
        return;
    }
    saved_put(words, table->place.choice);
    for (uint32_t window = 0; window < TABLE_WINDOWS; window++) {
        saved_put(words, table->place.start[window]);
    }
    saved_put(words, table->crc);
}

static void saved_put_thermal(struct words *words, const struct thermal *thermal) {
    saved_put(words, thermal->lanes);
    saved_put(words, (uint32_t)thermal->reference_mc);
    saved_put(words, thermal->time_constant_ms);
    for (uint32_t place = 0; place < thermal->lanes; place++) {
        const struct thermal_lane *lane = &thermal->lane[place];
        saved_put(words, lane->order);
        saved_put(words, (uint32_t)lane->cosine);
        saved_put(words, (uint32_t)lane->sine);
        saved_put(words, (uint32_t)lane->cosine_squared);
        saved_put(words, (uint32_t)lane->sine_squared);
    }
    if (thermal->lanes != 0 && !thermal_has_preset_range(thermal)) {
        saved_put(words, (uint32_t)thermal->least_mc);
        saved_put(words, (uint32_t)thermal->most_mc);
    }
}

static void saved_put_mean(struct words *words, const struct mean_set *mean) {
    if (mean->heads == 0) {
        return;
    }
    saved_put(words, mean->heads);
    saved_put(words, mean->carrier);
    saved_put(words, mean->used);
    saved_put(words, (uint32_t)mean->error_offset);
    saved_put(words, mean->delays);
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        saved_put(words, (uint32_t)mean->weight[head]);
        saved_put(words, mean->offset[head]);
    }
}

static uint32_t saved_lanes_used(const struct coefficients *coefficients) {
    ASSERT(coefficients->lanes <= LANES_LIMIT);
    uint32_t number = 0;
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        number += coefficients->lane[lane].order != 0;
    }
    return number;
}

uint32_t saved_lanes(const struct saved *saved) {
    return saved_lanes_used(&saved->own) + saved_lanes_used(&saved->loaded) +
           followed_all_lanes(&saved->followed);
}

uint32_t saved_write(const struct saved *saved, uint32_t sequence, uint32_t *words) {
    const struct settings *settings = &saved->settings;
    struct words to = {words, 0};
    saved_put(&to, SAVED_MAGIC);
    saved_put(&to, SAVED_VERSION);
    saved_put(&to, sequence);
    saved_put(&to, 0);
    saved_put(&to, (settings->frozen ? FROZEN : 0U) | (settings->bypassed ? BYPASSED : 0U) |
                       (settings->telemetry ? TELEMETRY : 0U) |
                       (saved->followed.lanes != 0 ? FOLLOWS : 0U) |
                       (saved->sets.number != 0 ? SETS : 0U) |
                       (saved->table.place.choice != 0 ? HAS_TABLE : 0U) |
                       (saved->followed.real_lanes != 0 ? HAS_REAL : 0U));
    saved_put_parameters(&to, &settings->parameters);
    saved_put(&to, (uint32_t)settings->parameters.counts_per_rev);
    saved_put(&to, saved_lanes_used(&saved->own) + saved_lanes_used(&saved->loaded));
    saved_put_lanes(&to, &saved->own, OF_CALIBRATION, 0);
    saved_put_lanes(&to, &saved->loaded, OF_OPERATOR, saved->unjudged);
    saved_put_sets(&to, &saved->sets);
    saved_put_followed(&to, &saved->followed);
    saved_put_real(&to, &saved->followed);
    saved_put_table(&to, &saved->table);
    saved_put_thermal(&to, &saved->thermal);
    saved_put_mean(&to, &saved->loaded.mean);
    words[LENGTH_WORD] = to.place - SAVED_HEAD_WORDS;
    saved_put(&to, saved_crc_of(words, to.place));
    return to.place;
}

/* Takes one parameter from the record and finds it by the check sum of its name. The search begins at `first`, the
   parameter's place in a record of this firmware, because computing the check sums of all names takes long. */
static void saved_take_parameter(struct source *from, struct parameters *parameters,
                                 uint32_t first) {
    uint32_t sum = saved_take(from);
    uint64_t bits = saved_take(from);
    bits |= (uint64_t)saved_take(from) << 32;
    double value;
    memcpy(&value, &bits, sizeof value);
    for (uint32_t step = 0; step < parameters_number(); step++) {
        const struct parameter_description *description =
            parameters_description((first + step) % parameters_number());
        if (saved_name_sum(description->name) == sum) {
            /* A value out of range is refused later by parameters_are_valid(). */
            *(double *)(void *)((unsigned char *)parameters + description->offset) = value;
            return;
        }
    }
}

static bool saved_take_settings(struct source *from, struct settings *settings,
                                uint32_t *all_switches) {
    uint32_t switches = saved_take(from);
    *all_switches = switches;
    uint32_t number = saved_take(from);
    *settings = (struct settings){
        .frozen = (switches & FROZEN) != 0,
        .bypassed = (switches & BYPASSED) != 0,
        .telemetry = (switches & TELEMETRY) != 0,
    };
    parameters_preset(&settings->parameters);
    if (switches > SWITCHES || number > SAVED_PARAMETERS_MOST) {
        return false;
    }
    for (uint32_t parameter = 0; parameter < number; parameter++) {
        saved_take_parameter(from, &settings->parameters, parameter);
    }
    return parameters_are_valid(&settings->parameters);
}

static bool saved_take_lane(struct source *from, struct saved *saved) {
    struct lane lane = {0};
    lane.order = saved_take(from);
    lane.phase_offset = saved_take(from);
    lane.amplitude = (int32_t)saved_take(from);
    uint32_t owner = saved_take(from);
    if (owner > OF_OPERATOR_UNJUDGED || !coefficients_lane_is_valid(&lane) ||
        coefficients_have(&saved->own, lane.order) ||
        coefficients_have(&saved->loaded, lane.order)) {
        return false;
    }
    struct coefficients *to = owner == OF_CALIBRATION ? &saved->own : &saved->loaded;
    if (owner == OF_OPERATOR_UNJUDGED) {
        saved->unjudged |= 1ULL << to->lanes;
    }
    ASSERT(to->lanes < LANES_LIMIT);
    to->lane[to->lanes++] = lane;
    return true;
}

static bool saved_take_coefficients(struct source *from, struct saved *saved) {
    uint32_t counts_per_rev = saved_take(from);
    uint32_t number = saved_take(from);
    saved->own = (struct coefficients){.counts_per_rev = counts_per_rev};
    saved->loaded = (struct coefficients){.counts_per_rev = counts_per_rev};
    saved->unjudged = 0;
    bool valid =
        counts_per_rev == saved->settings.parameters.counts_per_rev && number <= LANES_LIMIT;
    for (uint32_t lane = 0; valid && lane < number; lane++) {
        valid = saved_take_lane(from, saved);
    }
    return valid;
}

static bool saved_take_sets(struct source *from, struct kept_sets *sets) {
    uint32_t number = saved_take(from);
    bool fits = number > 0 && number <= KEPT_SETS_WORDS;
    while (fits && sets->number < number) {
        sets->word[sets->number++] = saved_take(from);
    }
    return fits;
}

static bool saved_take_followed(struct source *from, struct followed *followed) {
    uint32_t lanes = saved_take(from);
    followed->width = saved_take(from);
    followed->dead_zone = saved_take(from);
    followed->nominal_speed = saved_take(from);
    bool valid = lanes > 0 && lanes <= FOLLOWED_LANES_MAX &&
                 followed_conditions_are_valid(followed->width, followed->dead_zone,
                                               followed->nominal_speed);
    while (valid && followed->lanes < lanes) {
        struct followed_lane lane = {.modulator = saved_take(from)};
        lane.lane.order = saved_take(from);
        lane.lane.phase_offset = saved_take(from);
        lane.lane.amplitude = (int32_t)saved_take(from);
        valid = followed_lane_is_valid(&lane);
        followed->lane[followed->lanes++] = lane;
    }
    return valid;
}

static bool saved_take_real(struct source *from, struct followed *followed) {
    uint32_t lanes = saved_take(from);
    bool valid = lanes > 0 && lanes <= REAL_LANES_MAX;
    while (valid && followed->real_lanes < lanes) {
        struct real_lane lane = {.order = saved_take(from)};
        lane.turn_step = saved_take(from);
        lane.turn_step |= (uint64_t)saved_take(from) << 32;
        lane.amplitude = (int32_t)saved_take(from);
        lane.source = saved_take(from);
        lane.side = (int32_t)saved_take(from);
        lane.probe_phase = saved_take(from);
        valid = real_lane_is_valid(&lane);
        followed->real[followed->real_lanes++] = lane;
    }
    return valid;
}

static bool saved_take_table(struct source *from, struct load_table *table,
                             uint32_t counts_per_rev) {
    table->place.choice = saved_take(from);
    for (uint32_t window = 0; window < TABLE_WINDOWS; window++) {
        table->place.start[window] = saved_take(from);
    }
    table->crc = saved_take(from);
    return load_table_is_valid(&table->place, counts_per_rev);
}

static bool saved_take_thermal(struct source *from, struct saved *saved) {
    struct thermal *thermal = &saved->thermal;
    *thermal = (struct thermal){.lanes = saved_take(from)};
    thermal->reference_mc = (int32_t)saved_take(from);
    thermal->time_constant_ms = saved_take(from);
    thermal_preset_range(thermal);
    if (!thermal_is_valid(thermal)) {
        return false;
    }
    for (uint32_t place = 0; place < thermal->lanes; place++) {
        thermal->lane[place] = (struct thermal_lane){.order = saved_take(from)};
        thermal->lane[place].cosine = (int32_t)saved_take(from);
        thermal->lane[place].sine = (int32_t)saved_take(from);
        thermal->lane[place].cosine_squared = (int32_t)saved_take(from);
        thermal->lane[place].sine_squared = (int32_t)saved_take(from);
    }
    uint32_t left = from->end - from->place;
    if (left == SAVED_RANGE_WORDS || left == SAVED_RANGE_WORDS + SAVED_MEAN_WORDS) {
        thermal->least_mc = (int32_t)saved_take(from);
        thermal->most_mc = (int32_t)saved_take(from);
    }
    return thermal_is_valid(thermal);
}

static bool saved_take_mean(struct source *from, struct saved *saved) {
    struct mean_set *mean = &saved->loaded.mean;
    if (from->end - from->place != SAVED_MEAN_WORDS) {
        return true;
    }
    mean->heads = saved_take(from);
    mean->carrier = saved_take(from);
    mean->used = saved_take(from);
    mean->error_offset = (int32_t)saved_take(from);
    mean->delays = saved_take(from);
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        mean->weight[head] = (int32_t)saved_take(from);
        mean->offset[head] = saved_take(from);
    }
    return mean->delays == saved->settings.parameters.head_delays &&
           mean_set_is_valid(mean, mean->heads, saved->loaded.counts_per_rev);
}

enum saved_answer saved_read(const uint32_t *words, struct saved *saved, uint32_t *sequence) {
    uint32_t length = words[LENGTH_WORD];
    if (words[MAGIC_WORD] == ERASED) {
        return SAVED_EMPTY;
    }
    if (words[MAGIC_WORD] != SAVED_MAGIC || length > SAVED_WORDS_MOST - SAVED_HEAD_WORDS - 1) {
        return SAVED_DAMAGED;
    }
    uint32_t end = SAVED_HEAD_WORDS + length;
    if (saved_crc_of(words, end) != words[end]) {
        return SAVED_DAMAGED;
    }
    *sequence = words[SEQUENCE_WORD];
    if (words[VERSION_WORD] != SAVED_VERSION) {
        return SAVED_OTHER_VERSION;
    }
    struct source from = {words, SAVED_HEAD_WORDS, end};
    uint32_t switches = 0;
    saved->followed = (struct followed){.lanes = 0};
    saved->sets.number = 0;
    saved->table = (struct load_table){.next = 0};
    bool valid =
        saved_take_settings(&from, &saved->settings, &switches) &&
        saved_take_coefficients(&from, saved) &&
        ((switches & SETS) == 0 || saved_take_sets(&from, &saved->sets)) &&
        ((switches & FOLLOWS) == 0 || saved_take_followed(&from, &saved->followed)) &&
        ((switches & HAS_REAL) == 0 || saved_take_real(&from, &saved->followed)) &&
        ((switches & HAS_TABLE) == 0 ||
         saved_take_table(&from, &saved->table, saved->loaded.counts_per_rev)) &&
        saved_take_thermal(&from, saved) && saved_take_mean(&from, saved) &&
        kept_sets_are_valid(&saved->sets, saved->loaded.mean.heads, saved->loaded.counts_per_rev);
    return valid && from.place == end ? SAVED_READ : SAVED_OUT_OF_RANGE;
}
