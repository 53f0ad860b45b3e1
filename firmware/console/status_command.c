/* SPDX-License-Identifier: Apache-2.0 */

#include "status_command.h"

#include <stddef.h>

#include "advice.h"
#include "units.h"

const char status_use[] = "status";

static void status_value(struct console *console, const char *name, uint64_t value) {
    text_word(&console->sink, name);
    text_word(&console->sink, " ");
    text_unsigned(&console->sink, value);
    text_line(&console->sink, "");
}

static void status_word(struct console *console, const char *name, const char *value) {
    text_word(&console->sink, name);
    text_word(&console->sink, " ");
    text_line(&console->sink, value);
}

static void status_fixed(struct console *console, const char *name, double value) {
    text_word(&console->sink, name);
    text_word(&console->sink, " ");
    text_fixed(&console->sink, value, 9);
    text_line(&console->sink, "");
}

static void named_hexadecimal(struct console *console, const char *name, uint32_t value) {
    text_word(&console->sink, name);
    text_word(&console->sink, " 0x");
    text_hexadecimal(&console->sink, value);
    text_line(&console->sink, "");
}

static void advise(struct console *console, const char *name) {
    const char *advice = advice_for(name);
    if (advice != NULL) {
        status_word(console, "advice", advice);
    }
}

static void show_alarms(struct console *console) {
    uint32_t alarms = console->application->report.alarms;
    for (uint32_t bit = 1; bit != 0 && bit <= alarms; bit <<= 1) {
        if (alarms & bit && alarm_name(bit) != NULL) {
            status_word(console, "alarm", alarm_name(bit));
            advise(console, alarm_name(bit));
        }
    }
}

/* Prints each fault that disabled the line drivers, and whether it is still present. */
static void show_released(struct console *console) {
    uint32_t causes = application_release_causes(console->application);
    uint32_t present = application_release_present(console->application);
    if (causes == 0) {
        status_word(console, "released", "none");
        return;
    }
    for (uint32_t bit = 1; bit != 0 && bit <= causes; bit <<= 1) {
        if (causes & bit && core_fault_name(bit) != NULL) {
            text_word(&console->sink, "released ");
            text_word(&console->sink, core_fault_name(bit));
            text_line(&console->sink, present & bit ? ", still present" : "");
        }
    }
    advise(console, "released");
}

static void show_refusals(struct console *console) {
    for (uint32_t reason = 1; reason < REFUSALS; reason++) {
        if (console->application->refusals[reason] != 0) {
            text_word(&console->sink, "refused ");
            status_value(console, refusal_name((enum refusal)reason),
                         console->application->refusals[reason]);
        }
    }
}

static void show_heads(struct console *console) {
    static const char *const names[3] = {"_index_errors ", "_illegals ", "_overspeeds "};
    const struct application *application = console->application;
    for (uint32_t head = 0; head < application->configuration.heads; head++) {
        uint32_t counters[3];
        core_fault_counters(&application->core, head, counters);
        for (uint32_t place = 0; place < 3; place++) {
            text_word(&console->sink, "head");
            text_unsigned(&console->sink, head + 1);
            text_word(&console->sink, names[place]);
            text_unsigned(&console->sink, counters[place]);
            text_line(&console->sink, "");
        }
    }
}

static void show_settings(struct console *console) {
    const struct application *application = console->application;
    status_word(console, "settings", settings_origin_name(application->settings_origin));
    if (application->settings_origin == SETTINGS_LOST) {
        advise(console, "lost");
    }
    if (application->faults_in_a_row != 0) {
        status_value(console, "faults_in_a_row", application->faults_in_a_row);
    }
}

static void show_saved(struct console *console) {
    const struct application *application = console->application;
    status_word(console, "saved", saved_state_name(application->saved_state));
    if (application->saved_state == SAVED_NOT_CONFIRMED) {
        advise(console, "not_confirmed");
    }
    if (application->save != NULL && application->save->found == SAVED_READ) {
        status_value(console, "saved_record", application->save->sequence);
    } else if (application->save != NULL) {
        status_word(console, "saved_record", saved_answer_name(application->save->found));
        advise(console, saved_answer_name(application->save->found));
    }
    if (application->save != NULL && application->save->worn != 0) {
        status_value(console, "saved_worn_sectors", save_worn(application->save));
    }
}

