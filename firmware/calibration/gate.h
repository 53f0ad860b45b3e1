/* SPDX-License-Identifier: Apache-2.0 */

/* Implements the acceptance gate: a candidate becomes active only if the error expected with it is less than the error
   expected with the active coefficients. */

#ifndef ARCTRUE_GATE_H
#define ARCTRUE_GATE_H

#include "coefficients.h"
#include "estimate.h"
#include "refusal.h"

/* Default limit of the ratio between the noise of a turn and the noise of the turns before it; the gate refuses a turn
   whose ratio is higher. */
#define NOISE_LIMIT_DEFAULT 3.0

struct gate_prediction {
    /* RMS error, over a turn, of all orders that the heads can observe (`seen`), arcsec. */
    double active_arcsec;
    double candidate_arcsec;
};

/* Predicts the error with the active and with the candidate coefficients. `active`: NULL if nothing is applied.
   `estimate`: the estimate from which `candidate` was made. */
struct gate_prediction gate_predict(const struct estimate *estimate,
                                    const struct coefficients *active,
                                    const struct coefficients *candidate);

enum refusal gate_judge(const struct gate_prediction *prediction);

/* Judges the noise of a turn. `usual_arcsec`: noise of the earlier turns; 0: there is no earlier turn. */
enum refusal gate_judge_noise(double noise_arcsec, double usual_arcsec, double limit);

#endif
