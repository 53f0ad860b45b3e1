/* SPDX-License-Identifier: Apache-2.0 */

/* Finds the phase of one harmonic of the error (a line) whose order is not whole, from the difference of two heads in
   successive turns.

   The error of head 1 has a line Re(c e^{j nu Theta}), with Theta counted over the turns. If the line is fixed to the
   disc, it appears in head 2 minus head 1 as Re(c g e^{j nu Theta}) with g = e^{j nu alpha} - 1. S is the mean of the
   difference times e^{-j nu theta} over a turn, with theta counted within the turn. All whole orders together add the
   same constant K to S in every turn: S = K + (c g A + c* g* B)/2 with the means A of e^{j nu (Theta - theta)} and B of
   e^{-j nu (Theta + theta)}. A Kalman filter follows K and c; in its model c takes a random walk, because the phase of
   the line slips. sim/arctrue/calibration/line_phase.py contains the same calculation in numpy. */

#ifndef ARCTRUE_LINE_PHASE_H
#define ARCTRUE_LINE_PHASE_H

#include <stdbool.h>
#include <stdint.h>

#include "capture.h"

enum { LINE_STATES = 4 };

struct line_finder {
    /* Re K, Im K, Re c, Im c, arcsec, and their covariance. */
    double state[LINE_STATES];
    double covariance[LINE_STATES][LINE_STATES];
    uint32_t turns;
    int32_t last_turn;
    bool is_known;
};

/* Line whose phase is sought. Its order is a whole number plus turn_step/2^48; its amplitude is the amplitude of the
   loaded lane. */
struct line_sought {
    double order;
    uint64_t turn_step;
    double amplitude_arcsec;
};

/* Adds a turn whose first sample of head 1 is in turn `first_turn` of the core. `separation_rad` must be the same in
   every turn. `noise_arcsec`: standard deviation of the noise of a difference. */
void line_finder_add(struct line_finder *finder, const struct line_sought *line,
                     const struct turn *turn, int32_t first_turn, double separation_rad,
                     double noise_arcsec);
/* Returns the phase at angle 0 of turn 0, turns: the line is |c| cos(2 pi (nu Theta + phase)). */
double line_finder_phase(const struct line_finder *finder);

#endif
