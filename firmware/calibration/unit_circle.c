/* SPDX-License-Identifier: Apache-2.0 */

#include "unit_circle.h"

#include <stdint.h>

#include "units.h"

void unit_circle_prepare(struct unit_circle *circle) {
    for (int index = 0; index < UNIT_CIRCLE_STEPS; index++) {
        circle->step[index] = vector_unit(2.0 * PI * index / UNIT_CIRCLE_STEPS);
    }
}

/* Returns e^{jx} for |x| <= pi/64 from the series of cosine and sine; the first omitted term is below 1e-18. */
static struct vector near_one(double x) {
    double s = x * x;
    double cosine = 1.0 + s * (-1.0 / 2 + s * (1.0 / 24 + s * (-1.0 / 720 + s * (1.0 / 40320))));
    double sine = x * (1.0 + s * (-1.0 / 6 + s * (1.0 / 120 + s * (-1.0 / 5040 + s / 362880))));
    return (struct vector){cosine, sine};
}

struct vector unit_circle_at(const struct unit_circle *circle, double turns) {
    double steps = turns * UNIT_CIRCLE_STEPS;
    int32_t nearest = (int32_t)(steps < 0.0 ? steps - 0.5 : steps + 0.5);
    double rest = (steps - nearest) * (2.0 * PI / UNIT_CIRCLE_STEPS);
    uint32_t index = (uint32_t)nearest % UNIT_CIRCLE_STEPS;
    return vector_product(circle->step[index], near_one(rest));
}
