/* SPDX-License-Identifier: Apache-2.0 */

#include "release.h"

#include "alarms.h"
#include "control.h"
#include "zeros.h"

/* Faults that end when the flags of the heads are cleared. */
enum {
    HEAD_FAULTS = CORE_FAULT_HEAD1 | CORE_FAULT_HEAD2 | CORE_FAULT_SWALLOWED | CORE_FAULT_HEAD3 |
    CORE_FAULT_HEAD4
};

const char *application_output_fault(const struct application *application) {
    bool there = application->phase != PHASE_NO_CORE;
    return output_fault_name(there && core_status(&application->core).cannot_keep_up);
}

uint32_t application_release_causes(const struct application *application) {
    bool there = application->phase != PHASE_NO_CORE;
    return there ? core_status(&application->core).release_causes : 0U;
}

uint32_t application_release_present(const struct application *application) {
    bool there = application->phase != PHASE_NO_CORE;
    return there ? core_status(&application->core).release_present : 0U;
}

/* Evaluates the index error before the flags of the heads are cleared, because clearing them deletes the flag of the
   index error. (A turn would evaluate and clear the flags, but a table that its drive has stopped completes no turn.)
   The captured turns and the turn in progress are dropped, because they may contain the fault that set the flag. */
static void release_look_before_clearing(struct application *application, uint32_t faults) {
    if (!state_works(application) || (faults & HEAD_FAULTS) == 0) {
        return;
    }
    if (core_index_error(&application->core)) {
        int32_t zero = application->head2_zero;
        zeros_watch_doubt(application);
        zeros_follow_head2(application);
        if (zero != application->head2_zero) {
            alarm_between_turns(application, ALARM_ZERO_LOST);
        }
    }
    control_capture_anew(application);
    control_give_back_bank(application);
}

enum output_answer application_clear_output(struct application *application) {
    if (application->phase == PHASE_NO_CORE) {
        return OUTPUT_NO_CORE;
    }
    struct core_status before = core_status(&application->core);
    if (!before.cannot_keep_up && before.release_causes == 0) {
        return OUTPUT_NO_FAULT;
    }
    release_look_before_clearing(application, before.release_present);
    core_clear_output(&application->core, before.release_present);
    struct core_status after = core_status(&application->core);
    if (after.cannot_keep_up) {
        return OUTPUT_FAULT_AGAIN;
    }
    if (after.release_causes != 0) {
        return OUTPUT_STAYS_RELEASED;
    }
    return before.cannot_keep_up ? OUTPUT_CLEARED : OUTPUT_DRIVEN;
}

void release_watch(struct application *application) {
    uint32_t causes = application_release_causes(application);
    if (causes != 0 && !application->release_reported) {
        alarm_between_turns(application, ALARM_OUTPUT);
    }
    application->report.release_causes = causes;
    application->release_reported = causes != 0;
}
