/* SPDX-License-Identifier: Apache-2.0 */

/* The output that cannot keep up, and line drivers that are released. */

#ifndef ARCTRUE_RELEASE_H
#define ARCTRUE_RELEASE_H

#include "state.h"

enum output_answer {
    /* It follows again. */
    OUTPUT_CLEARED,
    /* It followed all the time, and its line drivers are enabled again. */
    OUTPUT_DRIVEN,
    OUTPUT_NO_CORE,
    OUTPUT_NO_FAULT,
    OUTPUT_FAULT_AGAIN,
    /* A fault that releases the line drivers is still present. */
    OUTPUT_STAYS_RELEASED,
};

/* End the fault of the output and the release of its line drivers; nothing else in the firmware does. */
enum output_answer application_clear_output(struct application *application);

/* Of enum core_fault: what released the line drivers, 0 where they are driven, and what of it is present. */
uint32_t application_release_causes(const struct application *application);
uint32_t application_release_present(const struct application *application);

/* Why the output stands now: "none" where it follows. */
const char *application_output_fault(const struct application *application);

/* Alarms when line drivers are released. At once: a table that its drive has stopped brings no turn to tell it with. */
void release_watch(struct application *application);

#endif
