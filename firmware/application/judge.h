/* SPDX-License-Identifier: Apache-2.0 */

/* Judges lanes that were not calibrated from this turn, order by order, against the turn's own estimate of the
   order. */

#ifndef ARCTRUE_JUDGE_H
#define ARCTRUE_JUDGE_H

#include "further_orders.h"
#include "load.h"

/* Natural logarithm of 1000: the firmware accepts a value that is a thousand times likelier than no correction, and
   refuses a value that is a thousand times less likely than no correction. A correct amplitude of 3.7 standard
   uncertainties reaches this limit in one turn. */
#define EVIDENCE_ENOUGH 6.9

struct judge {
    const struct turn *turn;
    struct motion motion;
    /* Lanes of the judged set that follow a condition; NULL if it has none. */
    const struct followed *followed;
    /* Estimate from this turn alone, a function of the reading. */
    const struct estimate *estimate;
    struct further_workspace *workspace;
    double gain_limit;
    /* Estimated change of the table's error since earlier turns, arcsec; a change within this turn may be as large. */
    double change_arcsec;
};

enum judgement {
    JUDGED_RIGHT,
    JUDGED_WRONG,
    /* The judgement needs more turns. */
    JUDGED_NOT_YET,
    /* No turn can judge the lanes. */
    JUDGED_NEVER,
};

/* Measures the orders of `set` in the turn; call it before judge_sight(). */
void judge_look(const struct judge *judge, const struct coefficients *set);

/* Returns the turn's measurement of an order of the set that was passed to judge_look() last. */
struct sight judge_sight(const struct judge *judge, uint32_t order, struct vector applied);

/* Judges the received set, whose lanes are in `candidate`. Returns LOAD_TAKEN, LOAD_NOT_YET, or the reason for a
   refusal. `active`: the active coefficients, or NULL. */
enum load_answer judge_received(const struct judge *judge, struct load *load,
                                const struct coefficients *active,
                                const struct coefficients *candidate);

/* Returns the value of an order of `set` in this turn, arcsec, including the lanes that follow the turn's direction and
   speed. */
struct vector judge_value(const struct judge *judge, const struct coefficients *set,
                          uint32_t order);

/* Writes to `measured` the turn's result for each lane of `judge->followed` that this turn shows; `set` holds the lanes
   without a condition. Returns the number of entries, at most FOLLOWED_LANES_MAX. */
uint32_t judge_measure_followed(const struct judge *judge, const struct coefficients *set,
                                struct followed_measured *measured);

/* Judges, after a start, the lanes in `candidate` that were judged before: no lane may be wrong, and all together must
   be confirmed. `unjudged`: lanes of `set` that no turn has judged before, one bit per lane. If a lane of the
   calibration (an order that `set` does not have) is wrong but leaves less error than `small_arcsec`, it is removed
   from `candidate`, and the next turn determines it anew. */
enum judgement judge_again(const struct judge *judge, const struct coefficients *set,
                           uint64_t unjudged, double small_arcsec, struct coefficients *candidate);

#endif
