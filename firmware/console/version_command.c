/* SPDX-License-Identifier: Apache-2.0 */

#include "version_command.h"

#include <stddef.h>

const char version_use[] = "version: firmware, gateware and the chip's number";

static void version_word(const struct text_sink *sink, const char *name, const char *value) {
    text_word(sink, name);
    text_word(sink, value != NULL ? value : "unknown");
    text_line(sink, "");
}

static void version_value(const struct text_sink *sink, const char *name, uint32_t value) {
    text_word(sink, name);
    text_unsigned(sink, value);
    text_line(sink, "");
}

static void tell_gateware(const struct text_sink *sink, const struct application *application) {
    struct core_origin origin = core_origin(&application->core);
    text_word(sink, "gateware ");
    text_unsigned(sink, origin.major);
    text_word(sink, ".");
    text_unsigned(sink, origin.minor);
    text_word(sink, ".");
    text_unsigned(sink, origin.patch);
    version_value(sink, "\r\nlanes ", application->configuration.lanes);
    version_value(sink, "fold ", origin.fold);
    version_word(sink, "rotation ", origin.has_table ? "table" : "cordic");
    version_value(sink, "capture_depth ", application->configuration.capture_depth);
    version_value(sink, "clock_hz ", application->configuration.clock_hz);
    if (!origin.has_dna) {
        version_word(sink, "dna ", NULL);
        return;
    }
    text_word(sink, "dna 0x");
    text_hexadecimal(sink, (uint32_t)(origin.dna >> 32));
    text_hexadecimal(sink, (uint32_t)origin.dna);
    text_line(sink, "");
}

void version_command(struct console *console, char *const *words, uint32_t number) {
    (void)words;
    (void)number;
    const struct text_sink *sink = &console->sink;
    version_word(sink, "firmware ", console->firmware);
    version_word(sink, "build ", console->build);
    if (console->application->phase == PHASE_NO_CORE) {
        version_word(sink, "gateware ", "none");
    } else {
        tell_gateware(sink, console->application);
    }
    text_word(sink, "ok\r\n");
}
