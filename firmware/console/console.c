/* SPDX-License-Identifier: Apache-2.0 */

#include "console.h"

#include <string.h>

#include "assertion.h"
#include "commands.h"
#include "dump.h"
#include "flash_command.h"
#include "save_command.h"
#include "telemetry.h"

enum { BACKSPACE = 0x08, DELETE = 0x7F, FIRST_PRINTABLE = 0x20, LAST_PRINTABLE = 0x7E };

void console_prepare(struct console *console, struct application *application,
                     const struct text_sink *sink) {
    memset(console, 0, sizeof *console);
    console->application = application;
    console->sink = *sink;
}

static uint32_t split(char *line, char **words) {
    uint32_t number = 0;
    char *next = line;
    while (*next != '\0') {
        if (*next == ' ') {
            *next++ = '\0';
            continue;
        }
        if (number == CONSOLE_WORDS_MOST) {
            return number + 1;
        }
        words[number++] = next;
        while (*next != '\0' && *next != ' ') {
            next++;
        }
    }
    return number;
}

static void run_line(struct console *console) {
    ASSERT(console->length <= CONSOLE_LINE_MOST);
    char *words[CONSOLE_WORDS_MOST];
    console->line[console->length] = '\0';
    uint32_t number = split(console->line, words);
    if (console->spoiled || number > CONSOLE_WORDS_MOST) {
        text_word(&console->sink, "error: the line is too long or is not text; try help\r\n");
    } else if (number > 0) {
        commands_run(console, words, number);
    }
    console->length = 0;
    console->spoiled = false;
}

void console_receive(struct console *console, uint8_t character) {
    ASSERT(console->length <= CONSOLE_LINE_MOST);
    if (character == '\r' || character == '\n') {
        run_line(console);
    } else if (character == BACKSPACE || character == DELETE) {
        console->length -= console->length > 0;
    } else if (character < FIRST_PRINTABLE || character > LAST_PRINTABLE ||
               console->length == CONSOLE_LINE_MOST) {
        console->spoiled = true;
    } else {
        console->line[console->length++] = (char)character;
    }
}

/* Prints the latest turn if the port has room. If a line is left out, the next printed line contains its alarms. */
static void tell_turn(struct console *console) {
    uint32_t alarms = console->application->report.alarms | console->unsent_alarms;
    bool sent = telemetry_turn(&console->sink, console->application, alarms);
    console->telemetry_overruns += !sent;
    console->unsent_alarms = sent ? 0 : alarms;
}

void console_step(struct console *console) {
    struct application *application = console->application;
    dump_step(console);
    save_step_reported(console);
    flash_step_reported(console);
    if (application->report.fresh) {
        application->report.fresh = false;
        if (application->telemetry) {
            tell_turn(console);
        }
        application->report.between_turns = false;
    }
}

bool console_busy(const struct console *console) {
    return dump_can_go_on(console);
}
