/* SPDX-License-Identifier: Apache-2.0 */

#include "further_orders.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"

enum { CIRCLE_BITS = 6, CIRCLE_SHIFT = 32 - CIRCLE_BITS };
_Static_assert(UNIT_CIRCLE_STEPS == 1 << CIRCLE_BITS, "a phase's upper bits name a direction");
#define RAD_PER_2_32 (2.0 * PI / 4294967296.0)

/* Returns e^{jx} of a phase of the gateware, within 3e-7, from the nearest direction of the table and a short
   series. */
static inline struct vector unit_of_phase(const struct unit_circle *circle, uint64_t phase) {
    uint32_t upper = (uint32_t)(phase >> (ARCTRUE_PHASE_STEP_WIDTH - 32));
    uint32_t nearest = (upper + (1U << (CIRCLE_SHIFT - 1))) >> CIRCLE_SHIFT;
    double x = (int32_t)(upper - (nearest << CIRCLE_SHIFT)) * RAD_PER_2_32;
    double s = x * x;
    struct vector small = {1.0 - 0.5 * s, x * (1.0 - s * (1.0 / 6))};
    return vector_product(circle->step[nearest % UNIT_CIRCLE_STEPS], small);
}

/* Returns the sum of the fitted orders at a reading whose direction is `unit`, arcsec, by Clenshaw's recurrence. */
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

/* Both readings of a sample, counts, and the part of their difference that the fit does not explain, arcsec. */
struct term {
    uint32_t angle1;
    uint32_t angle2;
    double residual;
};

/* Adds two samples per pass, because loading and storing the sums takes longer than adding to them. */
static void further_add_pair(struct further_order *sums, const struct unit_circle *circle,
                             const struct term *a, const struct term *b) {
    struct vector a1 = unit_of_phase(circle, sums->phase_step * a->angle1);
    struct vector a2 = unit_of_phase(circle, sums->phase_step * a->angle2);
    struct vector b1 = unit_of_phase(circle, sums->phase_step * b->angle1);
    struct vector b2 = unit_of_phase(circle, sums->phase_step * b->angle2);
    sums->head1.re += a->residual * a1.re + b->residual * b1.re;
    sums->head1.im += a->residual * a1.im + b->residual * b1.im;
    sums->head2.re += a->residual * a2.re + b->residual * b2.re;
    sums->head2.im += a->residual * a2.im + b->residual * b2.im;
    sums->apart.re += a1.re * a2.re + a1.im * a2.im + b1.re * b2.re + b1.im * b2.im;
    sums->apart.im += a1.re * a2.im - a1.im * a2.re + b1.re * b2.im - b1.im * b2.re;
    sums->products.re += a1.re * a1.re + b1.re * b1.re;
    sums->products.im += a1.re * a1.im + b1.re * b1.im;
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

static struct term term_of(struct further_workspace *workspace, const struct turn *turn,
                           const struct estimate *estimate, struct vector shift, uint32_t sample) {
    const struct unit_circle *circle = &workspace->circle;
    double turns_per_count = 1.0 / turn->counts_per_rev;
    double arcsec_per_count = ARCSEC_PER_TURN * turns_per_count;
    struct reading reading = turn_reading(turn, sample);
    struct vector unit1 = unit_circle_at(circle, reading.angle1 * turns_per_count);
    struct vector unit2 =
        vector_product(unit_circle_at(circle, reading.angle2 * turns_per_count), shift);
    double constant = estimate->measured_separation_rad * ARCSEC_PER_RAD;
    return (struct term){
        (uint32_t)reading.angle1,
        (uint32_t)reading.angle2,
        reading.difference * arcsec_per_count - constant - fitted(estimate, unit2) +
            fitted(estimate, unit1),
    };
}

static void follow_steps(struct further_workspace *workspace, const struct turn *turn) {
    int32_t before = 0;
    workspace->least_step = 1.0;
    workspace->most_step = 0.0;
    for (uint32_t sample = 1; sample < turn->samples; sample++) {
        int32_t travel = turn_reading(turn, sample).travel;
        double step = fabs((double)(travel - before)) / turn->counts_per_rev;
        workspace->least_step = fmin(workspace->least_step, step);
        workspace->most_step = fmax(workspace->most_step, step);
        before = travel;
    }
}

void further_orders_look(struct further_workspace *workspace, const struct turn *turn,
                         const struct estimate *estimate, const struct coefficients *set) {
    ASSERT(set->lanes <= LANES_LIMIT && estimate->orders <= ORDERS_MAX);
    struct vector shift = vector_unit(-further_orders_shift_rad(estimate));
    choose(workspace, turn, estimate, set);
    workspace->samples = turn->samples;
    if (workspace->number == 0) {
        return;
    }
    unit_circle_prepare(&workspace->circle);
    follow_steps(workspace, turn);
    /* If the number of samples is odd, the last sample is left out. */
    workspace->samples -= turn->samples % 2;
    for (uint32_t sample = 0; sample + 1 < turn->samples; sample += 2) {
        struct term a = term_of(workspace, turn, estimate, shift, sample);
        struct term b = term_of(workspace, turn, estimate, shift, sample + 1);
        for (uint32_t place = 0; place < workspace->number; place++) {
            further_add_pair(&workspace->order[place], &workspace->circle, &a, &b);
        }
    }
}
