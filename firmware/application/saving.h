/* SPDX-License-Identifier: Apache-2.0 */

/* Selects the data that `save` writes into the flash, and restores them from the flash at a start. */

#ifndef ARCTRUE_SAVING_H
#define ARCTRUE_SAVING_H

#include "state.h"

/* Begins to write parameters, switches and coefficients into the flash; returns SAVE_DONE if the writing has begun,
   otherwise the reason why it has not. */
enum save_answer application_save(struct application *application);

/* Reads the latest record at a start. Its coefficients wait for a turn that confirms them. */
void saving_recover(struct application *application);

#endif
