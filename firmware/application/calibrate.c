/* SPDX-License-Identifier: Apache-2.0 */

#include "calibrate.h"

#include <stddef.h>
#include <string.h>

#include "separation.h"
#include "units.h"

/* So many noisy turns in a row are no accident: their noise is then the usual one. */
enum { NOISY_TURNS_MOST = 5 };
/* Share of a turn in the running mean of the noise. */
#define NOISE_SHARE 0.2

static struct calibration_settings settings_of(const struct parameters *parameters) {
    return (struct calibration_settings){
        .nominal_separation_rad = parameters->separation_deg * PI / 180.0,
        .separation = SEPARATION_AUTOMATIC,
        .index_detection_arcsec = parameters->index_detection_arcsec,
        .orders = (uint32_t)parameters->orders,
    };
}

static enum refusal estimate_turn(struct application *application, struct turn *turn) {
    struct calibration_settings settings = settings_of(&application->parameters);
    union calibration_workspace *workspace = &application->workspace;
    double apart_rad = turn_align(turn, settings.nominal_separation_rad);
    if (separation_is_exchanged(settings.nominal_separation_rad, apart_rad)) {
        /* Told, and nothing more: what either method made of it would be an error for another
           table. */
        application->measured.measured_separation_rad = apart_rad;
        return REFUSED_HEADS_EXCHANGED;
    }
    if (application->parameters.method != 0.0) {
        return least_squares_estimate(&workspace->least_squares, turn, &settings,
                                      &application->measured);
    }
    enum refusal reason =
        fourier_estimate(&workspace->fourier, turn, &settings, &application->measured);
    estimate_as_function_of_reading(&workspace->reading, &application->measured);
    return reason;
}

static enum refusal judge_noise(struct application *application) {
    double noise = application->measured.noise_arcsec;
    double usual = application->usual_noise_arcsec;
    enum refusal reason = gate_judge_noise(noise, usual, application->parameters.noise_limit);
    if (reason != NOT_REFUSED && ++application->noisy_turns < NOISY_TURNS_MOST) {
        return reason;
    }
    bool restart = usual == 0.0 || reason != NOT_REFUSED;
    application->usual_noise_arcsec = restart ? noise : usual + NOISE_SHARE * (noise - usual);
    application->noisy_turns = 0;
    return NOT_REFUSED;
}

static enum refusal make_candidate(struct application *application) {
    const struct parameters *parameters = &application->parameters;
    struct estimate *estimate = &application->measured;
    uint32_t lanes = application->configuration.lanes;
    enum verdict verdicts[ORDERS_MAX];
    average_add(&application->average, estimate, parameters->keep);
    average_apply(&application->average, estimate);
    select_orders(estimate, lanes, parameters->gain_limit, verdicts);
    enum refusal reason = coefficients_quantise(
        estimate, verdicts, application->capture.counts_per_rev, lanes, &application->candidate);
    if (reason != NOT_REFUSED) {
        return reason;
    }
    application->estimate = *estimate;
    memcpy(application->verdicts, verdicts, sizeof verdicts);
    const struct coefficients *active = application->has_active ? &application->active : NULL;
    application->report.prediction = gate_predict(estimate, active, &application->candidate);
    reason = gate_judge(&application->report.prediction);
    if (reason != NOT_REFUSED && active != NULL &&
        coefficients_most_order(active) > estimate->orders) {
        /* `orders` was lowered: what no turn judges any more is not applied any more. */
        application->candidate = *active;
        coefficients_drop_orders(&application->candidate, estimate->orders);
        reason = NOT_REFUSED;
    }
    return reason;
}

enum refusal calibrate_turn(struct application *application) {
    struct turn turn;
    enum refusal reason =
        capture_verify(&application->capture, (uint32_t)application->parameters.orders, &turn,
                       &application->report.fault);
    if (reason == NOT_REFUSED) {
        reason = estimate_turn(application, &turn);
    }
    if (reason == NOT_REFUSED) {
        reason = judge_noise(application);
    }
    return reason == NOT_REFUSED ? make_candidate(application) : reason;
}
