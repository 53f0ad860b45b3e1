/* SPDX-License-Identifier: Apache-2.0 */

#include "load.h"

#include <stddef.h>
#include <string.h>

#include "assertion.h"
#include "crc32.h"
#include "units.h"

/* Upper limit of the slope of the lanes that follow the direction, while their factor changes after a reversal. Below
   this limit, the corrected angle moves in the direction of the table. */
#define STEEPEST_REVERSAL 0.5
/* Limit of an amplitude in counts: magnitude of the most negative word. */
#define AMPLITUDE_LIMIT ((double)(1 << (ARCTRUE_AMPLITUDE_WIDTH - 1 - ARCTRUE_AMPLITUDE_FRACTION)))
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
        [LOAD_UNSEEN] = "unseen_order",
        [LOAD_NO_MODULATORS] = "no_modulators",
        [LOAD_UNSTABLE_SPEED] = "unstable_speed",
        [LOAD_NO_REAL_ORDERS] = "no_real_orders",
        [LOAD_TOO_FEW_COUNTS] = "too_few_counts",
        [LOAD_NO_LOCAL_TABLE] = "no_local_table",
        [LOAD_OTHER_HEADS] = "other_heads",
        [LOAD_OTHER_DELAYS] = "other_delays",
        [LOAD_NO_FAILOVER] = "no_failover",
        [LOAD_HEAD_LEFT_OUT] = "head_left_out",
    };
    return (unsigned)answer < LOAD_ANSWERS ? names[answer] : "unknown";
}

static uint32_t load_crc_of(uint32_t crc, const uint32_t *words, uint32_t number) {
    for (uint32_t word = 0; word < number; word++) {
        crc = crc32_add_word(crc, words[word]);
    }
    return crc;
}

static bool load_has_loaded(const struct load *load) {
    return coefficients_most_order(&load->loaded) > 0 || load->loaded.mean.heads != 0 ||
           load->table.place.choice != 0 || followed_all_lanes(&load->followed) > 0;
}

void load_refuse(struct load *load, enum load_answer reason) {
    load->state = LOAD_REFUSED;
    load->reason = reason;
    load->whole = false;
}

static enum load_answer load_frame_refused(struct load *load, enum load_answer reason) {
    load_refuse(load, reason);
    return reason;
}

/* Sets the state that follows from the loaded set while no set is being received and no received set waits. */
static void load_settle(struct load *load) {
    load->whole = false;
    if (load->loaded_state == LOADED_PENDING) {
        load->state = LOAD_WAITING;
    } else {
        load->state = load_at_work(load) != NULL ? LOAD_ACTIVE : LOAD_NONE;
    }
}

void load_assert(const struct load *load) {
    ASSERT((unsigned)load->state <= LOAD_REFUSED);
    ASSERT((unsigned)load->loaded_state <= LOADED_REJECTED);
    ASSERT(load->received.lanes <= LANES_LIMIT && load->loaded.lanes <= LANES_LIMIT);
    ASSERT(load->received_thermal.lanes <= THERMAL_LANES_MAX);
    ASSERT(load->thermal.lanes <= THERMAL_LANES_MAX);
    ASSERT(!load->whole || load->state == LOAD_WAITING);
}

void load_abort(struct load *load) {
    load_settle(load);
}

const struct coefficients *load_at_work(const struct load *load) {
    return load->loaded_state == LOADED_AT_WORK && load_has_loaded(load) ? &load->loaded : NULL;
}

/* Marks the phases of real orders as unknown: they are unknown in a new set and after a start of the core, because the
   core then restarts its count of turns. */
static void load_seek_phases(struct load *load) {
    memset(load->finder, 0, sizeof load->finder);
    load->probe_seen = false;
    for (uint32_t place = 0; place < load->followed.real_lanes; place++) {
        load->followed.real[place].phase_known = false;
    }
}

