/* SPDX-License-Identifier: Apache-2.0 */

/* What one captured turn causes. */

#ifndef ARCTRUE_TURN_H
#define ARCTRUE_TURN_H

#include "state.h"

/* Calibrates from the bank that was taken, reports, swaps in what is to be applied, and releases the bank. */
void turn_finish(struct application *application);

#endif
