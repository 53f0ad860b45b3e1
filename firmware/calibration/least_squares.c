/* SPDX-License-Identifier: Apache-2.0 */

#include "least_squares.h"

#include <math.h>
#include <string.h>

#include "assertion.h"
#include "cholesky.h"
#include "noise.h"
#include "transfer_function.h"
#include "units.h"

/* Each round fits the orders and moves head 2. The rounds end when a further move would change the error by less than
   this. */
#define CONVERGED_ARCSEC 1e-4
/* Limit of the passes over the turn in all rounds together: one to build the matrix of each round, and one per
   refinement. A usual fit takes 3 to 6. A pass over 12,000 samples with 40 orders takes 23 million instructions
   (counted in QEMU), 70 ms at two cycles each. 14 passes end within half of the 2 s after which the watchdog regards
   the firmware as hung. */
enum { PASSES_MOST = 64 };
#define WORK_MOST (14U * 12000U * 40U)
/* Share of the largest value. The refinements end when a step, or ten times the step that is expected next, is below
   this share. */
#define REFINED_SHARE 1e-11

/* Values that the passes over the turn need in addition to the workspace. */
struct fit {
    struct least_squares_workspace *workspace;
    const struct turn *turn;
    uint32_t orders;
    double nominal_arcsec;
    double arcsec_per_count;
    double turns_per_count;
    double shift_arcsec;
    struct vector shift;
    uint32_t passes_left;
};

static void set_shift(struct fit *fit, double shift_arcsec) {
    fit->shift_arcsec = shift_arcsec;
    fit->shift = vector_unit(-shift_arcsec / ARCSEC_PER_RAD);
}

static void choose_orders(struct fit *fit) {
    struct gram_layout *layout = &fit->workspace->layout;
    int64_t sum = 0;
    for (uint32_t sample = 0; sample < fit->turn->samples; sample++) {
        sum += turn_reading(fit->turn, sample).difference;
    }
    double raw_rad = 2.0 * PI * (double)sum / fit->turn->samples / fit->turn->counts_per_rev;
    layout->number = 0;
    for (uint32_t order = 1; order <= fit->orders; order++) {
        /* An order that the nominal separation or the mean difference of the readings hides would make the matrix
           singular. */
        if (isfinite(noise_gain(order, fit->nominal_arcsec / ARCSEC_PER_RAD)) &&
            isfinite(noise_gain(order, raw_rad))) {
            layout->order[layout->number++] = order;
        }
    }
}

/* Computes d_n = e^{jnR2} - e^{jnR1} of all orders, and returns the residual of the sample. */
static double residual_of(const struct fit *fit, uint32_t sample, struct vector *columns) {
    const double *values = fit->workspace->values;
    struct reading reading = turn_reading(fit->turn, sample);
    const struct unit_circle *circle = &fit->workspace->circle;
    struct vector unit1 = unit_circle_at(circle, reading.angle1 * fit->turns_per_count);
    struct vector unit2 =
        vector_product(unit_circle_at(circle, reading.angle2 * fit->turns_per_count), fit->shift);
    struct vector power1 = unit1;
    struct vector power2 = unit2;
    double model = values[2 * fit->orders];
    for (uint32_t place = 0; place < fit->orders; place++) {
        columns[place] = vector_difference(power2, power1);
        model += columns[place].re * values[place];
        model += columns[place].im * values[fit->orders + place];
        power1 = vector_product(power1, unit1);
        power2 = vector_product(power2, unit2);
    }
    return reading.difference * fit->arcsec_per_count - fit->nominal_arcsec - model;
}

/* Computes X^T r, with r at the present values. */
static void accumulate_right(const struct fit *fit) {
    struct least_squares_workspace *workspace = fit->workspace;
    struct vector columns[ORDERS_MAX];
    double *right = workspace->right;
    memset(right, 0, sizeof workspace->right);
    for (uint32_t sample = 0; sample < fit->turn->samples; sample++) {
        double residual = residual_of(fit, sample, columns);
        for (uint32_t place = 0; place < fit->orders; place++) {
            right[place] += columns[place].re * residual;
            right[fit->orders + place] += columns[place].im * residual;
        }
        right[2 * fit->orders] += residual;
    }
}

