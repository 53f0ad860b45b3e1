/* SPDX-License-Identifier: Apache-2.0 */

#include "commands.h"

#include <stddef.h>

#include "advice.h"
#include "assertion.h"
#include "dump.h"
#include "flash_command.h"
#include "heads_table.h"
#include "load_commands.h"
#include "parameter_commands.h"
#include "prepared.h"
#include "save_command.h"
#include "units.h"
#include "version_command.h"

typedef void command_action(struct console *console, char *const *words, uint32_t number);

struct command {
    const char *name;
    const char *use;
    /* Least and greatest number of words, including the name. */
    uint32_t least;
    uint32_t most;
    command_action *action;
};

static void named(struct console *console, const char *name, uint64_t value) {
    text_word(&console->sink, name);
    text_word(&console->sink, " ");
    text_unsigned(&console->sink, value);
    text_line(&console->sink, "");
}

static void named_word(struct console *console, const char *name, const char *value) {
    text_word(&console->sink, name);
    text_word(&console->sink, " ");
    text_line(&console->sink, value);
}

static void named_fixed(struct console *console, const char *name, double value) {
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
        named_word(console, "advice", advice);
    }
}

static void show_alarms(struct console *console) {
    uint32_t alarms = console->application->report.alarms;
    for (uint32_t bit = 1; bit != 0 && bit <= alarms; bit <<= 1) {
        if (alarms & bit && alarm_name(bit) != NULL) {
            named_word(console, "alarm", alarm_name(bit));
            advise(console, alarm_name(bit));
        }
    }
}

