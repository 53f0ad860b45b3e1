/* SPDX-License-Identifier: Apache-2.0 */

#include "parameter_commands.h"

#include <stddef.h>
#include <string.h>

#include "assertion.h"

const char set_use[] = "set PARAMETER VALUE";
const char trigger_use[] = "trigger | trigger width CLOCKS: the pulse with each sample";
const char sync_use[] = "sync | sync capture 1: a sample at each edge of sync_in | sync falling 1";
const char probe_use[] =
    "probe: the position at the last edge of probe_in | probe events | probe falling 1";
const char compare_use[] =
    "compare | compare first COUNTS | compare interval COUNTS | compare on 1 | "
    "compare width CLOCKS | compare events 1: "
    "pulses at an angle after the index and at every interval from there";

enum { NAME_MOST = 32 };
/* Largest number of events that one command prints, and longest line of an event: five numbers, the longest with 20
   characters (a sign and 19 digits). */
enum { EVENTS_MOST = 64, EVENT_CHARACTERS_MOST = 64 };

static void show_value(const struct text_sink *sink, const char *name, int64_t value) {
    text_word(sink, name);
    text_signed(sink, value);
    text_line(sink, "");
}

void parameters_show(const struct console *console, const char *beginning) {
    const struct text_sink *sink = &console->sink;
    for (uint32_t place = 0; place < parameters_number(); place++) {
        const struct parameter_description *description = parameters_description(place);
        if (strncmp(description->name, beginning, strlen(beginning)) == 0) {
            double value = parameters_value(&console->application->parameters, place);
            text_word(sink, description->name);
            text_word(sink, " ");
            /* A parameter that is whole, or too large for text_fixed(), is never negative. */
            if (description->whole || value >= TEXT_FIXED_MOST) {
                text_unsigned(sink, (uint64_t)(value + 0.5));
            } else {
                text_fixed(sink, value, 9);
            }
            text_line(sink, "");
        }
    }
}

static void tell_range(const struct text_sink *sink, const char *name,
                       const struct parameter_description *description) {
    text_word(sink, "error: ");
    text_word(sink, name);
    text_word(sink, " takes ");
    text_fixed(sink, description->low, 2);
    text_word(sink, " to ");
    text_unsigned(sink, (uint64_t)description->high);
    text_line(sink, "");
}

static void set_parameter(const struct console *console, const char *name, const char *word) {
    const struct text_sink *sink = &console->sink;
    const struct parameter_description *description = NULL;
    double value;
    if (!text_parse_decimal(word, &value)) {
        text_error(sink, "not a decimal number: ", word);
        return;
    }
    switch (application_set(console->application, name, value, &description)) {
    case PARAMETER_SET:
        text_line(sink,
                  description->effect == EFFECT_REARM ? "ok, waiting for the index again" : "ok");
        break;
    case PARAMETER_OUT_OF_RANGE:
        tell_range(sink, name, description);
        break;
    case PARAMETER_NOT_WHOLE:
        text_error(sink, "expected a whole number, not ", word);
        break;
    case PARAMETER_UNKNOWN:
    default:
        text_error(sink, "no parameter ", name);
    }
}

void set_command(struct console *console, char *const *words, uint32_t number) {
    (void)number;
    set_parameter(console, words[1], words[2]);
}

static void tell_probe(const struct console *console) {
    const struct text_sink *sink = &console->sink;
    struct core_probe probe = core_probe(&console->application->core);
    show_value(sink, "edges ", probe.edges);
    show_value(sink, "time_clocks ", (int64_t)probe.time);
    show_value(sink, "position_counts ", probe.position);
    show_value(sink, "angle_counts ", probe.angle);
}

static void next_number(const struct text_sink *sink, int64_t value) {
    text_word(sink, " ");
    text_signed(sink, value);
}

/* Prints the waiting events for which the port has room; the operator repeats the command for the others. */
static void tell_events(const struct console *console) {
    const struct text_sink *sink = &console->sink;
    const struct core_access *core = &console->application->core;
    struct core_event event;
    if (console->application->phase == PHASE_NO_CORE) {
        text_line(sink, "error: no core");
        return;
    }
    if (!core_has_events(core)) {
        text_error(sink, "the gateware is built without ", "EVENTS");
        return;
    }
    for (uint32_t place = 0; place < EVENTS_MOST && text_has_room(sink, EVENT_CHARACTERS_MOST) &&
                             core_take_event(core, &event);
         place++) {
        text_word(sink, "event");
        next_number(sink, event.number);
        next_number(sink, event.kind);
        next_number(sink, (int64_t)event.time);
        next_number(sink, event.position);
        next_number(sink, event.angle);
        text_line(sink, "");
    }
    text_line(sink, "ok");
}

static void tell_unit(const struct console *console, const char *unit) {
    if (console->application->phase == PHASE_NO_CORE) {
        return;
    }
    if (text_equal(unit, "probe")) {
        tell_probe(console);
    } else if (text_equal(unit, "compare")) {
        bool armed = core_status(&console->application->core).compare_armed;
        text_line(&console->sink, armed ? "armed yes" : "armed no");
    }
}

void pins_command(struct console *console, char *const *words, uint32_t number) {
    char name[NAME_MOST] = {0};
    size_t length = strlen(words[0]);
    ASSERT(length + 1 < NAME_MOST);
    memcpy(name, words[0], length);
    name[length++] = '_';
    if (number == 3) {
        for (const char *next = words[1]; *next != '\0' && length + 1 < NAME_MOST; next++) {
            name[length++] = *next;
        }
        set_parameter(console, name, words[2]);
        return;
    }
    if (number == 2 && text_equal(words[0], "probe") && text_equal(words[1], "events")) {
        tell_events(console);
        return;
    }
    if (number == 2) {
        text_error(&console->sink, "expected a value after ", words[1]);
        return;
    }
    parameters_show(console, name);
    if (!text_equal(words[0], "trigger") && !text_equal(words[0], "compare")) {
        parameters_show(console, "pulse_filter");
    }
    tell_unit(console, words[0]);
    text_line(&console->sink, "ok");
}
