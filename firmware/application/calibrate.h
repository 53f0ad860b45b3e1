/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_CALIBRATE_H
#define ARCTRUE_CALIBRATE_H

#include "state.h"

/* Computes a candidate from the ready bank: verify, estimate, average, choose, quantise and judge. Results are the
   estimate, the verdicts, the candidate and the prediction in the report. */
enum refusal calibrate_turn(struct application *application);

#endif
