/* SPDX-License-Identifier: Apache-2.0 */

#include "capture.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "arctrue_number_formats.h"
#include "arctrue_registers.h"
#include "assertion.h"
#include "separation.h"
#include "units.h"

/* Tolerance of a step as a share of the median of its turn. A step of few counts may differ by one count, because of
   rounding. */
#define STEP_TOLERANCE 0.10
#define STEP_ROUNDING_COUNTS 1.0
/* Multiple of the median above which a step is a jump: no table moves two steps in the time of one step. */
#define JUMP_STEPS 2.0
/* Tolerance of the interval between two samples when the counts are compared with the limit of one edge per clock. */
#define INTERVAL_TOLERANCE_S 1e-6

#define FLAG(name) ((uint32_t)ARCTRUE_REGISTERS__CAPTURE_HEADER__FLAGS__##name##_bm)
#define FLAG_PLACE(name) ARCTRUE_REGISTERS__CAPTURE_HEADER__FLAGS__##name##_bp

static enum refusal verify_header(const struct capture *capture) {
    uint32_t flags = capture->flags;
    uint32_t both_seen = FLAG(INDEX_SEEN1) | FLAG(INDEX_SEEN2);
    if (capture->samples == 0 || capture->words == NULL) {
        return REFUSED_EMPTY;
    }
    if ((flags & both_seen) != both_seen) {
        return REFUSED_INDEX_NOT_SEEN;
    }
    if (flags & (FLAG(INDEX_ERROR1) | FLAG(INDEX_ERROR2))) {
        return REFUSED_INDEX_ERROR;
    }
    if (flags & (FLAG(ILLEGAL1) | FLAG(ILLEGAL2))) {
        return REFUSED_ILLEGAL_TRANSITION;
    }
    if (flags & (FLAG(OVERSPEED1) | FLAG(OVERSPEED2))) {
        return REFUSED_EDGE_SPACING;
    }
    return (flags & FLAG(FULL_BEFORE_TURN)) != 0 ? REFUSED_BANK_FULL : NOT_REFUSED;
}

enum { BINS = 256 };

static int32_t step_of(const struct capture *capture, uint32_t head, uint32_t step) {
    return counts_apart(capture_word(capture, step + 1, head), capture_word(capture, step, head));
}

struct extent {
    int32_t low;
    int32_t high;
};

static struct extent step_extent(const struct capture *capture, uint32_t head) {
    struct extent extent = {INT32_MAX, INT32_MIN};
    int32_t before = capture_word(capture, 0, head);
    for (uint32_t sample = 1; sample < capture->samples; sample++) {
        int32_t word = capture_word(capture, sample, head);
        int32_t counts = counts_apart(word, before);
        extent.low = counts < extent.low ? counts : extent.low;
        extent.high = counts > extent.high ? counts : extent.high;
        before = word;
    }
    return extent;
}

/* Divides `extent` into intervals of 2^shift values, and counts the steps of a head in each interval. */
static void count_steps(const struct capture *capture, uint32_t head, struct extent extent,
                        unsigned shift, uint16_t bins[BINS]) {
    uint32_t width = (uint32_t)extent.high - (uint32_t)extent.low;
    int32_t before = capture_word(capture, 0, head);
    memset(bins, 0, BINS * sizeof bins[0]);
    for (uint32_t sample = 1; sample < capture->samples; sample++) {
        int32_t word = capture_word(capture, sample, head);
        uint32_t above = (uint32_t)counts_apart(word, before) - (uint32_t)extent.low;
        before = word;
        if (above <= width) {
            bins[above >> shift]++;
        }
    }
}

/* Returns the step of rank `rank` (0 is the least) by narrowing an interval of values: a sorted copy would take as
   much memory as the capture, whose words are slow to read. */
