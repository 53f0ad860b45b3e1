/* SPDX-License-Identifier: Apache-2.0 */

#include "console.h"

#include <string.h>

#include "commands.h"
#include "save_command.h"
#include "telemetry.h"

/* Rows of a dump a step: the rest of the firmware goes on in between. */
enum { DUMP_ROWS = 8 };
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

/* Measured now: the turn's own reading comes with its telemetry. */
static void dump_temperature(const struct text_sink *sink, const struct application *application) {
    double celsius;
    if (application->read_temperature != NULL &&
        application->read_temperature(application->temperature_context, &celsius)) {
        text_word(sink, " temperature_c=");
        text_fixed(sink, celsius, 2);
    }
}

static void dump_head(const struct console *console) {
    const struct text_sink *sink = &console->sink;
    const struct application *application = console->application;
    text_word(sink, "dump sequence=");
    text_unsigned(sink, application->header.sequence_number);
    text_word(sink, " samples=");
    text_unsigned(sink, application->capture.samples);
    text_word(sink, " counts_per_rev=");
    text_unsigned(sink, application->capture.counts_per_rev);
    text_word(sink, " clock_hz=");
    text_unsigned(sink, application->capture.clock_hz);
    text_word(sink, " separation_deg=");
    text_fixed(sink, application->parameters.separation_deg, 6);
    dump_temperature(sink, application);
    text_word(sink, "\r\nrun,time_s,head1_counts,head2_counts\r\n");
}

static void dump_row(const struct console *console, uint32_t sample) {
    const struct text_sink *sink = &console->sink;
    const struct capture *capture = &console->application->capture;
    struct capture_counts counts = capture_counts(capture, sample);
    double clocks = (double)console->application->header.start_time +
                    (double)sample * capture->period_clocks;
    text_word(sink, "0,");
    text_fixed(sink, clocks / capture->clock_hz, 9);
    text_word(sink, ",");
    text_signed(sink, counts.head1);
    text_word(sink, ",");
    text_signed(sink, counts.head2);
    text_word(sink, "\r\n");
}

static void dump_step(struct console *console) {
    struct application *application = console->application;
    if (application->dumped == 0) {
        dump_head(console);
    }
    for (uint32_t row = 0; row < DUMP_ROWS && application->dumped < application->capture.samples;
         row++) {
        dump_row(console, application->dumped++);
    }
    if (application->dumped >= application->capture.samples) {
        text_word(&console->sink, "end of dump\r\n");
    }
}

void console_step(struct console *console) {
    struct application *application = console->application;
    if (application->phase == PHASE_DUMP && application->dumped < application->capture.samples) {
        dump_step(console);
    }
    save_step_told(console);
    if (application->report.fresh) {
        application->report.fresh = false;
        if (application->telemetry) {
            telemetry_turn(&console->sink, application);
        }
    }
}
