/* SPDX-License-Identifier: Apache-2.0 */

/* From what a fit leaves to the covariance of its harmonics. */

#ifndef ARCTRUE_NOISE_H
#define ARCTRUE_NOISE_H

#include "estimate.h"
#include "lines.h"

/* Noise and colour of the estimate from the residual's sum of squares and spectrum. */
void noise_measure(struct estimate *estimate, double residual_squares, const struct lines *lines);

/* Turn covariances for noise of variance 1 into those of the measured noise. */
void noise_scale_covariance(struct estimate *estimate);

/* What the uncertainty of the separation does: dE_n/d alpha = -j n e^{jn alpha} TF(n) E_n. */
void noise_add_separation(struct estimate *estimate, int32_t counts_per_rev,
                          double index_detection_arcsec);

#endif
