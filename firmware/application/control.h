/* SPDX-License-Identifier: Apache-2.0 */

/* Writes the core's control register, releases its banks and arms its position compare (the unit that emits pulses at
   given angles), as the operator has ordered. */

#ifndef ARCTRUE_CONTROL_H
#define ARCTRUE_CONTROL_H

#include "state.h"

/* Switches the output on, the correction on or off as application_corrects() states, and the capture to the mode that
   application_capture() states. */
void control_write(const struct application *application);

/* Releases the capture bank if it is ready. Call it after a restart, a cleared fault or a move of a zero, because the
   captured turn is from before this event and cannot be used. */
void control_give_back_bank(const struct application *application);

/* Stops the capture and restarts it. Call it if, during the capture of a turn, the zero or the sample steps changed or
   a fault was cleared: this turn cannot be used. */
void control_capture_anew(const struct application *application);

/* Arms the compare if the parameter `compare_on` is 1, otherwise disarms it. Arms nothing before the index has been
   seen, because the compare counts its angle from the index. */
void control_arm_compare(const struct application *application);

#endif
