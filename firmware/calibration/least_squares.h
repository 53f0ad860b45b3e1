/* SPDX-License-Identifier: Apache-2.0 */

/* Estimates the error by least squares at the angles that were read.

   With g(R) = eps(theta), the error as a function of the reading, each head's reading determines the angle of the disc
   under this head without approximation. The equation R2 - R1 = alpha + g(R2) - g(R1) is linear in the harmonics of g
   and in alpha, and is exact for any steps, speed and number of samples. Only the zero of head 2 depends on the result:
   if the separation is not taken from this turn, R2 is moved by the difference between the fitted constant and the
   separation, and the fit is repeated until a further move would change the error by less than 1e-4 arcsec. */

#ifndef ARCTRUE_LEAST_SQUARES_H
#define ARCTRUE_LEAST_SQUARES_H

#include "capture.h"
#include "estimate.h"
#include "gram.h"
#include "lines.h"

struct least_squares_workspace {
    struct unit_circle circle;
    struct gram_layout layout;
    /* The harmonics of all orders, cosines before sines, then the constant; arcsec. */
    double values[UNKNOWNS_MAX];
    double right[UNKNOWNS_MAX];
    double residual_squares;
    double packed[UNKNOWNS_MAX * (UNKNOWNS_MAX + 1) / 2];
    /* The sums are no longer needed when the spectrum is computed, so both share the memory. */
    union {
        struct gram_sums sums;
        struct lines lines;
    } pass;
};

/* Estimates the error as a function of the reading. */
enum refusal least_squares_estimate(struct least_squares_workspace *workspace,
                                    const struct turn *turn,
                                    const struct calibration_settings *settings,
                                    struct estimate *estimate);

#endif
