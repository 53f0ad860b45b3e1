/* SPDX-License-Identifier: Apache-2.0 */

#include "fourier.h"

#include <math.h>

#include "assertion.h"
#include "noise.h"
#include "transfer_function.h"
#include "units.h"

struct differences {
    const struct turn *turn;
    double mean_counts;
    double arcsec_per_count;
};

static double difference_arcsec(const void *context, uint32_t sample) {
    const struct differences *differences = context;
    double counts = turn_reading(differences->turn, sample).difference;
    return (counts - differences->mean_counts) * differences->arcsec_per_count;
}

struct means {
    double difference_counts;
    /* True angle of the first sample, computed from the fact that the mean error over equal steps is 0. */
    double start_rad;
};

static struct means turn_means(const struct turn *turn) {
    int64_t difference = 0;
    int64_t travel = 0;
    for (uint32_t sample = 0; sample < turn->samples; sample++) {
        struct reading reading = turn_reading(turn, sample);
        difference += reading.difference;
        travel += reading.travel;
    }
    double number = turn->samples;
    double sign = turn->step_counts > 0.0 ? 1.0 : -1.0;
    double start_turns = (turn->start_angle + (double)travel / number) / turn->counts_per_rev -
                         sign * (number - 1.0) / (2.0 * number);
    return (struct means){(double)difference / number, 2.0 * PI * start_turns};
}

/* Returns D_21[n] with its phase at angle 0; the phases of the transform refer to the first sample. */
static struct vector coefficient(const struct lines *lines, const struct turn *turn, uint32_t order,
                                 double start_rad) {
    struct vector line = vector_scaled(lines->sum[order - 1], 1.0 / turn->samples);
    struct vector upward = turn->step_counts > 0.0 ? line : vector_conjugate(line);
    return vector_product(upward, vector_unit(-(double)order * start_rad));
}

static void take_order(struct estimate *estimate, uint32_t order, struct vector difference) {
    struct vector transfer = transfer_function(order, estimate->separation_rad);
    struct vector error = vector_product(difference, transfer);
    struct harmonic *harmonic = &estimate->harmonic[order - 1];
    *harmonic = (struct harmonic){.noise_gain = noise_gain(order, estimate->separation_rad)};
    if (!isfinite(harmonic->noise_gain)) {
        return;
    }
    harmonic->seen = true;
    harmonic->cosine = 2.0 * error.re;
    harmonic->sine = -2.0 * error.im;
    /* White noise of variance 1 in the difference gives a cosine the variance 2 |TF|^2 / K. */
    harmonic->variance_cosine = 2.0 * vector_square(transfer) / estimate->samples;
    harmonic->variance_sine = harmonic->variance_cosine;
}

/* Returns the part of the sum of squares that the estimated orders explain; the transform has two components per order,
   because the signal is real. */
static double squares_of_orders(const struct lines *lines, const struct estimate *estimate) {
    double squares = 0.0;
    for (uint32_t place = 0; place < estimate->orders; place++) {
        if (estimate->harmonic[place].seen) {
            squares += 2.0 * vector_square(lines->sum[place]) / estimate->samples;
        }
    }
    return squares;
}

static void start_estimate(struct estimate *estimate, const struct turn *turn,
                           const struct calibration_settings *settings, double mean_counts) {
    *estimate = (struct estimate){
        .orders = settings->orders,
        .samples = turn->samples,
        .iterations = 1,
        .measured_separation_rad = 2.0 * PI * mean_counts / turn->counts_per_rev,
    };
    estimate->separation_choice = separation_judge(
        settings->nominal_separation_rad, estimate->measured_separation_rad, settings->separation);
    estimate->separation_rad = estimate->separation_choice == SEPARATION_MEASURED
                                   ? estimate->measured_separation_rad
                                   : settings->nominal_separation_rad;
}

enum refusal fourier_estimate(struct fourier_workspace *workspace, const struct turn *turn,
                              const struct calibration_settings *settings,
                              struct estimate *estimate) {
    ASSERT(settings->orders > 0 && settings->orders <= ORDERS_MAX);
    ASSERT(turn->samples > 0 && turn->counts_per_rev > 0);
    uint32_t lines = lines_wanted(settings->orders, turn->samples);
    if (lines < settings->orders) {
        return REFUSED_OVER_SPEED;
    }
    struct means means = turn_means(turn);
    struct differences differences = {turn, means.difference_counts,
                                      ARCSEC_PER_TURN / turn->counts_per_rev};
    double squares;
    unit_circle_prepare(&workspace->circle);
    lines_transform(&workspace->lines, lines, &workspace->circle, difference_arcsec, &differences,
                    turn->samples, &squares);
    start_estimate(estimate, turn, settings, means.difference_counts);
    for (uint32_t order = 1; order <= settings->orders; order++) {
        take_order(estimate, order, coefficient(&workspace->lines, turn, order, means.start_rad));
    }
    noise_measure(estimate, squares - squares_of_orders(&workspace->lines, estimate),
                  &workspace->lines);
    noise_scale_covariance(estimate);
    noise_add_separation(estimate, turn->counts_per_rev, settings->index_detection_arcsec);
    return estimate_is_finite(estimate) ? NOT_REFUSED : REFUSED_NOT_FINITE;
}
