/* SPDX-License-Identifier: Apache-2.0 */

#include "operator.h"

#include "control.h"
#include "core_setup.h"
#include "local_table.h"
#include "prepared.h"
#include "restart.h"
#include "settings.h"

void application_tell_temperature(struct application *application, double celsius) {
    table_temperature_tell(&application->table, celsius, state_seconds(application));
}

void application_choose_temperature(struct application *application,
                                    enum temperature_source source) {
    table_temperature_choose(&application->table, source);
}

static void operator_change_pins(struct application *application, enum parameter_effect effect) {
    struct core_setup setup = setup_of_parameters(application);
    core_set_pins(&application->core, &setup);
    if (effect == EFFECT_CAPTURE) {
        control_capture_anew(application);
    } else if (effect == EFFECT_COMPARE) {
        control_arm_compare(application);
    } else if (effect == EFFECT_FAILOVER) {
        prepared_arm(application);
    }
}

enum parameter_answer application_set(struct application *application, const char *name,
                                      double value,
                                      const struct parameter_description **description) {
    enum parameter_answer answer =
        parameters_set(&application->parameters, name, value, description);
    if (answer != PARAMETER_SET) {
        return answer;
    }
    if ((*description)->effect == EFFECT_REARM) {
        application_rearm(application);
        return answer;
    }
    settings_keep(application);
    if ((*description)->effect == EFFECT_NEXT_TURN) {
        state_forget_turns(application);
    } else if (state_works(application)) {
        operator_change_pins(application, (*description)->effect);
    }
    return answer;
}

enum load_answer application_load_end(struct application *application, uint32_t crc) {
    if (application->phase == PHASE_NO_CORE) {
        return LOAD_WRONG_FRAME;
    }
    const struct coefficients *active = state_active(application);
    const struct core_origin origin = core_origin(&application->core);
    const struct load_place place = {
        .counts_per_rev = (uint32_t)application->parameters.counts_per_rev,
        .heads = application->configuration.heads,
        .has_mean = application->configuration.has_mean,
        .has_modulators = origin.has_modulators,
        .has_failover = application->configuration.has_failover,
        .has_real_orders = origin.has_real_orders,
        .has_local_table = origin.has_local_table,
        .lanes = application->configuration.lanes,
        .delays = (uint32_t)application->parameters.head_delays,
    };
    enum load_answer answer = load_end(&application->load, &place, active, crc);
    if (answer == LOAD_TAKEN) {
        local_table_complete(application);
    }
    return answer;
}

void application_freeze(struct application *application, bool frozen) {
    application->frozen = frozen;
    settings_keep(application);
}

void application_telemetry(struct application *application, bool on) {
    application->telemetry = on;
    settings_keep(application);
}

void application_bypass(struct application *application, bool bypassed) {
    application->bypassed = bypassed;
    settings_keep(application);
    if (state_works(application)) {
        control_write(application);
    } else if (application->phase == PHASE_HELD && bypassed) {
        /* Only a re-arm switches the correction on again. */
        application->inherited = false;
        core_hold(&application->core);
    }
}

void application_want_dump(struct application *application) {
    application->dump = DUMP_WANTED;
    if (application->by_angle) {
        application->by_angle = false;
        control_capture_anew(application);
    }
}
