/* SPDX-License-Identifier: Apache-2.0 */

#include "selection.h"

#include <math.h>

#include "assertion.h"

/* Probability that noise alone makes at least one order look significant. */
#define FALSE_ALARM 0.05

const char *verdict_name(enum verdict verdict) {
    static const char *const names[] = {"applied",         "not_seen", "gain",
                                        "not_significant", "no_lane",  "loaded"};
    return (unsigned)verdict <= VERDICT_LOADED ? names[verdict] : "unknown";
}

/* Computes the factor from the distribution of noise. For noise, A^2/2u^2 has an F distribution with (2, 2m) degrees of
   freedom, because u is estimated from m lines of the spectrum: P(A > k u) = (1 + k^2/2m)^-m. log1p() replaces log(),
   whose table has 4 KB. */
double significance_factor(uint32_t orders) {
    double chance = FALSE_ALARM / (orders == 0 ? 1 : orders);
    return sqrt(2.0 * NOISE_LINES * expm1(log1p(1.0 / chance - 1.0) / NOISE_LINES));
}

static uint32_t seen_orders(const struct estimate *estimate) {
    uint32_t seen = 0;
    for (uint32_t place = 0; place < estimate->orders; place++) {
        seen += estimate->harmonic[place].seen;
    }
    return seen;
}

static enum verdict judge_harmonic(const struct harmonic *harmonic, double factor,
                                   double gain_limit) {
    if (!harmonic->seen) {
        return VERDICT_NOT_SEEN;
    }
    if (harmonic->noise_gain > gain_limit) {
        return VERDICT_GAIN;
    }
    bool significant = harmonic_amplitude(harmonic) > factor * harmonic_uncertainty(harmonic);
    return significant ? VERDICT_APPLIED : VERDICT_NOT_SIGNIFICANT;
}

/* Counts the orders that qualify for a lane and have a larger amplitude than this order, or the same amplitude and a
   lower number. */
static uint32_t larger_orders(const struct estimate *estimate, const enum verdict *verdicts,
                              uint32_t place) {
    double own = harmonic_amplitude(&estimate->harmonic[place]);
    uint32_t larger = 0;
    for (uint32_t other = 0; other < estimate->orders; other++) {
        bool wanted = verdicts[other] == VERDICT_APPLIED || verdicts[other] == VERDICT_NO_LANE;
        double amplitude = harmonic_amplitude(&estimate->harmonic[other]);
        larger += wanted && (amplitude > own || (amplitude == own && other < place));
    }
    return larger;
}

void select_orders(const struct estimate *estimate, uint32_t lanes, double gain_limit,
                   enum verdict *verdicts) {
    ASSERT(estimate->orders <= ORDERS_MAX && lanes <= LANES_LIMIT);
    double factor = significance_factor(seen_orders(estimate));
    for (uint32_t place = 0; place < estimate->orders; place++) {
        verdicts[place] = judge_harmonic(&estimate->harmonic[place], factor, gain_limit);
    }
    for (uint32_t place = 0; place < estimate->orders; place++) {
        bool wanted = verdicts[place] == VERDICT_APPLIED;
        if (wanted && larger_orders(estimate, verdicts, place) >= lanes) {
            verdicts[place] = VERDICT_NO_LANE;
        }
    }
}
