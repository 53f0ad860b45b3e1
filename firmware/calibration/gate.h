/* SPDX-License-Identifier: Apache-2.0 */

/* The acceptance gate: coefficients are made active only where the error that is to be expected
   with them is less than with those that are active. */

#ifndef ARCTRUE_GATE_H
#define ARCTRUE_GATE_H

#include "coefficients.h"
#include "estimate.h"
#include "refusal.h"

/* A turn this many times noisier than the turns before it is not taken. */
#define NOISE_LIMIT_DEFAULT 3.0

struct gate_prediction {
    /* Root mean square error over a turn of the orders that are seen, arcsec. */
    double active_arcsec;
    double candidate_arcsec;
};

/* `active`: NULL where nothing is applied. `estimate` is what `candidate` was made of. */
struct gate_prediction gate_predict(const struct estimate *estimate,
                                    const struct coefficients *active,
                                    const struct coefficients *candidate);

enum refusal gate_judge(const struct gate_prediction *prediction);

/* `usual_arcsec`: noise of the turns before; 0: none yet. */
enum refusal gate_judge_noise(double noise_arcsec, double usual_arcsec, double limit);

#endif
