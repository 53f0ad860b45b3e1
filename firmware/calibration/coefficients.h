/* SPDX-License-Identifier: Apache-2.0 */

/* Converts coefficients of equation (9) to and from the form of the gateware. */

#ifndef ARCTRUE_COEFFICIENTS_H
#define ARCTRUE_COEFFICIENTS_H

#include "estimate.h"
#include "mean_set.h"
#include "refusal.h"
#include "selection.h"
#include "vector.h"

/* Words of a lane, which is a unit of the gateware that adds one harmonic to the correction. Its phase step K follows
   from order and counts_per_rev and is computed when needed. */
struct lane {
    /* Phase Phi, u0.24 turn. */
    uint32_t phase_offset;
    /* Amplitude 2 A_n, s13.11 counts. */
    int32_t amplitude;
    /* Order of the lane; 0: the lane is unused. */
    uint32_t order;
};

struct coefficients {
    struct lane lane[LANES_LIMIT];
    uint32_t lanes;
    uint32_t counts_per_rev;
    /* Mean of heads that the lanes correct; its `heads` is 0 if they correct head 1 alone. */
    struct mean_set mean;
};

/* Quantises the orders whose verdict is VERDICT_APPLIED, one per lane; the remaining lanes stay unused. Returns
   REFUSED_AMPLITUDE if a lane cannot hold an amplitude. */
enum refusal coefficients_quantise(const struct estimate *estimate, const enum verdict *verdicts,
                                   uint32_t counts_per_rev, uint32_t lanes,
                                   struct coefficients *coefficients);

/* Returns K = round(n 2^48 / counts_per_rev) mod 2^48; `order` below 2^16. */
uint64_t coefficients_phase_step(uint32_t order, uint32_t counts_per_rev);

/* Tells whether a lane can hold order, phase offset and amplitude. */
bool coefficients_lane_is_valid(const struct lane *lane);

/* Tells whether a lane has the order; returns false if `coefficients` is NULL or the order is 0. */
bool coefficients_have(const struct coefficients *coefficients, uint32_t order);
/* Returns the lane of the order; NULL if no lane has the order or the order is 0. */
const struct lane *coefficients_lane_of(const struct coefficients *coefficients, uint32_t order);
/* Returns the highest order that has a lane, or 0 if there is none. */
uint32_t coefficients_most_order(const struct coefficients *coefficients);
/* Switches off the lanes of orders above `most`. */
void coefficients_drop_orders(struct coefficients *coefficients, uint32_t most);

/* Returns cosine and sine of a lane's order, arcsec. */
struct vector coefficients_lane_components(const struct lane *lane, uint32_t counts_per_rev);
/* Returns cosine and sine of an order as the lanes hold them, arcsec; 0 if no lane has the order. */
struct vector coefficients_components(const struct coefficients *coefficients, uint32_t order);

#endif
