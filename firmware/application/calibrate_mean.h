/* SPDX-License-Identifier: Apache-2.0 */

/* The mean of three or four heads, calibrated from a turn by the device itself. */

#ifndef ARCTRUE_CALIBRATE_MEAN_H
#define ARCTRUE_CALIBRATE_MEAN_H

#include "state.h"

/* The core can form a mean, the operator has given the places of all heads, and no loaded set is at work or waits for a
   turn that judges it. */
bool calibrate_mean_wanted(const struct application *application);

/* Makes `measured` the estimate of the mean's error and fills `mean`. The words of a mean that the device has
   calibrated before stay as long as they keep the axis out: other offsets would move the zero. Refused, `measured` says nothing. */
enum refusal calibrate_mean_estimate(struct application *application, const struct turn *turn,
                                     struct mean_set *mean);

#endif
