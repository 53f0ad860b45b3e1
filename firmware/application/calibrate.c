/* SPDX-License-Identifier: Apache-2.0 */

#include "calibrate.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "assertion.h"
#include "calibrate_mean.h"
#include "judge.h"
#include "local_table.h"
#include "real_follow.h"
#include "separation.h"
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

static uint32_t calibrate_lanes_used(const struct coefficients *coefficients) {
    uint32_t used = 0;
    for (uint32_t lane = 0; coefficients != NULL && lane < coefficients->lanes; lane++) {
        used += coefficients->lane[lane].order != 0;
    }
    return used;
}

/* Returns the number of lanes of the core that remain when lanes that follow a condition or have a real order are
   active. */
static uint32_t calibrate_plain_lanes(const struct application *application) {
    const struct followed followed = load_followed_at_work(&application->load);
    return application->configuration.lanes - followed_all_lanes(&followed);
}

/* Returns the places of the used lanes, one bit per place. */
static uint64_t calibrate_lanes_in_use(const struct coefficients *coefficients) {
    uint64_t used = 0;
    ASSERT(coefficients->lanes <= LANES_LIMIT);
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        used |= (uint64_t)(coefficients->lane[lane].order != 0) << lane;
    }
    return used;
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

/* Returns the active coefficients if their lanes correct head 1, otherwise NULL: lanes of a mean do not describe head
   1's error. */
