/* SPDX-License-Identifier: Apache-2.0 */

#include "alarms.h"

#include <math.h>
#include <stddef.h>

#include "assertion.h"
#include "units.h"

const char *alarm_name(uint32_t bit) {
    switch (bit) {
    case ALARM_NOISE:
        return "noise";
    case ALARM_ERROR:
        return "error";
    case ALARM_SEPARATION:
        return "separation";
    case ALARM_OUTPUT:
        return "output";
    case ALARM_OVERRUN:
        return "overrun";
    case ALARM_STUCK_CAPTURE:
        return "stuck_capture";
    case ALARM_COEFFICIENTS:
        return "coefficients";
    case ALARM_TEMPERATURE:
        return "temperature";
    case ALARM_ZERO_LOST:
        return "zero_lost";
    case ALARM_SWAP:
        return "swap";
    case ALARM_BEGAN_ANEW:
        return "began_anew";
    case ALARM_SAVED:
        return "not_confirmed";
    case ALARM_THERMOMETER:
        return "thermometer";
    case ALARM_CORE_RESET:
        return "core_reset";
    case ALARM_HEAD_LEFT_OUT:
        return "head_left_out";
    case ALARM_FAILOVER_OFF:
        return "failover_off";
    case ALARM_NO_SET:
        return "no_set";
    default:
        return NULL;
    }
}

void alarm_between_turns(struct application *application, uint32_t alarm) {
    ASSERT(alarm_name(alarm) != NULL);
    struct turn_report *report = &application->report;
    report->alarms |= alarm;
    report->between_turns = report->between_turns || !report->fresh;
    report->fresh = true;
}

/* Tells whether frames of a load have overwritten the active mean's sets for a missing head. */
static bool alarms_sets_are_lost(const struct application *application) {
    const struct coefficients *active = state_active(application);
    return application->prepared.overwritten && active != NULL && active->mean.heads > 2;
}

uint32_t alarms_of_turn(struct application *application) {
    const struct parameters *parameters = &application->parameters;
    const struct estimate *estimate = &application->estimate;
    double off_rad = estimate->measured_separation_rad - parameters->separation_deg * PI / 180.0;
    uint32_t overruns = core_overrun_count(&application->core);
    uint32_t alarms = 0;
    if (application->report.result != TURN_REFUSED) {
        double error = application->report.prediction.active_arcsec;
        alarms |= estimate->noise_arcsec > parameters->alarm_noise_arcsec ? ALARM_NOISE : 0;
        bool wrong = error > parameters->alarm_error_arcsec || application->load.watch.at_fault;
        alarms |= application->has_active && wrong ? ALARM_ERROR : 0;
        alarms |= fabs(off_rad) * ARCSEC_PER_RAD > parameters->alarm_separation_arcsec
                      ? ALARM_SEPARATION
                      : 0;
    }
    bool moved = application->report.mean_off_arcsec > parameters->alarm_separation_arcsec;
    enum refusal reason = application->report.reason;
    bool elsewhere = reason == REFUSED_HEADS_EXCHANGED || reason == REFUSED_HEADS_ELSEWHERE ||
                     application->report.mean_reason == REFUSED_HEADS_ELSEWHERE;
    alarms |= moved || elsewhere ? ALARM_SEPARATION : 0;
    const struct core_status status = core_status(&application->core);
    application->report.output_stands = status.cannot_keep_up;
    application->report.release_causes = status.release_causes;
    alarms |= status.cannot_keep_up || status.release_causes != 0 ? ALARM_OUTPUT : 0;
    alarms |= overruns != application->overruns ? ALARM_OVERRUN : 0;
    application->overruns = overruns;
    bool hot = application->report.has_temperature &&
               application->report.temperature_c > parameters->alarm_temperature_c;
    alarms |= hot ? ALARM_TEMPERATURE : 0;
    alarms |= application->prepared.reported != 0 ? ALARM_HEAD_LEFT_OUT : 0;
    alarms |= application->prepared.refused ? ALARM_NO_SET : 0;
    alarms |= alarms_sets_are_lost(application) ? ALARM_FAILOVER_OFF : 0;
    alarms |= table_temperature_is_held(&application->table) ? ALARM_THERMOMETER : 0;
    alarms |= application->faults_in_a_row != 0 ? ALARM_BEGAN_ANEW : 0;
    return alarms;
}
