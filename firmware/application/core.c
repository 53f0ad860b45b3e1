/* SPDX-License-Identifier: Apache-2.0 */

#include "core.h"

#include <stddef.h>

#include "core_registers.h"

/* A fault of head 1 also raises the interrupt, because the firmware must examine lost counts immediately. */
#define INTERRUPTS (BIT(INTERRUPT_ENABLE__CAPTURE_READY) | BIT(INTERRUPT_ENABLE__HEAD1_FAULT))

#define CAPTURE_MODE(mode) ((uint32_t)(mode) << ARCTRUE_REGISTERS__CONTROL__CAPTURE_MODE_bp)

/* Number of register reads that last at least as long as a re-arm: a re-arm takes 128 clocks of the fabric, a read at
   least one clock. */
enum { REARM_READS = 128 };

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
    core_control(core, false, core_output_enabled(core), CAPTURE_OFF);
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
