/* SPDX-License-Identifier: Apache-2.0 */

/* Every turn each loaded order is compared with the turn's own estimate of it: what is left of it,
   and whether that is more than it scatters from turn to turn. */

#ifndef ARCTRUE_LOADED_WATCH_H
#define ARCTRUE_LOADED_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "coefficients.h"
#include "sight.h"

/* An order is at fault where so many turns in a row show more than so many standard deviations of a
   turn left of it. Of noise alone: e^-18 a turn and order, and its third power in a row. */
#define WATCH_SIGMAS 6.0
enum { WATCH_TURNS = 3 };

struct watched_lane {
    /* What the latest turn shows left, arcsec; and the variance of a component from turn to turn. */
    float cosine;
    float sine;
    float variance;
};

struct loaded_watch {
    /* By place in the loaded set. */
    struct watched_lane lane[LANES_LIMIT];
    /* Turns in a row that are beyond the limit. */
    uint8_t beyond[LANES_LIMIT];
    /* Lanes that a turn has shown. */
    uint64_t shown;
    /* Of the latest turn: mean square of what all of them leave, arcsec^2; an order is at fault. */
    double mean_square;
    bool at_fault;
};

/* A turn follows. */
void watch_begin(struct loaded_watch *watch);

/* What it says of the lane at `place`, which is applied with this value. */
void watch_lane(struct loaded_watch *watch, uint32_t place, const struct sight *sight,
                struct vector applied);

/* Amplitude that the latest turn shows left of a lane, arcsec; negative where none has shown it. */
double watch_left(const struct loaded_watch *watch, uint32_t place);

#endif
