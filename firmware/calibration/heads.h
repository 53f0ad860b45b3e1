/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the geometry of a table's heads, and computes the combinations of their readings that a calibration uses and
   the weights of their mean.

   Head i stands at the angle p_i after head 1, on the radius R/rho_i. A displacement c of the axis adds rho_i Im(c
   e^{jp_i}) to its reading. Weights with sum w_i = 1 and sum w_i rho_i e^{jp_i} = 0 form a mean that no motion of
   the axis changes. */

#ifndef ARCTRUE_HEADS_H
#define ARCTRUE_HEADS_H

#include <stdbool.h>
#include <stdint.h>

#include "mean_set.h"
#include "vector.h"

/* Limit of a mean's noise divided by the noise of one reading: a mean of all heads, or without one head, must have less
   noise than one reading. */
#define MEAN_NOISE_LIMIT 1.0

enum { COMBINATIONS_MOST = 2 };

struct heads_geometry {
    uint32_t heads;
    /* Mean of R_i - R_1 over the turn, rad. */
    double offset_rad[HEADS_MOST];
    /* Angle by which head i detects the index mark late: p_i = offset + late. */
    double late_rad[HEADS_MOST];
    /* rho_i, the radius of the disc divided by the radius of the head. */
    double ratio[HEADS_MOST];
};

/* Returns rho_i e^{jp_i}, the sensitivity of head i to a motion of the axis. */
struct vector heads_sight(const struct heads_geometry *geometry, uint32_t head);

/* Computes orthonormal combinations of readings with sum 0. With four heads this is the parity, the only combination
   that also contains no motion of the axis. With two or three heads these are all combinations with sum 0. Returns
   their number; 0 if four heads stand at only two places. */
uint32_t heads_combinations(const struct heads_geometry *geometry,
                            double combination[COMBINATIONS_MOST][HEADS_MOST]);

/* Returns the noise of the disc's order n in these combinations divided by the noise of one head; INFINITY if they do
   not show this order. */
double heads_gain(const struct heads_geometry *geometry, uint32_t order);

/* Computes the weights with the least noise as s1.16 words whose sum is exactly 1, for the heads whose bits are set in
   `used`, at least three; the other heads get 0. Returns false if no weights suppress the motion of the axis, if their
   noise exceeds MEAN_NOISE_LIMIT, or if a weight does not fit into its word. */
bool heads_weights(const struct heads_geometry *geometry, uint32_t used,
                   int32_t weight[HEADS_MOST]);

/* Returns |sum w_i rho_i e^{jp_i}|, the share of a motion of the axis that the mean contains. */
double heads_leak(const struct heads_geometry *geometry, const int32_t weight[HEADS_MOST]);

#endif
