/* SPDX-License-Identifier: Apache-2.0 */

/* Computes the covariance of the harmonics from the residual of a fit. */

#ifndef ARCTRUE_NOISE_H
#define ARCTRUE_NOISE_H

#include "estimate.h"
#include "lines.h"

/* Computes noise and colour of the estimate from the residual's sum of squares and spectrum. */
void noise_measure(struct estimate *estimate, double residual_squares, const struct lines *lines);

/* Scales covariances for noise of variance 1 to the measured noise. */
void noise_scale_covariance(struct estimate *estimate);

/* Sets, for all orders, the change of cosine and sine by one standard uncertainty of the separation: dE_n/d alpha = -j
   n e^{jn alpha} TF(n) E_n. Also sets the uncertainty of the measured separation. */
void noise_add_separation(struct estimate *estimate, int32_t counts_per_rev,
                          double index_detection_arcsec);

#endif
