/* SPDX-License-Identifier: Apache-2.0 */

/* Runs the endless work of the processor: wait for the index, capture, verify, calibrate, write the idle coefficient
   bank, swap the banks, monitor. One call of application_step() does one piece of this work and returns. */

#ifndef ARCTRUE_APPLICATION_H
#define ARCTRUE_APPLICATION_H

#include "alarms.h"
#include "operator.h"
#include "release.h"
#include "restart.h"
#include "saving.h"
#include "state.h"

/* Stores the access to the core, sets all parameters to their presets, and clears all other state. */
void application_prepare(struct application *application, const struct core_access *core);

/* Sets the function that reads the temperature of the die for each turn. */
void application_use_temperature(struct application *application, temperature_read *read,
                                 void *context);

/* Sets the function that reads the table's thermometer, which is used unless the operator chooses another source. */
void application_use_thermometer(struct application *application, temperature_read *read,
                                 void *context);

/* Sets the memory that keeps the operator's settings; `settle` is called after each write. */
void application_keep_settings(struct application *application, struct kept_settings *kept,
                               memory_settle *settle);

/* Sets the memory that captures are copied to. */
void application_use_copy(struct application *application, struct capture_copy *copy);

/* Sets the memory for the repeating motion of the axis; the memory must be cleared. */
void application_use_axis(struct application *application, struct axis_mean *axis);

/* Sets the flash that stores settings and coefficients. */
void application_use_flash(struct application *application, struct save *save);

/* Does one piece of work and never waits. A whole calibration is one piece. */
void application_step(struct application *application);

/* Notes an interrupt of the core; call it before the step that the interrupt causes. An interrupt only makes a step run
   earlier: later steps find the work without an interrupt, so a lost interrupt only delays the work. */
void application_interrupt(struct application *application);

/* Tells whether there is more to do at once; if so, do not sleep before the next step. */
bool application_busy(const struct application *application);

#endif
