/* SPDX-License-Identifier: Apache-2.0 */

#include "further_orders.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "units.h"

enum { CIRCLE_BITS = 6, CIRCLE_SHIFT = 32 - CIRCLE_BITS };
_Static_assert(UNIT_CIRCLE_STEPS == 1 << CIRCLE_BITS, "a phase's upper bits name a direction");
#define RAD_PER_2_32 (2.0 * PI / 4294967296.0)

/* e^{jx} of a phase of the gateware, to 3e-9: nearest direction and a short series. */
static inline struct vector unit_of_phase(const struct unit_circle *circle, uint64_t phase) {
    uint32_t upper = (uint32_t)(phase >> (ARCTRUE_PHASE_STEP_WIDTH - 32));
    uint32_t nearest = (upper + (1U << (CIRCLE_SHIFT - 1))) >> CIRCLE_SHIFT;
    double x = (int32_t)(upper - (nearest << CIRCLE_SHIFT)) * RAD_PER_2_32;
    double s = x * x;
    struct vector small = {1.0 + s * (-0.5 + s * (1.0 / 24)), x * (1.0 + s * (-1.0 / 6))};
    return vector_product(circle->step[nearest % UNIT_CIRCLE_STEPS], small);
}

/* The fitted orders at a reading whose direction is `unit`, arcsec: Clenshaw's recurrence. */
static double fitted(const struct estimate *estimate, struct vector unit) {
    double twice = 2.0 * unit.re;
    struct vector one = {0.0, 0.0};
    struct vector two = {0.0, 0.0};
    for (uint32_t place = estimate->orders; place-- > 0;) {
        const struct harmonic *harmonic = &estimate->harmonic[place];
        struct vector next = {harmonic->cosine + twice * one.re - two.re,
                              harmonic->sine + twice * one.im - two.im};
        two = one;
        one = next;
    }
    return one.re * unit.re - two.re + one.im * unit.im;
}

static void add(struct further_order *sums, struct vector unit1, struct vector unit2,
                double residual) {
    sums->head1.re += residual * unit1.re;
    sums->head1.im += residual * unit1.im;
    sums->head2.re += residual * unit2.re;
    sums->head2.im += residual * unit2.im;
    sums->apart.re += unit1.re * unit2.re + unit1.im * unit2.im;
    sums->apart.im += unit1.re * unit2.im - unit1.im * unit2.re;
    sums->doubled.re += unit1.re * unit1.re - unit1.im * unit1.im;
    sums->doubled.im += 2.0 * unit1.re * unit1.im;
}

static void choose(struct further_workspace *workspace, const struct turn *turn,
                   const struct estimate *estimate, const struct coefficients *set) {
    workspace->number = 0;
    for (uint32_t lane = 0; lane < set->lanes; lane++) {
        uint32_t order = set->lane[lane].order;
        if (order > estimate->orders) {
            workspace->order[workspace->number++] = (struct further_order){
                .order = order,
                .phase_step = coefficients_phase_step(order, (uint32_t)turn->counts_per_rev),
            };
        }
    }
}

static void follow_steps(struct further_workspace *workspace, double step) {
    workspace->least_step = fmin(workspace->least_step, step);
    workspace->most_step = fmax(workspace->most_step, step);
}

void further_orders_look(struct further_workspace *workspace, const struct turn *turn,
                         const struct estimate *estimate, const struct coefficients *set) {
    double turns_per_count = 1.0 / turn->counts_per_rev;
    double arcsec_per_count = ARCSEC_PER_TURN * turns_per_count;
    double constant = estimate->measured_separation_rad * ARCSEC_PER_RAD;
    struct vector shift = vector_unit(-further_orders_shift_rad(estimate));
    int32_t before = 0;
    choose(workspace, turn, estimate, set);
    workspace->samples = turn->samples;
    workspace->least_step = 1.0;
    workspace->most_step = 0.0;
    if (workspace->number == 0) {
        return;
    }
    unit_circle_prepare(&workspace->circle);
    for (uint32_t sample = 0; sample < turn->samples; sample++) {
        struct reading reading = turn_reading(turn, sample);
        struct vector unit1 =
            unit_circle_at(&workspace->circle, reading.angle1 * turns_per_count);
        struct vector unit2 = vector_product(
            unit_circle_at(&workspace->circle, reading.angle2 * turns_per_count), shift);
        double residual = reading.difference * arcsec_per_count - constant -
                          fitted(estimate, unit2) + fitted(estimate, unit1);
        for (uint32_t place = 0; place < workspace->number; place++) {
            struct further_order *order = &workspace->order[place];
            add(order,
                unit_of_phase(&workspace->circle, order->phase_step * (uint32_t)reading.angle1),
                unit_of_phase(&workspace->circle, order->phase_step * (uint32_t)reading.angle2),
                residual);
        }
        if (sample != 0) {
            follow_steps(workspace, fabs((double)(reading.travel - before)) * turns_per_count);
        }
        before = reading.travel;
    }
}
