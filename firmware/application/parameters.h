/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the parameters of the console, with range and preset. */

#ifndef ARCTRUE_PARAMETERS_H
#define ARCTRUE_PARAMETERS_H

#include <stdbool.h>
#include <stdint.h>

struct parameters {
    double separation_deg;
    /* Angles from head 1 to heads 3 and 4, as mounted; 0: not known, so no mean of the heads is calibrated. */
    double head3_deg;
    double head4_deg;
    /* Standard uncertainty of the difference between the places where the heads detect the mark. */
    double index_detection_arcsec;
    /* 0: the paper's Fourier transform; 1: least squares at the angles that were read. */
    double method;
    double orders;
    double gain_limit;
    /* Factor by which one turn multiplies the weight of the turns before it. */
    double keep;
    double noise_limit;
    double counts_per_rev;
    double sample_period;
    /* Largest velocity and largest acceleration of a ramp; acceleration 0: not limited. */
    double ramp_arcsec_s;
    double ramp_arcsec_s2;
    double output_spacing;
    double filter_length;
    double minimum_edge_spacing;
    double index_tolerance;
    /* 1: the core adds counts that head 1 lost to the count of the output, on the ramp. */
    double heal;
    /* Polarity, direction and filter of a head's pins; polarity and direction of the output's pins. */
    double head1_input;
    double head2_input;
    double head3_input;
    double head4_input;
    /* Clocks by which A, B and Z of a head are delayed, one byte per head, head 1 in the lowest byte. */
    double head_delays;
    double output_pins;
    /* Causes for leaving a head out, as bits of the register `failover` from `illegal` on; 0: no head is left out. */
    double failover_causes;
    /* missing_counts and step_limit of core_failover_setup (core.h). */
    double failover_missing_counts;
    double failover_step_counts;
    /* Time after which a head that was left out may be used again, once it has its index; 0: only on request. */
    double failover_return_s;
    /* Limit of the parity of the heads; 0: none. */
    double failover_parity_counts;
    /* Faults that raise the alarm, and faults that release (switch off) the line drivers of the output. */
    double alarm_sources;
    double release_sources;
    /* Pulse outputs: clocks for which an output is high. Pulse inputs: 1 selects falling edges. */
    double trigger_width;
    /* 1: takes a sample at each edge of sync_in instead of at equal times. */
    double sync_capture;
    double sync_falling;
    double probe_falling;
    /* Filter length of both pulse inputs, clocks. */
    double pulse_filter;
    /* `compare_on` 1: the core gives a pulse `compare_first` counts after the index and then after every
       `compare_interval` counts; interval 0: a single pulse. */
    double compare_on;
    double compare_first;
    double compare_interval;
    double compare_width;
    /* 1: pulses of the compare are recorded as events too. */
    double compare_events;
    double alarm_noise_arcsec;
    double alarm_error_arcsec;
    double alarm_separation_arcsec;
    double alarm_temperature_c;
    /* A new bank is written if the temperature, or a newly found phase of a lane of a real order, changes the
       correction by more than this number of counts. */
    double temperature_step_counts;
    /* Largest change of the table's temperature from one reading to the next, and longest time without a change. */
    double temperature_jump_k;
    double temperature_still_s;
};

/* Effect of a new value. */
enum parameter_effect {
    EFFECT_NEXT_TURN,
    /* A re-arm, which makes the index invalid. */
    EFFECT_REARM,
    /* The registers of the pulse inputs and outputs are written at once. */
    EFFECT_PINS,
    EFFECT_CAPTURE,
    EFFECT_COMPARE,
    /* The new settings of the gateware's failover apply at once. */
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
/* Tells whether each parameter is within its range, and whole if it must be. */
bool parameters_are_valid(const struct parameters *parameters);
void parameters_preset(struct parameters *parameters);
/* Returns the place of a head after head 1, degrees; 0: head 1, or a place that is not set. */
double parameters_place_deg(const struct parameters *parameters, uint32_t head);
double parameters_value(const struct parameters *parameters, uint32_t place);
enum parameter_answer parameters_set(struct parameters *parameters, const char *name, double value,
                                     const struct parameter_description **description);

#endif
