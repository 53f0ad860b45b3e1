/* SPDX-License-Identifier: Apache-2.0 */

#include "turn.h"

#include <stddef.h>

#include "alarms.h"
#include "assertion.h"
#include "calibrate.h"
#include "control.h"
#include "own_sets.h"
#include "prepared.h"
#include "settings.h"
#include "swap.h"
#include "zeros.h"

/* Number of turns without a fault after which the number of faults in a row is set to 0. */
enum { FAULT_FORGOTTEN_TURNS = 20 };

static enum turn_result turn_result_of(enum refusal reason, bool frozen) {
    if (reason == NOT_REFUSED) {
        return frozen ? TURN_KEPT : TURN_APPLIED;
    }
    return reason == REFUSED_NOT_BETTER ? TURN_KEPT : TURN_REFUSED;
}

static void turn_take_temperature(struct application *application) {
    struct turn_report *report = &application->report;
    report->has_temperature =
        application->read_temperature != NULL &&
        application->read_temperature(application->temperature_context, &report->temperature_c);
}

/* Clears the sticky flags, so that the next turn is judged only by its own faults. Clearing would lose an index error
   that came after the end of the refused turn, so that error is evaluated first. */
static void turn_after_refusal(struct application *application) {
    bool in_doubt =
        application->report.reason == REFUSED_INDEX_ERROR || core_index_error(&application->core);
    if (in_doubt) {
        zeros_watch_doubt(application);
        zeros_follow_head2(application);
    }
    core_clear_faults(&application->core);
    bool swings = application->report.reason == REFUSED_WRONG_STEP &&
                  application_capture(application) == CAPTURE_BY_TIME;
    application->by_angle = application->by_angle || swings;
    if (zeros_moved(application) || swings) {
        control_capture_anew(application);
    }
}

static void turn_forget_old_faults(struct application *application) {
    if (application->faults_in_a_row != 0 && application->turns >= FAULT_FORGOTTEN_TURNS) {
        application->faults_in_a_row = 0;
        settings_keep(application);
    }
}

static void turn_take_calibration(struct application *application) {
    const struct followed followed = load_followed_at_work(&application->load);
    own_sets_make(application);
    enum swap_answer answer = swap_candidate(application, &followed);
    application->prepared.has_made = false;
    if (answer != SWAP_ASKED) {
        application->report.result = TURN_KEPT;
        application->report.alarms |= answer == SWAP_NOT_READ_BACK ? ALARM_COEFFICIENTS : 0U;
    }
}

/* Returns the lanes of the applied set that follow a condition or have a real order. */
static struct followed turn_followed(const struct application *application,
                                     enum candidate_origin origin) {
    const struct load *load = &application->load;
    if (origin == OF_SAVED) {
        return application->save->content.followed;
    }
    if (origin == OF_LOAD) {
        return load->received_followed;
    }
    return origin == OF_PENDING ? load->followed : load_followed_at_work(load);
}

/* Applies a loaded or saved set, even while the calibration is frozen. */
static void turn_take_set(struct application *application) {
    struct load *load = &application->load;
    enum candidate_origin origin = application->candidate_origin;
    const struct followed followed = turn_followed(application, origin);
    enum swap_answer answer = swap_candidate(application, &followed);
    if (answer != SWAP_ASKED) {
        bool left_out = answer == SWAP_HEAD_LEFT_OUT;
        application->report.result = TURN_KEPT;
        application->report.alarms |= left_out ? 0U : ALARM_COEFFICIENTS;
        if (origin == OF_LOAD) {
            load_refuse(load, left_out ? LOAD_HEAD_LEFT_OUT : LOAD_NOT_READ_BACK);
        }
        return;
    }
    application->report.result = TURN_APPLIED;
    if (origin == OF_LOAD) {
        prepared_take_over(application);
        load_take_over_received(load);
    } else if (origin == OF_PENDING) {
        load_at_work_again(load);
    } else {
        ASSERT(origin == OF_SAVED && application->save != NULL);
        const struct saved *saved = &application->save->content;
        application->saved_state = SAVED_CONFIRMED;
        load_take_over(load, &saved->loaded, &saved->thermal, &saved->followed, &saved->table,
                       saved->unjudged);
    }
}

static void turn_process(struct application *application) {
    struct turn_report *report = &application->report;
    *report = (struct turn_report){
        .number = ++application->turns,
        .sequence_number = application->header.sequence_number,
        .start_time = application->header.start_time,
        .samples = application->header.samples,
    };
    bool waited = application->saved_state == SAVED_WAITING;
    turn_take_temperature(application);
    report->reason = calibrate_turn(application);
    ASSERT((unsigned)report->reason < REFUSALS);
    report->result = turn_result_of(report->reason, application->frozen);
    application->refusals[report->reason] += report->reason != NOT_REFUSED;
    report->alarms = alarms_of_turn(application);
    if (report->result == TURN_REFUSED) {
        turn_after_refusal(application);
    }
    if (application->saved_state == SAVED_NOT_CONFIRMED && waited) {
        report->alarms |= ALARM_SAVED;
    }
    if (application->candidate_origin != OF_TURN) {
        turn_take_set(application);
    } else if (report->result == TURN_APPLIED) {
        turn_take_calibration(application);
    }
    report->fresh = true;
    turn_forget_old_faults(application);
}

void turn_finish(struct application *application) {
    ASSERT(application->phase == PHASE_CAPTURE);
    application->phase = PHASE_CAPTURE;
    turn_process(application);
    bool known = table_temperature_is_known(&application->table);
    application->before_celsius = application->table.celsius;
    application->before_s = known ? state_seconds(application) : 0.0;
    core_release_capture(&application->core);
}
