/* SPDX-License-Identifier: Apache-2.0 */

#include "core.h"

#include <math.h>
#include <stddef.h>

#include "arctrue_number_formats.h"
#include "arctrue_registers.h"
#include "assertion.h"
#include "crc32.h"

#define AT(register) ((uint32_t)offsetof(arctrue_registers_t, register))
#define BIT(name) ((uint32_t)ARCTRUE_REGISTERS__##name##_bm)
#define FIELD(word, name) (((word) & BIT(name)) >> ARCTRUE_REGISTERS__##name##_bp)

/* A fault of head 1 also raises the interrupt, because the firmware must examine lost counts immediately. */
#define INTERRUPTS (BIT(INTERRUPT_ENABLE__CAPTURE_READY) | BIT(INTERRUPT_ENABLE__HEAD1_FAULT))

#define CAPTURE_MODE(mode) ((uint32_t)(mode) << ARCTRUE_REGISTERS__CONTROL__CAPTURE_MODE_bp)

enum { WORDS_A_LANE = 4, WORD_BYTES = 4, HEADS = 2, MODULATOR_PLACE = 16 };
/* Numbers of the words in the registers of the mean. The offsets begin at word 0; the weights and the choice of heads
   follow. */
enum { MEAN_WEIGHTS = 4, MEAN_CHOICE = 8, MEAN_WORDS = 9, USED_SHIFT = 4 };
#define WEIGHT_ONE (1 << ARCTRUE_HEAD_WEIGHT_FRACTION)
/* Value 1 in the format s1.16 of the words that lanes follow. */
#define WORD_ONE ((double)(1 << ARCTRUE_MODULATOR_FRACTION))
/* Divisor of the turn that gives the margin of an armed compare: the table may move by 1/1024 turn between the reading
   of its position and the write that depends on this position. */
enum { COMPARE_MARGIN = 1024 };
/* Number of register reads that last at least as long as a re-arm: a re-arm takes 128 clocks of the fabric, a read at
   least one clock. */
enum { REARM_READS = 128 };
/* Bits of the flags of a head; these names serve all heads, while the generated mask names differ from head to head. */
enum { INDEX_SEEN = 1, INDEX_ERROR = 2 };

const char *core_capture_name(enum core_capture capture) {
    static const char *const names[] = {"off", "equal_times", "equal_angles", "sync_in"};
    return (unsigned)capture <= CAPTURE_BY_SYNC ? names[capture] : "unknown";
}

const char *core_fault_name(uint32_t bit) {
    switch (bit) {
    case CORE_FAULT_HEAD1:
        return "head1";
    case CORE_FAULT_HEAD2:
        return "head2";
    case CORE_FAULT_CANNOT_KEEP_UP:
        return "cannot_keep_up";
    case CORE_FAULT_CORRECTION_LIMITED:
        return "correction_limited";
    case CORE_FAULT_PROCESSOR_SILENT:
        return "processor_silent";
    case CORE_FAULT_SWALLOWED:
        return "swallowed";
    case CORE_FAULT_HEAD3:
        return "head3";
    case CORE_FAULT_HEAD4:
        return "head4";
    default:
        return NULL;
    }
}

static uint32_t core_read(const struct core_access *core, uint32_t offset) {
    return core->read(core->context, offset);
}

static void core_write(const struct core_access *core, uint32_t offset, uint32_t word) {
    core->write(core->context, offset, word);
}

/* Reads a word of 64 bits; the read of the low word latches the high word. */
static uint64_t core_read_wide(const struct core_access *core, uint32_t offset) {
    uint32_t low = core_read(core, offset);
    return (uint64_t)core_read(core, offset + WORD_BYTES) << 32 | low;
}

/* Returns the register `capability`; for gateware of an earlier minor version, which answers its address with an error,
   returns the configuration with two heads. */
static uint32_t core_capability(const struct core_access *core) {
    uint32_t version = core_read(core, AT(version));
    return FIELD(version, VERSION__MINOR) >= 8U ? core_read(core, AT(capability)) : HEADS;
}

