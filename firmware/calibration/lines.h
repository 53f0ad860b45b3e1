/* SPDX-License-Identifier: Apache-2.0 */

/* Some lines of a discrete Fourier transform, of any number of samples, without storing them. */

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

/* A sample of what is transformed. */
typedef double line_sample(const void *context, uint32_t sample);

/* Lines 1 to `number` of `samples` samples; `sum_of_squares` of the samples besides. */
void lines_transform(struct lines *lines, uint32_t number, const struct unit_circle *circle,
                     line_sample *sample, const void *context, uint32_t samples,
                     double *sum_of_squares);

/* Lines that can be told apart: the orders to fit and what the noise is read from. */
uint32_t lines_wanted(uint32_t orders, uint32_t samples);

/* Mean power |X|^2/K of the lines next to the fitted orders, NOISE_LINES of them where there are
   so many; those of orders that were fitted say nothing and are left out. 0: there are none. */
double lines_noise_power(const struct lines *lines, const struct estimate *estimate,
                         uint32_t samples);

#endif
