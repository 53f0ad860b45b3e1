/* SPDX-License-Identifier: Apache-2.0 */

#include "capture_copy.h"

#include <string.h>

#include "assertion.h"

static bool capture_copy_fits(int64_t value) {
    return value >= INT16_MIN && value <= INT16_MAX;
}

static void capture_copy_whole(struct capture_copy *copy, const struct capture *capture,
                               uint32_t every) {
    int32_t *word = copy->kept.since;
    for (uint32_t sample = 0; sample < copy->samples; sample++) {
        int64_t counts[HEADS_MOST];
        capture_all_counts(capture, sample * every, counts);
        for (uint32_t head = 0; head < copy->heads; head++) {
            *word++ = (int32_t)(counts[head] - copy->first[head]);
        }
    }
}

static bool capture_copy_steps(struct capture_copy *copy, const struct capture *capture,
                               uint32_t every) {
    int64_t before = copy->first[0];
    int16_t *word = copy->kept.step;
    for (uint32_t sample = 0; sample < copy->samples; sample++) {
        int64_t counts[HEADS_MOST];
        capture_all_counts(capture, sample * every, counts);
        int64_t travel = counts[0] - copy->first[0];
        for (uint32_t head = 0; head < copy->heads; head++) {
            int64_t value =
                head == 0 ? counts[0] - before : counts[head] - copy->first[head] - travel;
            if (!capture_copy_fits(value)) {
                return false;
            }
            *word++ = (int16_t)value;
        }
        before = counts[0];
    }
    return true;
}

bool capture_copy_take(struct capture_copy *copy, const struct capture *capture) {
    copy->samples = 0;
    uint32_t most = capture->heads > 2 ? CAPTURE_COPY_SAMPLES / 2 : CAPTURE_COPY_SAMPLES;
    uint32_t every = capture->heads > 2 && capture->samples > most ? 2 : 1;
    uint32_t samples = (capture->samples + every - 1) / every;
    if (samples == 0 || samples > most) {
        return false;
    }
    copy->samples = samples;
    copy->heads = capture->heads;
    capture_all_counts(capture, 0, copy->first);
    copy->whole = samples <= most / 2;
    if (copy->whole) {
        capture_copy_whole(copy, capture, every);
    } else if (!capture_copy_steps(copy, capture, every)) {
        copy->samples = 0;
        return false;
    }
    copy->counts_per_rev = capture->counts_per_rev;
    copy->clock_hz = capture->clock_hz;
    copy->period_clocks = capture->period_clocks * every;
    copy->place = 0;
    copy->at = copy->first[0];
    return true;
}

/* Sums head 1's stored steps up to `sample`; the counts of the other heads are stored as differences from head 1's
   counts. The sum continues from the sample of the previous call, unless `sample` lies before that sample. */
void capture_copy_counts(struct capture_copy *copy, uint32_t sample, int64_t counts[HEADS_MOST]) {
    uint32_t heads = copy->heads;
    ASSERT(sample < copy->samples && heads <= HEADS_MOST);
    memcpy(counts, copy->first, sizeof copy->first);
    if (copy->whole) {
        for (uint32_t head = 0; head < heads; head++) {
            counts[head] += copy->kept.since[sample * heads + head];
        }
        return;
    }
    if (sample < copy->place) {
        copy->place = 0;
        copy->at = copy->first[0];
    }
    while (copy->place < sample) {
        copy->at += copy->kept.step[++copy->place * heads];
    }
    for (uint32_t head = 1; head < heads; head++) {
        counts[head] += copy->at - copy->first[0] + copy->kept.step[sample * heads + head];
    }
    counts[0] = copy->at;
}
