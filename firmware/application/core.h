/* SPDX-License-Identifier: Apache-2.0 */

/* The gateware by name, over whatever reads and writes its registers: memory on the device, a
   simulator's bus or a model on the host. */

#ifndef ARCTRUE_CORE_H
#define ARCTRUE_CORE_H

#include <stdbool.h>
#include <stdint.h>

#include "capture.h"
#include "coefficients.h"
#include "followed.h"

typedef uint32_t core_read_word(void *context, uint32_t offset);
typedef void core_write_word(void *context, uint32_t offset, uint32_t word);
/* The ready bank's words, `number` of them; they stand still until the bank is released. */
typedef const volatile int32_t *core_capture_words(void *context, uint32_t number);

/* Before a core is looked for: whether anything answers may have changed. */
typedef void core_look(void *context);

struct core_access {
    core_read_word *read;
    core_write_word *write;
    core_capture_words *capture;
    void *context;
    /* NULL: nothing changes. */
    core_look *look;
    /* As `capture`, of heads 3 and 4; NULL where no core has them. */
    core_capture_words *further_capture;
};

struct core_configuration {
    uint32_t lanes;
    uint32_t capture_depth;
    uint32_t clock_hz;
    /* Two to four; what the firmware cannot reach counts as not there. */
    uint32_t heads;
    bool has_mean;
};

struct core_origin {
    uint32_t major;
    uint32_t minor;
    uint32_t patch;
    /* Lanes that share a pipeline. */
    uint32_t fold;
    /* The lanes find their cosine in a table, not by CORDIC. */
    bool has_table;
    /* Amplitudes of lanes may follow conditions. */
    bool has_modulators;
    /* Identifier of the chip, where the top level reads it. */
    bool has_dna;
    uint64_t dna;
};

struct core_setup {
    uint32_t counts_per_rev;
    /* Clocks, and counts of head 1, from one sample to the next. */
    uint32_t sample_period;
    uint32_t angle_step;
    uint32_t ramp_rate;
    uint32_t ramp_acceleration;
    uint32_t output_spacing;
    uint32_t filter_length;
    uint32_t minimum_edge_spacing;
    uint32_t index_tolerance;
    /* Counts that head 1 lost are put into the count of the output. */
    bool heal;
    /* Words of the registers. */
    uint32_t head1_input;
    uint32_t head2_input;
    /* Of cores that have them. */
    uint32_t head3_input;
    uint32_t head4_input;
    uint32_t head_delays;
    uint32_t output_pins;
    uint32_t alarm;
    uint32_t pulse_widths;
    uint32_t pulse_inputs;
};

/* When the core takes a sample. */
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

/* Of the last edge of the probe: clocks, and the corrected position and angle in counts. */
struct core_probe {
    uint64_t time;
    int32_t position;
    uint32_t angle;
    /* Since the reset of the core; wraps at 2^16. */
    uint32_t edges;
};

struct core_status {
    bool compensating;
    bool ramp_busy;
    bool capture_ready;
    bool cannot_keep_up;
    bool compare_armed;
    /* Some of enum core_fault: those that released the line drivers, 0 where they are driven, and those that
       would do so now. */
    uint32_t release_causes;
    uint32_t release_present;
};

/* As the bits of the register alarm. */
enum core_fault {
    CORE_FAULT_HEAD1 = 1,
    CORE_FAULT_HEAD2 = 2,
    CORE_FAULT_CANNOT_KEEP_UP = 4,
    CORE_FAULT_CORRECTION_LIMITED = 8,
    CORE_FAULT_PROCESSOR_SILENT = 16,
    /* Of head 1: counts, by the input filter. */
    CORE_FAULT_SWALLOWED = 32,
    CORE_FAULT_HEAD3 = 64,
    CORE_FAULT_HEAD4 = 128,
};

/* Angle and turn position of every head in the clock of the core_position() before. */
struct core_turns {
    uint32_t angle[HEADS_MOST];
    int32_t turn_position[HEADS_MOST];
};

/* NULL for what is no bit of these. */
const char *core_fault_name(uint32_t bit);

/* False: no core answers there, or one of another major version. */
bool core_identify(const struct core_access *core, struct core_configuration *configuration);

/* What a core that was identified is, and in which chip. */
struct core_origin core_origin(const struct core_access *core);

/* Correction and capture off; set the registers, let marks that are proven move the zero of head 1, let
   a ready bank and a fault of head 1 interrupt, and re-arm, which forgets the index. False:
   `counts_per_rev` is refused. */
