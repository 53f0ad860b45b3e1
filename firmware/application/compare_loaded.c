/* SPDX-License-Identifier: Apache-2.0 */

#include "compare_loaded.h"

#include <math.h>
#include <stddef.h>

#include "local_table.h"
#include "turn_judge.h"

/* Compares the active local table with the turn, if the idle bank still holds a copy of the table's points. */
static void compare_loaded_table(struct application *application, const struct turn *turn) {
    struct load *load = &application->load;
    if (load->table.place.choice != 0 && local_table_is_held(application, load->table.crc)) {
        watch_table(&load->watch, local_table_evidence(application, &load->table.place, turn),
                    EVIDENCE_ENOUGH);
    }
}

void compare_loaded(struct application *application, const struct turn *turn) {
    struct load *load = &application->load;
    const struct coefficients *set = load_at_work(load);
    watch_begin(&load->watch);
    if (set == NULL || !application->has_active) {
        return;
    }
    struct judge judge = turn_judge(application, turn);
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
    compare_loaded_table(application, turn);
    if (application->report.followed_lanes == 0) {
        application->report.followed_lanes =
            judge_measure_followed(&judge, &application->active, application->report.followed);
    }
}

void compare_loaded_add(struct application *application) {
    struct gate_prediction *prediction = &application->report.prediction;
    double square = application->load.watch.mean_square;
    double active = prediction->active_arcsec;
    double candidate = prediction->candidate_arcsec;
    application->report.loaded_arcsec = sqrt(square);
    prediction->active_arcsec = sqrt(active * active + square);
    prediction->candidate_arcsec = sqrt(candidate * candidate + square);
}
