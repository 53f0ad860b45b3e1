/* SPDX-License-Identifier: Apache-2.0 */

#include "estimate.h"

#include <math.h>

#include "assertion.h"

double harmonic_amplitude(const struct harmonic *harmonic) {
    return sqrt(harmonic->cosine * harmonic->cosine + harmonic->sine * harmonic->sine);
}

double harmonic_phase(const struct harmonic *harmonic) {
    return atan2(-harmonic->sine, harmonic->cosine);
}

double harmonic_uncertainty(const struct harmonic *harmonic) {
    if (!harmonic->seen) {
        return (double)INFINITY;
    }
    double separation = harmonic->by_separation_cosine * harmonic->by_separation_cosine +
                        harmonic->by_separation_sine * harmonic->by_separation_sine;
    return sqrt(0.5 * (harmonic->variance_cosine + harmonic->variance_sine + separation));
}

bool estimate_is_finite(const struct estimate *estimate) {
    ASSERT(estimate->orders <= ORDERS_MAX);
    for (uint32_t place = 0; place < estimate->orders; place++) {
        const struct harmonic *harmonic = &estimate->harmonic[place];
        bool known = isfinite(harmonic->cosine) && isfinite(harmonic->sine) &&
                     isfinite(harmonic->variance_cosine) && isfinite(harmonic->variance_sine);
        if (!known) {
            return false;
        }
    }
    return isfinite(estimate->measured_separation_rad);
}
