/* SPDX-License-Identifier: Apache-2.0 */

/* Reads the measurements of the core: probe, events, indices, capture, positions and turns; arms the position compare. */

#include <math.h>

#include "assertion.h"
#include "core.h"
#include "core_registers.h"

/* Divisor of the turn that gives the margin of an armed compare: the table may move by 1/1024 turn between the reading
   of its position and the write that depends on this position. */
enum { COMPARE_MARGIN = 1024 };
/* Bits of the flags of a head; these names serve all heads, while the generated mask names differ from head to head. */
enum { INDEX_SEEN = 1, INDEX_ERROR = 2 };

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

uint32_t core_zero_moves(const struct core_access *core) {
    return FIELD(core_read(core, AT(zero)), ZERO__MOVES);
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
