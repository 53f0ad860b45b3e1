/* SPDX-License-Identifier: Apache-2.0 */

/* What `save` writes into the flash, and what a start takes from there. */

#ifndef ARCTRUE_SAVING_H
#define ARCTRUE_SAVING_H

#include "state.h"

/* Parameters, switches and what is active, into the flash; what save_begin() says. */
enum save_answer application_save(struct application *application);

/* Reads the latest record at a start. Its coefficients have to wait for a turn that confirms them. */
void saving_recover(struct application *application);

#endif
