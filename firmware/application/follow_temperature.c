/* SPDX-License-Identifier: Apache-2.0 */

#include "follow_temperature.h"

#include <math.h>
#include <stddef.h>

#include "alarms.h"
#include "swap.h"

/* Writes the loaded lanes whose orders are not integers (real orders) again, if the phase of one of them has become
   known or unknown, or has changed, since the last call. Returns false if there is no such lane. */
static bool follow_given_phase(struct application *application) {
    struct load *load = &application->load;
    if (!load->phase_given || !application->has_active || load_at_work(load) == NULL) {
        return false;
    }
    const struct followed followed = load_followed_at_work(load);
    application->candidate = application->active;
    application->candidate_origin = OF_TURN;
    load->phase_given = false;
    if (swap_candidate(application, &followed) == SWAP_NOT_READ_BACK) {
        alarm_between_turns(application, ALARM_COEFFICIENTS);
    }
    return true;
}

void follow_between_turns(struct application *application) {
    const struct load *load = &application->load;
    if (follow_given_phase(application)) {
        return;
    }
    const struct thermal *thermal = application_thermal(application, &load->thermal);
    if (!application->has_active || thermal == NULL || thermal->lanes == 0 ||
        load_at_work(load) == NULL) {
        return;
    }
    application->candidate = application->active;
    application->candidate_origin = OF_TURN;
    for (uint32_t place = 0; place < application->candidate.lanes; place++) {
        struct lane *lane = &application->candidate.lane[place];
        const struct lane *written = coefficients_lane_of(&load->loaded, lane->order);
        if (written != NULL) {
            *lane = thermal_lane_at(thermal, written, application->table.celsius);
        }
    }
    if (thermal_apart_counts(&application->candidate, &application->active) <=
        application->parameters.temperature_step_counts) {
        return;
    }
    const struct followed followed = load_followed_at_work(load);
    enum swap_answer answer = swap_candidate(application, &followed);
    if (answer == SWAP_ASKED) {
        application->temperature_swaps++;
    } else if (answer == SWAP_NOT_READ_BACK) {
        alarm_between_turns(application, ALARM_COEFFICIENTS);
    }
}

/* Returns the thermal model of the set that waits to be judged; if no set waits, the model of the loaded set. */
static const struct thermal *follow_thermal_in_use(const struct application *application) {
    if (application->saved_state == SAVED_WAITING) {
        return &application->save->content.thermal;
    }
    const struct load *load = &application->load;
    return load->whole ? &load->received_thermal : &load->thermal;
}

void follow_thermometer(struct application *application) {
    const struct parameters *parameters = &application->parameters;
    const struct temperature_limits limits = {
        .jump_k = parameters->temperature_jump_k,
        .still_s = parameters->temperature_still_s,
    };
    table_temperature_follow(&application->table, &limits,
                             follow_thermal_in_use(application)->time_constant_ms / 1000.0,
                             state_seconds(application));
}

void follow_middle_of_turn(struct application *application) {
    double now_s = state_seconds(application);
    double clock_hz = application->configuration.clock_hz;
    double celsius = application->table.celsius;
    double half_s = 0.0;
    if (application->temperature_clock_hz > 0.0) {
        clock_hz = application->temperature_clock_hz;
    }
    if (application->before_s > 0.0 && clock_hz > 0.0) {
        half_s = 0.5 * (now_s - fmax((double)application->header.start_time / clock_hz,
                                     application->before_s));
    }
    double span_s = now_s - application->before_s;
    double change_k = application->before_s > 0.0 ? celsius - application->before_celsius : 0.0;
    bool between = half_s > 0.0 && span_s > half_s;
    application->middle_celsius = celsius - (between ? change_k * half_s / span_s : 0.0);
}
