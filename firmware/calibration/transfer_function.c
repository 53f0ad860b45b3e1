/* SPDX-License-Identifier: Apache-2.0 */

#include "transfer_function.h"

/* |e^{jn alpha} - 1| below this limit counts as 0, because alpha is not known more precisely. */
#define UNSEEN_DENOMINATOR 1e-4

struct vector transfer_function(uint32_t order, double separation_rad) {
    double half = 0.5 * order * separation_rad;
    /* e^{jx} - 1 = 2j sin(x/2) e^{jx/2} keeps its precision near whole turns. */
    double size = 2.0 * sin(half);
    if (fabs(size) <= UNSEEN_DENOMINATOR) {
        return (struct vector){0.0, 0.0};
    }
    /* 1/(j size e^{j half}) */
    return (struct vector){-sin(half) / size, -cos(half) / size};
}

double noise_gain(uint32_t order, double separation_rad) {
    struct vector transfer = transfer_function(order, separation_rad);
    double gain = vector_length(transfer);
    return gain > 0.0 ? gain : (double)INFINITY;
}
