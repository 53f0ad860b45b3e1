/* SPDX-License-Identifier: Apache-2.0 */

/* Orders that the calibration does not fit, as a turn shows them.

   What the fit leaves of head 2 less head 1 is, at order m, Re(G2 e^{jmR2} - G1 e^{jmR1}) with
   G = cosine - j sine of each head. Three sums over the turn are its normal equations

       A1 = 2 <r e^{-jmR1}> = D G2 - G1,   A2 = 2 <r e^{-jmR2}> = G2 - D* G1,   D = <e^{jm(R2 - R1)}>

   so that one pass serves all orders, and no cosine of the library is called. */

#ifndef ARCTRUE_FURTHER_ORDERS_H
#define ARCTRUE_FURTHER_ORDERS_H

#include "capture.h"
#include "coefficients.h"
#include "estimate.h"
#include "sight.h"
#include "unit_circle.h"

struct further_order {
    uint64_t phase_step;
    uint32_t order;
    /* Sums over the turn: of r e^{jmR1}, r e^{jmR2} and e^{jm(R2 - R1)}; of cos^2(mR1) and
       cos(mR1) sin(mR1). */
    struct vector head1;
    struct vector head2;
    struct vector apart;
    struct vector products;
};

struct further_workspace {
    struct unit_circle circle;
    struct further_order order[LANES_LIMIT];
    uint32_t number;
    uint32_t samples;
    /* Of head 1 from sample to sample, turns. */
    double least_step;
    double most_step;
};

/* Looks at the orders of `set` that `estimate`, a function of the reading, does not have. */
void further_orders_look(struct further_workspace *workspace, const struct turn *turn,
                         const struct estimate *estimate, const struct coefficients *set);

/* Where the separation is not the measured one, head 2 reads as much more. */
double further_orders_shift_rad(const struct estimate *estimate);

/* What the turn says of one of them. Where the readings cannot tell the heads' own errors apart it
   is taken for the disc's or for head 1's alone, whichever is nearer to `applied`. */
struct sight further_orders_sight(const struct further_workspace *workspace,
                                  const struct estimate *estimate, uint32_t order,
                                  double gain_limit, struct vector applied);

#endif