/* Returns the number of heads whose capture the firmware can read. */
static uint32_t core_heads(const struct core_access *core) {
    uint32_t heads = FIELD(core_capability(core), CAPABILITY__HEADS);
    return core->further_capture != NULL && heads > HEADS && heads <= HEADS_MOST ? heads : HEADS;
}

bool core_identify(const struct core_access *core, struct core_configuration *configuration) {
    if (core->look != NULL) {
        core->look(core->context);
    }
    if (core_read(core, AT(identification)) != ARCTRUE_REGISTERS__IDENTIFICATION__VALUE_reset) {
        return false;
    }
    uint32_t major = FIELD(core_read(core, AT(version)), VERSION__MAJOR);
    uint32_t built = core_read(core, AT(core_configuration));
    *configuration = (struct core_configuration){
        .lanes = FIELD(built, CORE_CONFIGURATION__LANES),
        .capture_depth = FIELD(built, CORE_CONFIGURATION__CAPTURE_DEPTH),
        .clock_hz = core_read(core, AT(clock_hz)),
        .heads = core_heads(core),
        .has_mean = FIELD(core_capability(core), CAPABILITY__MEAN) != 0,
        .has_failover = FIELD(core_capability(core), CAPABILITY__FAILOVER) != 0,
    };
    return major == ARCTRUE_REGISTERS__VERSION__MAJOR_reset && configuration->lanes > 0 &&
           configuration->lanes <= LANES_LIMIT && configuration->clock_hz > 0;
}

static bool core_has_real_orders(const struct core_access *core) {
    return FIELD(core_capability(core), CAPABILITY__REAL_ORDERS) != 0;
}

bool core_has_events(const struct core_access *core) {
    return FIELD(core_capability(core), CAPABILITY__EVENTS) != 0;
}

struct core_origin core_origin(const struct core_access *core) {
    uint32_t version = core_read(core, AT(version));
    uint32_t high = core_read(core, AT(chip_dna_high));
    return (struct core_origin){
        .major = FIELD(version, VERSION__MAJOR),
        .minor = FIELD(version, VERSION__MINOR),
        .patch = FIELD(version, VERSION__PATCH),
        .fold = FIELD(core_read(core, AT(pipeline)), PIPELINE__FOLD),
        .has_table = FIELD(core_capability(core), CAPABILITY__ROTATION) != 0,
        .has_modulators = FIELD(core_capability(core), CAPABILITY__MODULATORS) != 0,
        .has_real_orders = core_has_real_orders(core),
        .has_local_table = FIELD(core_capability(core), CAPABILITY__LOCAL_TABLE) != 0,
        .has_dna = FIELD(high, CHIP_DNA_HIGH__KNOWN) != 0,
        .dna =
            (uint64_t)FIELD(high, CHIP_DNA_HIGH__VALUE) << 32 | core_read(core, AT(chip_dna_low)),
    };
}

/* Switches correction and capture off. The output stays on if it is on: after a fault of the firmware a controller
   still uses the output, and would lose counts while it is off. */
void core_hold(const struct core_access *core) {
    bool output = (core_read(core, AT(control)) & BIT(CONTROL__OUTPUT_ENABLE)) != 0;
    core_control(core, false, output, CAPTURE_OFF);
}

void core_set_pins(const struct core_access *core, const struct core_setup *setup) {
    core_write(core, AT(pulse_widths), setup->pulse_widths);
    core_write(core, AT(pulse_inputs), setup->pulse_inputs);
    if (core_has_events(core)) {
        core_write(core, AT(events.recorded), setup->recorded_events);
    }
}

static void core_write_further_setup(const struct core_access *core,
                                     const struct core_setup *setup) {
    uint32_t heads = core_heads(core);
    if (heads > 2) {
        core_write(core, AT(head3), setup->head3_input);
    }
    if (heads > 3) {
        core_write(core, AT(head4), setup->head4_input);
    }
    if (FIELD(core_capability(core), CAPABILITY__MEAN) != 0) {
        core_write(core, AT(head_delays), setup->head_delays);
    }
}

