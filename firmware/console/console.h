/* SPDX-License-Identifier: Apache-2.0 */

/* Executes the commands that the operator sends on a serial port. Each line that contains a word gets one answer. An
   answer that begins with "error:" refuses the line. */

#ifndef ARCTRUE_CONSOLE_H
#define ARCTRUE_CONSOLE_H

#include "application.h"
#include "image_store.h"
#include "text.h"

enum { CONSOLE_LINE_MOST = 80, CONSOLE_WORDS_MOST = 9 };

/* Returns the name of a state; the caller of the console supplies this function. */
typedef const char *console_word(void);

struct console {
    struct application *application;
    struct text_sink sink;
    char line[CONSOLE_LINE_MOST + 1];
    uint32_t length;
    /* True if the line is too long or contains a character that is not text: it is read to its end and refused. */
    bool spoiled;
    /* First row of a capture that is still to be printed, and the row after the last one. */
    uint32_t dump_place;
    uint32_t dump_end;
    /* Lines of telemetry that were left out because the port had no room, and their alarms until they are printed. */
    uint32_t telemetry_overruns;
    uint32_t unsent_alarms;
    /* Number of times that the port lost characters. */
    uint32_t overruns;
    /* The flash that receives boot images; NULL: none. */
    struct image_store *images;
    /* Offset of the running image in the flash, in bytes, as the boot ROM found it. */
    uint32_t started_from;
    /* Version of the firmware and the commit that it was built from; NULL: unknown. */
    const char *firmware;
    const char *build;
    /* Cause of the last reset; NULL: none is reported. */
    const char *reset_reason;
    /* Instruction at which the program was before the reset. */
    uint32_t reset_instruction;
    /* Result of the fabric's configuration; NULL: none is reported. */
    console_word *fabric;
    /* Longest step of the application; 0 if it is not measured. */
    double longest_step_us;
};

void console_prepare(struct console *console, struct application *application,
                     const struct text_sink *sink);

/* Accepts one character from the port; `character` is 0 if the port lost characters. */
void console_receive(struct console *console, uint8_t character);

/* Prints output without a command: telemetry, a part of a dump, and the answers of flash operations that have ended. */
void console_step(struct console *console);
/* Tells whether the console has more to print at once. */
bool console_busy(const struct console *console);

#endif
