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

/* Orders that have a loaded lane are none of the calibration's business: for it they are as if they
   were not seen. Their bits, order n in bit n - 1. */
static uint64_t hide_loaded_orders(const struct coefficients *loaded, struct estimate *estimate) {
    uint64_t hidden = 0;
    for (uint32_t place = 0; place < estimate->orders; place++) {
        if (estimate->harmonic[place].seen && coefficients_have(loaded, place + 1)) {
            estimate->harmonic[place].seen = false;
            hidden |= 1ULL << place;
        }
    }
    return hidden;
}

static void show_loaded_orders(uint64_t hidden, struct estimate *estimate,
                               enum verdict *verdicts) {
    for (uint32_t place = 0; place < estimate->orders; place++) {
        if (hidden >> place & 1U) {
            estimate->harmonic[place].seen = true;
            verdicts[place] = VERDICT_LOADED;
        }
    }
}

static uint32_t lanes_used(const struct coefficients *coefficients) {
    uint32_t used = 0;
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        used += coefficients->lane[lane].order != 0;
    }
    return used;
}

static void combine(struct application *application, const struct coefficients *own) {
    const struct load *load = &application->load;
    load_combine(&load->loaded, application_thermal(application, &load->thermal),
                 application->table.celsius, own, application->configuration.lanes,
                 &application->candidate);
    application->candidate.counts_per_rev = own->counts_per_rev;
}

/* An order that `orders` no longer has, of the calibration's own. */
static bool has_dropped_orders(const struct coefficients *active,
                               const struct coefficients *loaded, uint32_t orders) {
    for (uint32_t lane = 0; lane < active->lanes; lane++) {
        uint32_t order = active->lane[lane].order;
        if (order > orders && !coefficients_have(loaded, order)) {
            return true;
        }
    }
    return false;
}

static enum refusal make_candidate(struct application *application) {
    const struct parameters *parameters = &application->parameters;
    struct estimate *estimate = &application->measured;
    const struct coefficients *loaded = &application->load.loaded;
    uint32_t lanes = application->configuration.lanes;
    uint32_t own_lanes = lanes - lanes_used(loaded);
    struct coefficients own;
    enum verdict verdicts[ORDERS_MAX];
    average_add(&application->average, estimate, parameters->keep);
    average_apply(&application->average, estimate);
    uint64_t hidden = hide_loaded_orders(loaded, estimate);
    select_orders(estimate, own_lanes, parameters->gain_limit, verdicts);
    enum refusal reason = coefficients_quantise(
        estimate, verdicts, application->capture.counts_per_rev, own_lanes, &own);
    if (reason != NOT_REFUSED) {
        return reason;
    }
    combine(application, &own);
    const struct coefficients *active = application->has_active ? &application->active : NULL;
    application->report.prediction = gate_predict(estimate, active, &application->candidate);
    reason = gate_judge(&application->report.prediction);
    if (reason != NOT_REFUSED && active != NULL &&
        has_dropped_orders(active, loaded, estimate->orders)) {
        /* `orders` was lowered: what no turn judges any more is not applied any more. */
        own = *active;
        coefficients_drop_orders(&own, estimate->orders);
        combine(application, &own);
        reason = NOT_REFUSED;
    }
    show_loaded_orders(hidden, estimate, verdicts);
    application->estimate = *estimate;
    memcpy(application->verdicts, verdicts, sizeof verdicts);
    return reason;
}

/* The saved coefficients, where with them head 2 less head 1 scatters clearly less. */
static void judge_saved(struct application *application, const struct turn *turn) {
    const struct saved *saved = &application->save->content;
    const struct coefficients *active = application->has_active ? &application->active : NULL;
    uint32_t lanes = application->configuration.lanes;
    load_combine(&saved->loaded, application_thermal(application, &saved->thermal),
                 application->table.celsius, &saved->own, lanes, &application->candidate);
    bool fits = saved_lanes(saved) <= lanes &&
                saved->own.counts_per_rev == application->capture.counts_per_rev;
    if (fits && load_is_better(turn, active, &application->candidate)) {
        application->candidate_origin = OF_SAVED;
        application->estimate = application->measured;
    } else {
        application->saved_state = SAVED_NOT_CONFIRMED;
    }
}

/* The loaded set is the idle bank's only owner in this turn. */
static void judge_load(struct application *application, const struct turn *turn) {
    struct load *load = &application->load;
    const struct coefficients *active = application->has_active ? &application->active : NULL;
    struct coefficients own;
    load_own_lanes(load, active, &own);
    uint32_t lanes = application->configuration.lanes;
    load_combine(&load->received, application_thermal(application, &load->received_thermal),
                 application->table.celsius, &own, lanes, &application->candidate);
    bool taken_away = lanes_used(&load->received) == 0;
    if (!taken_away && !load_is_no_worse(turn, active, &application->candidate)) {
        load_refuse(load, LOAD_WORSE);
        return;
    }
    application->candidate_origin = OF_LOAD;
    application->estimate = application->measured;
}

enum refusal calibrate_turn(struct application *application) {
    struct turn turn;
    application->candidate_origin = OF_TURN;
    enum refusal reason =
        capture_verify(&application->capture, (uint32_t)application->parameters.orders, &turn,
                       &application->report.fault);
    if (reason == NOT_REFUSED) {
        reason = estimate_turn(application, &turn);
    }
    if (reason == NOT_REFUSED && application->saved_state == SAVED_WAITING) {
        judge_saved(application, &turn);
    }
    if (reason == NOT_REFUSED && application->candidate_origin == OF_TURN &&
        application->load.state == LOAD_WAITING) {
        judge_load(application, &turn);
    }
    if (application->candidate_origin != OF_TURN) {
        return NOT_REFUSED;
    }
    if (reason == NOT_REFUSED) {
        reason = judge_noise(application);
    }
    return reason == NOT_REFUSED ? make_candidate(application) : reason;
}
