/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the estimate of the error from one turn: eps = sum of cosine cos(nx) + sine sin(nx), arcseconds. */

#ifndef ARCTRUE_ESTIMATE_H
#define ARCTRUE_ESTIMATE_H

#include <stdbool.h>
#include <stdint.h>

#include "limits.h"
#include "separation.h"

struct harmonic {
    double cosine;
    double sine;
    /* Covariance due to the noise of the turn, arcsec^2; 0 if the order is not seen. */
    double variance_cosine;
    double variance_sine;
    double covariance;
    /* Change of cosine and sine by one standard uncertainty of the separation, arcsec. It is the same in every turn,
       so averaging does not reduce it. */
    double by_separation_cosine;
    double by_separation_sine;
    /* |TF| with two heads; with more, heads_gain() (1 for order 1), which heads_estimate_of_mean() multiplies by the
       factor of the order in the mean. INFINITY for an order that the heads cannot observe. */
    double noise_gain;
    /* True if the heads can observe the order: its error differs from head to head. */
    bool seen;
};

struct estimate {
    /* Order n has the place n - 1. */
    struct harmonic harmonic[ORDERS_MAX];
    uint32_t orders;
    /* True if x is a reading (of a head or of the disc under a head), false if x is the true angle. */
    bool function_of_reading;
    uint32_t samples;
    uint32_t iterations;
    double separation_rad;
    double measured_separation_rad;
    double u_measured_separation_rad;
    enum separation_choice separation_choice;
    double residual_rms_arcsec;
    /* `noise_arcsec`: standard deviation of the noise of head 2 minus head 1; from heads_estimate(), of one reading.
       `colour`: ratio of the residual's power near the orders to its mean power. */
    double noise_arcsec;
    double colour;
};

struct calibration_settings {
    double nominal_separation_rad;
    enum separation_choice separation;
    /* Standard uncertainty of a constant difference between the places where the heads detect the mark. A measured
       separation contains this difference in full, and no capture shows it. */
    double index_detection_arcsec;
    /* Highest fitted order, at most ORDERS_MAX; the fit begins at order 1. */
    uint32_t orders;
};

/* Returns the amplitude of the cosine, 2 A_n of equation (9), arcsec. */
double harmonic_amplitude(const struct harmonic *harmonic);
/* Returns Phi_n of equation (9), rad, in (-pi, pi]. */
double harmonic_phase(const struct harmonic *harmonic);
/* Returns the standard uncertainty of a component: root of the mean of both variances, including the separation's part;
   INFINITY if the order is not seen. */
double harmonic_uncertainty(const struct harmonic *harmonic);

bool estimate_is_finite(const struct estimate *estimate);

#endif
