/* SPDX-License-Identifier: Apache-2.0 */

/* Compares, in every turn, each loaded order with the order that the turn shows. Its results are the remaining error of
   the order, and whether this error exceeds the scatter from turn to turn. */

#ifndef ARCTRUE_LOADED_WATCH_H
#define ARCTRUE_LOADED_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "coefficients.h"
#include "sight.h"

/* An order counts as wrong if its remaining error exceeds WATCH_SIGMAS standard deviations of a turn in WATCH_TURNS
   turns in a row. For one order, noise alone exceeds the limit with probability e^-18 in one turn, and with probability
   e^-54 in three turns in a row. */
#define WATCH_SIGMAS 6.0
enum { WATCH_TURNS = 3 };

struct watched_lane {
    /* Remaining error in the latest turn, arcsec, and variance of a component from turn to turn. */
    float cosine;
    float sine;
    float variance;
};

struct loaded_watch {
    /* Lanes by their place in the loaded set. */
    struct watched_lane lane[LANES_LIMIT];
    /* Number of turns in a row beyond the limit. */
    uint8_t beyond[LANES_LIMIT];
    /* Lanes that a turn has shown. */
    uint64_t shown;
    /* Results of the latest turn: mean square, over a turn, of the remaining error of all loaded orders together,
       arcsec^2; whether an order or the local table is at fault. */
    double mean_square;
    bool at_fault;
    /* Log odds of the local table against no table, summed over the turns since the sum was last 0; it is never above
       0. */
    float table_evidence;
};

/* Clears the results of the latest turn; call it at the beginning of a turn. */
void watch_begin(struct loaded_watch *watch);

/* Adds the turn's measurement of the lane at `place`; `applied` is the value of its order that the gateware applied in
   this turn. */
void watch_lane(struct loaded_watch *watch, uint32_t place, const struct sight *sight,
                struct vector applied);

/* Adds the turn's log odds of the local table against no table. The table is at fault while the sum of these log odds
   is -`enough` or less. */
void watch_table(struct loaded_watch *watch, double evidence, double enough);

/* Returns the remaining amplitude at the order of a lane in the latest turn, arcsec; negative if no turn has shown the
   lane. */
double watch_left(const struct loaded_watch *watch, uint32_t place);

#endif
