/* SPDX-License-Identifier: Apache-2.0 */

#include "dump.h"

#include <stddef.h>

#include "assertion.h"
#include "crc32.h"

const char dump_use[] = "dump: the next turn's capture as CSV, each row with a CRC | dump rows "
                        "FIRST NUMBER: rows again";

/* Number of rows that one step prints; the other work of the firmware runs between two steps. */
enum { ROWS_A_STEP = 8 };
/* Largest numbers of characters in a row: of the row number, the CRC and all separators together, and of the counts of
   one head (64 bits with sign). */
enum { ROW_CHARACTERS_MOST = 24, HEAD_CHARACTERS_MOST = 20 };
#define NO_TEMPERATURE 0x80000000U

static uint32_t crc_of(const uint32_t *words, uint32_t number) {
    uint32_t crc = 0;
    for (uint32_t word = 0; word < number; word++) {
        crc = crc32_add_word(crc, words[word]);
    }
    return crc;
}

static void dump_value(const struct text_sink *sink, const char *name, uint64_t value) {
    text_word(sink, " ");
    text_word(sink, name);
    text_word(sink, "=");
    text_unsigned(sink, value);
}

static void tell_head(const struct text_sink *sink, const struct capture_copy *copy) {
    ASSERT(copy->samples <= CAPTURE_COPY_SAMPLES);
    uint32_t temperature =
        copy->has_temperature ? (uint32_t)copy->temperature_cdeg : NO_TEMPERATURE;
    const uint32_t words[] = {
        copy->sequence_number,
        copy->samples,
        copy->counts_per_rev,
        copy->clock_hz,
        copy->period_clocks,
        (uint32_t)copy->start_time,
        (uint32_t)(copy->start_time >> 32),
        (uint32_t)copy->separation_udeg,
        temperature,
    };
    text_word(sink, "dump");
    dump_value(sink, "sequence", copy->sequence_number);
    dump_value(sink, "samples", copy->samples);
    dump_value(sink, "counts_per_rev", copy->counts_per_rev);
    dump_value(sink, "clock_hz", copy->clock_hz);
    dump_value(sink, "period_clocks", copy->period_clocks);
    dump_value(sink, "start_time", copy->start_time);
    text_word(sink, " separation_deg=");
    text_fixed(sink, copy->separation_udeg / 1e6, 6);
    if (copy->has_temperature) {
        text_word(sink, " temperature_c=");
        text_fixed(sink, copy->temperature_cdeg / 100.0, 2);
    }
    text_word(sink, " crc=");
    text_hexadecimal(sink, crc_of(words, sizeof words / sizeof words[0]));
    text_word(sink, "\r\nrow,");
    for (uint32_t head = 1; head <= copy->heads; head++) {
        text_word(sink, "head");
        text_unsigned(sink, head);
        text_word(sink, "_counts,");
    }
    text_line(sink, "crc");
}

static void tell_row(const struct text_sink *sink, struct capture_copy *copy, uint32_t row) {
    int64_t counts[HEADS_MOST];
    uint32_t words[1 + 2 * HEADS_MOST] = {row};
    capture_copy_counts(copy, row, counts);
    text_unsigned(sink, row);
    for (uint32_t head = 0; head < copy->heads; head++) {
        words[2 * head + 1] = (uint32_t)counts[head];
        words[2 * head + 2] = (uint32_t)((uint64_t)counts[head] >> 32);
        text_word(sink, ",");
        text_signed(sink, counts[head]);
    }
    text_word(sink, ",");
    text_hexadecimal(sink, crc_of(words, 1 + 2 * copy->heads));
    text_line(sink, "");
}

bool dump_busy(const struct console *console) {
    ASSERT(console->dump_place <= console->dump_end);
    return console->dump_place < console->dump_end;
}

bool dump_can_go_on(const struct console *console) {
    if (!dump_busy(console)) {
        return false;
    }
    uint32_t heads = console->application->copy->heads;
    return text_has_room(&console->sink, ROW_CHARACTERS_MOST + heads * HEAD_CHARACTERS_MOST);
}

void dump_step(struct console *console) {
    struct application *application = console->application;
    const struct text_sink *sink = &console->sink;
    struct capture_copy *copy = application->copy;
    if (application->dump == DUMP_NOT_COPIED) {
        application->dump = DUMP_NONE;
        text_word(sink, "error: dump not_copied\r\n");
    } else if (application->dump == DUMP_COPIED) {
        application->dump = DUMP_NONE;
        console->dump_place = 0;
        console->dump_end = copy->samples;
        tell_head(sink, copy);
    }
    if (!dump_busy(console)) {
        return;
    }
    ASSERT(copy != NULL && console->dump_end <= copy->samples);
    for (uint32_t row = 0; row < ROWS_A_STEP && dump_can_go_on(console); row++) {
        tell_row(sink, copy, console->dump_place++);
    }
    if (!dump_busy(console)) {
        text_word(sink, "end of dump\r\n");
    }
}

static void tell_rows_again(struct console *console, char *const *words) {
    const struct capture_copy *copy = console->application->copy;
    int64_t first;
    int64_t number;
    if (!text_parse_whole(words[2], CAPTURE_COPY_SAMPLES, &first) ||
        !text_parse_whole(words[3], CAPTURE_COPY_SAMPLES, &number) || first < 0 || number < 1 ||
        first + number > copy->samples) {
        text_word(&console->sink, "error: no such rows\r\n");
        return;
    }
    console->dump_place = (uint32_t)first;
    console->dump_end = (uint32_t)(first + number);
    text_word(&console->sink, "ok\r\n");
}

void dump_command(struct console *console, char *const *words, uint32_t number) {
    struct application *application = console->application;
    const struct text_sink *sink = &console->sink;
    if (dump_busy(console)) {
        text_word(sink, "error: an earlier dump has not ended\r\n");
    } else if (application->copy == NULL || application->phase == PHASE_NO_CORE) {
        text_word(sink, "error: no core\r\n");
    } else if (number == 4 && text_equal(words[1], "rows")) {
        tell_rows_again(console, words);
    } else if (number != 1) {
        text_error(sink, "use: ", dump_use);
    } else if (application->phase == PHASE_HELD) {
        text_word(sink, "error: nothing is captured in phase held; try help held\r\n");
    } else {
        application_want_dump(application);
        text_word(sink, "ok, with the next turn\r\n");
    }
}
