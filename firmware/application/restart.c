/* SPDX-License-Identifier: Apache-2.0 */

#include "restart.h"

#include "control.h"
#include "core_setup.h"
#include "prepared.h"
#include "saving.h"
#include "settings.h"
#include "zeros.h"

/* Number of faults in a row after which the firmware stops calibrating and leaves the core unchanged. */
enum { FAULTS_HELD = 3 };

void restart_with_nothing(struct application *application) {
    load_again(&application->load, (uint32_t)application->parameters.counts_per_rev);
    application->has_active = false;
    application->inherited = false;
    application->usual_noise_arcsec = 0.0;
    application->noisy_turns = 0;
    state_forget_turns(application);
    if (state_works(application)) {
        core_failover_off(&application->core);
        control_write(application);
        core_use_head1(&application->core);
    }
}

void application_forget(struct application *application) {
    load_forget(&application->load);
    prepared_forget(application);
    application->active = (struct coefficients){0};
    application->forgotten = true;
    application->saved_state = SAVED_NONE;
    restart_with_nothing(application);
}

void application_start(struct application *application) {
    application->phase = PHASE_NO_CORE;
    application->by_angle = false;
    restart_with_nothing(application);
    if (application->saved_state == SAVED_NOT_CONFIRMED) {
        application->saved_state = SAVED_WAITING;
    }
    if (!core_identify(&application->core, &application->configuration)) {
        return;
    }
    struct core_setup setup = setup_of_parameters(application);
    if (!core_set_up(&application->core, &setup)) {
        return;
    }
    core_use_head1(&application->core);
    core_disarm_compare(&application->core);
    if (application->configuration.has_failover) {
        core_come_back(&application->core, core_left_out(&application->core));
    }
    zeros_forget(application);
    control_give_back_bank(application);
    application->overruns = core_overrun_count(&application->core);
    application->phase = PHASE_WAIT_FOR_INDEX;
    control_write(application);
}

/* Enters PHASE_HELD if a core answers, and leaves the core unchanged. */
static void restart_hold(struct application *application) {
    application->phase = PHASE_NO_CORE;
    if (core_identify(&application->core, &application->configuration)) {
        application->inherited = core_compensates(&application->core);
        application->phase = PHASE_HELD;
    }
}

/* Resumes a core that has worked since before the fault: index, coefficients and correction are kept. Returns false if
   no core answers or it has another number of counts per turn. */
static bool restart_resume(struct application *application) {
    const struct core_access *core = &application->core;
    if (!core_identify(core, &application->configuration)) {
        return false;
    }
    struct core_setup setup = setup_of_parameters(application);
    if (!core_resume(core, &setup)) {
        return false;
    }
    restart_with_nothing(application);
    application->inherited = core_compensates(core);
    zeros_forget(application);
    if (core_indices_seen(core)) {
        application->head2_zero = zeros_look(application, 1, 0);
    }
    control_give_back_bank(application);
    application->overruns = core_overrun_count(core);
    application->phase = PHASE_WAIT_FOR_INDEX;
    control_write(application);
    return true;
}

void application_recover(struct application *application, bool after_fault) {
    if (after_fault) {
        settings_recover(application);
    }
    saving_recover(application);
    settings_keep(application);
}

/* Tells whether the settings are lost while a correction is active. If so, it clears the bypass, which is preset for
   lost settings, so that this correction stays on. */
static bool restart_must_not_touch(struct application *application) {
    if (application->settings_origin != SETTINGS_LOST ||
        !core_identify(&application->core, &application->configuration) ||
        !core_compensates(&application->core)) {
        return false;
    }
    application->bypassed = false;
    return true;
}

void application_begin(struct application *application) {
    if (application->faults_in_a_row >= FAULTS_HELD || restart_must_not_touch(application)) {
        restart_hold(application);
    } else if (application->settings_origin != SETTINGS_KEPT || !restart_resume(application)) {
        application_start(application);
    }
}

void application_rearm(struct application *application) {
    application->faults_in_a_row = 0;
    settings_keep(application);
    application_start(application);
}
