/* SPDX-License-Identifier: Apache-2.0 */

/* Defines the sizes of the calibration's workspaces; no memory is allocated at run time. */

#ifndef ARCTRUE_LIMITS_H
#define ARCTRUE_LIMITS_H

enum {
    ORDERS_MAX = 40,
    /* Number of cosines, sines and the constant. */
    UNKNOWNS_MAX = 2 * ORDERS_MAX + 1,
    /* Number of lines of the residual's spectrum that are averaged: the relative standard deviation of an uncertainty
       is then 1/(2 sqrt(96)) = 5 %. */
    NOISE_LINES = 96,
    LINES_MAX = ORDERS_MAX + NOISE_LINES,
    LANES_LIMIT = 64,
};

#endif
