/* SPDX-License-Identifier: Apache-2.0 */

/* Estimates, from one turn, the orders that the calibration does not fit.

   After the fit, the residual r of head 2 minus head 1 contains, at order m, Re(G2 e^{jmR2} - G1 e^{jmR1}) with G =
   cosine - j sine of each head. Three sums over the turn form the normal equations

       A1 = 2 <r e^{-jmR1}> = D G2 - G1,   A2 = 2 <r e^{-jmR2}> = G2 - D* G1,   D = <e^{jm(R2 - R1)}>

   so that one pass serves all orders and needs no cosine of the library. */

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
    /* Sums over the turn of r e^{jmR1}, r e^{jmR2} and e^{jm(R2 - R1)}; and of cos^2(mR1) and cos(mR1) sin(mR1). */
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
    /* Least and largest step of head 1 between samples, turns. */
    double least_step;
    double most_step;
};

/* Computes the sums over the turn for the orders of `set` that `estimate`, a function of the reading, does not
   contain. */
void further_orders_look(struct further_workspace *workspace, const struct turn *turn,
                         const struct estimate *estimate, const struct coefficients *set);

/* Returns the shift of head 2's readings, radians: the measured separation minus the separation that `estimate`
   uses. */
double further_orders_shift_rad(const struct estimate *estimate);

/* Returns the turn's result for one of these orders. If the readings cannot separate the errors of the two heads,
   the value is attributed to the disc or to head 1 alone, whichever is nearer to `applied`. */
struct sight further_orders_sight(const struct further_workspace *workspace,
                                  const struct estimate *estimate, uint32_t order,
                                  double gain_limit, struct vector applied);

#endif
