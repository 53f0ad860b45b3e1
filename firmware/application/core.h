/* SPDX-License-Identifier: Apache-2.0 */

/* Declares functions that operate the gateware (the core) through its registers. A lane is a unit of the core that adds
   one harmonic to the correction. The core has two coefficient banks, which hold the words of all lanes: one is active,
   the idle one can be written, and a swap exchanges them. Two further banks hold captured samples of the heads. */

#ifndef ARCTRUE_CORE_H
#define ARCTRUE_CORE_H

#include <stdbool.h>
#include <stdint.h>

#include "arctrue_number_formats.h"
#include "capture.h"
#include "coefficients.h"
#include "core_access.h"
#include "followed.h"
#include "table_place.h"

struct core_configuration {
    uint32_t lanes;
    uint32_t capture_depth;
    uint32_t clock_hz;
    /* Number of heads that the firmware can read, two to four. */
    uint32_t heads;
    bool has_mean;
    /* True if the gateware can leave a failed head out of the mean (generic FAILOVER). */
    bool has_failover;
};

struct core_origin {
    uint32_t major;
    uint32_t minor;
    uint32_t patch;
    /* Number of lanes that share a pipeline. */
    uint32_t fold;
    /* True if the lanes read their cosine from a table and do not calculate it by CORDIC. */
    bool has_table;
    /* True if conditions may modulate the amplitudes of lanes. */
    bool has_modulators;
    /* True if phases of lanes may continue from turn to turn. */
    bool has_real_orders;
    /* True if the gateware has a local table, which corrects windows of the turn. */
    bool has_local_table;
    /* True if the top level reads the identifier of the chip; `dna` is this identifier. */
    bool has_dna;
    uint64_t dna;
};

struct core_setup {
    uint32_t counts_per_rev;
    /* Distance between two samples: `sample_period` in clocks, `angle_step` in counts of head 1. */
    uint32_t sample_period;
    uint32_t angle_step;
    uint32_t ramp_rate;
    uint32_t ramp_acceleration;
    uint32_t output_spacing;
    uint32_t filter_length;
    uint32_t minimum_edge_spacing;
    uint32_t index_tolerance;
    /* True if the core adds counts that head 1 lost to the count of the output. */
    bool heal;
    /* The following members are words of the registers. */
    uint32_t head1_input;
    uint32_t head2_input;
    /* `head3_input` and `head4_input` are used only for cores with these heads, `head_delays` only for cores that can
       form a mean. */
    uint32_t head3_input;
    uint32_t head4_input;
    uint32_t head_delays;
    uint32_t output_pins;
    uint32_t alarm;
    uint32_t pulse_widths;
    uint32_t pulse_inputs;
    /* Kinds of events that the core records in its queue; used only for cores with EVENTS. */
    uint32_t recorded_events;
};

/* Instants at which the core takes a sample. */
enum core_capture { CAPTURE_OFF, CAPTURE_BY_TIME, CAPTURE_BY_ANGLE, CAPTURE_BY_SYNC };

const char *core_capture_name(enum core_capture capture);

struct core_header {
    uint64_t start_time;
    uint32_t sequence_number;
    uint32_t samples;
    uint32_t flags;
};

struct core_position {
    uint64_t time;
    int32_t head1_position;
    int32_t head1_turn_position;
    uint32_t head1_angle;
    int32_t correction;
};

/* Last edge of the probe: its clock, corrected position and angle in counts. */
struct core_probe {
    uint64_t time;
    int32_t position;
    uint32_t angle;
    /* Number of edges since the reset of the core, modulo 2^16. */
    uint32_t edges;
};

/* One entry of the queue of events, as the registers `events` show it. */
struct core_event {
    /* Bit 0: an edge of the probe; bit 1: a pulse of the position compare. */
    uint32_t kind;
    /* Number of this event: the core counts its events from 0 since its reset, including lost events, modulo 2^16. */
    uint32_t number;
    uint64_t time;
    int32_t position;
    uint32_t angle;
};

struct core_status {
    bool compensating;
    bool ramp_busy;
    bool capture_ready;
    bool cannot_keep_up;
    bool compare_armed;
    /* Bits of enum core_fault. `release_causes`: the faults that switched the line drivers off (0: the drivers are on);
       `release_present`: the present faults that would switch them off. */
    uint32_t release_causes;
    uint32_t release_present;
};

