/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_CALIBRATE_H
#define ARCTRUE_CALIBRATE_H

#include "state.h"

/* From the ready bank to a candidate: verify, estimate, average, choose, quantise and judge.
   Leaves estimate, verdicts, candidate and the report's prediction. */
enum refusal calibrate_turn(struct application *application);

#endif
