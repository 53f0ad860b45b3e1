/* SPDX-License-Identifier: Apache-2.0 */

#include "calibrate.h"

#include <stddef.h>
#include <string.h>

#include "calibrate_mean.h"
#include "compare_loaded.h"
#include "judge_sets.h"
#include "real_follow.h"
#include "separation.h"
#include "turn_judge.h"
#include "units.h"

/* Number of noisy turns in a row after which the firmware takes the noise of the last one as the usual noise. */
enum { NOISY_TURNS_MOST = 5 };
/* Weight of one turn in the running mean of the noise. */
#define NOISE_SHARE 0.2

static struct calibration_settings calibrate_settings(const struct parameters *parameters) {
    return (struct calibration_settings){
        .nominal_separation_rad = parameters->separation_deg * PI / 180.0,
        .separation = SEPARATION_AUTOMATIC,
        .index_detection_arcsec = parameters->index_detection_arcsec,
        .orders = (uint32_t)parameters->orders,
    };
}

static enum refusal calibrate_estimate(struct application *application, struct turn *turn) {
    struct calibration_settings settings = calibrate_settings(&application->parameters);
    union calibration_workspace *workspace = &application->workspace;
    double apart_rad = turn_align(turn, settings.nominal_separation_rad);
    if (separation_is_exchanged(settings.nominal_separation_rad, apart_rad)) {
        /* The separation is only reported: if the heads are exchanged, every other value derived from this turn is
           wrong. */
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

static enum refusal calibrate_judge_noise(struct application *application) {
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

/* Sets `seen` to false for the orders that have a loaded lane, so that the calibration ignores them. Returns these
   orders, order n in bit n - 1. */
static uint64_t calibrate_hide_loaded(const struct coefficients *loaded,
                                      struct estimate *estimate) {
    uint64_t hidden = 0;
    for (uint32_t place = 0; place < estimate->orders; place++) {
        if (estimate->harmonic[place].seen && coefficients_have(loaded, place + 1)) {
            estimate->harmonic[place].seen = false;
            hidden |= 1ULL << place;
        }
    }
    return hidden;
}

static void calibrate_show_loaded(uint64_t hidden, struct estimate *estimate,
                                  enum verdict *verdicts) {
    for (uint32_t place = 0; place < estimate->orders; place++) {
        if (hidden >> place & 1U) {
            estimate->harmonic[place].seen = true;
            verdicts[place] = VERDICT_LOADED;
        }
    }
}

/* Returns the number of lanes of the core that remain when lanes that follow a condition or have a real order are
   active. */
static uint32_t calibrate_plain_lanes(const struct application *application) {
    const struct followed followed = load_followed_at_work(&application->load);
    return application->configuration.lanes - followed_all_lanes(&followed);
}

static void calibrate_combine(struct application *application, const struct coefficients *own) {
    const struct load *load = &application->load;
    load_combine(load_at_work(load), application_thermal(application, &load->thermal),
                 application->table.celsius, own, calibrate_plain_lanes(application),
                 &application->candidate);
    application->candidate.counts_per_rev = own->counts_per_rev;
    if (own->mean.heads != 0) {
        application->candidate.mean = own->mean;
    }
}

/* Tells whether the calibration's own lanes have an order above `orders`. */
static bool calibrate_has_dropped(const struct coefficients *active,
                                  const struct coefficients *loaded, uint32_t orders) {
    for (uint32_t lane = 0; lane < active->lanes; lane++) {
        uint32_t order = active->lane[lane].order;
        if (order > orders && !coefficients_have(loaded, order)) {
            return true;
        }
    }
    return false;
}

/* Makes the candidate from the error of the mean that `mean` describes; if `mean` has no heads, from the error of head
   1. */
static enum refusal calibrate_make_candidate(struct application *application,
                                             struct mean_set *mean) {
    const struct parameters *parameters = &application->parameters;
    struct estimate *estimate = &application->measured;
    const struct coefficients *loaded = load_at_work(&application->load);
    uint32_t lanes = calibrate_plain_lanes(application);
    uint32_t own_lanes = lanes - judge_sets_lanes_used(loaded);
    struct coefficients own;
    enum verdict verdicts[ORDERS_MAX];
    const struct coefficients *active = state_active(application);
    bool other_heads = mean->heads != (active != NULL ? active->mean.heads : 0U);
    if (other_heads) {
        average_clear(&application->average);
    }
    if (mean->heads != 0) {
        calibrate_mean_average(application, mean);
    } else {
        average_add(&application->average, estimate, parameters->keep);
        average_apply(&application->average, estimate);
    }
    uint64_t hidden = calibrate_hide_loaded(loaded, estimate);
    select_orders(estimate, own_lanes, parameters->gain_limit, verdicts);
    enum refusal reason = coefficients_quantise(
        estimate, verdicts, application->capture.counts_per_rev, own_lanes, &own);
    if (reason != NOT_REFUSED) {
        return reason;
    }
    own.mean = *mean;
    calibrate_combine(application, &own);
    /* Active lanes that were made for other heads do not predict the error that remains now. */
    application->report.prediction =
        gate_predict(estimate, other_heads ? NULL : active, &application->candidate);
    /* The gate compares lanes only, so it cannot judge the new offset of a head that has moved. */
    bool is_needed = other_heads || application->report.moved_head != 0;
    reason = is_needed ? NOT_REFUSED : gate_judge(&application->report.prediction);
    compare_loaded_add(application);
    if (reason != NOT_REFUSED && active != NULL &&
        calibrate_has_dropped(active, loaded, estimate->orders)) {
        /* The parameter `orders` was lowered, so the orders that no turn judges any more are switched off. */
        own = *active;
        coefficients_drop_orders(&own, estimate->orders);
        calibrate_combine(application, &own);
        reason = NOT_REFUSED;
    }
    calibrate_show_loaded(hidden, estimate, verdicts);
    application->estimate = *estimate;
    memcpy(application->verdicts, verdicts, sizeof verdicts);
    return reason;
}

/* Called while a mean is active that this turn did not calibrate, for example because the mean was loaded or because a
   set waits to be judged. Reports head 1's error and the places of the heads, and makes no candidate. */
static enum refusal calibrate_watch_mean(struct application *application, const struct turn *turn) {
    (void)judge_sets_mean(application, turn, &application->active.mean);
    application->estimate = application->measured;
    memset(application->verdicts, 0, sizeof application->verdicts);
    return REFUSED_NOT_BETTER;
}

/* Estimates the error of the mean of all heads if the device calibrates the mean. Otherwise, or if heads 3 and 4 cannot
   be used and no mean is active, estimates the error of head 1. */
static enum refusal calibrate_estimate_heads(struct application *application, struct turn *turn,
                                             struct mean_set *mean) {
    if (calibrate_mean_wanted(application)) {
        enum refusal reason = calibrate_mean_estimate(application, turn, mean);
        if (reason == NOT_REFUSED ||
            turn_judge_active_of_head1(application) != state_active(application)) {
            return reason;
        }
        *mean = (struct mean_set){0};
    }
    return calibrate_estimate(application, turn);
}

/* Compares the offsets of the heads with the offsets in the last turn, if that turn had another speed. Call it before
   the average over turns replaces the noise of the turn. */
static void calibrate_add_to_skew(struct application *application, const struct turn *turn,
                                  bool of_mean) {
    const struct capture *capture = &application->capture;
    const struct estimate *measured = &application->measured;
    struct capture_fault ignored;
    double noise_rad = measured->noise_arcsec / ARCSEC_PER_RAD;
    struct skew_turn made = {
        /* An offset contains the noise of two heads; with `of_mean`, `noise_arcsec` is the noise of one head. */
        .variance =
            (of_mean ? 2.0 : 1.0) * noise_rad * noise_rad * measured->colour / turn->samples,
        .heads = capture->heads,
    };
    if (!of_mean && capture_verify_further(capture, turn, &ignored) != NOT_REFUSED) {
        made.heads = 2;
    }
    if (capture->period_clocks != 0 && application->report.moved_head == 0) {
        made.speed = turn->step_counts / capture->period_clocks * capture->clock_hz * 2.0 * PI /
                     turn->counts_per_rev;
    }
    capture_offsets(capture, turn, made.heads, made.offset_rad);
    head_skew_add(&application->skew, &made);
}

enum refusal calibrate_turn(struct application *application) {
    struct turn turn;
    struct mean_set mean = {0};
    application->candidate_origin = OF_TURN;
    application->found.geometry.heads = 0;
    enum refusal reason =
        capture_verify(&application->capture, (uint32_t)application->parameters.orders, &turn,
                       &application->report.fault);
    if (reason == NOT_REFUSED) {
        reason = calibrate_estimate_heads(application, &turn, &mean);
    }
    if (reason == NOT_REFUSED) {
        calibrate_add_to_skew(application, &turn, mean.heads != 0);
    }
    if (reason == NOT_REFUSED && mean.heads == 0) {
        real_follow_turn(application, &turn);
        judge_sets(application, &turn);
    }
    if (application->candidate_origin != OF_TURN) {
        return NOT_REFUSED;
    }
    if (reason == NOT_REFUSED) {
        reason = calibrate_judge_noise(application);
    }
    if (reason != NOT_REFUSED) {
        return reason;
    }
    bool of_mean = application->has_active && application->active.mean.heads != 0;
    if (mean.heads != 0) {
        application->report.mean_off_arcsec = -1.0;
        if (of_mean) {
            (void)judge_sets_mean(application, &turn, &application->active.mean);
        }
        return calibrate_make_candidate(application, &mean);
    }
    if (of_mean) {
        return calibrate_watch_mean(application, &turn);
    }
    compare_loaded(application, &turn);
    return calibrate_make_candidate(application, &mean);
}