/* Bits of the register alarm. */
enum core_fault {
    CORE_FAULT_HEAD1 = 1,
    CORE_FAULT_HEAD2 = 2,
    CORE_FAULT_CANNOT_KEEP_UP = 4,
    CORE_FAULT_CORRECTION_LIMITED = 8,
    CORE_FAULT_PROCESSOR_SILENT = 16,
    /* The input filter of head 1 suppressed counts. */
    CORE_FAULT_SWALLOWED = 32,
    CORE_FAULT_HEAD3 = 64,
    CORE_FAULT_HEAD4 = 128,
};

/* Angle and turn position of every head at the clock of the previous core_position(). */
struct core_turns {
    uint32_t angle[HEADS_MOST];
    int32_t turn_position[HEADS_MOST];
};

/* Returns the name of a fault; NULL if `bit` is no bit of enum core_fault. */
const char *core_fault_name(uint32_t bit);

/* Reads the configuration; returns false if no core answers, if the core has another major version, or if its number of
   lanes or its clock rate is impossible. */
bool core_identify(const struct core_access *core, struct core_configuration *configuration);

/* Returns version and chip of an identified core. */
struct core_origin core_origin(const struct core_access *core);

/* Switches correction and capture off and sets the registers. Lets an index mark move the zero of head 1 if it proves
   this zero wrong, enables the interrupts of a ready bank and of a fault of head 1, and re-arms, which makes the index
   invalid. Returns false if the core refuses `counts_per_rev`. */
bool core_set_up(const struct core_access *core, const struct core_setup *setup);
/* Sets the registers that core_set_up() sets, in a working core, and clears the faults of the heads. It does not re-arm
   and does not change the control register. Returns false and sets nothing if the core has another number of counts per
   turn. */
bool core_resume(const struct core_access *core, const struct core_setup *setup);
/* Sets the widths of the pulses, the edges and the filter of the pulse inputs, and the kinds of recorded events. They
   take effect at once. */
void core_set_pins(const struct core_access *core, const struct core_setup *setup);
struct core_probe core_probe(const struct core_access *core);
bool core_has_events(const struct core_access *core);
/* Takes the oldest event from the queue; returns false if the queue is empty. Only for cores with EVENTS. */
bool core_take_event(const struct core_access *core, struct core_event *event);
struct core_places {
    /* `first`: counts from the index to the first pulse; `interval`: counts between pulses, 0 for a single pulse. */
    uint32_t first;
    uint32_t interval;
    uint32_t counts_per_rev;
};

/* Arms the pulses at these places. The first pulse comes at the nearest of these places that lies at least 1/1024 turn
   away in the direction that `upwards` selects. */
void core_arm_compare(const struct core_access *core, const struct core_places *places,
                      bool upwards);
void core_disarm_compare(const struct core_access *core);
/* Tells whether the core applies the correction. */
bool core_compensates(const struct core_access *core);
/* Reports that the processor works. If the next report does not come within the limit, the core raises an alarm. */
void core_tell_alive(const struct core_access *core, uint32_t limit_clocks);

/* Makes the index of every head invalid and clears the faults of the heads; the correction is off until head 1 (with a
   mean, every used head) has seen its index again. */
void core_rearm(const struct core_access *core);
/* Returns the number of times that the core moved the zero of head 1 because of lost counts. */
uint32_t core_zero_moves(const struct core_access *core);
/* Returns the angle of a head, 0 or 1, at its last index, -½ … ½ turn in counts. It differs from 0 if counts were lost
   or added since the index that defined the zero. */
int32_t core_angle_at_index(const struct core_access *core, uint32_t head, uint32_t counts_per_rev);
void core_control(const struct core_access *core, bool compensate, bool output,
                  enum core_capture capture);
/* Switches correction and capture off and leaves the output as it is. */
void core_hold(const struct core_access *core);
/* Tells whether the output is enabled; false after a reset of the core. */
bool core_output_enabled(const struct core_access *core);
struct core_status core_status(const struct core_access *core);
/* Returns one bit per head that the gateware has left out of the mean. */
uint32_t core_left_out(const struct core_access *core);

