/* SPDX-License-Identifier: Apache-2.0 */

#include "separation.h"

#include <math.h>

#include "assertion.h"
#include "units.h"
#include "vector.h"

enum separation_choice separation_judge(double nominal_rad, double measured_rad,
                                        enum separation_choice asked) {
    if (asked != SEPARATION_AUTOMATIC) {
        return asked;
    }
    double off_arcsec = (measured_rad - nominal_rad) * ARCSEC_PER_RAD;
    bool believed = fabs(off_arcsec) <= SEPARATION_BELIEVABLE_ARCSEC;
    return believed ? SEPARATION_MEASURED : SEPARATION_NOMINAL;
}

static bool is_believable(double off_rad) {
    return fabs(remainder_of_turn(off_rad)) * ARCSEC_PER_RAD <= SEPARATION_BELIEVABLE_ARCSEC;
}

bool separation_is_exchanged(double nominal_rad, double measured_rad) {
    return is_believable(measured_rad + nominal_rad) && !is_believable(measured_rad - nominal_rad);
}

double index_uncertainty_rad(int32_t counts_per_rev, double index_detection_arcsec) {
    ASSERT(counts_per_rev > 0);
    double of_two_heads = 2.0 * PI / counts_per_rev * sqrt(2.0 / 3.0);
    const struct vector parts = {of_two_heads, index_detection_arcsec / ARCSEC_PER_RAD};
    return vector_length(parts);
}

double separation_uncertainty_rad(enum separation_choice choice, int32_t counts_per_rev,
                                  double index_detection_arcsec) {
    if (choice == SEPARATION_NOMINAL) {
        return SEPARATION_TOLERANCE_U_ARCSEC / ARCSEC_PER_RAD;
    }
    return index_uncertainty_rad(counts_per_rev, index_detection_arcsec);
}
