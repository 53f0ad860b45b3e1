/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_CALIBRATE_H
#define ARCTRUE_CALIBRATE_H

#include "state.h"

/* Computes a candidate from the ready bank: verify, estimate, average, choose, quantise and judge. If the turn confirms
   a set that waits (received, loaded or saved), this set is the candidate. Results are the estimate, the verdicts, the
   candidate and the prediction in the report. Returns NOT_REFUSED if there is a candidate to activate. */
enum refusal calibrate_turn(struct application *application);

#endif