/* Tells whether every head that is not left out of the mean has seen its index. Heads 3 and 4 need not have seen theirs
   once head 1 has seen two index marks. */
bool core_indices_seen(const struct core_access *core);
/* Tells whether an index of head 1 or head 2 was in the wrong place since the faults were cleared. */
bool core_index_error(const struct core_access *core);
/* Tells whether an index of head 1 (`head` 0) or head 2 (`head` 1) was in the wrong place since the faults were
   cleared. */
bool core_head_index_error(const struct core_access *core, uint32_t head);
struct core_header core_capture_header(const struct core_access *core);
struct core_position core_position(const struct core_access *core);
struct core_turns core_turns(const struct core_access *core, uint32_t heads);
/* Tells whether the head, 0 to 3, has seen its index since the reset or the last re-arm. */
bool core_head_indexed(const struct core_access *core, uint32_t head);
void core_release_capture(const struct core_access *core);
/* Clears the interrupt signal of the core and the causes of the interrupt. Call it before you read the status. */
void core_acknowledge_interrupt(const struct core_access *core);
/* Clears the faults of all heads, but not the fault of the output. */
void core_clear_faults(const struct core_access *core);
/* Ends the fault of the output, which continues from the present position. The same write clears the flags of heads 1
   and 2, if `faults` (bits of enum core_fault) names them, and enables the line drivers if no remaining fault releases
   them; the flags of heads 3 and 4 are cleared before this write. Call it only on the operator's order, because only
   the operator can decide whether the driven machine may move. */
void core_clear_output(const struct core_access *core, uint32_t faults);
void core_write_coefficients(const struct core_access *core,
                             const struct coefficients *coefficients);
/* Reads the idle bank back; returns false if a word differs. */
bool core_verify_coefficients(const struct core_access *core,
                              const struct coefficients *coefficients);
/* Writes the lanes that follow a condition to the last lanes of the idle bank, and the settings of the conditions, which
   the swap also makes active. The second function reads both back; it returns false if a word differs. */
void core_write_followed(const struct core_access *core, const struct followed *followed,
                         uint32_t counts_per_rev, uint32_t lanes);
bool core_verify_followed(const struct core_access *core, const struct followed *followed,
                          uint32_t counts_per_rev, uint32_t lanes);
/* Writes the lanes of real orders (orders that are not whole, real_lanes.h) and the turn step of every lane. The second
   function reads them back and returns false if a word differs. Without REAL_ORDERS the first function does nothing,
   and the second returns true if there is no such lane. */
void core_write_real(const struct core_access *core, const struct followed *followed,
                     uint32_t counts_per_rev, uint32_t lanes);
bool core_verify_real(const struct core_access *core, const struct followed *followed,
                      uint32_t counts_per_rev, uint32_t lanes);
/* Returns the number of turns of the reading that enters the lanes: the reading of head 1 or, with a mean, the reading
   of the carrier minus its offset. Returns 0 without REAL_ORDERS. */
int32_t core_turn_number(const struct core_access *core);
/* Angles and positions at one clock, and the turns of the core to which the angles belong. */
struct core_turn_place {
    /* Corrected. */
    int32_t turn;
    uint32_t angle;
    int32_t position;
    /* Not corrected. With a mean, `head1_turn` belongs to the reading that enters the lanes. */
    int32_t head1_turn;
    uint32_t head1_angle;
    int32_t head1_turn_position;
};
/* Reads the turns of the core; returns false if their number changed during the reading, or if the reading of the heads
   is so near 0 that its turn is uncertain. */
bool core_turn_place(const struct core_access *core, uint32_t counts_per_rev,
                     struct core_turn_place *place);
/* These functions write and read the points and the place in the idle bank of the local table; only for cores with
   LOCAL_TABLE. Writing the place makes the next swap include the table. */
void core_write_table_point(const struct core_access *core, uint32_t number, int32_t point);
int32_t core_table_point(const struct core_access *core, uint32_t number);
void core_write_table_place(const struct core_access *core, const struct table_place *place,
                            uint32_t counts_per_rev);
/* Reads the place of the windows in the idle bank. */
struct table_place core_table_place(const struct core_access *core);
/* Sets a word that lanes follow, MODULATOR_WORD_A or MODULATOR_WORD_B, to a value from -1 to 1. The gateware moves the
   present value of the word to this value at the rate `slew`. */
