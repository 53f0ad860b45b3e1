/* SPDX-License-Identifier: Apache-2.0 */

/* Computes e^{jx} of an angle in turns, within 2e-16, from a table of 64 directions and a short series. Every sample
   needs two such values, and the library's sine and cosine take five times as long. */

#ifndef ARCTRUE_UNIT_CIRCLE_H
#define ARCTRUE_UNIT_CIRCLE_H

#include "vector.h"

enum { UNIT_CIRCLE_STEPS = 64 };

struct unit_circle {
    struct vector step[UNIT_CIRCLE_STEPS];
};

void unit_circle_prepare(struct unit_circle *circle);

/* Returns e^{j 2 pi turns}; `turns`: any value below 2^24 in magnitude. */
struct vector unit_circle_at(const struct unit_circle *circle, double turns);

#endif
