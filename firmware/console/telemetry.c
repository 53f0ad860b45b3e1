/* SPDX-License-Identifier: Apache-2.0 */

#include "telemetry.h"

#include <stddef.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"

enum {
    ARCSEC_DECIMALS = 9,
    DEGREE_DECIMALS = 9,
    TEMPERATURE_DECIMALS = 2,
    TABLE_DECIMALS = 3,
    PARITY_DECIMALS = 3,
    LIST_DECIMALS = 6
};
/* One count as an s20.11 word. */
#define PARITY_ONE ((double)(1 << ARCTRUE_CORRECTION_FRACTION))

static void key(const struct text_sink *sink, const char *name) {
    text_word(sink, ",\"");
    text_word(sink, name);
    text_word(sink, "\":");
}

static void word(const struct text_sink *sink, const char *name, const char *value) {
    key(sink, name);
    text_word(sink, "\"");
    text_word(sink, value);
    text_word(sink, "\"");
}

static void number(const struct text_sink *sink, const char *name, uint64_t value) {
    key(sink, name);
    text_unsigned(sink, value);
}

static void fixed(const struct text_sink *sink, const char *name, double value) {
    key(sink, name);
    text_fixed(sink, value, ARCSEC_DECIMALS);
}

static void alarm_part(const struct text_sink *sink, uint32_t alarms) {
    bool first = true;
    key(sink, "alarms");
    text_word(sink, "[");
    for (uint32_t bit = 1; bit != 0 && bit <= alarms; bit <<= 1) {
        if (alarms & bit && alarm_name(bit) != NULL) {
            text_word(sink, first ? "\"" : ",\"");
            text_word(sink, alarm_name(bit));
            text_word(sink, "\"");
            first = false;
        }
    }
    text_word(sink, "]");
}

/* Prints the faults that disabled the line drivers. */
static void released_part(const struct text_sink *sink, uint32_t causes) {
    bool first = true;
    key(sink, "released");
    text_word(sink, "[");
    for (uint32_t bit = 1; bit != 0 && bit <= causes; bit <<= 1) {
        if (causes & bit && core_fault_name(bit) != NULL) {
            text_word(sink, first ? "\"" : ",\"");
            text_word(sink, core_fault_name(bit));
            text_word(sink, "\"");
            first = false;
        }
    }
    text_word(sink, "]");
}

/* Prints the heads that the gateware has left out of the mean, if there are any. */
static void left_out_part(const struct text_sink *sink, uint32_t left_out) {
    if (left_out != 0) {
        key(sink, "left_out");
        text_word(sink, "[");
        bool first = true;
        for (uint32_t head = 0; head < HEADS_MOST; head++) {
            if ((left_out >> head & 1U) != 0) {
                text_word(sink, first ? "" : ",");
                text_unsigned(sink, head + 1);
                first = false;
            }
        }
        text_word(sink, "]");
    }
}

/* Prints alarms in a line of their own, because the turn itself has been printed already. */
static void alarm_line(const struct text_sink *sink, const struct application *application,
                       uint32_t left_out, uint32_t alarms) {
    text_word(sink, "{\"turn\":");
    text_unsigned(sink, application->report.number);
    word(sink, "result", "alarm");
    word(sink, "reason", refusal_name(NOT_REFUSED));
    number(sink, "swaps", application->swaps);
    if (application->report.release_causes != 0) {
        released_part(sink, application->report.release_causes);
    }
    left_out_part(sink, left_out);
    alarm_part(sink, alarms);
    text_word(sink, "}\r\n");
}

static void turn_part(const struct text_sink *sink, const struct turn_report *report,
                      uint32_t clock_hz) {
    text_word(sink, "{\"turn\":");
    text_unsigned(sink, report->number);
    number(sink, "sequence", report->sequence_number);
    key(sink, "time_s");
    text_fixed(sink, (double)report->start_time / clock_hz, ARCSEC_DECIMALS);
    number(sink, "samples", report->samples);
    word(sink, "result", turn_result_name(report->result));
    word(sink, "reason", refusal_name(report->reason));
}

static void fault_part(const struct text_sink *sink, const struct capture_fault *fault) {
    if (fault->head == 0) {
        return;
    }
    number(sink, "fault_head", fault->head);
    number(sink, "fault_sample", fault->sample);
    key(sink, "fault_counts");
    text_signed(sink, fault->found);
}

static void temperature_part(const struct text_sink *sink, const struct turn_report *report) {
    key(sink, "temperature_c");
    if (report->has_temperature) {
        text_fixed(sink, report->temperature_c, TEMPERATURE_DECIMALS);
    } else {
        text_word(sink, "null");
    }
}

/* Prints the table's temperature if it is known. */
static void table_part(const struct text_sink *sink, const struct table_temperature *table) {
    if (!table_temperature_is_known(table)) {
        return;
    }
    key(sink, "table_c");
    text_fixed(sink, table->celsius, TABLE_DECIMALS);
    word(sink, "thermometer", temperature_state_name(table->state));
}

