/* SPDX-License-Identifier: Apache-2.0 */

/* What can be set on the console, with range and default. */

#ifndef ARCTRUE_PARAMETERS_H
#define ARCTRUE_PARAMETERS_H

#include <stdbool.h>
#include <stdint.h>

struct parameters {
    double separation_deg;
    /* Places of heads 3 and 4 after head 1, as mounted; 0: not known, and no mean of the heads is calibrated. */
    double head3_deg;
    double head4_deg;
    /* Standard uncertainty of what differs between the places where the heads detect the mark. */
    double index_detection_arcsec;
    /* 0: the paper's transform; 1: least squares at the angles read. */
    double method;
    double orders;
    double gain_limit;
    /* What a turn leaves of the weight of those before. */
    double keep;
    double noise_limit;
    double counts_per_rev;
    double sample_period;
    /* Largest velocity of a ramp and its change; 0: no bound of the change. */
    double ramp_arcsec_s;
    double ramp_arcsec_s2;
    double output_spacing;
    double filter_length;
    double minimum_edge_spacing;
    double index_tolerance;
    /* 1: counts that head 1 lost are put into the count of the output, on the ramp. */
    double heal;
    /* Polarity, direction and filter of a head's pins; polarity and direction of the output's. */
    double head1_input;
    double head2_input;
    double head3_input;
    double head4_input;
    /* Clocks by which A, B and Z of a head come later, a byte each, head 1 in the lowest. */
    double head_delays;
    double output_pins;
    /* Causes for leaving a head out, as bits of the register `failover` from `illegal` on; 0: no head is left out. */
    double failover_causes;
    double failover_missing_counts;
    double failover_step_counts;
    /* A head that was left out comes back so long after, once it has its index; 0: only on request. */
    double failover_return_s;
    /* Limit of the parity of the heads; 0: none. */
    double failover_parity_counts;
    /* Faults that raise the alarm, and those that release the outputs. */
    double alarm_sources;
    double release_sources;
    /* Pulses beside the table: clocks that an output is high; 1: falling edges of an input count. */
    double trigger_width;
    /* 1: a sample at each edge of sync_in, in place of equal times. */
    double sync_capture;
    double sync_falling;
    double probe_falling;
    /* Filter of both inputs, clocks. */
    double pulse_filter;
    /* 1: pulses at an angle after the index and at each multiple of the interval from there, counts;
       interval 0: once. */
    double compare_on;
    double compare_first;
    double compare_interval;
    double compare_width;
    double alarm_noise_arcsec;
    double alarm_error_arcsec;
    double alarm_separation_arcsec;
    double alarm_temperature_c;
    /* A change of the correction by the temperature that is worth a new bank. */
    double temperature_step_counts;
    /* What the table cannot do from one reading of its thermometer to the next, and how long it
       may say the same. */
    double temperature_jump_k;
    double temperature_still_s;
};

/* What a new value asks for. */
enum parameter_effect {
    EFFECT_NEXT_TURN,
    /* A re-arm, which forgets the index. */
    EFFECT_REARM,
    /* The pins beside the table, at once. */
    EFFECT_PINS,
    EFFECT_CAPTURE,
    EFFECT_COMPARE,
    /* The gateware's failover, at once. */
    EFFECT_FAILOVER,
};

struct parameter_description {
    const char *name;
    double low;
    double high;
    double preset;
    bool whole;
    enum parameter_effect effect;
    uint32_t offset;
};

enum parameter_answer {
    PARAMETER_SET,
    PARAMETER_UNKNOWN,
    PARAMETER_OUT_OF_RANGE,
    PARAMETER_NOT_WHOLE,
};

uint32_t parameters_number(void);
const struct parameter_description *parameters_description(uint32_t place);
/* Each within its range, and whole where it must be. */
bool parameters_are_valid(const struct parameters *parameters);
void parameters_preset(struct parameters *parameters);
double parameters_value(const struct parameters *parameters, uint32_t place);
enum parameter_answer parameters_set(struct parameters *parameters, const char *name, double value,
                                     const struct parameter_description **description);

#endif
