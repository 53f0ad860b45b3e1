/* SPDX-License-Identifier: Apache-2.0 */

/* A copy of a capture, so that the core has its bank back while the console tells it. */

#ifndef ARCTRUE_CAPTURE_COPY_H
#define ARCTRUE_CAPTURE_COPY_H

#include <stdbool.h>
#include <stdint.h>

#include "capture.h"

/* Samples of two words of 16 bits, or half as many of 32. */
enum { CAPTURE_COPY_SAMPLES = 12288 };

struct capture_copy {
    uint32_t samples;
    uint32_t sequence_number;
    uint32_t counts_per_rev;
    uint32_t clock_hz;
    uint32_t period_clocks;
    uint64_t start_time;
    int32_t separation_udeg;
    bool has_temperature;
    int32_t temperature_cdeg;
    /* Of the first sample. */
    struct capture_counts first;
    /* Few samples are kept whole. */
    bool whole;
    /* The sample that `place` is at. */
    uint32_t place;
    struct capture_counts at;
    union {
        /* Counts from the first sample on. */
        int32_t since[CAPTURE_COPY_SAMPLES / 2][2];
        /* Step of head 1; head 2 less head 1, less the first difference. */
        int16_t step[CAPTURE_COPY_SAMPLES][2];
    } kept;
};

/* False: a step or a difference does not fit; nothing is copied then. */
bool capture_copy_take(struct capture_copy *copy, const struct capture *capture);

struct capture_counts capture_copy_counts(struct capture_copy *copy, uint32_t sample);

#endif