static void estimate_part(const struct text_sink *sink, const struct application *application) {
    const struct estimate *estimate = &application->estimate;
    key(sink, "separation_deg");
    text_fixed(sink, estimate->measured_separation_rad * 180.0 / PI, DEGREE_DECIMALS);
    fixed(sink, "u_separation_arcsec", estimate->u_measured_separation_rad * ARCSEC_PER_RAD);
    word(sink, "separation",
         estimate->separation_choice == SEPARATION_MEASURED ? "measured" : "nominal");
    fixed(sink, "residual_arcsec", estimate->residual_rms_arcsec);
    fixed(sink, "noise_arcsec", estimate->noise_arcsec);
    /* The estimate is of head 1 or of the device's own mean; it does not show the remaining error
       of a loaded mean. */
    const struct coefficients *active = state_active(application);
    if (active == NULL || active->mean.heads == 0 || application->found.geometry.heads != 0) {
        fixed(sink, "active_arcsec", application->report.prediction.active_arcsec);
        fixed(sink, "candidate_arcsec", application->report.prediction.candidate_arcsec);
    }
}

/* Prints the remaining error of the loaded orders, and those orders that no turn has judged. */
static void loaded_part(const struct text_sink *sink, const struct application *application) {
    const struct load *load = &application->load;
    const struct coefficients *set = load_at_work(load);
    bool first = true;
    if (set == NULL) {
        return;
    }
    fixed(sink, "loaded_arcsec", application->report.loaded_arcsec);
    if (load->unjudged == 0) {
        return;
    }
    key(sink, "unjudged");
    text_word(sink, "[");
    for (uint32_t place = 0; place < set->lanes; place++) {
        if ((load->unjudged >> place & 1U) != 0) {
            text_word(sink, first ? "" : ",");
            text_unsigned(sink, set->lane[place].order);
            first = false;
        }
    }
    text_word(sink, "]");
}

/* Prints for each lane that follows a condition: order, modulator, measurement of the turn, its standard uncertainty,
   loaded value. */
static void followed_part(const struct text_sink *sink, const struct turn_report *report) {
    ASSERT(report->followed_lanes <= FOLLOWED_LANES_MAX);
    if (report->followed_lanes == 0) {
        return;
    }
    key(sink, "followed");
    for (uint32_t place = 0; place < report->followed_lanes; place++) {
        const struct followed_measured *lane = &report->followed[place];
        text_word(sink, place == 0 ? "[[" : ",[");
        text_unsigned(sink, lane->order);
        text_word(sink, ",\"");
        text_word(sink, followed_modulator_name(lane->modulator));
        text_word(sink, "\",");
        text_fixed(sink, lane->measured_arcsec, ARCSEC_DECIMALS);
        text_word(sink, ",");
        text_fixed(sink, lane->u_arcsec, ARCSEC_DECIMALS);
        text_word(sink, ",");
        text_fixed(sink, lane->loaded_arcsec, ARCSEC_DECIMALS);
        text_word(sink, "]");
    }
    text_word(sink, "]");
}

static void list(const struct text_sink *sink, const char *name, const double *value,
                 uint32_t values) {
    key(sink, name);
    for (uint32_t place = 0; place < values; place++) {
        text_word(sink, place == 0 ? "[" : ",");
        text_fixed(sink, value[place], LIST_DECIMALS);
    }
    text_word(sink, "]");
}

/* Prints the turn's results for the heads and the axis if the turn has calibrated the mean. If the turn tried to
   calibrate the mean and failed, prints the reason. */
static void found_part(const struct text_sink *sink, const struct application *application) {
    const struct heads_found *found = &application->found;
    double place_deg[HEADS_MOST];
    double radius[HEADS_MOST];
    uint32_t heads = found->geometry.heads;
    if (application->report.mean_reason != NOT_REFUSED) {
        word(sink, "no_mean", refusal_name(application->report.mean_reason));
    }
    if (heads == 0) {
        return;
    }
    for (uint32_t head = 0; head < heads; head++) {
        place_deg[head] =
            (found->geometry.offset_rad[head] + found->geometry.late_rad[head]) * 180.0 / PI;
        radius[head] = 1.0 / found->geometry.ratio[head];
    }
    list(sink, "places_deg", place_deg, heads);
    list(sink, "u_places_arcsec", found->u_late_arcsec, heads);
    list(sink, "radii", radius, heads);
    list(sink, "u_radii", found->u_ratio, heads);
    list(sink, "head_residual_arcsec", found->residual_arcsec, heads);
    list(sink, "axis_forward_arcsec", found->forward_arcsec, CIRCLE_ORDERS);
    list(sink, "axis_backward_arcsec", found->backward_arcsec, CIRCLE_ORDERS);
    if (found->asynchronous.stated) {
        fixed(sink, "axis_asynchronous_arcsec", found->asynchronous.arcsec);
        fixed(sink, "u_axis_asynchronous_arcsec", found->asynchronous.u_arcsec);
    }
}