static int32_t step_of_rank(const struct capture *capture, uint32_t head, struct extent extent,
                            uint32_t rank) {
    uint16_t bins[BINS];
    while (extent.low < extent.high) {
        uint32_t width = (uint32_t)extent.high - (uint32_t)extent.low;
        unsigned shift = 0;
        uint32_t bin = 0;
        while (width >> shift >= BINS) {
            shift++;
        }
        count_steps(capture, head, extent, shift, bins);
        /* The search ends at the last interval even if words of the capture change while they are read. */
        while (bin < BINS - 1 && rank >= bins[bin]) {
            rank -= bins[bin++];
        }
        uint32_t low = (uint32_t)extent.low + (bin << shift);
        uint32_t last = low + ((1U << shift) - 1);
        bool ends_inside = last - (uint32_t)extent.low < width;
        extent.low = (int32_t)low;
        extent.high = ends_inside ? (int32_t)last : extent.high;
    }
    return extent.low;
}

/* Returns the median of the steps; if their number is even, the mean of the two middle steps. */
static double median_step(const struct capture *capture, uint32_t head) {
    struct extent extent = step_extent(capture, head);
    uint32_t steps = capture->samples - 1;
    double low = step_of_rank(capture, head, extent, (steps - 1) / 2);
    if (steps % 2 == 1) {
        return low;
    }
    return 0.5 * (low + step_of_rank(capture, head, extent, steps / 2));
}

static bool find_wrong_step(const struct capture *capture, uint32_t head, double median,
                            struct capture_fault *fault) {
    double allowed = fmax(STEP_TOLERANCE * fabs(median), STEP_ROUNDING_COUNTS);
    for (uint32_t step = 0; step + 1 < capture->samples; step++) {
        int32_t counts = step_of(capture, head, step);
        if (fabs((double)counts - median) > allowed) {
            *fault = (struct capture_fault){step + 1, head + 1, counts, (int32_t)median};
            return true;
        }
    }
    return false;
}

static enum refusal kind_of_step(const struct capture_fault *fault, double median) {
    if (fabs((double)fault->found) > JUMP_STEPS * fabs(median)) {
        return REFUSED_JUMP;
    }
    return (double)fault->found * median < 0.0 ? REFUSED_REVERSAL : REFUSED_WRONG_STEP;
}

/* Checks the steps of both heads; if both have a fault, reports the one at the earlier sample. */
static enum refusal verify_steps(const struct capture *capture, const double median[2],
                                 struct capture_fault *fault) {
    struct capture_fault found[2] = {{0}};
    bool wrong[2];
    for (uint32_t head = 0; head < 2; head++) {
        if (median[head] == 0.0) {
            fault->head = head + 1;
            return REFUSED_STANDS_STILL;
        }
        wrong[head] = find_wrong_step(capture, head, median[head], &found[head]);
    }
    if (!wrong[0] && !wrong[1]) {
        return (median[0] > 0.0) == (median[1] > 0.0) ? NOT_REFUSED : REFUSED_INCONSISTENT_HEADS;
    }
    uint32_t first = !wrong[0] || (wrong[1] && found[1].sample < found[0].sample);
    *fault = found[first];
    return kind_of_step(fault, median[first]);
}

static bool faster_than_an_edge_a_clock(const struct capture *capture,
                                        struct capture_fault *fault) {
    double most = (double)capture->period_clocks + capture->clock_hz * INTERVAL_TOLERANCE_S;
    for (uint32_t step = 0; capture->period_clocks && step + 1 < capture->samples; step++) {
        int32_t counts = step_of(capture, 0, step);
        if (fabs((double)counts) > most) {
            *fault = (struct capture_fault){step + 1, 1, counts, (int32_t)fmin(most, INT32_MAX)};
            return true;
        }
    }
    return false;
}

static enum refusal verify_speed(const struct capture *capture, double median, uint32_t most_order,
                                 struct capture_fault *fault) {
    if (fabs(median) * (2.0 * most_order + 2.0) > capture->counts_per_rev) {
        *fault = (struct capture_fault){1, 1, (int32_t)median, 0};
        return REFUSED_OVER_SPEED;
    }
    return faster_than_an_edge_a_clock(capture, fault) ? REFUSED_OVER_SPEED : NOT_REFUSED;
}

static double travel_of(const struct capture *capture, uint32_t sample) {
    return fabs((double)counts_apart(capture->words[2 * sample], capture->words[0]));
}