/* Prints each fault that disabled the line drivers, and whether it is still present. */
static void show_released(struct console *console) {
    uint32_t causes = application_release_causes(console->application);
    uint32_t present = application_release_present(console->application);
    if (causes == 0) {
        named_word(console, "released", "none");
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
            named(console, refusal_name((enum refusal)reason),
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
    named_word(console, "settings", settings_origin_name(application->settings_origin));
    if (application->settings_origin == SETTINGS_LOST) {
        advise(console, "lost");
    }
    if (application->faults_in_a_row != 0) {
        named(console, "faults_in_a_row", application->faults_in_a_row);
    }
}

static void show_saved(struct console *console) {
    const struct application *application = console->application;
    named_word(console, "saved", saved_state_name(application->saved_state));
    if (application->saved_state == SAVED_NOT_CONFIRMED) {
        advise(console, "not_confirmed");
    }
    if (application->save != NULL && application->save->found == SAVED_READ) {
        named(console, "saved_record", application->save->sequence);
    } else if (application->save != NULL) {
        named_word(console, "saved_record", saved_answer_name(application->save->found));
        advise(console, saved_answer_name(application->save->found));
    }
    if (application->save != NULL && application->save->worn != 0) {
        named(console, "saved_worn_sectors", save_worn(application->save));
    }
}

static void show_temperature(struct console *console) {
    const struct table_temperature *table = &console->application->table;
    named_word(console, "thermometer", temperature_source_name(table->source));
    if (table->source == TEMPERATURE_NONE) {
        return;
    }
    named_word(console, "thermometer_state", temperature_state_name(table->state));
    if (table_temperature_is_known(table)) {
        named_fixed(console, "thermometer_c", table->shown_c);
        named_fixed(console, "table_c", table->celsius);
    }
    if (table_temperature_is_held(table)) {
        advise(console, temperature_state_name(table->state));
    }
    named(console, "temperature_swaps", console->application->temperature_swaps);
}

static void show_device(struct console *console) {
    const struct application *application = console->application;
    named_word(console, "reset", console->reset_reason ? console->reset_reason : "none");
    if (console->reset_instruction != 0) {
        named_hexadecimal(console, "reset_instruction", console->reset_instruction);
    }
    if (console->fabric != NULL) {
        named_word(console, "fabric", console->fabric());
    }
    show_settings(console);
    show_saved(console);
    show_temperature(console);
    named(console, "console_overruns", console->overruns);
    named(console, "telemetry_overruns", console->telemetry_overruns);
    named_fixed(console, "longest_step_us", console->longest_step_us);
    named(console, "interrupts", application->interrupts);
    named(console, "banks_without_interrupt", application->banks_without_interrupt);
}

/* Prints for every head, from one clock of the core: its position, its angle from its index mark, and whether it has
   detected this mark. */
static void heads(struct console *console, char *const *words, uint32_t number) {
    const struct application *application = console->application;
    const struct text_sink *sink = &console->sink;
    (void)words;
    (void)number;
    if (application->phase == PHASE_NO_CORE) {
        text_error(sink, "no core", "");
        return;
    }
    (void)core_position(&application->core);
    const struct core_turns turns =
        core_turns(&application->core, application->configuration.heads);
    for (uint32_t head = 0; head < application->configuration.heads; head++) {
        text_word(sink, "head");
        text_unsigned(sink, head + 1);
        text_word(sink, " ");
        text_signed(sink, turns.turn_position[head]);
        text_word(sink, " ");
        text_unsigned(sink, turns.angle[head]);
        text_line(sink, core_head_indexed(&application->core, head) ? " indexed" : " unseen");
    }
    text_line(sink, "ok");
}

/* Prints the state of the gateware's failover: its sets, the active set, and the heads that are left out. */
static void show_failover(struct console *console) {
    const struct application *application = console->application;
    if (!application->configuration.has_failover) {
        return;
    }
    const struct core_failover state = core_failover(&application->core);
    named_word(console, "failover", core_failover_is_on(&application->core) ? "on" : "off");
    named(console, "active_set", state.set);
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        if ((application->prepared.sets >> head & 1U) != 0) {
            named(console, "set_without_head", head + 1);
        }
        if ((state.left_out >> head & 1U) != 0) {
            named(console, "left_out", head + 1);
            named(console, "left_out_causes", state.causes);
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
        named_fixed(console, "_late_ns", skew->late_ns[head]);
    }
    named_fixed(console, "u_late_ns", skew->u_ns);
}

static void status(struct console *console, char *const *words, uint32_t number) {
    (void)words;
    (void)number;
    const struct application *application = console->application;
    named_word(console, "phase", application_phase_name(application->phase));
    if (application->phase == PHASE_HELD) {
        advise(console, "held");
    }
    show_device(console);
    named_word(console, "compensation",
               application->bypassed ? "bypassed"
                                     : (application_corrects(application) ? "on" : "off"));
    named_word(console, "coefficients", application->frozen ? "frozen" : "free");
    named_word(console, "samples", core_capture_name(application_capture(application)));
    named(console, "turns", application->turns);
    named(console, "swaps", application->swaps);
    named(console, "stuck_captures", application->stuck_captures);
    if (application->turns != 0) {
        named_word(console, "last", turn_result_name(application->report.result));
        named_word(console, "reason", refusal_name(application->report.reason));
        advise(console, refusal_name(application->report.reason));
        named_fixed(console, "noise_arcsec", application->measured.noise_arcsec);
        if (application->report.has_temperature) {
            named_fixed(console, "temperature_c", application->report.temperature_c);
        } else {
            named_word(console, "temperature_c", "absent");
        }
        named_fixed(console, "separation_deg",
                    application->measured.measured_separation_rad * 180.0 / PI);
    }
    show_alarms(console);
    if (application->phase != PHASE_NO_CORE) {
        named(console, "lanes", application->configuration.lanes);
        named_word(console, "output_fault", application_output_fault(application));
        advise(console, application_output_fault(application));
        show_released(console);
        named(console, "overruns", application->overruns);
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

static void show_harmonic(struct console *console, uint32_t place) {
    const struct harmonic *harmonic = &console->application->estimate.harmonic[place];
    const struct text_sink *sink = &console->sink;
    const double values[] = {harmonic->cosine, harmonic->sine, harmonic_uncertainty(harmonic)};
    text_unsigned(sink, place + 1);
    for (uint32_t value = 0; value < sizeof values / sizeof values[0]; value++) {
        text_word(sink, " ");
        text_fixed(sink, values[value], 9);
    }
    text_word(sink, " ");
    text_line(&console->sink, verdict_name(console->application->verdicts[place]));
}

static void show_harmonics(struct console *console) {
    text_line(&console->sink, "order cosine_arcsec sine_arcsec uncertainty_arcsec verdict");
    for (uint32_t place = 0; place < console->application->estimate.orders; place++) {
        show_harmonic(console, place);
    }
    text_line(&console->sink, "ok");
}

static void show(struct console *console, char *const *words, uint32_t number) {
    (void)number;
    if (text_equal(words[1], "harmonics")) {
        show_harmonics(console);
    } else if (text_equal(words[1], "parameters")) {
        parameters_show(console, "");
        text_line(&console->sink, "ok");
    } else if (text_equal(words[1], "heads")) {
        heads_table_show(console);
    } else {
        text_error(&console->sink, "expected show harmonics, parameters or heads, not ", words[1]);
    }
}

/* Reads `on` or `off`. Prints an error message and returns false if the word is neither. */
static bool read_switch(struct console *console, const char *word, bool *on) {
    *on = text_equal(word, "on");
    if (!*on && !text_equal(word, "off")) {
        text_error(&console->sink, "expected on or off, not ", word);
        return false;
    }
    return true;
}

static void freeze(struct console *console, char *const *words, uint32_t number) {
    bool on;
    (void)number;
    if (read_switch(console, words[1], &on)) {
        application_freeze(console->application, on);
        text_line(&console->sink, "ok");
    }
}

static void bypass(struct console *console, char *const *words, uint32_t number) {
    bool on;
    (void)number;
    if (read_switch(console, words[1], &on)) {
        application_bypass(console->application, on);
        text_line(&console->sink, "ok");
    }
}

static void telemetry(struct console *console, char *const *words, uint32_t number) {
    bool on;
    (void)number;
    if (read_switch(console, words[1], &on)) {
        application_telemetry(console->application, on);
        text_line(&console->sink, "ok");
    }
}

static void temperature(struct console *console, char *const *words, uint32_t number) {
    struct application *application = console->application;
    double celsius;
    (void)number;
    if (text_equal(words[1], "none")) {
        application_choose_temperature(application, TEMPERATURE_NONE);
        text_line(&console->sink, "ok");
    } else if (text_equal(words[1], "sensor")) {
        if (application->table.read == NULL) {
            text_error(&console->sink, "no thermometer answers", "");
            return;
        }
        application_choose_temperature(application, TEMPERATURE_SENSOR);
        text_line(&console->sink, "ok");
    } else if (!text_parse_decimal(words[1], &celsius)) {
        text_error(&console->sink, "expected a temperature, sensor or none, not ", words[1]);
    } else if (celsius < -55.0 || celsius > 150.0) {
        text_error(&console->sink, "a temperature is -55 to 150, not ", words[1]);
    } else {
        application_tell_temperature(application, celsius);
        text_line(&console->sink, "ok");
    }
}

/* Sets word a or b, the factor of the lanes that follow this word, to a value that the host measures (for example a
   load), in the scale of the coefficient file. */
static void followed_word(struct console *console, char *const *words, uint32_t number) {
    struct application *application = console->application;
    double value;
    bool first = text_equal(words[1], "a");
    (void)number;
    if (!first && !text_equal(words[1], "b")) {
        text_error(&console->sink, "expected a or b, not ", words[1]);
    } else if (!text_parse_decimal(words[2], &value) || !(value >= -1.0 && value <= 1.0)) {
        text_error(&console->sink, "a word is -1 to 1, not ", words[2]);
    } else if (application->phase == PHASE_NO_CORE) {
        text_line(&console->sink, "error: no core");
    } else if (!core_origin(&application->core).has_modulators) {
        text_error(&console->sink, "no_modulators", "");
    } else {
        core_set_word(&application->core, first ? MODULATOR_WORD_A : MODULATOR_WORD_B, value);
        text_line(&console->sink, "ok");
    }
}

static void forget(struct console *console, char *const *words, uint32_t number) {
    (void)words;
    (void)number;
    application_forget(console->application);
    text_line(&console->sink, "ok");
}

static void tell_still_present(struct console *console) {
    uint32_t present = application_release_present(console->application);
    text_word(&console->sink, "error: the line drivers stay released, still present:");
    for (uint32_t bit = 1; bit != 0 && bit <= present; bit <<= 1) {
        if (present & bit && core_fault_name(bit) != NULL) {
            text_word(&console->sink, " ");
            text_word(&console->sink, core_fault_name(bit));
        }
    }
    text_line(&console->sink, "; try help released");
}

static void clear_output(struct console *console, char *const *words, uint32_t number) {
    (void)words;
    (void)number;
    switch (application_clear_output(console->application)) {
    case OUTPUT_CLEARED:
        text_line(&console->sink, "ok, the output follows from the present position");
        break;
    case OUTPUT_DRIVEN:
        text_line(&console->sink, "ok, the line drivers are enabled again");
        break;
    case OUTPUT_NO_FAULT:
        text_error(&console->sink, "the output has no fault", "");
        break;
    case OUTPUT_FAULT_AGAIN:
        text_error(&console->sink, "the output has a fault again; try help output", "");
        break;
    case OUTPUT_STAYS_RELEASED:
        tell_still_present(console);
        break;
    case OUTPUT_NO_CORE:
    default:
        text_error(&console->sink, "no core", "");
    }
}

static void come_back(struct console *console, char *const *words, uint32_t number) {
    (void)number;
    int64_t head;
    if (!console->application->configuration.has_failover) {
        text_error(&console->sink, "this gateware leaves no head out", "");
    } else if (!text_parse_whole(words[1], HEADS_MOST, &head) || head < 1 ||
               !application_come_back(console->application, (uint32_t)head)) {
        text_error(&console->sink, "no head is left out with number ", words[1]);
    } else {
        text_line(&console->sink, "ok, the head is used from its next index on");
    }
}

static void rearm(struct console *console, char *const *words, uint32_t number) {
    (void)words;
    (void)number;
    application_rearm(console->application);
    if (console->application->phase == PHASE_NO_CORE) {
        text_error(&console->sink, "no core answers", "");
        return;
    }
    text_line(&console->sink, "ok, waiting for the index again");
}

static void help(struct console *console, char *const *words, uint32_t number);

static const struct command commands[] = {
    {"help", "help | help WORD: what a command, reason or alarm means, and what to do", 1, 2, help},
    {"status", "status", 1, 1, status},
    {"version", version_use, 1, 1, version_command},
    {"show", "show harmonics | show parameters | show heads: all data of each head", 2, 2, show},
    {"set", set_use, 3, 3, set_command},
    {"trigger", trigger_use, 1, 3, pins_command},
    {"sync", sync_use, 1, 3, pins_command},
    {"probe", probe_use, 1, 3, pins_command},
    {"compare", compare_use, 1, 3, pins_command},
    {"load", load_use, 2, 9, load_command},
    {"save", save_use, 1, 1, save_command},
    {"flash", flash_use, 2, 5, flash_command},
    {"dump", dump_use, 1, 4, dump_command},
    {"temperature",
     "temperature VALUE: degrees Celsius of the table | temperature sensor | temperature none", 2,
     2, temperature},
    {"word", "word a VALUE | word b VALUE: -1 to 1, the factor of the lanes that follow it", 3, 3,
     followed_word},
    {"freeze", "freeze on | freeze off: no calibration becomes active while it is on", 2, 2,
     freeze},
    {"bypass", "bypass on | bypass off: the output follows head 1", 2, 2, bypass},
    {"telemetry", "telemetry on | telemetry off: a line of JSON a turn", 2, 2, telemetry},
    {"forget", "forget: switch the correction off and calibrate anew", 1, 1, forget},
    {"clear_output",
     "clear_output: the output follows again from the present position, its missed counts stay "
     "lost, and released line drivers are enabled: make the servo safe first, and let it look for "
     "its zero afterwards",
     1, 1, clear_output},
    {"come_back", "come_back HEAD: use this left-out head again, from its next index on", 2, 2,
     come_back},
    {"heads",
     "heads: each head's position, angle after its index, indexed or unseen; all at one clock", 1,
     1, heads},
    {"rearm", "rearm: start the core and wait for the index again", 1, 1, rearm},
};

enum { COMMANDS = sizeof commands / sizeof commands[0] };

static void help(struct console *console, char *const *words, uint32_t number) {
    const char *word = number > 1 ? words[1] : NULL;
    bool found = word == NULL;
    for (uint32_t place = 0; place < COMMANDS; place++) {
        if (word == NULL || text_equal(commands[place].name, word)) {
            text_line(&console->sink, commands[place].use);
            found = true;
        }
    }
    if (word != NULL && advice_for(word) != NULL) {
        text_line(&console->sink, advice_for(word));
        found = true;
    }
    if (found) {
        text_line(&console->sink, "ok");
    } else {
        text_error(&console->sink, "no command, reason or alarm ", word);
    }
}

void commands_run(struct console *console, char *const *words, uint32_t number) {
    ASSERT(number > 0 && number <= CONSOLE_WORDS_MOST);
    for (uint32_t place = 0; place < COMMANDS; place++) {
        const struct command *command = &commands[place];
        if (!text_equal(command->name, words[0])) {
            continue;
        }
        if (number < command->least || number > command->most) {
            text_error(&console->sink, "use: ", command->use);
            return;
        }
        command->action(console, words, number);
        return;
    }
    text_error(&console->sink, "no such command, try help: ", words[0]);
}
