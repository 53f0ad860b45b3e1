/* SPDX-License-Identifier: Apache-2.0 */

/* Reports and ends the faults of the output: the output cannot keep up with the table, or its line drivers are
   released, that is, switched off. */

#ifndef ARCTRUE_RELEASE_H
#define ARCTRUE_RELEASE_H

#include "state.h"

enum output_answer {
    /* The output follows again. */
    OUTPUT_CLEARED,
    /* The output followed all the time, and its line drivers are enabled again. */
    OUTPUT_DRIVEN,
    OUTPUT_NO_CORE,
    OUTPUT_NO_FAULT,
    OUTPUT_FAULT_AGAIN,
    /* A fault that releases the line drivers is still present. */
    OUTPUT_STAYS_RELEASED,
};

/* Ends the fault of the output and the release of its line drivers. No other function of the firmware ends them. */
enum output_answer application_clear_output(struct application *application);

/* Return bits of enum core_fault: the faults that switched the line drivers off (0: the drivers are on), and the
   present faults that keep them off. */
uint32_t application_release_causes(const struct application *application);
uint32_t application_release_present(const struct application *application);

/* Returns the reason why the output stands still now; "none" if it follows. */
const char *application_output_fault(const struct application *application);

/* Raises an alarm as soon as line drivers are released. It does not wait for the report of a turn, because a table that
   its drive has stopped completes no turn. */
void release_watch(struct application *application);

#endif
