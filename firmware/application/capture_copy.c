/* SPDX-License-Identifier: Apache-2.0 */

#include "capture_copy.h"

#include "assertion.h"

static bool capture_copy_fits(int64_t value) {
    return value >= INT16_MIN && value <= INT16_MAX;
}

static int64_t capture_copy_apart(const struct capture_counts *counts) {
    return counts->head2 - counts->head1;
}

static void capture_copy_whole(struct capture_copy *copy, const struct capture *capture) {
    for (uint32_t sample = 0; sample < capture->samples; sample++) {
        struct capture_counts counts = capture_counts(capture, sample);
        copy->kept.since[sample][0] = (int32_t)(counts.head1 - copy->first.head1);
        copy->kept.since[sample][1] = (int32_t)(counts.head2 - copy->first.head2);
    }
}

static bool capture_copy_steps(struct capture_copy *copy, const struct capture *capture) {
    struct capture_counts before = copy->first;
    for (uint32_t sample = 0; sample < capture->samples; sample++) {
        struct capture_counts counts = capture_counts(capture, sample);
        int64_t step = counts.head1 - before.head1;
        int64_t difference = capture_copy_apart(&counts) - capture_copy_apart(&copy->first);
        if (!capture_copy_fits(step) || !capture_copy_fits(difference)) {
            return false;
        }
        copy->kept.step[sample][0] = (int16_t)step;
        copy->kept.step[sample][1] = (int16_t)difference;
        before = counts;
    }
    return true;
}

bool capture_copy_take(struct capture_copy *copy, const struct capture *capture) {
    copy->samples = 0;
    if (capture->samples == 0 || capture->samples > CAPTURE_COPY_SAMPLES) {
        return false;
    }
    copy->first = capture_counts(capture, 0);
    copy->whole = capture->samples <= CAPTURE_COPY_SAMPLES / 2;
    if (copy->whole) {
        capture_copy_whole(copy, capture);
    } else if (!capture_copy_steps(copy, capture)) {
        return false;
    }
    copy->samples = capture->samples;
    copy->counts_per_rev = capture->counts_per_rev;
    copy->clock_hz = capture->clock_hz;
    copy->period_clocks = capture->period_clocks;
    copy->place = 0;
    copy->at = copy->first;
    return true;
}

/* Steps add up: what comes after the sample before is found at once. */
struct capture_counts capture_copy_counts(struct capture_copy *copy, uint32_t sample) {
    ASSERT(sample < CAPTURE_COPY_SAMPLES);
    if (copy->whole) {
        return (struct capture_counts){
            copy->first.head1 + copy->kept.since[sample][0],
            copy->first.head2 + copy->kept.since[sample][1],
        };
    }
    if (sample < copy->place) {
        copy->place = 0;
        copy->at = copy->first;
    }
    while (copy->place < sample) {
        copy->at.head1 += copy->kept.step[++copy->place][0];
    }
    copy->at.head2 = copy->at.head1 + capture_copy_apart(&copy->first) + copy->kept.step[sample][1];
    return copy->at;
}
