/* SPDX-License-Identifier: Apache-2.0 */

/* Reads the thermometer of the table and adapts the loaded lanes to it. */

#ifndef ARCTRUE_FOLLOW_TEMPERATURE_H
#define ARCTRUE_FOLLOW_TEMPERATURE_H

#include "state.h"

/* Computes the loaded lanes for the table's temperature and makes them active by a swap, if this changes the correction
   by more than the parameter temperature_step_counts. Also writes the words of a lane of a real order again if its
   phase has become known or unknown, or has changed. It runs between two turns; a turn that is ready is processed
   first. */
void follow_between_turns(struct application *application);

/* Reads the table's thermometer, and removes its lag with the time constant of the thermal model in use. */
void follow_thermometer(struct application *application);

/* Computes the temperature in the middle of the captured turn, because the turn's estimate belongs to its middle and
   the table has warmed since. */
void follow_middle_of_turn(struct application *application);

#endif
