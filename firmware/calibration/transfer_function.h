/* SPDX-License-Identifier: Apache-2.0 */

/* Computes the transfer function of two read heads, equation (6) of the paper. */

#ifndef ARCTRUE_TRANSFER_FUNCTION_H
#define ARCTRUE_TRANSFER_FUNCTION_H

#include <stdint.h>

#include "vector.h"

/* Returns TF(n) = 1/(e^{jn alpha} - 1), or 0 if the denominator's magnitude is at most 1e-4. */
struct vector transfer_function(uint32_t order, double separation_rad);

/* Returns |TF(n)|, the noise of the error divided by the noise of head 2 minus head 1; INFINITY if TF(n) is 0, because
   the heads do not show this order. */
double noise_gain(uint32_t order, double separation_rad);

#endif
