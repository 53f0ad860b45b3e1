/* SPDX-License-Identifier: Apache-2.0 */

#include "turn_judge.h"

#include <math.h>
#include <stddef.h>

#include "units.h"

const struct coefficients *turn_judge_active_of_head1(const struct application *application) {
    const struct coefficients *active = state_active(application);
    return active != NULL && active->mean.heads != 0 ? NULL : active;
}

/* Multiple of the variance of a component above which the square of a change counts as real and not as noise. */
#define CHANGED 18.0

/* Returns the larger of two estimates of the error's change since earlier turns. The first is the largest difference
   between a measured order of the calibration and its active lane, reduced by the noise (CHANGED). The second is the
   change that the thermal model gives, since the previous turn, for the loaded orders that follow the temperature. */
static double turn_judge_change_arcsec(const struct application *application) {
    const struct estimate *estimate = &application->measured;
    const struct coefficients *active = turn_judge_active_of_head1(application);
    const struct load *load = &application->load;
    const struct coefficients *loaded = load_at_work(load);
    double most = 0.0;
    for (uint32_t place = 0; active != NULL && place < estimate->orders; place++) {
        const struct harmonic *harmonic = &estimate->harmonic[place];
        if (harmonic->seen && coefficients_have(active, place + 1) &&
            !coefficients_have(loaded, place + 1)) {
            const struct vector value = {harmonic->cosine, harmonic->sine};
            struct vector before = coefficients_components(active, place + 1);
            double square = vector_square(vector_difference(value, before));
            double noise = harmonic->variance_cosine + harmonic->variance_sine;
            most = fmax(most, square - 0.5 * CHANGED * noise);
        }
    }
    double followed = 0.0;
    if (loaded != NULL && application->before_s > 0.0) {
        followed = thermal_change_counts(application_thermal(application, &load->thermal), loaded,
                                         application->before_celsius, application->table.celsius) *
                   ARCSEC_PER_TURN / application->capture.counts_per_rev;
    }
    return fmax(sqrt(most), followed);
}

/* Returns the speed of head 1 in the turn, counts per clock. Without times of the samples it is the mean speed, in the
   direction of the turn's steps, because the table may have reversed after the turn. */
static double turn_judge_speed(const struct capture *capture, const struct turn *turn) {
    return capture->period_clocks != 0 ? turn->step_counts / capture->period_clocks
                                       : copysign(capture->mean_speed, turn->step_counts);
}

struct judge turn_judge(struct application *application, const struct turn *turn) {
    return (struct judge){
        .turn = turn,
        .motion = {turn_judge_speed(&application->capture, turn)},
        .estimate = &application->measured,
        .workspace = &application->workspace.further,
        .gain_limit = application->parameters.gain_limit,
        .change_arcsec = turn_judge_change_arcsec(application),
    };
}
