/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the state of a fit of the heads, and the steps of heads_estimate() (heads_fit.h). */

#ifndef ARCTRUE_HEADS_STEPS_H
#define ARCTRUE_HEADS_STEPS_H

#include "heads_fit.h"

struct heads_fit {
    struct heads_workspace *workspace;
    const struct capture *capture;
    const struct turn *turn;
    const struct heads_settings *settings;
    struct heads_geometry *geometry;
    uint32_t orders;
    uint32_t rows;
    double arcsec_per_count;
    double turns_per_count;
    /* Counts by which a head's word minus that of head 1 exceeds the angle between the two heads. */
    int32_t ahead[HEADS_MOST];
    double combination[COMBINATIONS_MOST][HEADS_MOST];
    /* e^{jd_i} and rho_i e^{jp_i} of each head (heads_fit.h, heads.h). */
    struct vector late[HEADS_MOST];
    struct vector sight[HEADS_MOST];
    /* Circular motion of the axis opposite to the table's rotation, arcsec. */
    struct vector backward;
};

/* Computes the residual of every head minus the residual of head 1, arcsec, and the columns; returns e^{jR1}. */
struct vector heads_look(const struct heads_fit *fit, uint32_t sample, double residual[HEADS_MOST]);
double heads_combined(const struct heads_fit *fit, uint32_t row, const double residual[HEADS_MOST]);

/* Chooses the orders of the disc from `first` on that the heads show. */
void heads_choose_orders(struct heads_fit *fit, uint32_t first);
/* Builds X^T X, scaled to the number of all samples. */
enum refusal heads_build_matrix(const struct heads_fit *fit);
/* Makes one step of the iteration for the disc and returns its size. */
double heads_step_of_disc(const struct heads_fit *fit);
void heads_take_disc(const struct heads_fit *fit, struct estimate *estimate);
/* Returns an order with its covariance. `packed`: inverse of the normal matrix of `size` unknowns; `cosine`, `sine`:
   numbers of the order's unknowns. */
struct harmonic heads_harmonic(const struct heads_fit *fit, uint32_t order, const double *packed,
                               uint32_t size, uint32_t cosine, uint32_t sine);

/* Tells whether order 1 is fitted together with the places, which needs three or four heads. */
bool heads_fits_places(const struct heads_fit *fit);
/* Returns the prior value of d_i, arcsec: the weighted mean of p_i - a_i, the value according to the mounting, and 0,
   the value according to the index. */
double heads_late_beforehand(const struct heads_fit *fit, uint32_t head);
void heads_add_lines(const struct heads_fit *fit, struct vector unit1,
                     const double residual[HEADS_MOST]);
void heads_add_density(const struct heads_fit *fit, struct vector unit1);
/* Separates the sums of the residuals into their mean and their component of order 1 (`line`). Both must be solved
   together, because samples at an uneven speed are not evenly spaced. */
enum refusal heads_separate_lines(const struct heads_fit *fit);
/* Makes one step of the iteration for the places and returns its size; returns NAN if the places cannot be
   determined. */
double heads_step_of_places(struct heads_fit *fit);
/* Takes order 1 of the disc with its covariance, and the uncertainties of places and radii, from the factor of the
   last pass. */
void heads_take_places(const struct heads_fit *fit, struct heads_found *found,
                       struct estimate *estimate);
/* Computes the circles of the axis. Only four heads show the circles of the orders from 2 on; with fewer heads, the
   fitted orders of the disc contain them. */
void heads_take_circles(const struct heads_fit *fit, struct heads_found *found);

/* Tells whether the motion of the axis that does not repeat is wanted, and the heads show it. */
bool heads_measure_axis(const struct heads_fit *fit);
void heads_take_noise(const struct heads_fit *fit, struct estimate *estimate);
/* Computes the motion of the axis that does not repeat, from the sums that heads_take_noise() has made. */
void heads_take_asynchronous(const struct heads_fit *fit, const struct estimate *estimate,
                             struct heads_found *found);

#endif