/* Makes a saved or received set the loaded set; a reception in progress continues. */
void load_take_over(struct load *load, const struct coefficients *set,
                    const struct thermal *thermal, const struct followed *followed,
                    const struct load_table *table, uint64_t unjudged) {
    ASSERT(followed->lanes <= FOLLOWED_LANES_MAX);
    ASSERT(set->lanes <= LANES_LIMIT && thermal->lanes <= THERMAL_LANES_MAX);
    load->loaded = *set;
    load->thermal = *thermal;
    load->unjudged = unjudged;
    load->followed = *followed;
    load->table = *table;
    load_seek_phases(load);
    load->loaded_crc = 0;
    load_at_work_again(load);
}

void load_take_over_received(struct load *load) {
    uint32_t crc = load->crc;
    load->whole = false;
    load_take_over(load, &load->received, &load->received_thermal, &load->received_followed,
                   &load->received_table, load->received_unjudged);
    load->loaded_crc = crc;
    load_settle(load);
}

void load_at_work_again(struct load *load) {
    load->loaded_state = LOADED_AT_WORK;
    load->watch = (struct loaded_watch){.shown = 0};
    if (load->state != LOAD_RECEIVING && !load->whole) {
        load_settle(load);
    }
}

void load_reject(struct load *load, enum load_answer reason) {
    load->loaded_state = LOADED_REJECTED;
    if (load->state != LOAD_RECEIVING && !load->whole) {
        load_refuse(load, reason);
    }
}

void load_forget(struct load *load) {
    memset(load, 0, sizeof *load);
}

static void load_begin_evidence(struct load *load) {
    memset(load->evidence, 0, sizeof load->evidence);
    load->table_evidence = 0.0;
    load->shown = 0;
    load->shown_twice = 0;
    load->undecided = 0;
    load->refused_order = 0;
}

