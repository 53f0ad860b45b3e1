/* SPDX-License-Identifier: Apache-2.0 */

/* A copy of a capture, so that the core has its bank back while the console tells it. */

#ifndef ARCTRUE_CAPTURE_COPY_H
#define ARCTRUE_CAPTURE_COPY_H

#include <stdbool.h>
#include <stdint.h>

#include "capture.h"

/* With two heads so many samples of two words of 16 bits, or half as many of 32; with more heads half as many, so that
   of a longer capture every second sample is kept. */
enum { CAPTURE_COPY_SAMPLES = 12288, CAPTURE_COPY_WORDS = 2 * CAPTURE_COPY_SAMPLES };

struct capture_copy {
    /* That are kept. */
    uint32_t samples;
    uint32_t heads;
    uint32_t sequence_number;
    uint32_t counts_per_rev;
    uint32_t clock_hz;
    uint32_t period_clocks;
    uint64_t start_time;
    int32_t separation_udeg;
    bool has_temperature;
    int32_t temperature_cdeg;
    /* Of the first sample. */
    int64_t first[HEADS_MOST];
    /* Few samples are kept whole. */
    bool whole;
    /* The sample that `place` is at. */
    uint32_t place;
    int64_t at;
    /* A word a head and sample, one sample after the other. */
    union {
        /* Counts from the first sample on. */
        int32_t since[CAPTURE_COPY_WORDS / 2];
        /* Step of head 1; another head less head 1, less the first difference. */
        int16_t step[CAPTURE_COPY_WORDS];
    } kept;
};

/* False: a step or a difference does not fit; nothing is copied then. */
bool capture_copy_take(struct capture_copy *copy, const struct capture *capture);

/* Of every head; they count on where words wrap. */
void capture_copy_counts(struct capture_copy *copy, uint32_t sample, int64_t counts[HEADS_MOST]);

#endif
