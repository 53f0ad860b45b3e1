/* SPDX-License-Identifier: Apache-2.0 */

/* Measures the motion of the axis that does not repeat from turn to turn: asynchronous error motion, ISO 230-7.

   Four heads show at every sample the displacement c = x + jy of the axis, divided by the radius of the disc. The mean
   over former turns of its lines at the orders -N to N is the motion that repeats. The mean square of the remainder,
   minus the share of the noise, is the square of the result. Motion and errors of the disc above order N count as
   motion that does not repeat; so does a drift from turn to turn. */

#ifndef ARCTRUE_AXIS_MOTION_H
#define ARCTRUE_AXIS_MOTION_H

#include <stdbool.h>
#include <stdint.h>

#include "heads.h"
#include "limits.h"
#include "vector.h"

enum { AXIS_LINES = 2 * ORDERS_MAX + 1 };

/* Mean of the lines over the turns; it is kept between turns. The line of order m has the place m + orders. */
struct axis_mean {
    /* Highest order N; 0: no turn yet. */
    uint32_t orders;
    /* Sum of the weights of all turns, and variance of the mean divided by the variance of one turn. */
    double turns;
    double variance;
    struct vector line[AXIS_LINES];
};

/* Sums over the samples of one turn. */
struct axis_sums {
    uint32_t orders;
    /* Motion c that corresponds to a residual of one unit in a head, for each head. */
    struct vector by[HEADS_MOST];
    double squares;
    /* Lines of x and y, from order 0 on. */
    struct vector x[ORDERS_MAX + 1];
    struct vector y[ORDERS_MAX + 1];
};

/* Further data of a turn. */
struct axis_turn {
    uint32_t samples;
    /* Motion that the fit of the heads contains, at the orders 0, 1 and -1, arcsec. */
    struct vector still;
    struct vector forward;
    struct vector backward;
    /* Variance of a reading, arcsec^2. */
    double variance;
    /* Variance of the motion due to the uncertainty of the disc's orders, divided by the variance of a reading. */
    double of_disc;
};

/* RMS over both directions, arcsec at the disc, with its standard uncertainty. */
struct axis_asynchronous {
    bool stated;
    double arcsec;
    double u_arcsec;
};

void axis_begin(struct axis_sums *sums, const struct heads_geometry *geometry, uint32_t orders);

/* Adds a sample. `unit1`: e^{jR1}; `weight`: share of the sample's angle in the turn. */
void axis_add(struct axis_sums *sums, const double residual[HEADS_MOST], struct vector unit1,
              double weight);

/* Returns the motion that corresponds to one value per head. */
struct vector axis_of_heads(const struct axis_sums *sums, const double value[HEADS_MOST]);

/* Returns the mean square of the motion that an error of 1 at the disc's order n would cause, times 4. */
double axis_of_order(const struct axis_sums *sums, const struct heads_geometry *geometry,
                     uint32_t order);

/* Computes the result of the turn and adds its lines to the mean. The result is not stated for the first turn. */
struct axis_asynchronous axis_end(const struct axis_sums *sums, const struct axis_turn *turn,
                                  struct axis_mean *mean);

#endif
