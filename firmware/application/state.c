/* SPDX-License-Identifier: Apache-2.0 */

#include "state.h"

#include <stddef.h>
#include <string.h>

#include "assertion.h"

const char *application_phase_name(enum application_phase phase) {
    static const char *const names[] = {"no_core", "wait_for_index", "capture", "swap", "held"};
    return (unsigned)phase <= PHASE_HELD ? names[phase] : "unknown";
}

const char *settings_origin_name(enum settings_origin origin) {
    static const char *const names[] = {"preset", "kept", "lost", "saved"};
    return (unsigned)origin <= SETTINGS_SAVED ? names[origin] : "unknown";
}

const char *saved_state_name(enum saved_state state) {
    static const char *const names[] = {"none", "waiting", "confirmed", "not_confirmed"};
    return (unsigned)state <= SAVED_NOT_CONFIRMED ? names[state] : "unknown";
}

const char *output_fault_name(bool stands) {
    return stands ? "cannot_keep_up" : "none";
}

const char *turn_result_name(enum turn_result result) {
    static const char *const names[] = {"applied", "kept", "refused"};
    return (unsigned)result <= TURN_REFUSED ? names[result] : "unknown";
}

bool state_works(const struct application *application) {
    return application->phase != PHASE_NO_CORE && application->phase != PHASE_HELD;
}

double state_seconds(const struct application *application) {
    double clock_hz = application->temperature_clock_hz > 0.0 ? application->temperature_clock_hz
                                                              : application->configuration.clock_hz;
    return clock_hz > 0.0 ? (double)core_position(&application->core).time / clock_hz : 0.0;
}

const struct thermal *application_thermal(const struct application *application,
                                          const struct thermal *thermal) {
    return table_temperature_is_known(&application->table) ? thermal : NULL;
}

const struct coefficients *state_active(const struct application *application) {
    return application->has_active ? &application->active : NULL;
}

/* Tells whether the correction is on. Without a bypass it is on with coefficients that this program wrote, or with
   coefficients from before a fault. The words in the banks do not show this: they survive a reset of the core and may
   belong to other coefficients. */
bool application_corrects(const struct application *application) {
    return (application->has_active || application->inherited) && !application->bypassed;
}

enum core_capture application_capture(const struct application *application) {
    if (application->parameters.sync_capture != 0.0) {
        return CAPTURE_BY_SYNC;
    }
    return application->by_angle ? CAPTURE_BY_ANGLE : CAPTURE_BY_TIME;
}

void state_assert(const struct application *application) {
    ASSERT((unsigned)application->phase <= PHASE_HELD);
    ASSERT((unsigned)application->settings_origin <= SETTINGS_SAVED);
    ASSERT((unsigned)application->saved_state <= SAVED_NOT_CONFIRMED);
    ASSERT((unsigned)application->dump <= DUMP_NOT_COPIED);
    ASSERT((unsigned)application->candidate_origin <= OF_SAVED);
    /* A device that is no ArcTrue core may answer with any number of lanes. */
    ASSERT(application->phase == PHASE_NO_CORE || application->configuration.lanes <= LANES_LIMIT);
    ASSERT(application->active.lanes <= LANES_LIMIT);
    ASSERT(!application->has_active ||
           application->active.lanes <= application->configuration.lanes);
    ASSERT(!application->has_active || !application->inherited);
    ASSERT(application->saved_state == SAVED_NONE || application->save != NULL);
    load_assert(&application->load);
}

void state_forget_turns(struct application *application) {
    average_clear(&application->average);
    if (application->axis != NULL) {
        application->axis->orders = 0;
    }
    application->skew = (struct head_skew){.heads = 0};
    application->found.geometry.heads = 0;
    memset(application->capture.travel, 0, sizeof application->capture.travel);
}
