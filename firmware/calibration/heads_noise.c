/* SPDX-License-Identifier: Apache-2.0 */

/* Measures the noise of the fitted turn, and the motion of the axis that does not repeat. */

#include <stddef.h>

#include "heads_steps.h"
#include "noise.h"
#include "units.h"

bool heads_measure_axis(const struct heads_fit *fit) {
    return fit->settings->axis != NULL && fit->geometry->heads == HEADS_MOST;
}

/* Returns the share of the turn that belongs to a sample: half the angle between its neighbours. */
static double share_of(const struct heads_fit *fit, uint32_t sample) {
    const struct turn *turn = fit->turn;
    uint32_t last = turn->samples - 1;
    double whole = turn->step_counts < 0.0 ? -turn->counts_per_rev : turn->counts_per_rev;
    int32_t before = turn->words[2 * (sample == 0 ? last : sample - 1)];
    int32_t after = turn->words[2 * (sample == last ? 0 : sample + 1)];
    double apart = counts_apart(after, before);
    apart += sample == 0 || sample == last ? whole : 0.0;
    return 0.5 * apart / whole;
}

static double heads_residual_sample(const void *context, uint32_t sample) {
    const struct heads_fit *fit = context;
    double residual[HEADS_MOST];
    struct vector unit1 = heads_look(fit, sample, residual);
    if (heads_measure_axis(fit)) {
        axis_add(&fit->workspace->axis, residual, unit1, share_of(fit, sample));
    }
    return heads_combined(fit, 0, residual);
}

void heads_take_noise(const struct heads_fit *fit, struct estimate *estimate) {
    struct heads_workspace *workspace = fit->workspace;
    double of_one_row;
    if (heads_measure_axis(fit)) {
        axis_begin(&workspace->axis, fit->geometry, fit->orders);
    }
    lines_transform(&workspace->lines, lines_wanted(fit->orders, fit->turn->samples),
                    &workspace->circle, heads_residual_sample, fit, fit->turn->samples,
                    &of_one_row);
    noise_measure(estimate, workspace->squares / fit->rows, &workspace->lines);
    noise_scale_covariance(estimate);
}

void heads_take_asynchronous(const struct heads_fit *fit, const struct estimate *estimate,
                             struct heads_found *found) {
    const struct heads_workspace *workspace = fit->workspace;
    const double variance = estimate->noise_arcsec * estimate->noise_arcsec;
    double off[HEADS_MOST];
    double of_disc = 0.0;
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        double apart = fit->geometry->offset_rad[head] - fit->settings->place_rad[head];
        off[head] = remainder_of_turn(apart) * ARCSEC_PER_RAD;
    }
    for (uint32_t place = 1; place < fit->orders; place++) {
        const struct harmonic *harmonic = &estimate->harmonic[place];
        if (harmonic->seen) {
            of_disc += harmonic->noise_gain * harmonic->noise_gain *
                       axis_of_order(&workspace->axis, fit->geometry, place + 1);
        }
    }
    /* The disc's order 1 reads like a forward circle: Re(D e^{jy}) = Im(jD e^{jy}), D = cosine - j sine. */
    const struct axis_turn turn = {
        .samples = fit->turn->samples,
        .still = axis_of_heads(&workspace->axis, off),
        .forward = {workspace->values[fit->orders], workspace->values[0]},
        .backward = fit->backward,
        .variance = variance,
        .of_disc = of_disc * estimate->colour / fit->turn->samples,
    };
    found->asynchronous = axis_end(&workspace->axis, &turn, fit->settings->axis);
}
