/* SPDX-License-Identifier: Apache-2.0 */

/* Receives a local table (points between which the gateware interpolates the correction in windows of the turn), judges
   it by turns, and makes it active by a swap. Its points go straight into the idle bank of the gateware, because the
   memory of the processor is too small for them. */

#ifndef ARCTRUE_LOCAL_TABLE_H
#define ARCTRUE_LOCAL_TABLE_H

#include "state.h"

/* These functions receive the frames of a table like the functions of load.h, and also write the points into the idle
   bank. */
enum load_answer application_load_table(struct application *application,
                                        const struct table_place *place, uint32_t crc);
enum load_answer application_load_points(struct application *application, uint32_t number,
                                         const int32_t points[LOAD_POINTS], uint32_t crc);
/* Writes 0 to the points that did not arrive, and stores the CRC of all points in the received table. */
void local_table_complete(struct application *application);

/* Returns the log odds of the table at `place`, with the points of the idle bank, against no table, from one turn. */
double local_table_evidence(const struct application *application, const struct table_place *place,
                            const struct turn *turn);
/* Writes the saved points into the idle bank if it does not hold them. Returns false if flash or gateware do not hold
   the points. */
bool local_table_restore(const struct application *application);
/* Returns a point of the idle bank for the record that is being written; `context` is the application. */
int32_t local_table_point(const void *context, uint32_t number);

/* Tells whether the core has a local table and its idle bank holds the points with this CRC. */
bool local_table_is_held(const struct application *application, uint32_t crc);

/* Makes the next swap activate the table that belongs to the candidate, or switch the former table off. Returns false
   if the written words could not be read back. */
bool local_table_write(struct application *application);

#endif
