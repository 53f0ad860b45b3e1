/* SPDX-License-Identifier: Apache-2.0 */

/* Finds the phases of the active lanes of real orders and follows them: from the difference of the heads in every
   turn, or from the edges of an index of the drive at probe_in. */

#ifndef ARCTRUE_REAL_FOLLOW_H
#define ARCTRUE_REAL_FOLLOW_H

#include "state.h"

/* Adds a turn that is verified, aligned and estimated. Lanes of a mean get no phase from the heads. */
void real_follow_turn(struct application *application, const struct turn *turn);
/* Takes the last edge of the probe. An edge at which the angle falls is ignored: the pulse has a width, so its rising
   edge is then at its other end. */
void real_follow_probe(struct application *application);

#endif