static const struct coefficients *calibrate_active_of_head1(const struct application *application) {
    const struct coefficients *active = state_active(application);
    return active != NULL && active->mean.heads != 0 ? NULL : active;
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

/* Multiple of the variance of a component above which the square of a change counts as real and not as noise. */
#define CHANGED 18.0

/* Returns the larger of two estimates of the error's change since earlier turns. The first is the largest difference
   between a measured order of the calibration and its active lane, reduced by the noise (CHANGED). The second is the
   change that the thermal model gives, since the previous turn, for the loaded orders that follow the temperature. */
static double calibrate_change_arcsec(const struct application *application) {
    const struct estimate *estimate = &application->measured;
    const struct coefficients *active = calibrate_active_of_head1(application);
    const struct load *load = &application->load;
    const struct coefficients *loaded = load_at_work(load);
    double most = 0.0;
    for (uint32_t place = 0; active != NULL && place < estimate->orders; place++) {
        const struct harmonic *harmonic = &estimate->harmonic[place];
        if (harmonic->seen && coefficients_have(active, place + 1) &&
            !coefficients_have(loaded, place + 1)) {
            const struct vector value = {harmonic->cosine, harmonic->sine};
            struct vector before = coefficients_components(active, place + 1);
            double square = vector_square(vector_difference(value, before));
            double noise = harmonic->variance_cosine + harmonic->variance_sine;
            most = fmax(most, square - 0.5 * CHANGED * noise);
        }
    }
    double followed = 0.0;
    if (loaded != NULL && application->before_s > 0.0) {
        followed = thermal_change_counts(application_thermal(application, &load->thermal), loaded,
                                         application->before_celsius, application->table.celsius) *
                   ARCSEC_PER_TURN / application->capture.counts_per_rev;
    }
    return fmax(sqrt(most), followed);
}

/* Returns the speed of head 1 in the turn, counts per clock. Without times of the samples it is the mean speed, in the
   direction of the turn's steps, because the table may have reversed after the turn. */
static double calibrate_speed(const struct capture *capture, const struct turn *turn) {
    return capture->period_clocks != 0 ? turn->step_counts / capture->period_clocks
                                       : copysign(capture->mean_speed, turn->step_counts);
}

static struct judge calibrate_judge(struct application *application, const struct turn *turn) {
    return (struct judge){
        .turn = turn,
        .motion = {calibrate_speed(&application->capture, turn)},
        .estimate = &application->measured,
        .workspace = &application->workspace.further,
        .gain_limit = application->parameters.gain_limit,
        .change_arcsec = calibrate_change_arcsec(application),
    };
}

/* Compares the active local table with the turn, if the idle bank, a copy of the active one, still holds its points. */
static void calibrate_watch_table(struct application *application, const struct turn *turn) {
    struct load *load = &application->load;
    if (load->table.place.choice != 0 && local_table_is_held(application, load->table.crc)) {
        watch_table(&load->watch, local_table_evidence(application, &load->table.place, turn),
                    EVIDENCE_ENOUGH);
    }
}

/* Compares the loaded orders and the loaded local table with the turn. Call it before the turn is averaged, because an average would lag behind an
   order that changes. */
static void calibrate_watch_loaded(struct application *application, const struct turn *turn) {
    struct load *load = &application->load;
    const struct coefficients *set = load_at_work(load);
    watch_begin(&load->watch);
    if (set == NULL || !application->has_active) {
        return;
    }
    struct judge judge = calibrate_judge(application, turn);
    judge.followed = &load->followed;
    const struct thermal *thermal = application_thermal(application, &load->thermal);
    load_combine(set, thermal, application->middle_celsius, NULL, set->lanes,
                 &application->candidate);
    judge_look(&judge, set);
    for (uint32_t place = 0; place < set->lanes; place++) {
        uint32_t order = set->lane[place].order;
        bool follows = thermal_follows(thermal, order);
        struct vector applied =
            judge_value(&judge, follows ? &application->candidate : &application->active, order);
        if (order == 0) {
            continue;
        }
        const struct sight sight = judge_sight(&judge, order, applied);
        if (sight.state == SIGHT_CLEAR) {
            watch_lane(&load->watch, place, &sight, applied);
        }
    }
    calibrate_watch_table(application, turn);
    if (application->report.followed_lanes == 0) {
        application->report.followed_lanes =
            judge_measure_followed(&judge, &application->active, application->report.followed);
    }
}

/* Adds the error that remains at the loaded orders to both predictions, because these orders keep this error with
   either choice of coefficients. */
static void calibrate_add_loaded(struct application *application) {
    struct gate_prediction *prediction = &application->report.prediction;
    double square = application->load.watch.mean_square;
    double active = prediction->active_arcsec;
    double candidate = prediction->candidate_arcsec;
    application->report.loaded_arcsec = sqrt(square);
    prediction->active_arcsec = sqrt(active * active + square);
    prediction->candidate_arcsec = sqrt(candidate * candidate + square);
}

/* Makes the candidate from the error of the mean that `mean` describes; if `mean` has no heads, from the error of head
   1. */
static enum refusal calibrate_make_candidate(struct application *application,
                                             struct mean_set *mean) {
    const struct parameters *parameters = &application->parameters;
    struct estimate *estimate = &application->measured;
    const struct coefficients *loaded = load_at_work(&application->load);
    uint32_t lanes = calibrate_plain_lanes(application);
    uint32_t own_lanes = lanes - calibrate_lanes_used(loaded);
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
    calibrate_add_loaded(application);
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

/* Fills the report of a turn whose candidate does not come from the calibration. */
static void calibrate_take_candidate(struct application *application,
                                     enum candidate_origin origin) {
    const struct coefficients *active = state_active(application);
    application->candidate_origin = origin;
    application->estimate = application->measured;
    if (application->candidate.mean.heads == 0) {
        application->report.prediction =
            gate_predict(&application->measured, active, &application->candidate);
    }
}

/* Tolerance of a head's place in counts: an index mark repeats within one count, both in this turn and in the turn from
   which the set was made. */
#define PLACE_COUNTS 2.0

/* Judges a mean only by the places of its heads: a turn shows whether the heads are at the places that the mean's
   offsets give. It cannot judge the lanes of a mean, because these do not describe head 1's error. */
static enum judgement calibrate_judge_mean(struct application *application, const struct turn *turn,
                                           const struct mean_set *set) {
    double place[HEADS_MOST];
    uint32_t counts_per_rev = application->capture.counts_per_rev;
    double arcsec = ARCSEC_PER_TURN / counts_per_rev;
    application->report.mean_off_arcsec = -1.0;
    if (set->heads != application->capture.heads ||
        !capture_places(&application->capture, turn->samples, place)) {
        return JUDGED_NOT_YET;
    }
    double off = mean_set_off(set, place, counts_per_rev);
    application->report.mean_off_arcsec = off * arcsec;
    bool far = off * arcsec > application->parameters.alarm_separation_arcsec;
    return far && off > PLACE_COUNTS ? JUDGED_WRONG : JUDGED_RIGHT;
}

/* Returns LOAD_TAKEN if the core can apply a set, otherwise the reason why it cannot. A set that was loaded or saved
   earlier may have been made for another bitstream, or saved by an earlier firmware. */
static enum load_answer calibrate_core_takes(const struct application *application,
                                             const struct coefficients *set,
                                             const struct followed *followed,
                                             const struct load_table *table) {
    const struct core_configuration *configuration = &application->configuration;
    const struct core_origin origin = core_origin(&application->core);
    uint32_t heads = set->mean.heads;
    if (heads != 0 && (!configuration->has_mean || heads != configuration->heads)) {
        return LOAD_OTHER_HEADS;
    }
    if (calibrate_lanes_used(set) + followed_all_lanes(followed) > configuration->lanes) {
        return LOAD_TOO_MANY_LANES;
    }
    if (followed->lanes != 0 && !origin.has_modulators) {
        return LOAD_NO_MODULATORS;
    }
    if (!followed_speed_is_stable(followed)) {
        return LOAD_UNSTABLE_SPEED;
    }
    if (followed->real_lanes != 0 && !origin.has_real_orders) {
        return LOAD_NO_REAL_ORDERS;
    }
    if (followed->real_lanes != 0 &&
        !real_lanes_counts_suffice(configuration->lanes, set->counts_per_rev)) {
        return LOAD_TOO_FEW_COUNTS;
    }
    return table->place.choice == 0 || origin.has_local_table ? LOAD_TAKEN : LOAD_NO_LOCAL_TABLE;
}

/* Tells whether a turn of two heads contradicts the local table of a set. Turns do not judge the table of a mean. */
static bool calibrate_table_is_wrong(const struct application *application,
                                     const struct coefficients *set, const struct load_table *table,
                                     const struct turn *turn) {
    return table->place.choice != 0 && set->mean.heads == 0 &&
           local_table_evidence(application, &table->place, turn) <= -EVIDENCE_ENOUGH;
}

/* Judges the saved coefficients, combined with the active lanes or, if none are active, with the saved lanes of the
   calibration. */
static void calibrate_judge_saved(struct application *application, const struct turn *turn) {
    const struct saved *saved = &application->save->content;
    struct judge judge = calibrate_judge(application, turn);
    judge.followed = &saved->followed;
    const struct coefficients *active = calibrate_active_of_head1(application);
    uint32_t lanes = application->configuration.lanes;
    if (saved->table.place.choice != 0 &&
        (application->load.state == LOAD_RECEIVING || application->load.whole)) {
        /* The idle bank holds the points of the table that is being received, so the saved table cannot use it. */
        return;
    }
    bool fits = saved_lanes(saved) <= lanes &&
                calibrate_core_takes(application, &saved->loaded, &saved->followed,
                                     &saved->table) == LOAD_TAKEN &&
                saved->own.counts_per_rev == application->capture.counts_per_rev;
    fits = fits && (saved->table.place.choice == 0 || local_table_restore(application));
    if (!fits) {
        application->saved_state = SAVED_NOT_CONFIRMED;
        return;
    }
    load_combine(&saved->loaded, application_thermal(application, &saved->thermal),
                 application->middle_celsius, active != NULL ? active : &saved->own,
                 lanes - followed_all_lanes(&saved->followed), &application->candidate);
    enum judgement found =
        saved->loaded.mean.heads != 0
            ? calibrate_judge_mean(application, turn, &saved->loaded.mean)
            : judge_again(&judge, &saved->loaded, saved->unjudged,
                          application->parameters.alarm_error_arcsec, &application->candidate);
    if (calibrate_table_is_wrong(application, &saved->loaded, &saved->table, turn)) {
        found = JUDGED_WRONG;
    }
    if (found == JUDGED_RIGHT) {
        calibrate_take_candidate(application, OF_SAVED);
    } else if (found == JUDGED_WRONG) {
        application->saved_state = SAVED_NOT_CONFIRMED;
    }
}

/* Combines the judgement of the received lanes with the judgement of the received local table. */
static enum load_answer calibrate_judge_table(struct application *application,
                                              const struct turn *turn, enum load_answer of_lanes) {
    struct load *load = &application->load;
    bool may_be_right = of_lanes == LOAD_TAKEN || of_lanes == LOAD_NOT_YET;
    if (load->received_table.place.choice == 0 || !may_be_right) {
        return of_lanes;
    }
    load->table_evidence += local_table_evidence(application, &load->received_table.place, turn);
    if (load->table_evidence <= -EVIDENCE_ENOUGH) {
        return LOAD_WORSE;
    }
    return load->table_evidence >= EVIDENCE_ENOUGH || load->forced ? of_lanes : LOAD_NOT_YET;
}

/* Judges the received set. Call it only if no saved set has become the candidate of this turn. */
static void calibrate_judge_load(struct application *application, const struct turn *turn) {
    struct load *load = &application->load;
    struct judge judge = calibrate_judge(application, turn);
    judge.followed = &load->received_followed;
    const struct coefficients *active = calibrate_active_of_head1(application);
    struct coefficients own;
    enum load_answer answer = calibrate_core_takes(application, &load->received,
                                                   &load->received_followed, &load->received_table);
    if (load->received.counts_per_rev != application->capture.counts_per_rev) {
        answer = LOAD_ANOTHER_TABLE;
    }
    if (answer != LOAD_TAKEN) {
        load_refuse(load, answer);
        return;
    }
    load_own_lanes(load, active, &own);
    load_combine(&load->received, application_thermal(application, &load->received_thermal),
                 application->middle_celsius, &own,
                 application->configuration.lanes - followed_all_lanes(&load->received_followed),
                 &application->candidate);
    answer = LOAD_NOT_YET;
    if (load->received.mean.heads == 0) {
        answer = calibrate_judge_table(
            application, turn, judge_received(&judge, load, active, &application->candidate));
        application->report.followed_lanes =
            judge_measure_followed(&judge, &application->candidate, application->report.followed);
    } else {
        enum judgement found = calibrate_judge_mean(application, turn, &load->received.mean);
        answer = found == JUDGED_RIGHT ? LOAD_TAKEN : answer;
        answer = found == JUDGED_WRONG ? LOAD_OTHER_HEADS : answer;
        load->received_unjudged = calibrate_lanes_in_use(&load->received);
    }
    if (answer == LOAD_TAKEN) {
        calibrate_take_candidate(application, OF_LOAD);
    } else if (answer != LOAD_NOT_YET) {
        load_refuse(load, answer);
    }
}

/* Judges a set that was loaded before the start. The turn must confirm the set with the set's lanes alone, without
   lanes of the calibration. */
static void calibrate_judge_pending(struct application *application, const struct turn *turn) {
    struct load *load = &application->load;
    struct judge judge = calibrate_judge(application, turn);
    judge.followed = &load->followed;
    const struct thermal *thermal = application_thermal(application, &load->thermal);
    const struct coefficients *active = calibrate_active_of_head1(application);
    uint32_t lanes = application->configuration.lanes - followed_all_lanes(&load->followed);
    struct coefficients *candidate = &application->candidate;
    enum load_answer answer =
        calibrate_core_takes(application, &load->loaded, &load->followed, &load->table);
    if (answer == LOAD_TAKEN && load->table.place.choice != 0 &&
        !local_table_is_held(application, load->table.crc)) {
        answer = LOAD_NOT_WHOLE;
    }
    if (answer != LOAD_TAKEN) {
        load_reject(load, answer);
        return;
    }
    load_combine(&load->loaded, thermal, application->middle_celsius, NULL, lanes, candidate);
    enum judgement found = load->loaded.mean.heads != 0
                               ? calibrate_judge_mean(application, turn, &load->loaded.mean)
                               : judge_again(&judge, &load->loaded, load->unjudged, 0.0, candidate);
    if (calibrate_table_is_wrong(application, &load->loaded, &load->table, turn)) {
        found = JUDGED_WRONG;
    }
    if (found == JUDGED_WRONG) {
        load_reject(load, LOAD_WORSE);
    } else if (found == JUDGED_RIGHT) {
        load_combine(&load->loaded, thermal, application->middle_celsius, active, lanes, candidate);
        calibrate_take_candidate(application, OF_PENDING);
    }
}

/* Reports head 1's error and the places of the heads while a mean is active that this turn did not calibrate, for
   example because the mean was loaded or because a set waits to be judged. Makes no candidate for head 1. */
static enum refusal calibrate_watch_mean(struct application *application, const struct turn *turn) {
    (void)calibrate_judge_mean(application, turn, &application->active.mean);
    application->estimate = application->measured;
    memset(application->verdicts, 0, sizeof application->verdicts);
    return REFUSED_NOT_BETTER;
}

static void calibrate_judge_sets(struct application *application, const struct turn *turn) {
    const struct load *load = &application->load;
    if (application->saved_state == SAVED_WAITING) {
        calibrate_judge_saved(application, turn);
    }
    if (application->candidate_origin == OF_TURN && load->whole) {
        calibrate_judge_load(application, turn);
    }
    if (application->candidate_origin == OF_TURN && load->loaded_state == LOADED_PENDING) {
        calibrate_judge_pending(application, turn);
    }
}

/* Estimates the error of the mean of all heads if the device calibrates the mean. Otherwise, or if heads 3 and 4 cannot
   be used and no mean is active, estimates the error of head 1. */
static enum refusal calibrate_estimate_heads(struct application *application, struct turn *turn,
                                             struct mean_set *mean) {
    if (calibrate_mean_wanted(application)) {
        enum refusal reason = calibrate_mean_estimate(application, turn, mean);
        if (reason == NOT_REFUSED ||
            calibrate_active_of_head1(application) != state_active(application)) {
            return reason;
        }
        *mean = (struct mean_set){0};
    }
    return calibrate_estimate(application, turn);
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
    if (reason == NOT_REFUSED && mean.heads == 0) {
        real_follow_turn(application, &turn);
        calibrate_judge_sets(application, &turn);
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
            (void)calibrate_judge_mean(application, &turn, &application->active.mean);
        }
        return calibrate_make_candidate(application, &mean);
    }
    if (of_mean) {
        return calibrate_watch_mean(application, &turn);
    }
    calibrate_watch_loaded(application, &turn);
    return calibrate_make_candidate(application, &mean);
}
