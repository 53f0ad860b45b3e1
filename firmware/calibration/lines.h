/* SPDX-License-Identifier: Apache-2.0 */

/* Computes some lines of a discrete Fourier transform of any number of samples, without storing the samples. */

#ifndef ARCTRUE_LINES_H
#define ARCTRUE_LINES_H

#include <stdint.h>

#include "capture.h"
#include "estimate.h"
#include "unit_circle.h"

struct lines {
    /* Sum of x_k e^{-j 2 pi l k / K}; line l at place l - 1. */
    struct vector sum[LINES_MAX];
    uint32_t number;
};

/* Returns a sample of the transformed function. */
typedef double line_sample(const void *context, uint32_t sample);

/* Computes the lines 1 to `number` of `samples` samples, and the `sum_of_squares` of the samples. */
void lines_transform(struct lines *lines, uint32_t number, const struct unit_circle *circle,
                     line_sample *sample, const void *context, uint32_t samples,
                     double *sum_of_squares);

/* Returns the number of lines that `samples` samples can separate, at most the orders to fit plus the lines for the
   noise. */
uint32_t lines_wanted(uint32_t orders, uint32_t samples);

/* Returns the mean power |X|^2/K of the lowest lines that belong to no fitted order, at most NOISE_LINES lines. Lines
   of fitted orders do not show the noise. Returns 0 if every line belongs to a fitted order. */
double lines_noise_power(const struct lines *lines, const struct estimate *estimate,
                         uint32_t samples);

#endif
