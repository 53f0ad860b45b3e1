/* SPDX-License-Identifier: Apache-2.0 */

/* Lanes that are not of this turn's calibration, judged order by order: each against the turn's own
   estimate of its order. */

#ifndef ARCTRUE_JUDGE_H
#define ARCTRUE_JUDGE_H

#include "further_orders.h"
#include "load.h"

struct judge {
    const struct turn *turn;
    struct motion motion;
    /* Lanes that follow a condition of the set that is judged; NULL: it has none. */
    const struct followed *followed;
    /* Of this turn alone, a function of the reading. */
    const struct estimate *estimate;
    struct further_workspace *workspace;
    double gain_limit;
    /* By how much an order of the table has changed since the turn before, arcsec. */
    double change_arcsec;
};

enum judgement {
    JUDGED_RIGHT,
    JUDGED_WRONG,
    /* More turns are needed. */
    JUDGED_NOT_YET,
    /* No turn says anything of it. */
    JUDGED_NEVER,
};

/* Looks at the orders of `set`, for what follows. */
void judge_look(const struct judge *judge, const struct coefficients *set);

/* What the turn says of an order of the set that was looked at last. */
struct sight judge_sight(const struct judge *judge, uint32_t order, struct vector applied);

/* The set that waits: LOAD_TAKEN with its lanes in `candidate`, LOAD_NOT_YET, or why not. `active`:
   what is active, NULL where nothing is. */
enum load_answer judge_received(const struct judge *judge, struct load *load,
                                const struct coefficients *active,
                                const struct coefficients *candidate);

/* What an order of `set` is in this turn, arcsec: with what follows the turn's direction and speed. */
struct vector judge_value(const struct judge *judge, const struct coefficients *set,
                          uint32_t order);

/* What the turn says of each lane of `judge->followed` that a turn shows, with `set` as the plain lanes: at most
   FOLLOWED_LANES_MAX entries of `measured`; their number. */
uint32_t judge_measure_followed(const struct judge *judge, const struct coefficients *set,
                                struct followed_measured *measured);

/* Lanes that were judged before, in `candidate`, after a start: none may be wrong, and all together
   have to be of this table. `unjudged`: lanes of `set` by place that nobody could judge. Of the
   calibration's own lanes (those that `set` has not) a small one that is wrong is left out of
   `candidate`: the next turn finds it anew. */
enum judgement judge_again(const struct judge *judge, const struct coefficients *set,
                           uint64_t unjudged, double small_arcsec, struct coefficients *candidate);

#endif