static void core_write_setup(const struct core_access *core, const struct core_setup *setup) {
    core_failover_off(core);
    core_write(core, AT(counts_per_rev), setup->counts_per_rev);
    core_write(core, AT(sample_period), setup->sample_period);
    core_write(core, AT(angle_step), setup->angle_step);
    core_write(core, AT(ramp_rate), setup->ramp_rate);
    core_write(core, AT(ramp_acceleration), setup->ramp_acceleration);
    core_write(core, AT(output_spacing), setup->output_spacing);
    core_write(core, AT(filter_length), setup->filter_length);
    core_write(core, AT(minimum_edge_spacing), setup->minimum_edge_spacing);
    core_write(core, AT(index_tolerance), setup->index_tolerance);
    core_write(core, AT(head1_input), setup->head1_input);
    core_write(core, AT(head2_input), setup->head2_input);
    core_write_further_setup(core, setup);
    core_write(core, AT(output_pins), setup->output_pins);
    core_write(core, AT(alarm), setup->alarm);
    core_set_pins(core, setup);
    core_write(core, AT(lost_counts),
               BIT(LOST_COUNTS__ZERO_AGAIN) | (setup->heal ? BIT(LOST_COUNTS__HEAL) : 0U));
}

static void core_interrupts_on(const struct core_access *core) {
    core_acknowledge_interrupt(core);
    core_write(core, AT(interrupt_enable), INTERRUPTS);
}

bool core_set_up(const struct core_access *core, const struct core_setup *setup) {
    core_hold(core);
    core_write_setup(core, setup);
    core_rearm(core);
    core_interrupts_on(core);
    return core_read(core, AT(counts_per_rev_active)) == setup->counts_per_rev;
}

bool core_resume(const struct core_access *core, const struct core_setup *setup) {
    if (core_read(core, AT(counts_per_rev_active)) != setup->counts_per_rev) {
        return false;
    }
    core_write_setup(core, setup);
    core_clear_faults(core);
    core_interrupts_on(core);
    return true;
}

bool core_compensates(const struct core_access *core) {
    return core_status(core).compensating;
}

/* Reads a group of registers; the read of the low word of the time latches the whole group. */
struct core_probe core_probe(const struct core_access *core) {
    struct core_probe probe;
    probe.time = core_read_wide(core, AT(probe.time));
    probe.position = (int32_t)core_read(core, AT(probe.position));
    probe.angle = core_read(core, AT(probe.angle));
    probe.edges = core_read(core, AT(probe.edges));
    return probe;
}

bool core_take_event(const struct core_access *core, struct core_event *event) {
    uint32_t state = core_read(core, AT(events.state));
    event->kind = FIELD(state, EVENTS__STATE__KIND);
    if (event->kind == 0) {
        return false;
    }
    event->number = FIELD(state, EVENTS__STATE__SEQUENCE_NUMBER);
    event->time = core_read_wide(core, AT(events.time_low));
    event->position = (int32_t)core_read(core, AT(events.position));
    event->angle = core_read(core, AT(events.angle));
    core_write(core, AT(command), BIT(COMMAND__NEXT_EVENT));
    return true;
}

void core_arm_compare(const struct core_access *core, const struct core_places *places,
                      bool upwards) {
    int64_t margin = places->counts_per_rev / COMPARE_MARGIN + 1;
    ASSERT(places->counts_per_rev > 0);
    int64_t period = places->interval != 0 ? places->interval : places->counts_per_rev;
    (void)core_read_wide(core, AT(snapshot.time));
    uint32_t position = core_read(core, AT(snapshot.corrected_position));
    int64_t away = (int64_t)places->first - core_read(core, AT(snapshot.corrected_angle));
    int64_t beyond = ((upwards ? away : -away) - margin) % period;
    int64_t counts = margin + beyond + (beyond < 0 ? period : 0);
    core_write(core, AT(compare.first), position + (uint32_t)(upwards ? counts : -counts));
    core_write(core, AT(compare.interval), places->interval);
    core_write(core, AT(command), BIT(COMMAND__COMPARE_ARM));
}

