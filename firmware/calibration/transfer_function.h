/* SPDX-License-Identifier: Apache-2.0 */

/* The transfer function of two read heads, equation (6) of the paper. */

#ifndef ARCTRUE_TRANSFER_FUNCTION_H
#define ARCTRUE_TRANSFER_FUNCTION_H

#include <stdint.h>

#include "vector.h"

/* TF(n) = 1/(e^{jn alpha} - 1), 0 where the denominator is 0. */
struct vector transfer_function(uint32_t order, double separation_rad);

/* |TF(n)|: noise of the error over noise of head 2 less head 1; INFINITY where it is not seen. */
double noise_gain(uint32_t order, double separation_rad);

#endif