/* Counts the samples of the whole turn; the sample that closes it belongs to the next turn. */
static enum refusal verify_travel(const struct capture *capture, double step, uint32_t *samples) {
    double turn = capture->counts_per_rev;
    /* A turn of K samples ends one step after its last sample; the tolerance is half a step. */
    double turns = floor((travel_of(capture, capture->samples - 1) + 1.5 * fabs(step)) / turn);
    if (turns < 1.0) {
        return REFUSED_SHORT_OF_A_TURN;
    }
    if (turns > 1.0) {
        return REFUSED_MORE_THAN_A_TURN;
    }
    *samples = 0;
    for (uint32_t sample = 0; sample < capture->samples; sample++) {
        *samples += travel_of(capture, sample) < turn - 0.5 * fabs(step);
    }
    return NOT_REFUSED;
}

struct capture_counts capture_counts(const struct capture *capture, uint32_t sample) {
    int32_t head1 = capture->words[2 * sample];
    int32_t head2 = capture->words[2 * sample + 1];
    int32_t first = capture->words[0];
    struct capture_counts counts;
    counts.head1 = (int64_t)first + capture->angle_offset + counts_apart(head1, first);
    counts.head2 = counts.head1 + counts_apart(counts_apart(head2, head1), capture->head2_zero);
    return counts;
}

void capture_all_counts(const struct capture *capture, uint32_t sample,
                        int64_t counts[HEADS_MOST]) {
    struct capture_counts both = capture_counts(capture, sample);
    counts[0] = both.head1;
    counts[1] = both.head2;
    for (uint32_t head = 2; head < capture->heads; head++) {
        int32_t first = capture_word(capture, 0, head);
        counts[head] = (int64_t)capture->start[head] +
                       counts_apart(capture_word(capture, sample, head), first);
    }
}

/* Checks the flags of head 3 and, with four heads, of head 4. */
static enum refusal verify_further_flags(const struct capture *capture) {
    uint32_t heads = (1U << (capture->heads - 2)) - 1U;
    uint32_t seen = (capture->flags & FLAG(FURTHER_INDEX_SEEN)) >> FLAG_PLACE(FURTHER_INDEX_SEEN);
    if (capture->further == NULL || (seen & heads) != heads) {
        return REFUSED_INDEX_NOT_SEEN;
    }
    if (capture->flags & FLAG(FURTHER_INDEX_ERROR)) {
        return REFUSED_INDEX_ERROR;
    }
    if (capture->flags & FLAG(FURTHER_ILLEGAL)) {
        return REFUSED_ILLEGAL_TRANSITION;
    }
    return (capture->flags & FLAG(FURTHER_OVERSPEED)) != 0 ? REFUSED_EDGE_SPACING : NOT_REFUSED;
}

enum refusal capture_verify_further(const struct capture *capture, const struct turn *turn,
                                    struct capture_fault *fault) {
    enum refusal flagged = capture->heads > 2 ? verify_further_flags(capture) : NOT_REFUSED;
    if (flagged != NOT_REFUSED) {
        return flagged;
    }
    for (uint32_t head = 2; head < capture->heads; head++) {
        double median = median_step(capture, head);
        fault->head = head + 1;
        if (median == 0.0) {
            return REFUSED_STANDS_STILL;
        }
        if (find_wrong_step(capture, head, median, fault)) {
            return kind_of_step(fault, median);
        }
        if (median * turn->step_counts < 0.0) {
            return REFUSED_INCONSISTENT_HEADS;
        }
    }
    *fault = (struct capture_fault){0};
    return NOT_REFUSED;
}

/* Sums the changes of the difference of two heads as integers. Each change is less than two turns, so 64 bits hold the
   sum. */
bool capture_places(const struct capture *capture, uint32_t samples, double place[HEADS_MOST]) {
    int64_t turn = capture->counts_per_rev;
    ASSERT(samples > 0 && turn > 0 && capture->heads <= HEADS_MOST);
    place[0] = 0.0;
    for (uint32_t head = 1; head < capture->heads; head++) {
        int32_t apart_first = counts_apart(capture_word(capture, 0, head), capture->words[0]);
        int64_t sum = 0;
        for (uint32_t sample = 0; sample < samples; sample++) {
            int32_t apart =
                counts_apart(capture_word(capture, sample, head), capture->words[2 * sample]);
            sum += counts_apart(apart, apart_first);
        }
        double mean = (double)sum / samples + capture->start[head] - capture->start[0];
        place[head] = mean - (double)turn * floor(mean / (double)turn);
    }
    return capture->heads <= 2 || verify_further_flags(capture) == NOT_REFUSED;
}

