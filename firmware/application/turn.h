/* SPDX-License-Identifier: Apache-2.0 */

/* Processes one captured turn. */

#ifndef ARCTRUE_TURN_H
#define ARCTRUE_TURN_H

#include "state.h"

/* Calibrates from the taken bank, reports, swaps in new coefficients if there are any, and releases the bank. */
void turn_finish(struct application *application);

#endif
