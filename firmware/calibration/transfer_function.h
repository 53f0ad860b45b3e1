/* SPDX-License-Identifier: Apache-2.0 */

/* Computes the transfer function of two read heads, equation (6) of the paper. */

#ifndef ARCTRUE_TRANSFER_FUNCTION_H
#define ARCTRUE_TRANSFER_FUNCTION_H

#include <stdint.h>

#include "vector.h"

/* Returns TF(n) = 1/(e^{jn alpha} - 1), or 0 if the denominator is 0. */
struct vector transfer_function(uint32_t order, double separation_rad);

/* Returns |TF(n)|, the noise of the error over the noise of head 2 minus head 1; INFINITY if the order is not seen. */
double noise_gain(uint32_t order, double separation_rad);

#endif
