/* SPDX-License-Identifier: Apache-2.0 */

#include "line_phase.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"
#include "vector.h"

/* Standard deviation of the slip of a line (a harmonic whose order is not an integer) in one turn, divided by the
   line's order; turns. */
#define SLIP 0.001
/* Standard deviation of K before the first turn, which is far larger than any error of a table. K and c are defined in
   line_phase.h. */
#define START_ARCSEC 1e4
/* Least |c| as a share of the loaded amplitude: below half, the lane would add more error than it removes. */
#define LEAST_SIZE 0.5
#define SIGMAS 3.0
/* Largest standard uncertainty of c divided by |c|: twice this uncertainty is then a quarter of the line's
   amplitude. */
#define LARGEST_SHARE 0.125
#define TURN_STEPS ((double)(1ULL << ARCTRUE_PHASE_STEP_WIDTH))

/* LEAST_TURNS is the number of turns before a phase counts as known; two turns determine K and c. */
enum { LEAST_TURNS = 4, RE_K = 0, RE_C = 2, IM_C = 3 };

/* Sums over the samples to which the core gives one turn number: their shares of the turn, and the shares times e^{-2 j
   nu theta}. */
struct part {
    double share;
    struct vector twice;
};

struct sums {
    struct vector total;
    /* Sums for the turn before that of the first sample, for the first sample's turn, and for the turn after it. */
    struct part part[3];
};

static struct sums line_sums(const struct line_sought *line, const struct turn *turn,
                             double separation_counts) {
    struct sums sums = {.total = {0.0, 0.0}};
    double per_rev = turn->counts_per_rev;
    double way = turn->step_counts > 0.0 ? 1.0 : -1.0;
    double before = turn_reading(turn, turn->samples - 1).travel - way * per_rev;
    for (uint32_t sample = 0; sample < turn->samples; sample++) {
        const struct reading reading = turn_reading(turn, sample);
        double after = sample + 1 < turn->samples ? turn_reading(turn, sample + 1).travel
                                                  : turn_reading(turn, 0).travel + way * per_rev;
        double share = 0.5 * way * (after - before) / per_rev;
        double place = line->order * reading.angle1 / per_rev;
        const struct vector wave = vector_unit(-2.0 * PI * (place - floor(place)));
        const struct vector part = vector_scaled(wave, share);
        int32_t gone = turn->start_angle + reading.travel;
        uint32_t number = gone < 0 ? 0U : gone < turn->counts_per_rev ? 1U : 2U;
        sums.total =
            vector_sum(sums.total, vector_scaled(part, reading.difference - separation_counts));
        sums.part[number].share += share;
        sums.part[number].twice = vector_sum(sums.part[number].twice, vector_product(part, wave));
        before = reading.travel;
    }
    return sums;
}

static void line_go_on(struct line_finder *finder, const struct line_sought *line, int32_t turn,
                       double variance) {
    double *const covariance = &finder->covariance[0][0];
    bool begins = finder->turns == 0;
    double gone = begins ? 1.0 : fabs((double)turn - finder->last_turn);
    double slip = 2.0 * PI * line->order * SLIP * line->amplitude_arcsec;
    double of_c = begins ? 4.0 * line->amplitude_arcsec * line->amplitude_arcsec : slip * slip;
    double of_k = begins ? START_ARCSEC * START_ARCSEC : variance;
    for (uint32_t at = RE_K; at < LINE_STATES; at++) {
        covariance[at * (LINE_STATES + 1)] += gone * (at < RE_C ? of_k : of_c);
    }
}

static void line_update(struct line_finder *finder, const double row[LINE_STATES], double value,
                        double variance) {
    double spread[LINE_STATES];
    double total = variance;
    for (uint32_t at = 0; at < LINE_STATES; at++) {
        spread[at] = 0.0;
        for (uint32_t other = 0; other < LINE_STATES; other++) {
            spread[at] += finder->covariance[at][other] * row[other];
        }
        total += row[at] * spread[at];
        value -= row[at] * finder->state[at];
    }
    for (uint32_t at = 0; at < LINE_STATES; at++) {
        double gain = spread[at] / total;
        finder->state[at] += gain * value;
        for (uint32_t other = 0; other < LINE_STATES; other++) {
            finder->covariance[at][other] -= gain * spread[other];
        }
    }
}

static void line_judge(struct line_finder *finder, double amplitude_arcsec) {
    const struct vector line = {finder->state[RE_C], finder->state[IM_C]};
    double size = vector_length(line);
    double u = sqrt(0.5 * (finder->covariance[RE_C][RE_C] + finder->covariance[IM_C][IM_C]));
    bool found = finder->turns >= LEAST_TURNS && u <= LARGEST_SHARE * size;
    double doubt = finder->is_known ? 0.0 : SIGMAS * u;
    finder->is_known = (finder->is_known || found) && size - doubt >= LEAST_SIZE * amplitude_arcsec;
}

void line_finder_add(struct line_finder *finder, const struct line_sought *line,
                     const struct turn *turn, int32_t first_turn, double separation_rad,
                     double noise_arcsec) {
    ASSERT(turn->samples > 0 && turn->counts_per_rev > 0);
    double arcsec = ARCSEC_PER_TURN / turn->counts_per_rev;
    const struct sums sums =
        line_sums(line, turn, separation_rad / (2.0 * PI) * turn->counts_per_rev);
    struct vector forward = {0.0, 0.0};
    struct vector backward = {0.0, 0.0};
    for (uint32_t number = 0; number < 3; number++) {
        /* The product modulo 2^64 is enough, because the 48 bits of a turn are its low bits. */
        uint64_t gone = (uint64_t)((int64_t)first_turn + number - 1) * line->turn_step;
        double phase = 2.0 * PI * (double)(gone & ((1ULL << 48) - 1)) / TURN_STEPS;
        const struct vector gone_on = vector_unit(phase);
        forward = vector_sum(forward, vector_scaled(gone_on, sums.part[number].share));
        backward = vector_sum(backward,
                              vector_product(sums.part[number].twice, vector_conjugate(gone_on)));
    }
    struct vector seen = vector_unit(line->order * separation_rad);
    seen.re -= 1.0;
    forward = vector_scaled(vector_product(forward, seen), 0.5);
    backward = vector_scaled(vector_product(backward, vector_conjugate(seen)), 0.5);
    double variance = 0.5 * noise_arcsec * noise_arcsec / turn->samples;
    /* The column of Im c is j (forward - backward). */
    const double real[LINE_STATES] = {1.0, 0.0, forward.re + backward.re, backward.im - forward.im};
    const double imaginary[LINE_STATES] = {0.0, 1.0, forward.im + backward.im,
                                           forward.re - backward.re};
    line_go_on(finder, line, first_turn, variance);
    line_update(finder, real, sums.total.re * arcsec, variance);
    line_update(finder, imaginary, sums.total.im * arcsec, variance);
    finder->turns++;
    finder->last_turn = first_turn;
    line_judge(finder, line->amplitude_arcsec);
}

double line_finder_phase(const struct line_finder *finder) {
    return atan2(finder->state[IM_C], finder->state[RE_C]) / (2.0 * PI);
}
