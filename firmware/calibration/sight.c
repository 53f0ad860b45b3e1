/* SPDX-License-Identifier: Apache-2.0 */

#include "sight.h"

#include <math.h>

double sight_left(const struct sight *sight, struct vector applied) {
    return vector_length(vector_difference(sight->value, applied));
}

double sight_variance(const struct sight *sight) {
    return sight->variance + sight->by_separation + sight->by_change;
}

double sight_evidence(const struct sight *sight, struct vector applied) {
    double apart = vector_square(vector_difference(sight->value, applied));
    return 0.5 * (vector_square(sight->value) - apart) / sight_variance(sight);
}
