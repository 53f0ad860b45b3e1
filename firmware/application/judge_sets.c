/* SPDX-License-Identifier: Apache-2.0 */

#include "judge_sets.h"

#include <stddef.h>

#include "assertion.h"
#include "local_table.h"
#include "turn_judge.h"
#include "units.h"

uint32_t judge_sets_lanes_used(const struct coefficients *coefficients) {
    uint32_t used = 0;
    for (uint32_t lane = 0; coefficients != NULL && lane < coefficients->lanes; lane++) {
        used += coefficients->lane[lane].order != 0;
    }
    return used;
}

/* Returns the places of the used lanes, one bit per place. */
static uint64_t judge_sets_lanes_in_use(const struct coefficients *coefficients) {
    uint64_t used = 0;
    ASSERT(coefficients->lanes <= LANES_LIMIT);
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        used |= (uint64_t)(coefficients->lane[lane].order != 0) << lane;
    }
    return used;
}

/* Fills the report of a turn whose candidate does not come from the calibration. */
static void judge_sets_take(struct application *application, enum candidate_origin origin) {
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

enum judgement judge_sets_mean(struct application *application, const struct turn *turn,
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
static enum load_answer judge_sets_core_takes(const struct application *application,
                                              const struct coefficients *set,
                                              const struct followed *followed,
                                              const struct load_table *table) {
    const struct core_configuration *configuration = &application->configuration;
    const struct core_origin origin = core_origin(&application->core);
    uint32_t heads = set->mean.heads;
    if (heads != 0 && (!configuration->has_mean || heads != configuration->heads)) {
        return LOAD_OTHER_HEADS;
    }
    if (judge_sets_lanes_used(set) + followed_all_lanes(followed) > configuration->lanes) {
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
static bool judge_sets_table_is_wrong(const struct application *application,
                                      const struct coefficients *set,
                                      const struct load_table *table, const struct turn *turn) {
    return table->place.choice != 0 && set->mean.heads == 0 &&
           local_table_evidence(application, &table->place, turn) <= -EVIDENCE_ENOUGH;
}

/* Judges the saved coefficients, combined with the active lanes or, if none are active, with the saved lanes of the
   calibration. */
static void judge_sets_saved(struct application *application, const struct turn *turn) {
    const struct saved *saved = &application->save->content;
    struct judge judge = turn_judge(application, turn);
    judge.followed = &saved->followed;
    const struct coefficients *active = turn_judge_active_of_head1(application);
    uint32_t lanes = application->configuration.lanes;
    if (saved->table.place.choice != 0 &&
        (application->load.state == LOAD_RECEIVING || application->load.whole)) {
        /* The idle bank holds the points of the table that is being received, so the saved table cannot use it. */
        return;
    }
    bool fits = saved_lanes(saved) <= lanes &&
                judge_sets_core_takes(application, &saved->loaded, &saved->followed,
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
            ? judge_sets_mean(application, turn, &saved->loaded.mean)
            : judge_again(&judge, &saved->loaded, saved->unjudged,
                          application->parameters.alarm_error_arcsec, &application->candidate);
    if (judge_sets_table_is_wrong(application, &saved->loaded, &saved->table, turn)) {
        found = JUDGED_WRONG;
    }
    if (found == JUDGED_RIGHT) {
        judge_sets_take(application, OF_SAVED);
    } else if (found == JUDGED_WRONG) {
        application->saved_state = SAVED_NOT_CONFIRMED;
    }
}

/* Combines the judgement of the received lanes with the judgement of the received local table. */
static enum load_answer judge_sets_table(struct application *application, const struct turn *turn,
                                         enum load_answer of_lanes) {
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
static void judge_sets_received(struct application *application, const struct turn *turn) {
    struct load *load = &application->load;
    struct judge judge = turn_judge(application, turn);
    judge.followed = &load->received_followed;
    const struct coefficients *active = turn_judge_active_of_head1(application);
    struct coefficients own;
    enum load_answer answer = judge_sets_core_takes(
        application, &load->received, &load->received_followed, &load->received_table);
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
        answer = judge_sets_table(application, turn,
                                  judge_received(&judge, load, active, &application->candidate));
        application->report.followed_lanes =
            judge_measure_followed(&judge, &application->candidate, application->report.followed);
    } else {
        enum judgement found = judge_sets_mean(application, turn, &load->received.mean);
        answer = found == JUDGED_RIGHT ? LOAD_TAKEN : answer;
        answer = found == JUDGED_WRONG ? LOAD_OTHER_HEADS : answer;
        load->received_unjudged = judge_sets_lanes_in_use(&load->received);
    }
    if (answer == LOAD_TAKEN) {
        judge_sets_take(application, OF_LOAD);
    } else if (answer != LOAD_NOT_YET) {
        load_refuse(load, answer);
    }
}

/* Judges a set that was loaded before the start. The turn must confirm the set with the set's lanes alone, without
   lanes of the calibration. */
static void judge_sets_pending(struct application *application, const struct turn *turn) {
    struct load *load = &application->load;
    struct judge judge = turn_judge(application, turn);
    judge.followed = &load->followed;
    const struct thermal *thermal = application_thermal(application, &load->thermal);
    const struct coefficients *active = turn_judge_active_of_head1(application);
    uint32_t lanes = application->configuration.lanes - followed_all_lanes(&load->followed);
    struct coefficients *candidate = &application->candidate;
    enum load_answer answer =
        judge_sets_core_takes(application, &load->loaded, &load->followed, &load->table);
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
                               ? judge_sets_mean(application, turn, &load->loaded.mean)
                               : judge_again(&judge, &load->loaded, load->unjudged, 0.0, candidate);
    if (judge_sets_table_is_wrong(application, &load->loaded, &load->table, turn)) {
        found = JUDGED_WRONG;
    }
    if (found == JUDGED_WRONG) {
        load_reject(load, LOAD_WORSE);
    } else if (found == JUDGED_RIGHT) {
        load_combine(&load->loaded, thermal, application->middle_celsius, active, lanes, candidate);
        judge_sets_take(application, OF_PENDING);
    }
}

void judge_sets(struct application *application, const struct turn *turn) {
    const struct load *load = &application->load;
    if (application->saved_state == SAVED_WAITING) {
        judge_sets_saved(application, turn);
    }
    if (application->candidate_origin == OF_TURN && load->whole) {
        judge_sets_received(application, turn);
    }
    if (application->candidate_origin == OF_TURN && load->loaded_state == LOADED_PENDING) {
        judge_sets_pending(application, turn);
    }
}
