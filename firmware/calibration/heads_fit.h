/* SPDX-License-Identifier: Apache-2.0 */

/* The disc's error and the heads' places from one turn of two to four heads, at the angles really read.

   With g(R) the error of the disc as a function of its own reading, head i reads

       R_i = theta + a_i + g_i(R_i + d_i) + m_i,

   a_i the offset of its counter, d_i what it detects the index mark late, m_i what it sees of the axis; order 1 of g
   acts by rho_i. Four heads: the parity, free of rotation and of every motion of the axis, shows the orders from 2 on.
   Three heads: both combinations without rotation show them, as far as the axis is at rest at these orders. Two heads:
   one combination shows all orders. With three and four, the readings' lines at order 1 give order 1 of the disc, the
   backward circle of the axis, and d_i and rho_i together with what is known beforehand, by Gauss-Newton.

   Each pass over the turn works out all residuals at the present values; the passes end when nothing changes. */

#ifndef ARCTRUE_HEADS_FIT_H
#define ARCTRUE_HEADS_FIT_H

#include "capture.h"
#include "estimate.h"
#include "gram.h"
#include "heads.h"
#include "lines.h"
#include "unit_circle.h"

/* Orders at which the motion of the axis is worked out. */
enum { CIRCLE_ORDERS = 4 };

struct heads_settings {
    /* As mounted, after head 1. */
    double place_rad[HEADS_MOST];
    /* Standard uncertainties: of a place as mounted; of the difference between the places where two heads detect the
       mark; of a radius over the disc's. */
    double u_place_arcsec;
    double u_index_arcsec;
    double u_radius;
    /* Orders 1 to this are fitted; at most ORDERS_MAX. */
    uint32_t orders;
};

/* What a turn says of the heads and of the axis. */
struct heads_found {
    struct heads_geometry geometry;
    double u_late_arcsec[HEADS_MOST];
    double u_ratio[HEADS_MOST];
    /* Of each head against the mean of all, without the disc's error: RMS. */
    double residual_arcsec[HEADS_MOST];
    /* Four heads: radius of the axis' circles by order, with the table and against it, arcsec at the disc. The forward
       circle of order 1 is an eccentric disc and 0 here. */
    double forward_arcsec[CIRCLE_ORDERS];
    double backward_arcsec[CIRCLE_ORDERS];
};

enum {
    LINE_PARTS = 3,
    FIT_UNKNOWNS = 2 * ORDERS_MAX,
    /* Order 1 of the disc, backward circle, d and rho of heads 2 and on. */
    PLACE_UNKNOWNS = 4 + 2 * (HEADS_MOST - 1),
};

struct heads_workspace {
    struct unit_circle circle;
    struct gram_layout layout;
    /* Cosines of all orders before sines, arcsec. */
    double values[FIT_UNKNOWNS];
    double right[FIT_UNKNOWNS];
    double packed[FIT_UNKNOWNS * (FIT_UNKNOWNS + 1) / 2];
    double of_places[PLACE_UNKNOWNS * (PLACE_UNKNOWNS + 1) / 2];
    struct vector columns[COMBINATIONS_MOST][ORDERS_MAX];
    struct lines lines;
    /* Sums over a pass: of each head's residual less head 1's, times e^{-jkR1}; of it alone; of squares. */
    struct vector line[CIRCLE_ORDERS][HEADS_MOST];
    double sum[HEADS_MOST];
    double head_squares[HEADS_MOST];
    /* Sums of products of 1, cosine and sine of R1. */
    double density[LINE_PARTS * (LINE_PARTS + 1) / 2];
    double squares;
};

/* The disc's error as a function of the disc's reading; `found` beside it. */
enum refusal heads_estimate(struct heads_workspace *workspace, const struct capture *capture,
                            const struct turn *turn, const struct heads_settings *settings,
                            struct heads_found *found, struct estimate *estimate);

/* Turn an estimate of the disc into one of the error of the mean `set` as a function of head 1's reading, and set the
   constant part of it. The uncertainty of places and radii becomes that by the separation. */
void heads_estimate_of_mean(struct heads_workspace *workspace, const struct heads_found *found,
                            uint32_t counts_per_rev, struct mean_set *set,
                            struct estimate *estimate);

#endif
