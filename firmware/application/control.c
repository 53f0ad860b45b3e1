/* SPDX-License-Identifier: Apache-2.0 */

#include "control.h"

void control_write(const struct application *application) {
    core_control(&application->core, application_corrects(application), true,
                 application_capture(application));
}

void control_give_back_bank(const struct application *application) {
    if (core_status(&application->core).capture_ready) {
        core_release_capture(&application->core);
    }
}

void control_capture_anew(const struct application *application) {
    core_control(&application->core, application_corrects(application), true, CAPTURE_OFF);
    control_write(application);
}

void control_arm_compare(const struct application *application) {
    const struct parameters *parameters = &application->parameters;
    if (parameters->compare_on == 0.0) {
        core_disarm_compare(&application->core);
    } else if (application->phase != PHASE_WAIT_FOR_INDEX) {
        const struct core_places places = {
            .first = (uint32_t)parameters->compare_first,
            .interval = (uint32_t)parameters->compare_interval,
            .counts_per_rev = (uint32_t)parameters->counts_per_rev,
        };
        int32_t position = core_position(&application->core).head1_position;
        core_arm_compare(&application->core, &places,
                         counts_apart(position, application->position_at_bank) >= 0);
    }
}