/* Picks the right-hand sides of the orders that have unknowns. */
static void gather(const struct fit *fit, double *unknowns) {
    const struct gram_layout *layout = &fit->workspace->layout;
    const double *right = fit->workspace->right;
    for (uint32_t place = 0; place < layout->number; place++) {
        unknowns[place] = right[layout->order[place] - 1];
        unknowns[layout->number + place] = right[fit->orders + layout->order[place] - 1];
    }
    unknowns[2 * layout->number] = right[2 * fit->orders];
}

/* Adds a step to the values; returns its largest component. */
static double take_step(const struct fit *fit, const double *unknowns) {
    const struct gram_layout *layout = &fit->workspace->layout;
    double *values = fit->workspace->values;
    double largest = fabs(unknowns[2 * layout->number]);
    for (uint32_t place = 0; place < layout->number; place++) {
        values[layout->order[place] - 1] += unknowns[place];
        values[fit->orders + layout->order[place] - 1] += unknowns[layout->number + place];
        largest =
            fmax(largest, fmax(fabs(unknowns[place]), fabs(unknowns[layout->number + place])));
    }
    values[2 * fit->orders] += unknowns[2 * layout->number];
    return largest;
}

static double largest_value(const struct fit *fit) {
    double largest = 0.0;
    for (uint32_t place = 0; place < 2 * fit->orders; place++) {
        largest = fmax(largest, fabs(fit->workspace->values[place]));
    }
    return largest;
}

static uint32_t passes_of(const struct fit *fit) {
    uint32_t passes = WORK_MOST / (fit->turn->samples * fit->orders);
    return passes < PASSES_MOST ? passes : PASSES_MOST;
}

static bool take_pass(struct fit *fit) {
    bool left = fit->passes_left > 0;
    fit->passes_left -= left;
    return left;
}

/* Refines the solution until the remaining error is small. Successive steps shrink by nearly the same factor, so the
   remaining error is the last step times that factor. */
static enum refusal refine(struct fit *fit) {
    const struct least_squares_workspace *workspace = fit->workspace;
    double unknowns[UNKNOWNS_MAX];
    double before = 0.0;
    while (take_pass(fit)) {
        accumulate_right(fit);
        gather(fit, unknowns);
        cholesky_solve(workspace->packed, 2 * workspace->layout.number + 1, unknowns);
        double step = take_step(fit, unknowns);
        if (!isfinite(step)) {
            return REFUSED_NOT_FINITE;
        }
        double least = REFINED_SHARE * largest_value(fit);
        if (step <= least || step * step <= 0.1 * least * before) {
            return NOT_REFUSED;
        }
        before = step;
    }
    return REFUSED_NOT_CONVERGED;
}

static enum refusal fit_once(struct fit *fit) {
    struct least_squares_workspace *workspace = fit->workspace;
    if (!take_pass(fit)) {
        return REFUSED_NOT_CONVERGED;
    }
    gram_accumulate(&workspace->pass.sums, &workspace->circle, fit->turn, fit->orders,
                    fit->shift_arcsec / ARCSEC_PER_RAD);
    gram_build(&workspace->pass.sums, &workspace->layout, workspace->packed);
    if (!cholesky_factor(workspace->packed, 2 * workspace->layout.number + 1)) {
        return REFUSED_SINGULAR;
    }
    return refine(fit);
}

/* Returns an upper bound of the error's slope, arcsec per arcsec. */
static double steepest(const struct fit *fit) {
    const double *values = fit->workspace->values;
    double slope = 0.0;
    for (uint32_t place = 0; place < fit->orders; place++) {
        const struct vector value = {values[place], values[fit->orders + place]};
        slope += (place + 1) * vector_length(value);
    }
    return slope / ARCSEC_PER_RAD;
}

/* Fits repeatedly, and moves head 2 until its zero agrees with the separation in use. */
static enum refusal fit_consistently(struct fit *fit, const struct calibration_settings *settings,
                                     struct estimate *estimate) {
    double nominal = settings->nominal_separation_rad;
    for (estimate->iterations = 1;; estimate->iterations++) {
        enum refusal reason = fit_once(fit);
        if (reason != NOT_REFUSED) {
            return reason;
        }
        double constant = fit->workspace->values[2 * fit->orders];
        estimate->measured_separation_rad = nominal + constant / ARCSEC_PER_RAD;
        if (estimate->iterations == 1) {
            estimate->separation_choice =
                separation_judge(nominal, estimate->measured_separation_rad, settings->separation);
        }
        bool measured = estimate->separation_choice == SEPARATION_MEASURED;
        double used = measured ? constant : 0.0;
        estimate->separation_rad = nominal + used / ARCSEC_PER_RAD;
        double moved = fabs(constant - used - fit->shift_arcsec);
        if (moved * steepest(fit) < CONVERGED_ARCSEC) {
            return NOT_REFUSED;
        }
        set_shift(fit, constant - used);
    }
}

