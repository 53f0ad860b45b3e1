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
#include "status_command.h"
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

static void temperature_command(struct console *console, char *const *words, uint32_t number) {
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
    {"status", status_use, 1, 1, status_command},
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
     2, temperature_command},
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
