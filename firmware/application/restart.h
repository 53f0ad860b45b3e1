/* SPDX-License-Identifier: Apache-2.0 */

/* Carries out the first start, the start after a fault, and the operator's re-arm. */

#ifndef ARCTRUE_RESTART_H
#define ARCTRUE_RESTART_H

#include "state.h"

/* Restores the settings. At power-on these are the settings saved in flash. Kept settings are a copy in memory that
   survives a fault. After a fault the firmware uses this copy or, if it is lost, the parameters in flash (not the
   switches) with bypass on; settings in neither place get their presets. Then the firmware makes a new copy. */
void application_recover(struct application *application, bool after_fault);

/* Starts the firmware after power-on or after a fault. If the kept settings have survived the fault, the core keeps
   index, coefficients and correction. After several faults in a row, or if the settings are lost while a correction is
   active, the firmware calibrates nothing until application_rearm() and leaves the core unchanged. */
void application_begin(struct application *application);

/* Discards the results of all turns, finds the core and sets it up; afterwards `phase` shows whether a core was
   found. */
void application_start(struct application *application);

/* Restarts the core on request of the operator and sets the number of faults in a row to 0. */
void application_rearm(struct application *application);

/* Switches the correction off, and discards the calibration and the loaded set. */
void application_forget(struct application *application);

/* Discards the results of all turns, and switches the correction off. The loaded set (coefficients that the operator
   has sent) is judged again by the next turns; the operator need not send it again. */
void restart_with_nothing(struct application *application);

#endif
