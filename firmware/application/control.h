/* SPDX-License-Identifier: Apache-2.0 */

/* The core's control register, its banks and its compare, as the operator has ordered them. */

#ifndef ARCTRUE_CONTROL_H
#define ARCTRUE_CONTROL_H

#include "state.h"

/* Correction, output and capture, as ordered. */
void control_write(const struct application *application);

/* Releases a bank that is ready: from what the core had seen before the re-arm nothing can be used. */
void control_give_back_bank(const struct application *application);

/* Stops the capture and starts it again: what has been captured of the turn has another zero, or other steps. */
void control_capture_anew(const struct application *application);

/* Arms the compare where it is on, or disarms it. The angle is that after the index: before it nothing is armed. */
void control_arm_compare(const struct application *application);

#endif
