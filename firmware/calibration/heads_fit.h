/* SPDX-License-Identifier: Apache-2.0 */

/* Estimates the disc's error and the heads' places from one turn of two to four heads, at the angles that were read.

   With g(R), the error of the disc as a function of its own reading, head i reads

       R_i = theta + a_i + g_i(R_i + d_i) + m_i,

   where a_i is the offset of its counter, d_i the angle by which it detects the index mark late, and m_i the effect of
   a motion of the axis; order 1 of g acts with the factor rho_i. With four heads, the parity, which contains neither
   rotation nor any motion of the axis, shows the orders from 2 on. With three heads, both combinations without rotation
   show them if the axis does not move at these orders. With two heads, one combination shows all orders. With three and
   four heads, a Gauss-Newton iteration determines order 1 of the disc, the circular motion of the axis against the
   table's rotation, d_i and rho_i. It uses the Fourier components of the readings at order 1, and prior values of d_i
   and rho_i.

   Each pass over the turn computes all residuals at the present values; the passes end when a further step would change
   the values by less than 1e-11 of the largest value. */

#ifndef ARCTRUE_HEADS_FIT_H
#define ARCTRUE_HEADS_FIT_H

#include "axis_motion.h"
#include "capture.h"
#include "coefficients.h"
#include "estimate.h"
#include "gram.h"
#include "heads.h"
#include "lines.h"
#include "unit_circle.h"

/* Number of orders at which the motion of the axis is determined. */
enum { CIRCLE_ORDERS = 4 };

struct heads_settings {
    /* Angles from head 1 to each head, as mounted. */
    double place_rad[HEADS_MOST];
    /* Standard uncertainties: of a place as mounted; of the difference between the places where two heads detect the
       mark; and of a head's radius relative to the disc's. */
    double u_place_arcsec;
    double u_index_arcsec;
    double u_radius;
    /* Highest fitted order, at most ORDERS_MAX; the fit begins at order 1. */
    uint32_t orders;
    /* Motion of the axis that repeats, of the former turns; NULL: the motion that does not repeat is not computed. */
    struct axis_mean *axis;
};

/* Results of a turn for the heads and the axis. */
struct heads_found {
    struct heads_geometry geometry;
    double u_late_arcsec[HEADS_MOST];
    double u_ratio[HEADS_MOST];
    /* RMS of each head's reading minus the mean of all heads, after subtraction of the disc's error. */
    double residual_arcsec[HEADS_MOST];
    /* Radius of the circular motions of the axis by order, in the direction of the table and against it, arcsec at the
       disc. The forward circle of order 1 cannot be distinguished from an eccentric disc and is 0 here. Three heads
       show only the backward circle of order 1; the other values are then 0. */
    double forward_arcsec[CIRCLE_ORDERS];
    double backward_arcsec[CIRCLE_ORDERS];
    /* Motion of the axis that does not repeat from turn to turn; only four heads show it. */
    struct axis_asynchronous asynchronous;
};

enum {
    LINE_PARTS = 3,
    FIT_UNKNOWNS = 2 * ORDERS_MAX,
    /* Order 1 of the disc, backward circle, and d and rho of heads 2 to 4. */
    PLACE_UNKNOWNS = 4 + 2 * (HEADS_MOST - 1),
};

/* The disc's estimate, and the results from it: the estimate of one mean, and the words of the means without one
   head. */
struct heads_made {
    struct estimate disc;
    struct estimate of_mean;
    struct coefficients without[HEADS_MOST];
};

struct heads_workspace {
    struct unit_circle circle;
    struct gram_layout layout;
    /* Cosines of all orders, then sines, arcsec. */
    double values[FIT_UNKNOWNS];
    double right[FIT_UNKNOWNS];
    union {
        double packed[FIT_UNKNOWNS * (FIT_UNKNOWNS + 1) / 2];
        /* Sums and results that are computed after the fit. */
        struct axis_sums axis;
        struct heads_made made;
    };
    double of_places[PLACE_UNKNOWNS * (PLACE_UNKNOWNS + 1) / 2];
    struct vector columns[COMBINATIONS_MOST][ORDERS_MAX];
    struct lines lines;
    /* Sums over a pass, where x is a head's residual minus head 1's: x times e^{-jkR1}; x alone; and the squares of x
       minus its mean over the heads. */
    struct vector line[CIRCLE_ORDERS][HEADS_MOST];
    double sum[HEADS_MOST];
    double head_squares[HEADS_MOST];
    /* Sums of the products of 1, cosine and sine of R1. */
    double density[LINE_PARTS * (LINE_PARTS + 1) / 2];
    /* Sum of the squares of all combinations of the residuals. */
    double squares;
};

/* Estimates the disc's error as a function of the disc's reading, and fills `found`. */
enum refusal heads_estimate(struct heads_workspace *workspace, const struct capture *capture,
                            const struct turn *turn, const struct heads_settings *settings,
                            struct heads_found *found, struct estimate *estimate);

/* Converts an estimate of the disc into an estimate of the error of the mean `set` as a function of the reading of its
   carrier, the head that the mean follows, and sets the constant part of the error in `set`. The uncertainty of places
   and radii replaces the uncertainty of the separation. */
void heads_estimate_of_mean(struct heads_workspace *workspace, const struct heads_found *found,
                            uint32_t counts_per_rev, struct mean_set *set,
                            struct estimate *estimate);

#endif
