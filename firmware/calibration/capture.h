/* SPDX-License-Identifier: Apache-2.0 */

/* The capture of one turn: where it lies, whether it can be used, its readings. */

#ifndef ARCTRUE_CAPTURE_H
#define ARCTRUE_CAPTURE_H

#include <stdbool.h>
#include <stdint.h>

#include "mean_set.h"
#include "refusal.h"

/* A bank as the sampler hands it over. */
struct capture {
    /* Head 1, head 2, head 1, ...: turn positions in counts, modulo 2^32. Read in place. */
    const volatile int32_t *words;
    uint32_t samples;
    /* The flags of the capture header, as in the register map. */
    uint32_t flags;
    uint32_t counts_per_rev;
    /* What must be added to head 1's first word to have its angle modulo the turn: not 0 once the
       word has wrapped and the turn does not divide 2^32. */
    uint32_t angle_offset;
    /* What head 2's words are ahead of its angle by, counts: not 0 once head 2 lost counts. */
    int32_t head2_zero;
    /* Clocks between two samples; 0: sampled at equal angles. */
    uint32_t period_clocks;
    uint32_t clock_hz;
    uint32_t heads;
    /* Head 3, head 4, head 3, ...; NULL with two heads. With three, head 4's words mean nothing. */
    const volatile int32_t *further;
    /* Of each head at the first sample: its angle, 0 <= angle < counts_per_rev. */
    int32_t start[HEADS_MOST];
};

/* A verified turn: `samples` evenly cover it. */
struct turn {
    const volatile int32_t *words;
    uint32_t samples;
    /* Head 1's first word. */
    int32_t first;
    int32_t counts_per_rev;
    /* Angle of head 1 at the first sample, 0 <= angle < counts_per_rev. */
    int32_t start_angle;
    /* Counts that do not belong to the angle between the heads: what head 2's zero is off by, and
       whole turns between their counters, which mean nothing. */
    int32_t head2_ahead;
    /* Median step of head 1 with its sign. */
    double step_counts;
};

/* One sample. Angles are 0 <= angle < counts_per_rev; `travel` counts from the first sample. */
struct reading {
    int32_t angle1;
    int32_t angle2;
    int32_t travel;
    int32_t difference;
};

/* Where and what, for a message. */
struct capture_fault {
    uint32_t sample;
    uint32_t head;
    int32_t found;
    int32_t expected;
};

/* Counts of both heads that count on where words wrap; modulo the turn they are the angles. */
struct capture_counts {
    int64_t head1;
    int64_t head2;
};

/* The word of head 0, 1, ... */
static inline int32_t capture_word(const struct capture *capture, uint32_t sample, uint32_t head) {
    const volatile int32_t *words = head < 2 ? capture->words : capture->further;
    return words[2 * sample + head % 2];
}

struct capture_counts capture_counts(const struct capture *capture, uint32_t sample);

/* The same of all heads. */
void capture_all_counts(const struct capture *capture, uint32_t sample, int64_t counts[HEADS_MOST]);

/* Of each head's reading against head 1's, 0 <= place < counts_per_rev: the mean over the first `samples`. False: head
   3 or 4 has seen no index, or has a fault. */
bool capture_places(const struct capture *capture, uint32_t samples, double place[HEADS_MOST]);

/* Fill `turn` or say why not. `most_order`: the highest order that the fit will have. */
enum refusal capture_verify(const struct capture *capture, uint32_t most_order, struct turn *turn,
                            struct capture_fault *fault);

/* Heads 3 and 4 of a turn that capture_verify() has found good: indices, faults and steps. */
enum refusal capture_verify_further(const struct capture *capture, const struct turn *turn,
                                    struct capture_fault *fault);

/* Take whole turns out of head 2 less head 1, so that its mean is nearest to the separation;
   returns the mean, rad. */
double turn_align(struct turn *turn, double nominal_separation_rad);

static inline int32_t angle_reduced(int32_t angle, int32_t counts_per_rev) {
    while (angle >= counts_per_rev) {
        angle -= counts_per_rev;
    }
    while (angle < 0) {
        angle += counts_per_rev;
    }
    return angle;
}

static inline int32_t counts_apart(int32_t later, int32_t earlier) {
    return (int32_t)((uint32_t)later - (uint32_t)earlier);
}

static inline struct reading turn_reading(const struct turn *turn, uint32_t sample) {
    int32_t head1 = turn->words[2 * sample];
    int32_t head2 = turn->words[2 * sample + 1];
    struct reading reading;
    reading.travel = counts_apart(head1, turn->first);
    reading.difference = counts_apart(counts_apart(head2, head1), turn->head2_ahead);
    reading.angle1 = angle_reduced(turn->start_angle + reading.travel, turn->counts_per_rev);
    reading.angle2 = angle_reduced(reading.angle1 + reading.difference, turn->counts_per_rev);
    return reading;
}

#endif
