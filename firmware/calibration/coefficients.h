/* SPDX-License-Identifier: Apache-2.0 */

/* The coefficients of equation (9) as the gateware holds them. */

#ifndef ARCTRUE_COEFFICIENTS_H
#define ARCTRUE_COEFFICIENTS_H

#include "estimate.h"
#include "mean_set.h"
#include "refusal.h"
#include "selection.h"
#include "vector.h"

/* K, the phase step, follows from order and counts_per_rev: it is worked out where it is needed. */
struct lane {
    /* Phi, u0.24 turn. */
    uint32_t phase_offset;
    /* 2 A_n, s13.11 counts. */
    int32_t amplitude;
    /* 0: the lane is not used. */
    uint32_t order;
};

struct coefficients {
    struct lane lane[LANES_LIMIT];
    uint32_t lanes;
    uint32_t counts_per_rev;
    /* Of which heads the lanes correct the mean. */
    struct mean_set mean;
};

/* Quantise the applied orders; the lanes left over have amplitude 0. */
enum refusal coefficients_quantise(const struct estimate *estimate, const enum verdict *verdicts,
                                   uint32_t counts_per_rev, uint32_t lanes,
                                   struct coefficients *coefficients);

/* K = round(n 2^48 / counts_per_rev) mod 2^48; `order` below 2^16. */
uint64_t coefficients_phase_step(uint32_t order, uint32_t counts_per_rev);

/* Order, phase offset and amplitude are what a lane holds. */
bool coefficients_lane_is_valid(const struct lane *lane);

/* A lane has the order; of NULL none has. */
bool coefficients_have(const struct coefficients *coefficients, uint32_t order);
/* Its lane, NULL where there is none; of order 0 there is none. */
const struct lane *coefficients_lane_of(const struct coefficients *coefficients, uint32_t order);
/* The highest order that has a lane; 0: none has. */
uint32_t coefficients_most_order(const struct coefficients *coefficients);
/* Switch off the lanes of orders above `most`. */
void coefficients_drop_orders(struct coefficients *coefficients, uint32_t most);

/* Cosine and sine of a lane's order, arcsec. */
struct vector coefficients_lane_components(const struct lane *lane, uint32_t counts_per_rev);
/* Cosine and sine of an order, arcsec, as the lanes hold them; 0 where no lane has it. */
struct vector coefficients_components(const struct coefficients *coefficients, uint32_t order);

#endif