bool core_set_up(const struct core_access *core, const struct core_setup *setup);
/* The same registers, with the core at work: no re-arm, and control as it is. False: the core counts
   another turn, and nothing was set. */
bool core_resume(const struct core_access *core, const struct core_setup *setup);
/* Widths of the pulses and edges of the pulse inputs, at once. */
void core_set_pins(const struct core_access *core, const struct core_setup *setup);
struct core_probe core_probe(const struct core_access *core);
struct core_places {
    /* After the index, and from one to the next; counts. Interval 0: once. */
    uint32_t first;
    uint32_t interval;
    uint32_t counts_per_rev;
};

/* Pulses at these places, from the next one upwards or downwards that is 1/1024 turn away. */
void core_arm_compare(const struct core_access *core, const struct core_places *places,
                      bool upwards);
void core_disarm_compare(const struct core_access *core);
/* The correction is applied. */
bool core_compensates(const struct core_access *core);
/* The processor works; where this does not come for so many clocks, the core raises an alarm. */
void core_tell_alive(const struct core_access *core, uint32_t limit_clocks);

/* Forget the index and the faults; the correction is off until head 1 has seen its index again. */
void core_rearm(const struct core_access *core);
/* How often the core has moved the zero of head 1, because counts were lost. */
uint32_t core_zero_moves(const struct core_access *core);
/* The angle that the mark had which moved it last: the counts lost, with a minus. */
int32_t core_zero_slip(const struct core_access *core);
/* The angle that a head, 0 or 1, had at its last index, -½ … ½ turn in counts: not 0 where counts
   were lost or added since the index that defined the zero. */
int32_t core_angle_at_index(const struct core_access *core, uint32_t head, uint32_t counts_per_rev);
void core_control(const struct core_access *core, bool compensate, bool output,
                  enum core_capture capture);
/* Correction and capture off, the output as it is. */
void core_hold(const struct core_access *core);
/* False in a core that was set up: it was reset since. */
bool core_output_enabled(const struct core_access *core);
struct core_status core_status(const struct core_access *core);
/* A bit a head: the gateware has left it out of the mean. */
uint32_t core_left_out(const struct core_access *core);

/* Of all heads that are not left out. */
bool core_indices_seen(const struct core_access *core);
/* An index of a head was in the wrong place since the faults were cleared. */
bool core_index_error(const struct core_access *core);
/* The same of one head, 0 or 1. */
bool core_head_index_error(const struct core_access *core, uint32_t head);
struct core_header core_capture_header(const struct core_access *core);
struct core_position core_position(const struct core_access *core);
struct core_turns core_turns(const struct core_access *core, uint32_t heads);
void core_release_capture(const struct core_access *core);
/* The interrupt line low, and what raised it forgotten; call before looking at the status. */
void core_acknowledge_interrupt(const struct core_access *core);
/* Of all heads; the fault of the output stays. */
void core_clear_faults(const struct core_access *core);
/* End the fault of the output: it follows from the present position. In the same write the flags of those
   heads that are among `faults`, of enum core_fault, are cleared, and the line drivers are enabled where no fault is left that
   releases them. Only the operator knows whether what the output drives may move. */
void core_clear_output(const struct core_access *core, uint32_t faults);
void core_write_coefficients(const struct core_access *core,
                             const struct coefficients *coefficients);
/* Read the idle bank back; false where a word differs. */
bool core_verify_coefficients(const struct core_access *core,
                              const struct coefficients *coefficients);
/* Lanes that follow a condition, in the last lanes of the bank, and what the conditions need; and whether
   the bank reads back as written. */
void core_write_followed(const struct core_access *core, const struct followed *followed,
                         uint32_t counts_per_rev, uint32_t lanes);
bool core_verify_followed(const struct core_access *core, const struct followed *followed,
                          uint32_t counts_per_rev, uint32_t lanes);
/* Switch off the failover of a core that has one, and wait until no set is being loaded: the prepared sets
   belong to other coefficients than those that come. */
void core_failover_off(const struct core_access *core);
void core_swap(const struct core_access *core);
uint32_t core_swap_count(const struct core_access *core);
uint32_t core_overrun_count(const struct core_access *core);
/* Index marks in the wrong place, illegal transitions and over-speed edges of a head, 0 to 3. */
void core_fault_counters(const struct core_access *core, uint32_t head, uint32_t counters[3]);

#endif
