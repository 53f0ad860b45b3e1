/* SPDX-License-Identifier: Apache-2.0 */

/* Makes the sets for a missing head from the device's own calibration of four heads. */

#ifndef ARCTRUE_OWN_SETS_H
#define ARCTRUE_OWN_SETS_H

#include "state.h"

/* Computes in the workspace, for each head, the set that applies without this head: carrier (the head whose counts the
   mean follows), weights, offsets, lanes. No set is made for a head if no mean without this head is usable, for example
   because the noise of the mean would be too large. Computes sets only if the core has the failover and the candidate
   is the mean of four heads that this turn has calibrated. */
void own_sets_make(struct application *application);
/* Writes the computed sets into the register windows of the prepared sets, and makes the gateware refuse the sets of
   the other heads. The failover must be off. Does nothing if no sets belong to the candidate. */
void own_sets_write(struct application *application);

#endif
