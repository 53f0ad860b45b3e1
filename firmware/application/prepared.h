/* SPDX-License-Identifier: Apache-2.0 */

/* Manages the gateware's prepared sets. A prepared set contains the coefficients that become active when the gateware
   leaves one head out of the mean (the failover). The firmware writes the sets while the operator loads them, when it
   restores saved sets, or when it has calibrated them itself. It switches the failover on when the mean to which the
   sets belong is active. The firmware keeps no copy of loaded sets in memory: to save them, it reads them from the
   gateware. */

#ifndef ARCTRUE_PREPARED_H
#define ARCTRUE_PREPARED_H

#include "state.h"

/* These functions receive the frames of a set for a missing head through load_without(), load_without_head() and
   load_without_lane(). They write the words of an accepted lane to the gateware at once, and the words of the mean when
   the set is complete. The first frame overwrites the former sets and switches the failover off; ALARM_FAILOVER_OFF
   reports this until a loaded set is active. If the core has no failover, these functions refuse the frames; the other
   frames of the received set are still accepted. */
enum load_answer application_load_without(struct application *application, uint32_t head,
                                          uint32_t lanes, const struct mean_set *mean,
                                          uint32_t crc);
enum load_answer application_load_without_head(struct application *application, uint32_t number,
                                               int32_t weight, uint32_t offset, uint32_t crc);
enum load_answer application_load_without_lane(struct application *application, uint32_t number,
                                               const struct lane *lane, uint32_t crc);

/* Notes that the received sets, if there are any, belong to the mean that has just been loaded. */
void prepared_take_over(struct application *application);
/* Notes that the gateware now holds a set for each of these missing heads, one bit per head. */
void prepared_hold(struct application *application, uint32_t sets);
/* Reads the sets of the mean from the gateware into `kept`; `kept` stays empty if the gateware's words differ from the
   written words. */
void prepared_keep(const struct application *application, struct kept_sets *kept);
/* Switches the failover off, then writes the saved sets into the register windows of the prepared sets. Sets that this
   core cannot hold are left out. */
void prepared_restore(struct application *application);
/* Returns the missing heads for which the saved record has a set that this core can hold, one bit per head. */
uint32_t prepared_saved(const struct application *application);
/* Notes that no prepared set belongs to the active coefficients, and switches the failover off. */
void prepared_forget(struct application *application);
/* Switches the failover on if the gateware still holds the sets of the active mean and `failover_causes` is not 0,
   otherwise off. If the words of the sets differ from the written words, the function discards the sets and raises an
   alarm. Does nothing if there are no sets. */
void prepared_arm(struct application *application);
/* Raises an alarm if, since the previous call, the gateware has left out a head, or has refused the set for a head that
   failed. */
void prepared_watch(struct application *application);
/* Allows a head, counted from 1, to be used again after its next index. Returns false if the head is not left out. */
bool application_come_back(const struct application *application, uint32_t head);

#endif
