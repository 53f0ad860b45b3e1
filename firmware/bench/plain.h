/* SPDX-License-Identifier: Apache-2.0 */

/* Both estimates as a textbook writes them: a sine and a cosine of the C library for every sample
   and order, and a normal matrix summed element by element. What the firmware is compared with;
   nothing of it is in the firmware. */

#ifndef ARCTRUE_PLAIN_H
#define ARCTRUE_PLAIN_H

#include "estimate.h"

struct turn;
struct further_workspace;

enum { PLAIN_MATRIX = UNKNOWNS_MAX * (UNKNOWNS_MAX + 1) / 2 };

struct plain_workspace {
    double matrix[PLAIN_MATRIX];
    double right[UNKNOWNS_MAX];
    double row[UNKNOWNS_MAX];
};

/* Cosines, then sines, of orders 1 to `orders`, in arcsec, for the separation of `estimate`. */
void plain_fourier(struct plain_workspace *workspace, const struct turn *turn,
                   const struct estimate *estimate, double *values);

/* Also for the zero of head 2 that `estimate` ended with, so one round is enough. False: the
   matrix is singular. */
bool plain_least_squares(struct plain_workspace *workspace, const struct turn *turn,
                         const struct estimate *estimate, double nominal_rad, double *values);

/* The sums of further_orders_look() for the orders that `made` has: the largest difference from its
   own, as a share of the largest sum of its kind. */
double plain_further_orders(const struct further_workspace *made, const struct turn *turn,
                            const struct estimate *estimate);

#endif
