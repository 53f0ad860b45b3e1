/* SPDX-License-Identifier: Apache-2.0 */

/* What one turn says of the error: eps = sum of cosine cos(nx) + sine sin(nx), arcseconds. */

#ifndef ARCTRUE_ESTIMATE_H
#define ARCTRUE_ESTIMATE_H

#include <stdbool.h>
#include <stdint.h>

#include "limits.h"
#include "separation.h"

struct harmonic {
    double cosine;
    double sine;
    /* Covariance by the noise of the turn, arcsec^2; 0 where not seen. */
    double variance_cosine;
    double variance_sine;
    double covariance;
    /* What one standard uncertainty of the separation adds to cosine and sine, arcsec. The same
       in every turn: averaging does not lessen it. */
    double by_separation_cosine;
    double by_separation_sine;
    /* |TF|; INFINITY where the order cannot be seen. */
    double noise_gain;
    bool seen;
};

struct estimate {
    /* Order n at place n - 1. */
    struct harmonic harmonic[ORDERS_MAX];
    uint32_t orders;
    /* x is the reading of head 1; otherwise its true angle. */
    bool function_of_reading;
    uint32_t samples;
    uint32_t iterations;
    double separation_rad;
    double measured_separation_rad;
    double u_measured_separation_rad;
    enum separation_choice separation_choice;
    double residual_rms_arcsec;
    /* Standard deviation of the noise of head 2 less head 1, and the power of the residual near
       the orders over its mean power. */
    double noise_arcsec;
    double colour;
};

struct calibration_settings {
    double nominal_separation_rad;
    enum separation_choice separation;
    /* Standard uncertainty of a constant difference between the places where the heads detect the
       mark: a measured separation holds it one to one, and no capture tells. */
    double index_detection_arcsec;
    /* Orders 1 to this are fitted; at most ORDERS_MAX. */
    uint32_t orders;
};

/* Amplitude of the cosine, 2 A_n of equation (9), arcsec. */
double harmonic_amplitude(const struct harmonic *harmonic);
/* Phi_n of equation (9), rad, in (-pi, pi]. */
double harmonic_phase(const struct harmonic *harmonic);
/* Standard uncertainty of a component: root of the mean of both variances, separation included. */
double harmonic_uncertainty(const struct harmonic *harmonic);

bool estimate_is_finite(const struct estimate *estimate);

#endif
