/* SPDX-License-Identifier: Apache-2.0 */

#include "core_setup.h"

#include "units.h"

/* Number of samples of a bank that stay free, so that the closing sample of the turn fits. */
enum { SPARE_SAMPLES = 4 };

/* Units of the registers of the ramp: 2^-35 count per clock, and 2^-59 count per clock squared. */
#define RATE_UNIT 0x1p35
#define ACCELERATION_UNIT 0x1p59

static uint32_t setup_register(double value) {
    return value < (double)UINT32_MAX ? (uint32_t)(value + 0.5) : UINT32_MAX;
}

/* Returns the step between samples at equal angles, counts. If a step divides the turn, so that all steps are equal,
   and its samples fill at least half of a bank, the function returns this step; otherwise it returns the smallest step
   with which the samples of a turn fit into a bank. */
static uint32_t setup_angle_step(uint32_t counts_per_rev, uint32_t depth) {
    uint32_t most = depth > 2 * SPARE_SAMPLES ? depth - SPARE_SAMPLES : SPARE_SAMPLES;
    uint32_t least = counts_per_rev / most + 1;
    for (uint32_t step = least; step < 2 * least; step++) {
        if (counts_per_rev % step == 0) {
            return step;
        }
    }
    return least;
}

struct core_setup setup_of_parameters(const struct application *application) {
    const struct parameters *parameters = &application->parameters;
    double clock_hz = application->configuration.clock_hz;
    double counts_an_arcsec = parameters->counts_per_rev / ARCSEC_PER_TURN;
    double counts_a_clock = parameters->ramp_arcsec_s * counts_an_arcsec / clock_hz;
    double counts_a_clock_2 = parameters->ramp_arcsec_s2 * counts_an_arcsec / (clock_hz * clock_hz);
    return (struct core_setup){
        .counts_per_rev = (uint32_t)parameters->counts_per_rev,
        .sample_period = (uint32_t)parameters->sample_period,
        .angle_step = setup_angle_step((uint32_t)parameters->counts_per_rev,
                                       application->configuration.capture_depth),
        .ramp_rate = setup_register(counts_a_clock * RATE_UNIT),
        .ramp_acceleration = setup_register(counts_a_clock_2 * ACCELERATION_UNIT),
        .output_spacing = (uint32_t)parameters->output_spacing,
        .filter_length = (uint32_t)parameters->filter_length,
        .minimum_edge_spacing = (uint32_t)parameters->minimum_edge_spacing,
        .index_tolerance = (uint32_t)parameters->index_tolerance,
        .heal = parameters->heal != 0.0,
        .head1_input = (uint32_t)parameters->head1_input,
        .head2_input = (uint32_t)parameters->head2_input,
        .head3_input = (uint32_t)parameters->head3_input,
        .head4_input = (uint32_t)parameters->head4_input,
        .head_delays = (uint32_t)parameters->head_delays,
        .output_pins = (uint32_t)parameters->output_pins,
        .alarm = (uint32_t)parameters->release_sources << 8 | (uint32_t)parameters->alarm_sources,
        .pulse_widths =
            (uint32_t)parameters->compare_width << 16 | (uint32_t)parameters->trigger_width,
        .pulse_inputs = (uint32_t)parameters->pulse_filter << 8 |
                        (uint32_t)parameters->probe_falling << 1 |
                        (uint32_t)parameters->sync_falling,
        .recorded_events = 1U | (uint32_t)parameters->compare_events << 1,
    };
}
