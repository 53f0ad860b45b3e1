/* SPDX-License-Identifier: Apache-2.0 */

/* Computes both estimates as a textbook describes them: with a sine and a cosine of the C library for every sample and
   order, and a normal matrix that is summed element by element. bench.c compares the functions of the firmware with
   these functions; the firmware does not contain them. */

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

/* Computes the cosines, then the sines, of the orders 1 to `orders`, in arcsec, for the separation of `estimate`. */
void plain_fourier(struct plain_workspace *workspace, const struct turn *turn,
                   const struct estimate *estimate, double *values);

/* Computes the same values by least squares. One round is enough, because the fit begins with the final zero of head 2
   in `estimate`. Returns false if the matrix is singular. */
bool plain_least_squares(struct plain_workspace *workspace, const struct turn *turn,
                         const struct estimate *estimate, double nominal_rad, double *values);

/* Computes the sums of further_orders_look() for the orders in `made`; returns the largest difference from the sums
   `head1` and `head2` in `made`, as a share of the largest sum of head 1. */
double plain_further_orders(const struct further_workspace *made, const struct turn *turn,
                            const struct estimate *estimate);

#endif
