/* SPDX-License-Identifier: Apache-2.0 */

/* Implements the Fourier method of the paper, equations (1) to (7).

   The method assumes equal steps of the true angle between samples. Sampling at equal times at an uneven speed violates
   this assumption; the method of least_squares.h does not need it. */

#ifndef ARCTRUE_FOURIER_H
#define ARCTRUE_FOURIER_H

#include "capture.h"
#include "estimate.h"
#include "lines.h"

struct fourier_workspace {
    struct unit_circle circle;
    struct lines lines;
};

/* Estimates the error as a function of the true angle. */
enum refusal fourier_estimate(struct fourier_workspace *workspace, const struct turn *turn,
                              const struct calibration_settings *settings,
                              struct estimate *estimate);

#endif
