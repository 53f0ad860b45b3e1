/* SPDX-License-Identifier: Apache-2.0 */

/* Stores a copy of a capture, so that the core gets its bank back while the console prints the copy. */

#ifndef ARCTRUE_CAPTURE_COPY_H
#define ARCTRUE_CAPTURE_COPY_H

#include <stdbool.h>
#include <stdint.h>

#include "capture.h"

/* Capacity of the copy. With two heads it holds 12,288 samples of two 16-bit words, or 6,144 samples of two 32-bit
   words; with more heads it holds half as many samples. A longer capture of two heads is not copied. If a capture of
   more heads is longer, every second sample is copied, provided that these samples fit. */
enum { CAPTURE_COPY_SAMPLES = 12288, CAPTURE_COPY_WORDS = 2 * CAPTURE_COPY_SAMPLES };

struct capture_copy {
    /* Number of kept samples. */
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
    /* Counts of the first sample, one per head. */
    int64_t first[HEADS_MOST];
    /* True if the words have 32 bits; the copy uses them if the capture has few samples. */
    bool whole;
    /* Last sample that capture_copy_counts() has read, and head 1's counts at this sample. */
    uint32_t place;
    int64_t at;
    /* One word per head, sample after sample. */
    union {
        /* Counts since the first sample. */
        int32_t since[CAPTURE_COPY_WORDS / 2];
        /* Head 1: step since the previous sample. Other heads: head's counts minus head 1's counts, minus the value of
           this difference at the first sample. */
        int16_t step[CAPTURE_COPY_WORDS];
    } kept;
};

/* Copies the capture. Makes no copy and returns false if the capture is empty or too long, or if a step or difference
   does not fit into its word. */
bool capture_copy_take(struct capture_copy *copy, const struct capture *capture);

/* Computes the counts of every head at `sample`; unlike the words, the counts do not wrap. */
void capture_copy_counts(struct capture_copy *copy, uint32_t sample, int64_t counts[HEADS_MOST]);

#endif
