/* SPDX-License-Identifier: Apache-2.0 */

#include "parameters.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "arctrue_number_formats.h"
#include "arctrue_registers.h"
#include "assertion.h"
#include "gate.h"
#include "limits.h"
#include "selection.h"
#include "separation.h"

#define PRESET(name) ((double)ARCTRUE_REGISTERS__##name##__VALUE_reset)
#define PLACE(field) ((uint32_t)offsetof(struct parameters, field))
/* Limit for strncmp(), longer than every name. */
#define NAME_MOST 64U
#define MOST_U32 4294967295.0
#define MOST_ARCSEC 1e6

static const struct parameter_description descriptions[] = {
    /* Columns: name, least, most, preset, whole, effect, place */
    {"separation_deg", 0.01, 359.99, 33.0, false, EFFECT_NEXT_TURN, PLACE(separation_deg)},
    {"head3_deg", 0, 359.99, 0, false, EFFECT_NEXT_TURN, PLACE(head3_deg)},
    {"head4_deg", 0, 359.99, 0, false, EFFECT_NEXT_TURN, PLACE(head4_deg)},
    {"index_detection_arcsec", 0, MOST_ARCSEC, SEPARATION_TOLERANCE_U_ARCSEC, false,
     EFFECT_NEXT_TURN, PLACE(index_detection_arcsec)},
    {"method", 0, 1, 1, true, EFFECT_NEXT_TURN, PLACE(method)},
    {"orders", 1, ORDERS_MAX, 32, true, EFFECT_NEXT_TURN, PLACE(orders)},
    {"gain_limit", 0.5, 10000, GAIN_LIMIT_DEFAULT, false, EFFECT_NEXT_TURN, PLACE(gain_limit)},
    {"keep", 0, 1, 0.8, false, EFFECT_NEXT_TURN, PLACE(keep)},
    {"noise_limit", 1, 1000, NOISE_LIMIT_DEFAULT, false, EFFECT_NEXT_TURN, PLACE(noise_limit)},
    {"counts_per_rev", ARCTRUE_COUNTS_PER_REV_MIN, ARCTRUE_COUNTS_PER_REV_MAX,
     PRESET(COUNTS_PER_REV), true, EFFECT_REARM, PLACE(counts_per_rev)},
    {"sample_period", 1, MOST_U32, PRESET(SAMPLE_PERIOD), true, EFFECT_REARM, PLACE(sample_period)},
    /* Presets: 1,900 counts per second at 2^24 counts per turn, reached in 0.1 s. */
    {"ramp_arcsec_s", 0, MOST_ARCSEC * 1e3, 147, false, EFFECT_REARM, PLACE(ramp_arcsec_s)},
    {"ramp_arcsec_s2", 0, MOST_ARCSEC * 1e6, 1470, false, EFFECT_REARM, PLACE(ramp_arcsec_s2)},
    {"output_spacing", 1, 65535, PRESET(OUTPUT_SPACING), true, EFFECT_REARM, PLACE(output_spacing)},
    {"filter_length", 1, 255, PRESET(FILTER_LENGTH), true, EFFECT_REARM, PLACE(filter_length)},
    {"minimum_edge_spacing", 0, 65535, PRESET(MINIMUM_EDGE_SPACING), true, EFFECT_REARM,
     PLACE(minimum_edge_spacing)},
    {"index_tolerance", 0, 65535, PRESET(INDEX_TOLERANCE), true, EFFECT_REARM,
     PLACE(index_tolerance)},
    {"heal", 0, 1, 0, true, EFFECT_REARM, PLACE(heal)},
    {"head1_input", 0, 65535, 0, true, EFFECT_REARM, PLACE(head1_input)},
    {"head2_input", 0, 65535, 0, true, EFFECT_REARM, PLACE(head2_input)},
    {"head3_input", 0, 65535, 0, true, EFFECT_REARM, PLACE(head3_input)},
    {"head4_input", 0, 65535, 0, true, EFFECT_REARM, PLACE(head4_input)},
    {"head_delays", 0, MOST_U32, 0, true, EFFECT_REARM, PLACE(head_delays)},
    {"output_pins", 0, 15, 0, true, EFFECT_REARM, PLACE(output_pins)},
    {"alarm_sources", 0, 255, 255, true, EFFECT_REARM, PLACE(alarm_sources)},
    {"release_sources", 0, 255, 0, true, EFFECT_REARM, PLACE(release_sources)},
    {"failover_causes", 0, 63, 63, true, EFFECT_FAILOVER, PLACE(failover_causes)},
    {"failover_missing_counts", 0, 255, 48, true, EFFECT_FAILOVER, PLACE(failover_missing_counts)},
    /* Presets for an axis motion of 0.5 um and a table speed of 90 deg/s: see docs/heads.md. */
    {"failover_step_counts", 0, 65535, 32, true, EFFECT_FAILOVER, PLACE(failover_step_counts)},
    {"failover_return_s", 0, 85, 0, false, EFFECT_FAILOVER, PLACE(failover_return_s)},
    {"failover_parity_counts", 0, 65535, 0, true, EFFECT_FAILOVER, PLACE(failover_parity_counts)},
    {"trigger_width", 1, 65535, (double)ARCTRUE_REGISTERS__PULSE_WIDTHS__TRIGGER_reset, true,
     EFFECT_PINS, PLACE(trigger_width)},
    {"sync_capture", 0, 1, 0, true, EFFECT_CAPTURE, PLACE(sync_capture)},
    {"sync_falling", 0, 1, 0, true, EFFECT_PINS, PLACE(sync_falling)},
    {"probe_falling", 0, 1, 0, true, EFFECT_PINS, PLACE(probe_falling)},
    {"pulse_filter", 1, 255, (double)ARCTRUE_REGISTERS__PULSE_INPUTS__FILTER_LENGTH_reset, true,
     EFFECT_PINS, PLACE(pulse_filter)},
    {"compare_on", 0, 1, 0, true, EFFECT_COMPARE, PLACE(compare_on)},
    {"compare_first", 0, ARCTRUE_COUNTS_PER_REV_MAX - 1, 0, true, EFFECT_COMPARE,
     PLACE(compare_first)},
    {"compare_interval", 0, ARCTRUE_COUNTS_PER_REV_MAX - 1, 0, true, EFFECT_COMPARE,
     PLACE(compare_interval)},
    {"compare_width", 1, 65535, (double)ARCTRUE_REGISTERS__PULSE_WIDTHS__COMPARE_reset, true,
     EFFECT_PINS, PLACE(compare_width)},
    {"compare_events", 0, 1, 0, true, EFFECT_PINS, PLACE(compare_events)},
    {"alarm_noise_arcsec", 0, MOST_ARCSEC, 1.0, false, EFFECT_NEXT_TURN, PLACE(alarm_noise_arcsec)},
    {"alarm_error_arcsec", 0, MOST_ARCSEC, 2.0, false, EFFECT_NEXT_TURN, PLACE(alarm_error_arcsec)},
    {"alarm_separation_arcsec", 0, MOST_ARCSEC, SEPARATION_TOLERANCE_ARCSEC, false,
     EFFECT_NEXT_TURN, PLACE(alarm_separation_arcsec)},
    /* Limit of the commercial temperature grade. */
    {"alarm_temperature_c", -55, 150, 85, false, EFFECT_NEXT_TURN, PLACE(alarm_temperature_c)},
    {"temperature_step_counts", 0.01, 1000, 0.5, false, EFFECT_NEXT_TURN,
     PLACE(temperature_step_counts)},
    {"temperature_jump_k", 0.01, 100, 1, false, EFFECT_NEXT_TURN, PLACE(temperature_jump_k)},
    {"temperature_still_s", 0, 1e6, 900, false, EFFECT_NEXT_TURN, PLACE(temperature_still_s)},
};

