/* SPDX-License-Identifier: Apache-2.0 */

/* The operator's line on a serial port. Every line gets an answer of its own; what cannot be
   understood gets one line that begins with "error:". */

#ifndef ARCTRUE_CONSOLE_H
#define ARCTRUE_CONSOLE_H

#include "application.h"
#include "image_store.h"
#include "text.h"

enum { CONSOLE_LINE_MOST = 80, CONSOLE_WORDS_MOST = 9 };

/* A word that somebody else knows. */
typedef const char *console_word(void);

struct console {
    struct application *application;
    struct text_sink sink;
    char line[CONSOLE_LINE_MOST + 1];
    uint32_t length;
    /* The line is too long or holds what is no text: it is read to its end and refused. */
    bool spoiled;
    /* Rows of a capture that are still to be told. */
    uint32_t dump_place;
    uint32_t dump_end;
    /* Lines of telemetry for which the port had no room, and their alarms until they are told. */
    uint32_t telemetry_overruns;
    uint32_t untold_alarms;
    /* Times that the port lost characters. */
    uint32_t overruns;
    /* Where boot images are written to; NULL: nowhere. */
    struct image_store *images;
    /* Where the boot ROM found the image that runs, bytes from the flash's beginning. */
    uint32_t started_from;
    /* Version of the firmware and the commit that it was built of; NULL: nobody tells. */
    const char *firmware;
    const char *build;
    /* What the last reset was for; NULL: nothing to tell. */
    const char *reset_reason;
    /* Where the program was then. */
    uint32_t reset_instruction;
    /* What the fabric's configuration came to; NULL: nothing to tell. */
    console_word *fabric;
    /* Longest step of the application; 0 where nobody measures. */
    double longest_step_us;
};

void console_prepare(struct console *console, struct application *application,
                     const struct text_sink *sink);

/* One character from the port; 0 where the port has lost some. */
void console_receive(struct console *console, uint8_t character);

/* What is to be told without being asked: telemetry, and a part of a dump. */
void console_step(struct console *console);
/* There is more to tell at once. */
bool console_busy(const struct console *console);

#endif