/* Prints the delays of the heads, if turns at two speeds have shown them. */
static void skew_part(const struct text_sink *sink, const struct head_skew *skew) {
    if (skew->heads != 0) {
        list(sink, "late_ns", skew->late_ns, skew->heads);
        fixed(sink, "u_late_ns", skew->u_ns);
    }
}

static void mean_part(const struct text_sink *sink, const struct application *application) {
    const struct coefficients *active = state_active(application);
    double off = application->report.mean_off_arcsec;
    if (active == NULL || active->mean.heads == 0) {
        return;
    }
    number(sink, "mean_of_heads", active->mean.heads);
    number(sink, "carrier", active->mean.carrier + 1);
    if (off >= 0.0) {
        fixed(sink, "mean_off_arcsec", off);
    }
    if (application->report.moved_head != 0) {
        number(sink, "moved_head", application->report.moved_head);
        fixed(sink, "moved_arcsec", application->report.moved_arcsec);
    }
}

/* Prints the state of the failover. This part is printed for refused turns too, because a failed head may cause the
   refusal of every turn. */
static void failover_part(const struct text_sink *sink, const struct application *application,
                          const struct core_failover *state) {
    left_out_part(sink, state->left_out);
    if (!application->configuration.has_failover) {
        return;
    }
    number(sink, "active_set", state->set);
    if (application->configuration.heads > 3) {
        key(sink, "parity_counts");
        text_fixed(sink, state->parity / PARITY_ONE, PARITY_DECIMALS);
        word(sink, "parity", state->parity_beyond ? "beyond" : "within");
    }
}

static void harmonic_part(const struct text_sink *sink, const struct harmonic *harmonic,
                          uint32_t order, enum verdict verdict) {
    text_word(sink, "[");
    text_unsigned(sink, order);
    text_word(sink, ",");
    text_fixed(sink, harmonic_amplitude(harmonic), ARCSEC_DECIMALS);
    text_word(sink, ",");
    text_fixed(sink, harmonic_phase(harmonic), ARCSEC_DECIMALS);
    text_word(sink, ",");
    text_fixed(sink, harmonic_uncertainty(harmonic), ARCSEC_DECIMALS);
    text_word(sink, verdict == VERDICT_APPLIED ? ",1]" : ",0]");
}

static void harmonics_part(const struct text_sink *sink, const struct application *application) {
    ASSERT(application->estimate.orders <= ORDERS_MAX);
    /* Values of each order: order, amplitude in arcsec, phase in rad, uncertainty in arcsec, 1 if the order is
       applied. */
    key(sink, "harmonics");
    text_word(sink, "[");
    for (uint32_t place = 0; place < application->estimate.orders; place++) {
        text_word(sink, place == 0 ? "" : ",");
        harmonic_part(sink, &application->estimate.harmonic[place], place + 1,
                      application->verdicts[place]);
    }
    text_word(sink, "]");
}

static void line(const struct text_sink *sink, const struct application *application,
                 const struct core_failover *state, uint32_t alarms) {
    const struct turn_report *report = &application->report;
    if (report->between_turns) {
        alarm_line(sink, application, state->left_out, alarms);
        return;
    }
    turn_part(sink, report, application->configuration.clock_hz);
    fault_part(sink, &report->fault);
    temperature_part(sink, report);
    table_part(sink, &application->table);
    if (report->result != TURN_REFUSED) {
        estimate_part(sink, application);
        mean_part(sink, application);
        found_part(sink, application);
        skew_part(sink, &application->skew);
        loaded_part(sink, application);
        followed_part(sink, report);
        harmonics_part(sink, application);
    }
    failover_part(sink, application, state);
    number(sink, "swaps", application->swaps);
    word(sink, "output_fault", output_fault_name(report->output_stands));
    released_part(sink, report->release_causes);
    alarm_part(sink, alarms);
    text_word(sink, "}\r\n");
}

static void add_length(void *context, const char *characters, size_t length) {
    (void)characters;
    *(size_t *)context += length;
}

bool telemetry_turn(const struct text_sink *sink, const struct application *application,
                    uint32_t alarms) {
    size_t length = 0;
    const struct text_sink counter = {add_length, &length, NULL};
    /* The state of the failover is read once, so that both passes print the same state. */
    const struct core_failover state =
        application->configuration.has_failover
            ? core_failover(&application->core)
            : (struct core_failover){.left_out = core_left_out(&application->core)};
    line(&counter, application, &state, alarms);
    if (!text_has_room(sink, length)) {
        return false;
    }
    line(sink, application, &state, alarms);
    return true;
}
