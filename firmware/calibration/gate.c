/* SPDX-License-Identifier: Apache-2.0 */

#include "gate.h"

#include <math.h>
#include <stddef.h>

#include "assertion.h"

static struct vector components(const struct coefficients *coefficients, uint32_t order) {
    if (coefficients == NULL) {
        return (struct vector){0.0, 0.0};
    }
    return coefficients_components(coefficients, order);
}

static double apart_squared(const struct harmonic *harmonic, struct vector applied) {
    struct vector apart = {harmonic->cosine - applied.re, harmonic->sine - applied.im};
    return vector_square(apart);
}

/* Returns the expected square of the error that remains at an order with the coefficients a and the estimate x.

   If a was not made from x, the mean of |x - a|^2 exceeds this square by the noise of x. If a was made from x, the
   noise of x is part of the error, in addition to the quantisation. An error of the separation changes x and a equally:
   it cancels in x - a and remains as an error. If no coefficients are applied, the error of the separation makes |x|^2
   too large. */
static double expected_square(const struct harmonic *harmonic, struct vector applied,
                              bool made_of_estimate) {
    double noise = harmonic->variance_cosine + harmonic->variance_sine;
    double separation = harmonic->by_separation_cosine * harmonic->by_separation_cosine +
                        harmonic->by_separation_sine * harmonic->by_separation_sine;
    double apart = apart_squared(harmonic, applied);
    if (applied.re == 0.0 && applied.im == 0.0) {
        return fmax(apart - noise - separation, 0.0);
    }
    return (made_of_estimate ? apart + noise : fmax(apart - noise, 0.0)) + separation;
}

struct gate_prediction gate_predict(const struct estimate *estimate,
                                    const struct coefficients *active,
                                    const struct coefficients *candidate) {
    ASSERT(estimate->orders <= ORDERS_MAX);
    double before = 0.0;
    double after = 0.0;
    for (uint32_t place = 0; place < estimate->orders; place++) {
        const struct harmonic *harmonic = &estimate->harmonic[place];
        if (!harmonic->seen) {
            continue;
        }
        before += expected_square(harmonic, components(active, place + 1), false);
        after += expected_square(harmonic, components(candidate, place + 1), true);
    }
    /* A cosine of amplitude A has the mean square A^2/2. */
    return (struct gate_prediction){sqrt(0.5 * before), sqrt(0.5 * after)};
}

enum refusal gate_judge(const struct gate_prediction *prediction) {
    bool better = prediction->candidate_arcsec < prediction->active_arcsec;
    return better ? NOT_REFUSED : REFUSED_NOT_BETTER;
}

enum refusal gate_judge_noise(double noise_arcsec, double usual_arcsec, double limit) {
    bool noisy = usual_arcsec > 0.0 && noise_arcsec > limit * usual_arcsec;
    return noisy ? REFUSED_NOISE : NOT_REFUSED;
}