static void show_temperature(struct console *console) {
    const struct table_temperature *table = &console->application->table;
    status_word(console, "thermometer", temperature_source_name(table->source));
    if (table->source == TEMPERATURE_NONE) {
        return;
    }
    status_word(console, "thermometer_state", temperature_state_name(table->state));
    if (table_temperature_is_known(table)) {
        status_fixed(console, "thermometer_c", table->shown_c);
        status_fixed(console, "table_c", table->celsius);
    }
    if (table_temperature_is_held(table)) {
        advise(console, temperature_state_name(table->state));
    }
    status_value(console, "temperature_swaps", console->application->temperature_swaps);
}

static void show_device(struct console *console) {
    const struct application *application = console->application;
    status_word(console, "reset", console->reset_reason ? console->reset_reason : "none");
    if (console->reset_instruction != 0) {
        named_hexadecimal(console, "reset_instruction", console->reset_instruction);
    }
    if (console->fabric != NULL) {
        status_word(console, "fabric", console->fabric());
    }
    show_settings(console);
    show_saved(console);
    show_temperature(console);
    status_value(console, "console_overruns", console->overruns);
    status_value(console, "telemetry_overruns", console->telemetry_overruns);
    status_fixed(console, "longest_step_us", console->longest_step_us);
    status_value(console, "interrupts", application->interrupts);
    status_value(console, "banks_without_interrupt", application->banks_without_interrupt);
}

/* Prints the state of the gateware's failover: its sets, the active set, and the heads that are left out. */
static void show_failover(struct console *console) {
    const struct application *application = console->application;
    if (!application->configuration.has_failover) {
        return;
    }
    const struct core_failover state = core_failover(&application->core);
    status_word(console, "failover", core_failover_is_on(&application->core) ? "on" : "off");
    status_value(console, "active_set", state.set);
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        if ((application->prepared.sets >> head & 1U) != 0) {
            status_value(console, "set_without_head", head + 1);
        }
        if ((state.left_out >> head & 1U) != 0) {
            status_value(console, "left_out", head + 1);
            status_value(console, "left_out_causes", state.causes);
        }
    }
}

/* Prints the delays of the heads, if turns at two speeds have shown them. */
static void show_skew(struct console *console) {
    const struct head_skew *skew = &console->application->skew;
    if (skew->heads == 0) {
        return;
    }
    for (uint32_t head = 1; head < skew->heads; head++) {
        text_word(&console->sink, "head");
        text_unsigned(&console->sink, head + 1);
        status_fixed(console, "_late_ns", skew->late_ns[head]);
    }
    status_fixed(console, "u_late_ns", skew->u_ns);
}

void status_command(struct console *console, char *const *words, uint32_t number) {
    (void)words;
    (void)number;
    const struct application *application = console->application;
    status_word(console, "phase", application_phase_name(application->phase));
    if (application->phase == PHASE_HELD) {
        advise(console, "held");
    }
    show_device(console);
    status_word(console, "compensation",
                application->bypassed ? "bypassed"
                                      : (application_corrects(application) ? "on" : "off"));
    status_word(console, "coefficients", application->frozen ? "frozen" : "free");
    status_word(console, "samples", core_capture_name(application_capture(application)));
    status_value(console, "turns", application->turns);
    status_value(console, "swaps", application->swaps);
    status_value(console, "stuck_captures", application->stuck_captures);
    if (application->turns != 0) {
        status_word(console, "last", turn_result_name(application->report.result));
        status_word(console, "reason", refusal_name(application->report.reason));
        advise(console, refusal_name(application->report.reason));
        status_fixed(console, "noise_arcsec", application->measured.noise_arcsec);
        if (application->report.has_temperature) {
            status_fixed(console, "temperature_c", application->report.temperature_c);
        } else {
            status_word(console, "temperature_c", "absent");
        }
        status_fixed(console, "separation_deg",
                     application->measured.measured_separation_rad * 180.0 / PI);
    }
    show_alarms(console);
    if (application->phase != PHASE_NO_CORE) {
        status_value(console, "lanes", application->configuration.lanes);
        status_word(console, "output_fault", application_output_fault(application));
        advise(console, application_output_fault(application));
        show_released(console);
        status_value(console, "overruns", application->overruns);
        text_word(&console->sink, "head2_zero_counts ");
        text_signed(&console->sink, application->head2_zero);
        text_line(&console->sink, "");
        show_heads(console);
        show_skew(console);
        show_failover(console);
    }
    show_refusals(console);
    text_line(&console->sink, "ok");
}