static void take_values(const struct fit *fit, struct estimate *estimate) {
    const struct gram_layout *layout = &fit->workspace->layout;
    const double *values = fit->workspace->values;
    for (uint32_t place = 0; place < fit->orders; place++) {
        estimate->harmonic[place] = (struct harmonic){.noise_gain = (double)INFINITY};
    }
    for (uint32_t place = 0; place < layout->number; place++) {
        uint32_t order = layout->order[place];
        struct harmonic *harmonic = &estimate->harmonic[order - 1];
        harmonic->seen = true;
        harmonic->cosine = values[order - 1];
        harmonic->sine = values[fit->orders + order - 1];
        harmonic->noise_gain = noise_gain(order, estimate->separation_rad);
    }
}

/* Takes the variances from the inverse of the normal matrix, in which the constant counts as unknown. */
static void take_covariance(const struct fit *fit, struct estimate *estimate) {
    struct least_squares_workspace *workspace = fit->workspace;
    uint32_t number = workspace->layout.number;
    uint32_t size = 2 * number + 1;
    double *packed = workspace->packed;
    cholesky_invert_factor(packed, size);
    for (uint32_t place = 0; place < number; place++) {
        struct harmonic *harmonic = &estimate->harmonic[workspace->layout.order[place] - 1];
        uint32_t sine = number + place;
        harmonic->variance_cosine = cholesky_inverse_element(packed, size, place, place);
        harmonic->variance_sine = cholesky_inverse_element(packed, size, sine, sine);
        harmonic->covariance = cholesky_inverse_element(packed, size, sine, place);
    }
}

static double residual_sample(const void *context, uint32_t sample) {
    struct vector columns[ORDERS_MAX];
    return residual_of(context, sample, columns);
}

static void take_noise(struct fit *fit, const struct calibration_settings *settings,
                       struct estimate *estimate) {
    struct least_squares_workspace *workspace = fit->workspace;
    struct lines *lines = &workspace->pass.lines;
    lines_transform(lines, lines_wanted(fit->orders, fit->turn->samples), &workspace->circle,
                    residual_sample, fit, fit->turn->samples, &workspace->residual_squares);
    noise_measure(estimate, workspace->residual_squares, lines);
    noise_scale_covariance(estimate);
    noise_add_separation(estimate, fit->turn->counts_per_rev, settings->index_detection_arcsec);
}

enum refusal least_squares_estimate(struct least_squares_workspace *workspace,
                                    const struct turn *turn,
                                    const struct calibration_settings *settings,
                                    struct estimate *estimate) {
    ASSERT(settings->orders > 0 && settings->orders <= ORDERS_MAX);
    ASSERT(turn->samples > 0 && turn->counts_per_rev > 0);
    struct fit fit = {
        .workspace = workspace,
        .turn = turn,
        .orders = settings->orders,
        .nominal_arcsec = settings->nominal_separation_rad * ARCSEC_PER_RAD,
        .arcsec_per_count = ARCSEC_PER_TURN / turn->counts_per_rev,
        .turns_per_count = 1.0 / turn->counts_per_rev,
    };
    unit_circle_prepare(&workspace->circle);
    memset(workspace->values, 0, sizeof workspace->values);
    set_shift(&fit, 0.0);
    *estimate = (struct estimate){
        .orders = settings->orders,
        .samples = turn->samples,
        .function_of_reading = true,
    };
    fit.passes_left = passes_of(&fit);
    choose_orders(&fit);
    enum refusal reason = fit_consistently(&fit, settings, estimate);
    if (reason != NOT_REFUSED) {
        return reason;
    }
    take_values(&fit, estimate);
    take_covariance(&fit, estimate);
    take_noise(&fit, settings, estimate);
    return estimate_is_finite(estimate) ? NOT_REFUSED : REFUSED_NOT_FINITE;
}