void core_disarm_compare(const struct core_access *core) {
    core_write(core, AT(command), BIT(COMMAND__COMPARE_DISARM));
}

void core_tell_alive(const struct core_access *core, uint32_t limit_clocks) {
    core_write(core, AT(processor_limit), limit_clocks);
    core_write(core, AT(command), BIT(COMMAND__ALIVE));
}

void core_rearm(const struct core_access *core) {
    core_write(core, AT(command), BIT(COMMAND__REARM));
    for (uint32_t reads = 0; reads < REARM_READS; reads++) {
        (void)core_read(core, AT(scratch));
    }
    core_clear_faults(core);
}

uint32_t core_zero_moves(const struct core_access *core) {
    return FIELD(core_read(core, AT(zero)), ZERO__MOVES);
}

int32_t core_zero_slip(const struct core_access *core) {
    return (int32_t)core_read(core, AT(zero_slip));
}

int32_t core_angle_at_index(const struct core_access *core, uint32_t head,
                            uint32_t counts_per_rev) {
    ASSERT(head < HEADS && counts_per_rev > 0);
    /* The read of the low word of the time latches the whole group. */
    (void)core_read_wide(core, AT(snapshot.time));
    uint32_t position =
        core_read(core, head ? AT(snapshot.head2_position) : AT(snapshot.head1_position));
    uint32_t angle = core_read(core, head ? AT(snapshot.head2_angle) : AT(snapshot.head1_angle));
    uint32_t index = core_read(core, head ? AT(head2.index) : AT(head1.index));
    /* The travel is less than a turn, so the difference of the words is right when they wrap. */
    int64_t since = (int32_t)(position - index);
    int64_t turn = counts_per_rev;
    int64_t at_index = ((int64_t)angle - since) % turn;
    at_index += at_index < 0 ? turn : 0;
    return (int32_t)(2 * at_index > turn ? at_index - turn : at_index);
}

void core_control(const struct core_access *core, bool compensate, bool output,
                  enum core_capture capture) {
    uint32_t word = (compensate ? BIT(CONTROL__COMPENSATE) : 0U) |
                    (output ? BIT(CONTROL__OUTPUT_ENABLE) : 0U) |
                    (capture != CAPTURE_OFF ? BIT(CONTROL__CAPTURE_ENABLE) : 0U) |
                    (capture != CAPTURE_OFF ? CAPTURE_MODE(capture - CAPTURE_BY_TIME) : 0U);
    core_write(core, AT(control), word);
}

bool core_output_enabled(const struct core_access *core) {
    return (core_read(core, AT(control)) & BIT(CONTROL__OUTPUT_ENABLE)) != 0;
}

struct core_status core_status(const struct core_access *core) {
    uint32_t word = core_read(core, AT(status));
    return (struct core_status){
        .compensating = (word & BIT(STATUS__COMPENSATING)) != 0,
        .ramp_busy = (word & BIT(STATUS__RAMP_BUSY)) != 0,
        .capture_ready = (word & BIT(STATUS__CAPTURE_READY)) != 0,
        .cannot_keep_up = (word & BIT(STATUS__CANNOT_KEEP_UP)) != 0,
        .compare_armed = (word & BIT(STATUS__COMPARE_ARMED)) != 0,
        .release_causes = FIELD(word, STATUS__RELEASE_CAUSES),
        .release_present = FIELD(word, STATUS__RELEASE_PRESENT),
    };
}

uint32_t core_left_out(const struct core_access *core) {
    return core_heads(core) > HEADS
               ? FIELD(core_read(core, AT(heads_status)), HEADS_STATUS__LEFT_OUT)
               : 0;
}

/* Tells whether heads 3 and 4 have seen their indices or are left out. Also returns true once head 1 has seen two index
   marks, because a further head without an index must not block the calibration. */
