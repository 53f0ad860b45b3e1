/* SPDX-License-Identifier: Apache-2.0 */

#include "reading_function.h"

#include <math.h>

#include "assertion.h"
#include "units.h"

/* Number of readings per turn: more than 16 per wave of the highest order. */
enum { READINGS = 1024, ITERATIONS_MOST = 20 };
/* Step below which the iteration ends. Each step is the step before times the slope of the error (1e-3 at 200 arcsec),
   so the remaining error of the iteration is below 1e-11 arcsec. */
#define UNCHANGED_ARCSEC 1e-8

struct error_function {
    const struct unit_circle *circle;
    const struct estimate *estimate;
};

static double error_at(const struct error_function *function, double turns) {
    struct vector unit = unit_circle_at(function->circle, turns);
    struct vector power = unit;
    double error = 0.0;
    for (uint32_t place = 0; place < function->estimate->orders; place++) {
        const struct harmonic *harmonic = &function->estimate->harmonic[place];
        error += harmonic->cosine * power.re + harmonic->sine * power.im;
        power = vector_product(power, unit);
    }
    return error;
}

/* Solves g(R) = eps(R - g(R)) by iteration. */
static double error_at_reading(const void *context, uint32_t sample) {
    const struct error_function *function = context;
    double reading = (double)sample / READINGS;
    double error = error_at(function, reading);
    for (uint32_t round = 0; round < ITERATIONS_MOST; round++) {
        double before = error;
        error = error_at(function, reading - error / ARCSEC_PER_TURN);
        if (fabs(error - before) < UNCHANGED_ARCSEC) {
            break;
        }
    }
    return error;
}

void estimate_as_function_of_reading(struct reading_workspace *workspace,
                                     struct estimate *estimate) {
    ASSERT(estimate->orders <= ORDERS_MAX);
    if (estimate->function_of_reading) {
        return;
    }
    struct error_function function = {&workspace->circle, estimate};
    double squares;
    unit_circle_prepare(&workspace->circle);
    lines_transform(&workspace->lines, estimate->orders, &workspace->circle, error_at_reading,
                    &function, READINGS, &squares);
    for (uint32_t place = 0; place < estimate->orders; place++) {
        struct harmonic *harmonic = &estimate->harmonic[place];
        harmonic->cosine = workspace->lines.sum[place].re * (2.0 / READINGS);
        harmonic->sine = -workspace->lines.sum[place].im * (2.0 / READINGS);
    }
    estimate->function_of_reading = true;
}
