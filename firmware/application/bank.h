/* SPDX-License-Identifier: Apache-2.0 */

/* A bank of the capture: taken, copied for the console, or missing. */

#ifndef ARCTRUE_BANK_H
#define ARCTRUE_BANK_H

#include "state.h"

/* While no bank is ready: a table that has turned for long without one has a capture that is stuck. Samples
   that others ask for may fail to come: no fault of the capture. */
void bank_watch(struct application *application);

/* The bank that is ready becomes `header` and `capture`. */
void bank_take(struct application *application);

/* The bank that was taken is copied for the console, which takes seconds to tell it. The die's temperature is that of now. */
void bank_copy(struct application *application);

#endif