static bool core_further_indices_seen(const struct core_access *core) {
    uint32_t heads = core_heads(core);
    if (heads == HEADS) {
        return true;
    }
    uint32_t word = core_read(core, AT(heads_status));
    uint32_t found = FIELD(word, HEADS_STATUS__INDEX_SEEN) | FIELD(word, HEADS_STATUS__LEFT_OUT);
    uint32_t all = (1U << heads) - 1U;
    return (found & all) == all || core_read_wide(core, AT(head1.index)) >> 32 != 0;
}

bool core_indices_seen(const struct core_access *core) {
    uint32_t left_out = core_left_out(core);
    bool head1 = (left_out & 1U) != 0 || (core_read(core, AT(head1.flags)) & INDEX_SEEN) != 0;
    bool head2 = (left_out & 2U) != 0 || (core_read(core, AT(head2.flags)) & INDEX_SEEN) != 0;
    return head1 && head2 && core_further_indices_seen(core);
}

bool core_head_indexed(const struct core_access *core, uint32_t head) {
    static const uint32_t flags[HEADS_MOST] = {AT(head1.flags), AT(head2.flags), AT(head3.flags),
                                               AT(head4.flags)};
    ASSERT(head < HEADS_MOST);
    return (core_read(core, flags[head]) & INDEX_SEEN) != 0;
}

bool core_head_index_error(const struct core_access *core, uint32_t head) {
    ASSERT(head < HEADS);
    return (core_read(core, head ? AT(head2.flags) : AT(head1.flags)) & INDEX_ERROR) != 0;
}

bool core_index_error(const struct core_access *core) {
    return core_head_index_error(core, 0) || core_head_index_error(core, 1);
}

struct core_header core_capture_header(const struct core_access *core) {
    return (struct core_header){
        .start_time = core_read_wide(core, AT(capture_header.start_time)),
        .sequence_number = core_read(core, AT(capture_header.sequence_number)),
        .samples = core_read(core, AT(capture_header.sample_count)),
        .flags = core_read(core, AT(capture_header.flags)),
    };
}

/* Reads a group of registers; the read of the low word of the time latches the whole group. */
struct core_position core_position(const struct core_access *core) {
    struct core_position position;
    position.time = core_read_wide(core, AT(snapshot.time));
    position.head1_position = (int32_t)core_read(core, AT(snapshot.head1_position));
    position.head1_turn_position = (int32_t)core_read(core, AT(snapshot.head1_turn_position));
    position.head1_angle = core_read(core, AT(snapshot.head1_angle));
    position.correction = (int32_t)core_read(core, AT(snapshot.correction));
    return position;
}

struct core_turns core_turns(const struct core_access *core, uint32_t heads) {
    struct core_turns turns = {
        .angle = {core_read(core, AT(snapshot.head1_angle)),
                  core_read(core, AT(snapshot.head2_angle))},
        .turn_position = {(int32_t)core_read(core, AT(snapshot.head1_turn_position)),
                          (int32_t)core_read(core, AT(snapshot.head2_turn_position))},
    };
    for (uint32_t head = HEADS; head < heads; head++) {
        turns.angle[head] = core_read(core, head > 2 ? AT(head4.angle) : AT(head3.angle));
        turns.turn_position[head] =
            (int32_t)core_read(core, head > 2 ? AT(head4.turn_position) : AT(head3.turn_position));
    }
    return turns;
}

void core_release_capture(const struct core_access *core) {
    core_write(core, AT(command), BIT(COMMAND__CAPTURE_RELEASE));
}

void core_acknowledge_interrupt(const struct core_access *core) {
    /* The bits of interrupt_status have the same places as the bits of interrupt_enable. */
    core_write(core, AT(interrupt_status), INTERRUPTS);
}

/* Clears the faults of heads 3 and 4. Call it before the command that enables released line drivers again, because that
   command checks which faults are present. */
static void core_clear_further(const struct core_access *core, bool head3, bool head4) {
    uint32_t heads = core_heads(core);
    if (heads > 2 && (head3 || head4)) {
        core_write(core, AT(heads_command),
                   (head3 ? BIT(HEADS_COMMAND__CLEAR_HEAD3) : 0U) |
                       (head4 && heads > 3 ? BIT(HEADS_COMMAND__CLEAR_HEAD4) : 0U));
    }
}