void core_set_word(const struct core_access *core, enum modulator word, double value);
/* Switches the failover and the limit of the parity off, in a core that has them, and waits until no set is being
   loaded. Call it before other coefficients are activated, because neither the prepared sets nor the weights of the
   parity belong to them. */
void core_failover_off(const struct core_access *core);
bool core_failover_is_on(const struct core_access *core);
/* State of the failed heads and of the gateware's prepared sets (prepared.h); only in cores with generic FAILOVER. */
struct core_failover {
    /* One bit per head. */
    uint32_t left_out;
    /* Number of the active prepared set; CORE_OWN_WORDS if the processor's words are active. */
    uint32_t set;
    /* Causes for which the last failed head was left out: bits of the register `failover` from `illegal` on. */
    uint32_t causes;
    /* Sum of the readings with the parity weights, 2^-11 counts; `parity_beyond` is true if the sum reached its
       limit. */
    int32_t parity;
    bool parity_beyond;
};

enum { CORE_OWN_WORDS = ARCTRUE_OWN_WORDS_SET };

struct core_failover core_failover(const struct core_access *core);
/* Tells whether the gateware has refused words since the failover was switched on. It does so if a head fails and there
   is no valid set without this head; the head is then still in the mean. */
bool core_set_is_refused(const struct core_access *core);

struct core_failover_setup {
    /* Faults for which a head is left out: bits of the register `failover` from `illegal` on. */
    uint32_t causes;
    /* A head has failed if it stands still while all other heads move by this number of counts; 0: no check. */
    uint32_t missing_counts;
    /* Search for a head whose reading steps: two heads agree if they move by the same distance within less than this
       number of counts; 0: no search. */
    uint32_t step_limit;
    /* Clocks after which a head may be used again; 0: only on request. */
    double return_after;
    uint32_t parity_limit;
    /* s1.16; all 0: there is no parity. */
    int32_t parity_weight[HEADS_MOST];
};

/* Switches the failover on; core_failover_off() switches it off. */
void core_failover_on(const struct core_access *core, const struct core_failover_setup *setup);
/* Writes the lanes of `coefficients` and the words of its mean as prepared set `set`: set 0 has all heads, set n lacks
   head n. Lanes beyond `coefficients->lanes` keep their words. The gateware refuses a set whose mean uses no head.
   Returns the sum of the written words, see core_prepared_sum(). */
uint32_t core_write_prepared(const struct core_access *core, uint32_t set,
                             const struct coefficients *coefficients);
/* Writes one lane of a prepared set; returns the sum of its words. */
uint32_t core_write_prepared_lane(const struct core_access *core, uint32_t set, uint32_t place,
                                  const struct lane *lane, uint32_t counts_per_rev);
/* Reads `set->lanes` lanes and the words of the mean of a prepared set that was written for `set->counts_per_rev`. */
void core_read_prepared(const struct core_access *core, uint32_t number, struct coefficients *set);
/* Returns the check sum of all prepared sets, as read back from the core: the sum, modulo 2^32, of one CRC-32 for each
   word that is not 0, computed from the word's address and the word. So the order of the writes does not matter, and
   sets that are filled with 0 have the sum 0. */
uint32_t core_prepared_sum(const struct core_access *core, uint32_t lanes);
/* Activates a prepared set instead of the idle bank; the core counts this as a swap. */
void core_take_set(const struct core_access *core, uint32_t set);
/* Allows the core to use these heads (one bit per head) again, each after its next index. */
void core_come_back(const struct core_access *core, uint32_t heads);
void core_swap(const struct core_access *core);
/* Makes the words of head 1 alone active in a core with a mean, because no turn is captured while the mean uses a head
   without an index. Call it while the correction is off: the lanes of the idle bank become active too. Does nothing if
   head 1 is left out. */
void core_use_head1(const struct core_access *core);
uint32_t core_swap_count(const struct core_access *core);
uint32_t core_overrun_count(const struct core_access *core);
/* Reads the numbers of index marks in the wrong place, of illegal transitions and of over-speed edges of a head, 0 to
   3. */
void core_fault_counters(const struct core_access *core, uint32_t head, uint32_t counters[3]);

#endif