void load_again(struct load *load, uint32_t counts_per_rev) {
    load_begin_evidence(load);
    if (!load_has_loaded(load)) {
        return;
    }
    load_seek_phases(load);
    if (load->loaded.counts_per_rev == counts_per_rev) {
        load->loaded_state = LOADED_PENDING;
        if (load->state != LOAD_RECEIVING && !load->whole) {
            load_settle(load);
        }
    } else {
        load_reject(load, LOAD_ANOTHER_TABLE);
    }
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
    load->crc = load_crc_of(0, words, 2);
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
    if (load_crc_of(0, words, 4) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || number != load->next || number >= load->frames) {
        return LOAD_WRONG_FRAME;
    }
    const struct lane lane = {phase_offset, amplitude, order};
    if (!coefficients_lane_is_valid(&lane)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    if (coefficients_have(&load->received, order)) {
        return load_frame_refused(load, LOAD_ORDER_TWICE);
    }
    load->received.lane[load->next++] = lane;
    load->crc = load_crc_of(load->crc, words, 4);
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
    if (load_crc_of(0, words, 6) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || number != thermal->lanes) {
        return LOAD_WRONG_FRAME;
    }
    if (number >= THERMAL_LANES_MAX || !coefficients_have(&load->received, lane->order)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    thermal->lane[thermal->lanes++] = *lane;
    load->crc = load_crc_of(load->crc, words, 6);
    return LOAD_TAKEN;
}

enum load_answer load_temperature(struct load *load, int32_t reference_mc,
                                  uint32_t time_constant_ms, uint32_t crc) {
    const uint32_t words[] = {(uint32_t)reference_mc, time_constant_ms};
    if (load_crc_of(0, words, 2) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING) {
        return LOAD_WRONG_FRAME;
    }
    load->received_thermal.reference_mc = reference_mc;
    load->received_thermal.time_constant_ms = time_constant_ms;
    thermal_preset_range(&load->received_thermal);
    if (!thermal_is_valid(&load->received_thermal)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    load->crc = load_crc_of(load->crc, words, 2);
    return LOAD_TAKEN;
}

enum load_answer load_range(struct load *load, int32_t least_mc, int32_t most_mc, uint32_t crc) {
    const uint32_t words[] = {(uint32_t)least_mc, (uint32_t)most_mc};
    if (load_crc_of(0, words, 2) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING) {
        return LOAD_WRONG_FRAME;
    }
    load->received_thermal.least_mc = least_mc;
    load->received_thermal.most_mc = most_mc;
    if (!thermal_is_valid(&load->received_thermal)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    load->crc = load_crc_of(load->crc, words, 2);
    return LOAD_TAKEN;
}

enum load_answer load_followed(struct load *load, uint32_t number, const struct followed_lane *lane,
                               uint32_t crc) {
    const uint32_t words[] = {number, lane->modulator, lane->lane.order, lane->lane.phase_offset,
                              (uint32_t)lane->lane.amplitude};
    struct followed *followed = &load->received_followed;
    if (load_crc_of(0, words, 5) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || number != followed->lanes) {
        return LOAD_WRONG_FRAME;
    }
    if (number >= FOLLOWED_LANES_MAX) {
        return load_frame_refused(load, LOAD_TOO_MANY_LANES);
    }
    if (!followed_lane_is_valid(lane)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    followed->lane[followed->lanes++] = *lane;
    load->crc = load_crc_of(load->crc, words, 5);
    return LOAD_TAKEN;
}

enum load_answer load_real(struct load *load, uint32_t number, const struct real_lane *lane,
                           uint32_t crc) {
    const uint32_t words[] = {number, lane->order, (uint32_t)lane->turn_step,
                              (uint32_t)(lane->turn_step >> 32), (uint32_t)lane->amplitude};
    struct followed *followed = &load->received_followed;
    if (load_crc_of(0, words, 5) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || number != followed->real_lanes) {
        return LOAD_WRONG_FRAME;
    }
    if (number >= REAL_LANES_MAX) {
        return load_frame_refused(load, LOAD_TOO_MANY_LANES);
    }
    if (!real_lane_is_valid(lane)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    followed->real[followed->real_lanes++] = *lane;
    load->crc = load_crc_of(load->crc, words, 5);
    return LOAD_TAKEN;
}

enum load_answer load_phase_source(struct load *load, uint32_t number, const struct real_lane *lane,
                                   uint32_t crc) {
    const uint32_t words[] = {number, lane->source, (uint32_t)lane->side, lane->probe_phase};
    struct followed *followed = &load->received_followed;
    if (load_crc_of(0, words, 4) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || number >= followed->real_lanes) {
        return LOAD_WRONG_FRAME;
    }
    struct real_lane *real = &followed->real[number];
    real->source = lane->source;
    real->side = lane->side;
    real->probe_phase = lane->probe_phase;
    if (!real_lane_is_valid(real)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    load->crc = load_crc_of(load->crc, words, 4);
    return LOAD_TAKEN;
}

bool load_phase(struct load *load, uint32_t number, uint32_t phase, int32_t turn) {
    if (load_at_work(load) == NULL || number >= load->followed.real_lanes) {
        return false;
    }
    real_lane_set_phase(&load->followed.real[number], phase, turn);
    load->phase_given = true;
    return true;
}

enum load_answer load_conditions(struct load *load, uint32_t width, uint32_t dead_zone,
                                 uint32_t nominal_speed, uint32_t crc) {
    const uint32_t words[] = {width, dead_zone, nominal_speed};
    if (load_crc_of(0, words, 3) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING) {
        return LOAD_WRONG_FRAME;
    }
    if (!followed_conditions_are_valid(width, dead_zone, nominal_speed)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    load->received_followed.width = width;
    load->received_followed.dead_zone = dead_zone;
    load->received_followed.nominal_speed = nominal_speed;
    load->crc = load_crc_of(load->crc, words, 3);
    return LOAD_TAKEN;
}

enum { TABLE_WINDOWS_SHIFT = 4, TABLE_WIDTH_SHIFT = 8, TABLE_FRACTION_SHIFT = 12 };
enum {
    TABLE_WIDTH_MOST = 6,
    TABLE_CHOICE_BITS = 0x373F,
    POINT_MOST = 1 << (ARCTRUE_LOCAL_POINT_WIDTH - 1)
};

uint32_t load_table_windows(const struct table_place *place) {
    return 1U << (place->choice >> TABLE_WINDOWS_SHIFT & 3U);
}

uint32_t load_table_width(const struct table_place *place) {
    return place->choice >> TABLE_WIDTH_SHIFT & 7U;
}

double load_table_unit(const struct table_place *place) {
    return 1.0 / (double)(16U << 2U * (place->choice >> TABLE_FRACTION_SHIFT & 3U));
}

/* Tells whether two windows overlap or touch. A window that begins like an earlier one only fills up the number of
   windows; it never gives the value. */
static bool load_windows_overlap(const struct table_place *place, uint32_t windows,
                                 uint32_t counts_per_rev) {
    bool overlap = false;
    for (uint32_t pair = 0; pair < windows * windows; pair++) {
        uint32_t from = place->start[pair / windows];
        uint32_t to = place->start[pair % windows];
        uint32_t away = to >= from ? to - from : to + counts_per_rev - from;
        overlap = overlap ||
                  (away != 0 && (uint64_t)(away - 1) << load_table_width(place) < counts_per_rev);
    }
    return overlap;
}

bool load_table_is_valid(const struct table_place *place, uint32_t counts_per_rev) {
    uint32_t windows = load_table_windows(place);
    bool fits = (place->choice & ~(uint32_t)TABLE_CHOICE_BITS) == 0 && windows <= TABLE_WINDOWS &&
                (place->choice & 0xFU) == (1U << windows) - 1U &&
                load_table_width(place) <= TABLE_WIDTH_MOST;
    for (uint32_t window = 0; window < TABLE_WINDOWS; window++) {
        fits = fits && place->start[window] < counts_per_rev;
    }
    return fits && !load_windows_overlap(place, windows, counts_per_rev);
}

enum load_answer load_table(struct load *load, const struct table_place *place, uint32_t crc) {
    const uint32_t words[] = {place->choice, place->start[0], place->start[1], place->start[2],
                              place->start[3]};
    if (load_crc_of(0, words, 5) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || load->received_table.place.choice != 0) {
        return LOAD_WRONG_FRAME;
    }
    if (!load_table_is_valid(place, load->received.counts_per_rev)) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    load->received_table = (struct load_table){.place = *place};
    load->crc = load_crc_of(load->crc, words, 5);
    return LOAD_TAKEN;
}

static uint32_t load_step(int32_t one, int32_t other) {
    return (uint32_t)(one > other ? one - other : other - one);
}

/* Adds a point of the local table to its CRC, and updates the largest step between neighbouring points. The last point
   of a window is a neighbour of the window's first point, because the table interpolates between them. */
static void load_add_point(struct load_table *table, int32_t point) {
    uint32_t each = TABLE_POINTS / load_table_windows(&table->place);
    uint32_t in_window = table->next % each;
    uint32_t rise = in_window != 0 ? load_step(point, table->previous) : 0;
    if (in_window == 0) {
        uint32_t leap = load_step(point, 0);
        table->first = point;
        table->leap = leap > table->leap ? leap : table->leap;
    } else if (in_window == each - 1) {
        uint32_t around = load_step(point, table->first);
        rise = around > rise ? around : rise;
    }
    table->rise = rise > table->rise ? rise : table->rise;
    table->previous = point;
    table->next++;
    table->crc = crc32_add_word(table->crc, (uint32_t)point);
}

enum load_answer load_points(struct load *load, uint32_t number, const int32_t points[LOAD_POINTS],
                             uint32_t crc) {
    uint32_t words[LOAD_POINTS + 1] = {number};
    struct load_table *table = &load->received_table;
    for (uint32_t place = 0; place < LOAD_POINTS; place++) {
        words[place + 1] = (uint32_t)points[place];
    }
    if (load_crc_of(0, words, LOAD_POINTS + 1) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || table->place.choice == 0 || number != table->next ||
        number >= TABLE_POINTS) {
        return LOAD_WRONG_FRAME;
    }
    for (uint32_t place = 0; place < LOAD_POINTS; place++) {
        bool beyond = table->next == TABLE_POINTS;
        if (points[place] < -POINT_MOST || points[place] >= POINT_MOST ||
            (beyond && points[place] != 0)) {
            return load_frame_refused(load, LOAD_OUT_OF_RANGE);
        }
        if (!beyond) {
            load_add_point(table, points[place]);
        }
    }
    load->crc = load_crc_of(load->crc, words, LOAD_POINTS + 1);
    return LOAD_TAKEN;
}

/* Returns an upper bound of the table's |d eps / d R|. A window shorter than a turn begins with a step from 0 to its
   first point, which counts as a slope over one count, and ends with a step to 0 from a value that is at most one
   count's slope away from the first point. The points that did not arrive are 0. */
static double load_table_steepest(const struct load_table *received, uint32_t counts_per_rev) {
    struct load_table table = *received;
    if (table.place.choice == 0) {
        return 0.0;
    }
    while (table.next < TABLE_POINTS) {
        load_add_point(&table, 0);
    }
    double points = TABLE_POINTS / load_table_windows(&table.place);
    uint32_t width = load_table_width(&table.place);
    double between = counts_per_rev / ((double)(1U << width) * points);
    double rise = table.rise / between;
    double leap = width != 0 ? table.leap : 0.0;
    return (rise + leap) * load_table_unit(&table.place);
}

enum load_answer load_mean(struct load *load, const struct mean_set *mean, uint32_t crc) {
    const uint32_t words[] = {mean->carrier, mean->used, (uint32_t)mean->error_offset,
                              mean->delays};
    if (load_crc_of(0, words, 4) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING) {
        return LOAD_WRONG_FRAME;
    }
    load->received.mean = *mean;
    load->crc = load_crc_of(load->crc, words, 4);
    return LOAD_TAKEN;
}

enum load_answer load_head(struct load *load, uint32_t number, int32_t weight, uint32_t offset,
                           uint32_t crc) {
    const uint32_t words[] = {number, (uint32_t)weight, offset};
    struct mean_set *mean = &load->received.mean;
    if (load_crc_of(0, words, 3) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || number != mean->heads || number >= HEADS_MOST) {
        return LOAD_WRONG_FRAME;
    }
    mean->weight[number] = weight;
    mean->offset[number] = offset;
    mean->heads++;
    load->crc = load_crc_of(load->crc, words, 3);
    return LOAD_TAKEN;
}

/* Tells whether all lanes and heads of the prepared set that is being received have arrived, or no such set is being
   received. A prepared set applies if one head is left out. */
static bool load_without_is_whole(const struct load *load) {
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
    if (load_crc_of(0, words, 5) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || !load_without_is_whole(load)) {
        return LOAD_WRONG_FRAME;
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
    load->crc = load_crc_of(load->crc, words, 5);
    return LOAD_TAKEN;
}

enum load_answer load_without_head(struct load *load, uint32_t number, int32_t weight,
                                   uint32_t offset, uint32_t crc) {
    const uint32_t words[] = {number, (uint32_t)weight, offset};
    struct load_without *set = &load->without;
    if (load_crc_of(0, words, 3) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || load_without_is_whole(load) || number != set->mean.heads ||
        number >= load->received.mean.heads) {
        return LOAD_WRONG_FRAME;
    }
    set->mean.weight[number] = weight;
    set->mean.offset[number] = offset;
    set->mean.heads++;
    load->crc = load_crc_of(load->crc, words, 3);
    return load_close_without(load);
}

enum load_answer load_without_lane(struct load *load, uint32_t number, const struct lane *lane,
                                   uint32_t crc) {
    const uint32_t words[] = {number, lane->order, lane->phase_offset, (uint32_t)lane->amplitude};
    struct load_without *set = &load->without;
    if (load_crc_of(0, words, 4) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING || load_without_is_whole(load) || number != set->next_lane ||
        number >= set->lanes) {
        return LOAD_WRONG_FRAME;
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
    load->crc = load_crc_of(load->crc, words, 4);
    return load_close_without(load);
}

bool load_takes_unseen(const struct load *load) {
    return load->forced || load->unseen_taken;
}

enum load_answer load_force(struct load *load, uint32_t scope, uint32_t crc) {
    const uint32_t words[] = {scope};
    if (load_crc_of(0, words, 1) != crc) {
        return LOAD_WRONG_CRC;
    }
    if (load->state != LOAD_RECEIVING) {
        return LOAD_WRONG_FRAME;
    }
    if (scope != LOAD_FORCES_ALL && scope != LOAD_FORCES_UNSEEN) {
        return load_frame_refused(load, LOAD_OUT_OF_RANGE);
    }
    load->forced = load->forced || scope == LOAD_FORCES_ALL;
    load->unseen_taken = load->unseen_taken || scope == LOAD_FORCES_UNSEEN;
    load->crc = load_crc_of(load->crc, words, 1);
    return LOAD_TAKEN;
}

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

bool load_waits_for(const struct load *load, bool other_direction) {
    const struct followed *followed = &load->received_followed;
    if (!load->whole || load->forced) {
        return false;
    }
    for (uint32_t place = 0; place < followed->lanes; place++) {
        bool direction = followed->lane[place].modulator == MODULATOR_DIRECTION;
        bool once = (load->shown & ~load->shown_twice) >> place & 1U;
        if (once && direction == other_direction) {
            return true;
        }
    }
    return false;
}

struct followed load_followed_at_work(const struct load *load) {
    return load_at_work(load) != NULL ? load->followed : (struct followed){.lanes = 0};
}

void load_own_lanes(const struct load *load, const struct coefficients *active,
                    struct coefficients *own) {
    ASSERT(active == NULL || active->lanes <= LANES_LIMIT);
    *own = (struct coefficients){.counts_per_rev = active != NULL ? active->counts_per_rev : 0};
    for (uint32_t lane = 0; active != NULL && lane < active->lanes; lane++) {
        if (!coefficients_have(load_at_work(load), active->lane[lane].order)) {
            own->lane[own->lanes++] = active->lane[lane];
        }
    }
}

void load_combine(const struct coefficients *set, const struct thermal *thermal, double celsius,
                  const struct coefficients *own, uint32_t lanes, struct coefficients *candidate) {
    uint32_t used = 0;
    uint32_t of_set = set != NULL ? set->lanes : 0;
    uint32_t of_own = own != NULL ? own->lanes : 0;
    const struct coefficients *either = set != NULL ? set : own;
    ASSERT(lanes <= LANES_LIMIT && of_set <= LANES_LIMIT && of_own <= LANES_LIMIT);
    ASSERT(candidate != set && candidate != own);
    *candidate = (struct coefficients){
        .lanes = lanes,
        .counts_per_rev = either != NULL ? either->counts_per_rev : 0,
    };
    if (set != NULL && set->mean.heads != 0) {
        /* The calibration's own lanes correct head 1, not a mean, so the core uses none of these lanes. */
        candidate->mean = set->mean;
        of_own = 0;
    }
    for (uint32_t lane = 0; lane < of_set && used < lanes; lane++) {
        if (set->lane[lane].order != 0) {
            candidate->lane[used++] = thermal_lane_at(thermal, &set->lane[lane], celsius);
        }
    }
    for (uint32_t lane = 0; lane < of_own && used < lanes; lane++) {
        uint32_t order = own->lane[lane].order;
        if (order != 0 && !coefficients_have(set, order)) {
            candidate->lane[used++] = own->lane[lane];
        }
    }
}
