/* SPDX-License-Identifier: Apache-2.0 */

#include "noise.h"

#include <math.h>

#include "assertion.h"
#include "transfer_function.h"
#include "units.h"

/* Least variance, arcsec^2: a residual of exactly zero must not cause a division by zero. */
#define LEAST_VARIANCE 1e-18

static uint32_t parameters(const struct estimate *estimate) {
    uint32_t number = 1;
    for (uint32_t place = 0; place < estimate->orders; place++) {
        number += estimate->harmonic[place].seen ? 2U : 0U;
    }
    return number;
}

void noise_measure(struct estimate *estimate, double residual_squares, const struct lines *lines) {
    ASSERT(estimate->samples > 0 && estimate->orders <= ORDERS_MAX);
    uint32_t used = parameters(estimate);
    uint32_t freedom = estimate->samples > used ? estimate->samples - used : 1;
    double squares = fmax(residual_squares, 0.0);
    double variance = fmax(squares / freedom, LEAST_VARIANCE);
    double power = lines_noise_power(lines, estimate, estimate->samples);
    estimate->noise_arcsec = sqrt(variance);
    estimate->residual_rms_arcsec = sqrt(squares / estimate->samples);
    estimate->colour = power > 0.0 ? power / variance : 1.0;
}

void noise_scale_covariance(struct estimate *estimate) {
    double factor = estimate->noise_arcsec * estimate->noise_arcsec * estimate->colour;
    for (uint32_t place = 0; place < estimate->orders; place++) {
        struct harmonic *harmonic = &estimate->harmonic[place];
        harmonic->variance_cosine *= factor;
        harmonic->variance_sine *= factor;
        harmonic->covariance *= factor;
    }
}

void noise_add_separation(struct estimate *estimate, int32_t counts_per_rev,
                          double index_detection_arcsec) {
    ASSERT(counts_per_rev > 0 && estimate->orders <= ORDERS_MAX);
    double u_rad = separation_uncertainty_rad(estimate->separation_choice, counts_per_rev,
                                              index_detection_arcsec);
    for (uint32_t place = 0; place < estimate->orders; place++) {
        struct harmonic *harmonic = &estimate->harmonic[place];
        uint32_t order = place + 1;
        struct vector turned = vector_product(vector_unit(order * estimate->separation_rad),
                                              transfer_function(order, estimate->separation_rad));
        struct vector error = {harmonic->cosine, -harmonic->sine};
        struct vector slope = vector_product(turned, error);
        /* The derivative of cosine - j sine is -j n slope. */
        harmonic->by_separation_cosine = order * slope.im * u_rad;
        harmonic->by_separation_sine = order * slope.re * u_rad;
    }
    double statistical = estimate->noise_arcsec * sqrt(estimate->colour / estimate->samples);
    const struct vector parts = {statistical / ARCSEC_PER_RAD,
                                 index_uncertainty_rad(counts_per_rev, index_detection_arcsec)};
    estimate->u_measured_separation_rad = vector_length(parts);
}
