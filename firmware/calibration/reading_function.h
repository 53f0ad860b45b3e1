/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_READING_FUNCTION_H
#define ARCTRUE_READING_FUNCTION_H

#include "estimate.h"
#include "lines.h"

struct reading_workspace {
    struct unit_circle circle;
    struct lines lines;
};

/* Converts an estimate of eps(theta) into an estimate of g, where g(R) = eps(theta) and R = theta + eps(theta), because
   the gateware computes the error at the reading, equation (8). Using eps(R) for eps(theta) would leave 0.055 arcsec of
   order 2 at 150 arcsec of eccentricity. The covariance is kept, because values change by less than a thousandth. An
   estimate that is already one of g is not changed. */
void estimate_as_function_of_reading(struct reading_workspace *workspace,
                                     struct estimate *estimate);

#endif
