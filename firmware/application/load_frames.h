/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the steps that every frame of a set takes, for the files load_*.c. */

#ifndef ARCTRUE_LOAD_FRAMES_H
#define ARCTRUE_LOAD_FRAMES_H

#include "load.h"

/* Tells whether a frame with these words may be used: LOAD_WRONG_CRC if its CRC is wrong, LOAD_WRONG_FRAME if no set is
   being received or the frame is not `expected`, otherwise LOAD_TAKEN. */
enum load_answer load_arrived(const struct load *load, const uint32_t *words, uint32_t number,
                              uint32_t crc, bool expected);
/* Adds the words of a used frame to the CRC of the set; returns LOAD_TAKEN. */
enum load_answer load_frame_taken(struct load *load, const uint32_t *words, uint32_t number);
/* Refuses the set because of a frame; returns `reason`. */
enum load_answer load_frame_refused(struct load *load, enum load_answer reason);
/* Tells whether all lanes and heads of the prepared set that is being received have arrived, or no such set is being
   received. A prepared set applies if one head is left out. */
bool load_without_is_whole(const struct load *load);
/* Returns an upper bound of the table's |d eps / d R|. A window shorter than a turn begins and ends with a step between
   0 and its first point, which counts as a slope over one count; the step at the end may be larger by the slope of one
   count. The points that did not arrive are 0. */
double load_table_steepest(const struct load_table *received, uint32_t counts_per_rev);

#endif
