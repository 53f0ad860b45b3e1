/* SPDX-License-Identifier: Apache-2.0 */

/* Calibrates the mean of three or four heads from a turn, in the device itself. */

#ifndef ARCTRUE_CALIBRATE_MEAN_H
#define ARCTRUE_CALIBRATE_MEAN_H

#include "state.h"

/* Tells whether the core can form a mean, the operator has set the places of all heads, and no loaded set is active or
   waits for the turn that judges it. */
bool calibrate_mean_wanted(const struct application *application);

/* Sets `measured` to the estimate of the mean's error, and fills `mean`. A mean that the device has calibrated before
   keeps its weights as long as they suppress the motion of the axis. It always keeps its offsets, because other offsets
   would move the zero; only the offset of a head that has moved is shifted by this motion. After a refusal `measured`
   is invalid. */
enum refusal calibrate_mean_estimate(struct application *application, const struct turn *turn,
                                     struct mean_set *mean);

/* Adds the estimate of the disc from an accepted turn to the running average, and sets `measured` to the estimate of
   the mean's error from the averaged disc. */
void calibrate_mean_average(struct application *application, struct mean_set *mean);

#endif