uint32_t parameters_number(void) {
    return sizeof descriptions / sizeof descriptions[0];
}

const struct parameter_description *parameters_description(uint32_t place) {
    return place < parameters_number() ? &descriptions[place] : NULL;
}

static double *parameter_at(struct parameters *parameters, uint32_t place) {
    return (double *)(void *)((unsigned char *)parameters + descriptions[place].offset);
}

void parameters_preset(struct parameters *parameters) {
    for (uint32_t place = 0; place < parameters_number(); place++) {
        *parameter_at(parameters, place) = descriptions[place].preset;
    }
}

double parameters_value(const struct parameters *parameters, uint32_t place) {
    struct parameters copy = *parameters;
    return place < parameters_number() ? *parameter_at(&copy, place) : 0.0;
}

static enum parameter_answer parameter_judge(const struct parameter_description *description,
                                             double value) {
    if (!(value >= description->low && value <= description->high)) {
        return PARAMETER_OUT_OF_RANGE;
    }
    return description->whole && value != floor(value) ? PARAMETER_NOT_WHOLE : PARAMETER_SET;
}

bool parameters_are_valid(const struct parameters *parameters) {
    for (uint32_t place = 0; place < parameters_number(); place++) {
        if (parameter_judge(&descriptions[place], parameters_value(parameters, place)) !=
            PARAMETER_SET) {
            return false;
        }
    }
    return true;
}

double parameters_place_deg(const struct parameters *parameters, uint32_t head) {
    const double places[] = {0.0, parameters->separation_deg, parameters->head3_deg,
                             parameters->head4_deg};
    ASSERT(head < sizeof places / sizeof places[0]);
    return places[head];
}

enum parameter_answer parameters_set(struct parameters *parameters, const char *name, double value,
                                     const struct parameter_description **description) {
    for (uint32_t place = 0; place < parameters_number(); place++) {
        if (strncmp(descriptions[place].name, name, NAME_MOST) != 0) {
            continue;
        }
        *description = &descriptions[place];
        enum parameter_answer answer = parameter_judge(*description, value);
        if (answer == PARAMETER_SET) {
            *parameter_at(parameters, place) = value;
        }
        return answer;
    }
    return PARAMETER_UNKNOWN;
}