void core_clear_faults(const struct core_access *core) {
    core_clear_further(core, true, true);
    core_write(core, AT(command), BIT(COMMAND__CLEAR_HEAD1) | BIT(COMMAND__CLEAR_HEAD2));
}

void core_clear_output(const struct core_access *core, uint32_t faults) {
    bool of_head1 = (faults & (CORE_FAULT_HEAD1 | CORE_FAULT_SWALLOWED)) != 0;
    bool of_head2 = (faults & CORE_FAULT_HEAD2) != 0;
    core_clear_further(core, (faults & CORE_FAULT_HEAD3) != 0, (faults & CORE_FAULT_HEAD4) != 0);
    core_write(core, AT(command),
               BIT(COMMAND__CLEAR_OUTPUT) | (of_head1 ? BIT(COMMAND__CLEAR_HEAD1) : 0U) |
                   (of_head2 ? BIT(COMMAND__CLEAR_HEAD2) : 0U));
}

static void core_lane_words(const struct lane *lane, uint32_t counts_per_rev, uint32_t modulator,
                            uint32_t words[WORDS_A_LANE]) {
    uint64_t step = coefficients_phase_step(lane->order, counts_per_rev);
    words[0] = (uint32_t)step;
    words[1] = (uint32_t)(step >> 32) | modulator << MODULATOR_PLACE;
    words[2] = lane->phase_offset;
    words[3] = (uint32_t)lane->amplitude;
}

static uint32_t core_lane_offset(uint32_t lane, uint32_t word) {
    return AT(coefficients) + (lane * WORDS_A_LANE + word) * WORD_BYTES;
}

/* Returns a word for the registers of the mean; without a mean, head 1 has the whole weight. */
static uint32_t core_mean_word(const struct mean_set *mean, uint32_t place) {
    if (place == MEAN_CHOICE) {
        return mean->heads != 0 ? mean->carrier | mean->used << USED_SHIFT : 1U << USED_SHIFT;
    }
    if (place < MEAN_WEIGHTS) {
        return mean->offset[place];
    }
    bool alone = mean->heads == 0 && place == MEAN_WEIGHTS;
    return alone ? (uint32_t)WEIGHT_ONE : (uint32_t)mean->weight[place - MEAN_WEIGHTS];
}

/* Tells whether the core contains this word of the mean. It answers the words of heads that are not built with an error
   of the bus. */
static bool core_mean_word_is_built(const struct core_access *core, uint32_t place) {
    return place == MEAN_CHOICE ||
           place % MEAN_WEIGHTS < FIELD(core_capability(core), CAPABILITY__HEADS);
}

/* Returns the summand of a word in the check sum of the prepared sets: 0 for the word 0. */
static uint32_t core_summand(uint32_t offset, uint32_t word) {
    return word != 0 ? crc32_add_word(offset, word) : 0U;
}

/* Writes a word and returns its summand. */
static uint32_t core_write_summed(const struct core_access *core, uint32_t offset, uint32_t word) {
    core_write(core, offset, word);
    return core_summand(offset, word);
}

/* Writes the words of the mean from address `first` on; returns their sum. */
static uint32_t core_write_mean(const struct core_access *core, const struct mean_set *mean,
                                uint32_t first) {
    uint32_t sum = 0;
    for (uint32_t place = 0; place < MEAN_WORDS; place++) {
        if (core_mean_word_is_built(core, place)) {
            sum += core_write_summed(core, first + place * WORD_BYTES, core_mean_word(mean, place));
        }
    }
    return sum;
}

