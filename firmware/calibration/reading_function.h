/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_READING_FUNCTION_H
#define ARCTRUE_READING_FUNCTION_H

#include "estimate.h"
#include "lines.h"

struct reading_workspace {
    struct unit_circle circle;
    struct lines lines;
};

/* Make an estimate of eps(theta) one of g with g(R) = eps(theta), R = theta + eps(theta): the
   gateware works out the error at the reading, equation (8). Taking eps(R) for eps(theta) would
   leave 0.055 arcsec of order 2 at 150 arcsec of eccentricity. The covariance stays: values
   change by less than a thousandth. Does nothing where it is one already. */
void estimate_as_function_of_reading(struct reading_workspace *workspace,
                                     struct estimate *estimate);

#endif
