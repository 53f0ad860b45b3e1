/* SPDX-License-Identifier: Apache-2.0 */

#include "application.h"

#include <stddef.h>
#include <string.h>

#include "alarms.h"
#include "assertion.h"
#include "bank.h"
#include "control.h"
#include "follow_temperature.h"
#include "local_table.h"
#include "prepared.h"
#include "real_follow.h"
#include "swap.h"
#include "turn.h"
#include "zeros.h"

void application_prepare(struct application *application, const struct core_access *core) {
    memset(application, 0, sizeof *application);
    application->core = *core;
    application->phase = PHASE_NO_CORE;
    parameters_preset(&application->parameters);
}

void application_use_temperature(struct application *application, temperature_read *read,
                                 void *context) {
    application->read_temperature = read;
    application->temperature_context = context;
}

void application_use_thermometer(struct application *application, temperature_read *read,
                                 void *context) {
    table_temperature_use(&application->table, read, context);
}

void application_keep_settings(struct application *application, struct kept_settings *kept,
                               memory_settle *settle) {
    application->kept = kept;
    application->settle = settle;
}

void application_use_copy(struct application *application, struct capture_copy *copy) {
    application->copy = copy;
}

void application_use_axis(struct application *application, struct axis_mean *axis) {
    application->axis = axis;
}

void application_use_flash(struct application *application, struct save *save) {
    application->save = save;
    save->point = local_table_point;
    save->point_context = application;
}

/* Sets the core up again if it was reset. A disabled output shows a reset, because the output of a core in use is
   always enabled. The output must be enabled within 2^20 clocks (10 ms) of a reset; otherwise the core switches the
   line drivers off. */
static void watch_reset(struct application *application) {
    if (!core_output_enabled(&application->core)) {
        application_start(application);
        alarm_between_turns(application, ALARM_CORE_RESET);
    }
}

static void wait_for_index(struct application *application) {
    if (core_indices_seen(&application->core)) {
        application->phase = PHASE_CAPTURE;
        /* An armed compare is kept: after a fault of the firmware it continues from its present place. */
        if (!core_status(&application->core).compare_armed) {
            control_arm_compare(application);
        }
        application->position_at_bank = core_position(&application->core).head1_position;
    }
}

static void look_for_bank(struct application *application) {
    real_follow_probe(application);
    if (!core_status(&application->core).capture_ready) {
        bank_watch(application);
        zeros_watch(application);
        if (application->phase == PHASE_CAPTURE) {
            follow_between_turns(application);
        }
        return;
    }
    application->banks_without_interrupt += !application->interrupted;
    application->interrupted = false;
    bank_take(application);
    if (application->dump == DUMP_WANTED) {
        bank_copy(application);
    }
    turn_finish(application);
}

void application_interrupt(struct application *application) {
    application->interrupts++;
    if (application->phase != PHASE_NO_CORE) {
        application->interrupted = true;
        core_acknowledge_interrupt(&application->core);
    }
}

bool application_busy(const struct application *application) {
    return application->phase == PHASE_SWAP;
}

void application_step(struct application *application) {
    state_assert(application);
    if (application->save != NULL) {
        save_step(application->save);
    }
    if (state_works(application)) {
        watch_reset(application);
        follow_thermometer(application);
        release_watch(application);
        if (application->configuration.has_failover) {
            prepared_watch(application);
        }
    }
    switch (application->phase) {
    case PHASE_WAIT_FOR_INDEX:
        wait_for_index(application);
        break;
    case PHASE_CAPTURE:
        look_for_bank(application);
        break;
    case PHASE_SWAP:
        swap_wait(application);
        break;
    case PHASE_NO_CORE:
    case PHASE_HELD:
    default:
        break;
    }
}