void core_write_coefficients(const struct core_access *core,
                             const struct coefficients *coefficients) {
    ASSERT(coefficients->lanes <= LANES_LIMIT);
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        uint32_t words[WORDS_A_LANE];
        core_lane_words(&coefficients->lane[lane], coefficients->counts_per_rev, MODULATOR_ONE,
                        words);
        for (uint32_t word = 0; word < WORDS_A_LANE; word++) {
            core_write(core, core_lane_offset(lane, word), words[word]);
        }
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
        for (uint32_t word = 0; word < WORDS_A_LANE; word++) {
            if (core_read(core, core_lane_offset(lane, word)) != words[word]) {
                return false;
            }
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
        for (uint32_t word = 0; word < WORDS_A_LANE; word++) {
            core_write(core, core_lane_offset(lanes - followed->lanes + place, word), words[word]);
        }
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
        for (uint32_t word = 0; word < WORDS_A_LANE; word++) {
            uint32_t offset = core_lane_offset(lanes - followed->lanes + place, word);
            if (core_read(core, offset) != words[word]) {
                return false;
            }
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
        for (uint32_t word = 0; word < WORDS_A_LANE; word++) {
            core_write(core, core_lane_offset(first + place, word), words[word]);
        }
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
        for (uint32_t word = 0; word < WORDS_A_LANE; word++) {
            equal = equal && core_read(core, core_lane_offset(first + place, word)) == words[word];
        }
    }
    for (uint32_t lane = 0; lane < lanes; lane++) {
        uint64_t step = core_turn_step(followed, lanes, lane);
        equal = equal && core_read(core, core_turn_step_offset(lane, 0)) == (uint32_t)step &&
                core_read(core, core_turn_step_offset(lane, 1)) == (uint32_t)(step >> 32);
    }
    return equal;
}

int32_t core_turn_number(const struct core_access *core) {
    return core_has_real_orders(core) ? (int32_t)core_read(core, AT(turn_number)) : 0;
}

/* Distance of a reading from 0 within which its turn is uncertain: the corrected angle belongs to a reading that is up
   to 44 clocks old, the count of turns to a newer one, and in each clock the reading moves by at most one count. */
enum { TURN_UNCERTAIN_COUNTS = 64 };

bool core_turn_place(const struct core_access *core, uint32_t counts_per_rev,
                     struct core_turn_place *place) {
    const double one = 1 << ARCTRUE_CORRECTION_FRACTION;
    place->head1_turn = core_turn_number(core);
    const struct core_position position = core_position(core);
    place->angle = core_read(core, AT(snapshot.corrected_angle));
    place->position = (int32_t)core_read(core, AT(snapshot.corrected_position));
    place->head1_angle = position.head1_angle;
    place->head1_turn_position = position.head1_turn_position;
    /* Reading to which the corrected angle belongs, counted from the start of the turn of the corrected angle. The core
       counts the turns of the reading. */
    int64_t turn = counts_per_rev;
    int64_t reading = place->angle + (int64_t)floor(position.correction / one + 0.5);
    int32_t ahead = (reading < 0 ? 1 : 0) - (reading >= turn ? 1 : 0);
    place->turn = place->head1_turn + ahead;
    reading += ahead * turn;
    return core_turn_number(core) == place->head1_turn && reading >= TURN_UNCERTAIN_COUNTS &&
           reading + TURN_UNCERTAIN_COUNTS < turn;
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
    /* Closes the set; the choice of heads, the last word, opens it. */
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

void core_swap(const struct core_access *core) {
    core_write(core, AT(command), BIT(COMMAND__SWAP));
}

uint32_t core_swap_count(const struct core_access *core) {
    return core_read(core, AT(swap_count));
}

uint32_t core_overrun_count(const struct core_access *core) {
    return core_read(core, AT(overrun_count));
}

void core_fault_counters(const struct core_access *core, uint32_t head, uint32_t counters[3]) {
    static const struct {
        uint32_t faults;
        uint32_t overspeeds;
    } places[HEADS_MOST] = {
        {AT(head1.faults), AT(head1.overspeeds)},
        {AT(head2.faults), AT(head2.overspeeds)},
        {AT(head3.faults), AT(head3.overspeeds)},
        {AT(head4.faults), AT(head4.overspeeds)},
    };
    ASSERT(head < HEADS_MOST);
    uint32_t faults = core_read(core, places[head].faults);
    counters[0] = faults & 0xFFFFU;
    counters[1] = faults >> 16;
    counters[2] = core_read(core, places[head].overspeeds);
}
