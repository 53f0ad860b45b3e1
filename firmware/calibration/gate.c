/* SPDX-License-Identifier: Apache-2.0 */

#include "gate.h"

#include <math.h>
#include <stddef.h>

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

/* |x - a|^2 of an estimate x with variance u^2 a component is 2u^2 too large in the mean where a
   does not come from x; where it does, the error of x is all of the error, and what quantising
   adds. */
static double expected_square(const struct harmonic *harmonic, struct vector applied,
                              bool made_of_estimate) {
    double u = harmonic_uncertainty(harmonic);
    double apart = apart_squared(harmonic, applied);
    return made_of_estimate ? apart + 2.0 * u * u : fmax(apart - 2.0 * u * u, 0.0);
}

struct gate_prediction gate_predict(const struct estimate *estimate,
                                    const struct coefficients *active,
                                    const struct coefficients *candidate) {
    double before = 0.0;
    double after = 0.0;
    for (uint32_t place = 0; place < estimate->orders; place++) {
        const struct harmonic *harmonic = &estimate->harmonic[place];
        if (!harmonic->seen) {
            continue;
        }
        struct vector now = components(active, place + 1);
        struct vector then = components(candidate, place + 1);
        bool applied = then.re != 0.0 || then.im != 0.0;
        before += expected_square(harmonic, now, false);
        after += expected_square(harmonic, then, applied);
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
