/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the capture of one turn, checks whether the calibration can use it, and computes its readings. */

#ifndef ARCTRUE_CAPTURE_H
#define ARCTRUE_CAPTURE_H

#include <stdbool.h>
#include <stdint.h>

#include "mean_set.h"
#include "refusal.h"

/* Samples of one turn in a memory bank, as the core's sampler delivers them. */
struct capture {
    /* Turn positions of head 1, head 2, head 1, ... in counts, modulo 2^32. They are read in place. */
    const volatile int32_t *words;
    uint32_t samples;
    /* Flags of the capture header, as in the register map. */
    uint32_t flags;
    uint32_t counts_per_rev;
    /* Angle of head 1 at the first sample minus its first word, modulo the turn. It is not 0 once the word has wrapped
       and the turn does not divide 2^32. */
    uint32_t angle_offset;
    /* Counts by which head 2's words exceed the angle of head 2; not 0 once head 2 has lost counts. */
    int32_t head2_zero;
    /* Clocks between two samples; 0: the samples are not at equal times, but at equal angles or at edges of sync_in. */
    uint32_t period_clocks;
    /* Mean speed of head 1 from the first sample until the bank was read, counts per clock; 0: not known. */
    double mean_speed;
    uint32_t clock_hz;
    uint32_t heads;
    /* Turn positions of head 3, head 4, head 3, ...; NULL with two heads. With three heads the words of head 4 are
       meaningless. */
    const volatile int32_t *further;
    /* Angle of each head at the first sample, 0 <= angle < counts_per_rev. */
    int32_t start[HEADS_MOST];
    /* Counts by which each head moved from the first to the last sample. */
    int32_t travel[HEADS_MOST];
};

/* A verified turn of `samples` samples; the sample that closes the turn is not counted. */
struct turn {
    const volatile int32_t *words;
    uint32_t samples;
    /* Head 1's first word. */
    int32_t first;
    int32_t counts_per_rev;
    /* Angle of head 1 at the first sample, 0 <= angle < counts_per_rev. */
    int32_t start_angle;
    /* Counts in the difference of the heads' words that do not belong to the angle between them: the error of head
       2's zero, and whole turns between the counters, which are meaningless. */
    int32_t head2_ahead;
    /* Median step of head 1, signed. */
    double step_counts;
};

/* One sample. Angles are 0 <= angle < counts_per_rev; `travel` counts from the first sample. */
struct reading {
    int32_t angle1;
    int32_t angle2;
    int32_t travel;
    int32_t difference;
};

/* Place and values of a fault, for a message. */
struct capture_fault {
    uint32_t sample;
    uint32_t head;
    int32_t found;
    int32_t expected;
};

/* Counts of both heads; unlike the words, they do not wrap. Modulo the counts of a turn they are the angles. */
struct capture_counts {
    int64_t head1;
    int64_t head2;
};

/* Returns the word of a head, counted from 0. */
static inline int32_t capture_word(const struct capture *capture, uint32_t sample, uint32_t head) {
    const volatile int32_t *words = head < 2 ? capture->words : capture->further;
    return words[2 * sample + head % 2];
}

struct capture_counts capture_counts(const struct capture *capture, uint32_t sample);

/* Sets the counts of all heads; capture_counts() returns the counts of the first two. */
void capture_all_counts(const struct capture *capture, uint32_t sample, int64_t counts[HEADS_MOST]);

/* Computes the place of each head: the mean over the first `samples` samples of the head's reading minus head 1's
   reading, 0 <= place < counts_per_rev. Returns false if head 3 or 4 has seen no index or has a fault. */
bool capture_places(const struct capture *capture, uint32_t samples, double place[HEADS_MOST]);

/* Computes the mean of each of the first `heads` heads minus head 1 over one turn of head 1's reading, rad, within half
   a turn. A mean over the reading and not over the samples does not change with the speed within the turn, so that turns
   of other speeds and directions can be compared. */
void capture_offsets(const struct capture *capture, const struct turn *turn, uint32_t heads,
                     double offset_rad[HEADS_MOST]);

/* Verifies a capture and fills `turn`, or returns the reason why the calibration cannot use the capture. `most_order`:
   highest order that will be fitted. */
enum refusal capture_verify(const struct capture *capture, uint32_t most_order, struct turn *turn,
                            struct capture_fault *fault);

/* Verifies indices, faults and steps of heads 3 and 4 in a turn that capture_verify() has accepted. */
enum refusal capture_verify_further(const struct capture *capture, const struct turn *turn,
                                    struct capture_fault *fault);

/* Removes whole turns from head 2 minus head 1, so that the mean is nearest to the nominal separation; returns the
   mean, rad. */
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