/* Integrates the difference over the travel of head 1 by the trapezoidal rule, which converges fast for a whole period.
   The samples are a closed turn, so the sample before the first one is the last one, a turn earlier. */
void capture_offsets(const struct capture *capture, const struct turn *turn, uint32_t heads,
                     double offset_rad[HEADS_MOST]) {
    int32_t signed_turn = turn->step_counts > 0.0 ? turn->counts_per_rev : -turn->counts_per_rev;
    ASSERT(turn->samples > 1 && heads <= HEADS_MOST);
    offset_rad[0] = 0.0;
    for (uint32_t head = 1; head < heads; head++) {
        int32_t apart_first = counts_apart(capture_word(capture, 0, head), capture->words[0]);
        int32_t last = counts_apart(capture->words[2 * (turn->samples - 1)], capture->words[0]);
        int32_t before = last - signed_turn;
        int32_t here = 0;
        double sum = 0.0;
        for (uint32_t sample = 0; sample < turn->samples; sample++) {
            bool ends = sample + 1 == turn->samples;
            int32_t after = ends
                                ? signed_turn
                                : counts_apart(capture->words[2 * (sample + 1)], capture->words[0]);
            int32_t apart = counts_apart(capture_word(capture, sample, head),
                                         (int32_t)((uint32_t)capture->words[0] + (uint32_t)here));
            sum += (double)counts_apart(apart, apart_first) * ((double)after - before);
            before = here;
            here = after;
        }
        int32_t slip = head == 1 ? capture->head2_zero : 0;
        double mean = sum / 2.0 / signed_turn + capture->start[head] - capture->start[0];
        offset_rad[head] = remainder_of_turn((mean - slip) / turn->counts_per_rev * 2.0 * PI);
    }
}

static int32_t start_angle(const struct capture *capture) {
    int64_t angle = capture_counts(capture, 0).head1 % capture->counts_per_rev;
    return (int32_t)(angle < 0 ? angle + capture->counts_per_rev : angle);
}

enum refusal capture_verify(const struct capture *capture, uint32_t most_order, struct turn *turn,
                            struct capture_fault *fault) {
    *fault = (struct capture_fault){0};
    enum refusal reason = verify_header(capture);
    if (reason != NOT_REFUSED) {
        return reason;
    }
    if (capture->samples < 2) {
        return REFUSED_SHORT_OF_A_TURN;
    }
    const double median[2] = {median_step(capture, 0), median_step(capture, 1)};
    reason = verify_steps(capture, median, fault);
    if (reason == NOT_REFUSED) {
        reason = verify_speed(capture, median[0], most_order, fault);
    }
    if (reason != NOT_REFUSED) {
        return reason;
    }
    *turn = (struct turn){
        .words = capture->words,
        .first = capture->words[0],
        .counts_per_rev = (int32_t)capture->counts_per_rev,
        .start_angle = start_angle(capture),
        .head2_ahead = capture->head2_zero,
        .step_counts = median[0],
    };
    return verify_travel(capture, median[0], &turn->samples);
}

double turn_align(struct turn *turn, double nominal_separation_rad) {
    ASSERT(turn->samples > 0 && turn->counts_per_rev > 0);
    int64_t sum = 0;
    for (uint32_t sample = 0; sample < turn->samples; sample++) {
        int32_t apart = counts_apart(turn->words[2 * sample + 1], turn->words[2 * sample]);
        sum += counts_apart(apart, turn->head2_ahead);
    }
    double mean_turns = (double)sum / turn->samples / turn->counts_per_rev;
    double whole = rint(mean_turns - nominal_separation_rad / (2.0 * PI));
    uint32_t whole_counts = (uint32_t)((int64_t)whole * turn->counts_per_rev);
    turn->head2_ahead = (int32_t)((uint32_t)turn->head2_ahead + whole_counts);
    return (mean_turns - whole) * 2.0 * PI;
}
