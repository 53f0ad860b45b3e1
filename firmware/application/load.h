/* SPDX-License-Identifier: Apache-2.0 */

/* Coefficients that the operator loads, beside those of the calibration.

   They come in frames, each with its number and a CRC, and are taken whole or not at all. What is
   whole waits until captured turns have judged each of its orders. An order that has a loaded lane
   belongs to it: the calibration leaves it alone. */

#ifndef ARCTRUE_LOAD_H
#define ARCTRUE_LOAD_H

#include <stdbool.h>
#include <stdint.h>

#include "capture.h"
#include "coefficients.h"
#include "followed.h"
#include "loaded_watch.h"
#include "thermal.h"

enum load_state {
    LOAD_NONE,
    /* Frames are coming. */
    LOAD_RECEIVING,
    /* Turns judge what has come, or what was loaded before a start. */
    LOAD_WAITING,
    LOAD_ACTIVE,
    /* What was loaded before stays. */
    LOAD_REFUSED,
};

/* What became of the loaded set since the core began anew. */
enum loaded_state {
    LOADED_AT_WORK,
    /* A turn has yet to judge it again. */
    LOADED_PENDING,
    /* It is of another table, or a turn speaks against it: kept until the next start. */
    LOADED_REJECTED,
};

enum load_answer {
    LOAD_TAKEN,
    /* Of a frame: it may be sent again. */
    LOAD_WRONG_CRC,
    LOAD_WRONG_FRAME,
    /* Of the set. */
    LOAD_TOO_MANY_LANES,
    LOAD_OUT_OF_RANGE,
    LOAD_ORDER_TWICE,
    LOAD_NOT_WHOLE,
    LOAD_ANOTHER_TABLE,
    LOAD_TOO_STEEP,
    LOAD_WORSE,
    LOAD_NOT_READ_BACK,
    /* Two heads cannot see an order of it: `load force`. */
    LOAD_UNSEEN,
    /* A lane follows a condition: the gateware is built without MODULATORS. */
    LOAD_NO_MODULATORS,
    /* A lane has a real order: the gateware is built without REAL_ORDERS, or a turn has too few counts for it. */
    LOAD_NO_REAL_ORDERS,
    LOAD_TOO_FEW_COUNTS,
    /* Its mean is not one of this core's heads, or its heads stand elsewhere, or are delayed otherwise. */
    LOAD_OTHER_HEADS,
    LOAD_OTHER_DELAYS,
    /* It has sets for a missing head: the gateware is built without FAILOVER. */
    LOAD_NO_FAILOVER,
    /* It uses a head that the gateware has left out, and has no set without that head. */
    LOAD_HEAD_LEFT_OUT,
    LOAD_ANSWERS,
    /* Of a judgement: more turns are needed. */
    LOAD_NOT_YET,
};

/* The set for a missing head that is being received. */
struct load_without {
    /* Its number, from 1 on; 0: none has begun. */
    uint32_t head;
    uint32_t lanes;
    uint32_t next_lane;
    struct mean_set mean;
    /* The order of its previous lane, and the sum of |d eps / d R| of its lanes. */
    uint32_t order;
    double steepness;
    /* A bit per head: its set is whole. */
    uint32_t whole;
};

struct load {
    enum load_state state;
    enum load_answer reason;
    uint32_t frames;
    uint32_t next;
    /* Of all frames so far. */
    uint32_t crc;
    /* What is coming, and what belongs to the operator now. */
    struct coefficients received;
    struct coefficients loaded;
    /* How their lanes follow the temperature. */
    struct thermal received_thermal;
    struct thermal thermal;
    /* Lanes that follow a condition. */
    struct followed received_followed;
    struct followed followed;
    /* Sets for a missing head: the gateware holds their words. */
    struct load_without without;
    /* What was received is whole and not yet judged. */
    bool whole;
    /* The phase of a lane of a real order has become known, and the core does not have it yet. */
    bool phase_given;
    /* The operator takes orders of it that no turn has judged; or only those that no turn of two heads shows. */
    bool forced;
    bool unseen_taken;
    /* Logarithm of the odds of each of its lanes, of the turns so far. */
    float evidence[LANES_LIMIT];
    /* Its lanes by place: that need more turns, and that nobody could judge. */
    uint64_t undecided;
    uint64_t received_unjudged;
    /* Of the lanes that follow a condition, a bit a lane: a turn showed it, where its modulator was
       `shown_at`; and a turn where that was another. */
    uint32_t shown;
    uint32_t shown_twice;
    float shown_at[FOLLOWED_LANES_MAX];
    /* In that turn, arcsec: what followed a condition in the lane's order, and what was left of the order. */
    struct vector shown_part[FOLLOWED_LANES_MAX];
    struct vector shown_left[FOLLOWED_LANES_MAX];
    /* An order that it was refused for; 0: none. */
    uint32_t refused_order;
    /* Of the loaded set: where it stands, the lanes that nobody could judge, the CRC of all its
       frames (0: it was saved), and what each turn shows of it. */
    enum loaded_state loaded_state;
    uint64_t unjudged;
    uint32_t loaded_crc;
    struct loaded_watch watch;
};

/* Lanes that wait for a turn in the other direction, or at another speed. */
bool load_waits_for(const struct load *load, bool other_direction);

const char *load_state_name(enum load_state state);
const char *load_answer_name(enum load_answer answer);

/* A frame's CRC-32 is that of its numbers as little-endian words, in the order in which they are
   written; the last one's is that of all words of the frames before it. */
enum load_answer load_begin(struct load *load, uint32_t frames, uint32_t counts_per_rev,
                            uint32_t lanes, uint32_t crc);
enum load_answer load_lane(struct load *load, uint32_t number, uint32_t order,
                           uint32_t phase_offset, int32_t amplitude, uint32_t crc);
/* How a lane of before follows the temperature; by their numbers, from 0 on. */
enum load_answer load_slope(struct load *load, uint32_t number, const struct thermal_lane *lane,
                            uint32_t crc);
/* At which temperature the lanes are as they are written, and how the thermometer lags. */
enum load_answer load_temperature(struct load *load, int32_t reference_mc,
                                  uint32_t time_constant_ms, uint32_t crc);
/* Between which temperatures the lanes follow; after the frame above, which presets it. */
enum load_answer load_range(struct load *load, int32_t least_mc, int32_t most_mc, uint32_t crc);
/* A lane that follows a condition; by their numbers, from 0 on. Then what the conditions need. */
enum load_answer load_followed(struct load *load, uint32_t number, const struct followed_lane *lane,
                               uint32_t crc);
enum load_answer load_conditions(struct load *load, uint32_t width, uint32_t dead_zone,
                                 uint32_t nominal_speed, uint32_t crc);
/* A lane of a real order; by their numbers, from 0 on. Its phase is not known. */
enum load_answer load_real(struct load *load, uint32_t number, const struct real_lane *lane,
                           uint32_t crc);
/* The phase of such a lane of the set at work, u0.24 turn, at angle 0 of turn `turn` of the core. False: there is none. */
bool load_phase(struct load *load, uint32_t number, uint32_t phase, int32_t turn);
/* The lanes are those of a mean: `mean` holds its carrier, heads, offset and delays; then one frame a head. */
enum load_answer load_mean(struct load *load, const struct mean_set *mean, uint32_t crc);
enum load_answer load_head(struct load *load, uint32_t number, int32_t weight, uint32_t offset,
                           uint32_t crc);
/* After the mean of all heads: the set for the missing head `head`, counted from 1; `mean` holds its carrier, heads and
   offset. Then one frame a head and one a lane, of ascending orders. No lane may follow temperature or condition. */
enum load_answer load_without(struct load *load, uint32_t head, uint32_t lanes,
                              const struct mean_set *mean, uint32_t crc);
enum load_answer load_without_head(struct load *load, uint32_t number, int32_t weight,
                                   uint32_t offset, uint32_t crc);
enum load_answer load_without_lane(struct load *load, uint32_t number, const struct lane *lane,
                                   uint32_t crc);
/* What is taken unjudged of the set that is coming: all that turns do not decide, or only what no turn of two heads
   shows. As in the frame. */
enum load_scope { LOAD_FORCES_ALL = 1, LOAD_FORCES_UNSEEN = 2 };
enum load_answer load_force(struct load *load, uint32_t scope, uint32_t crc);
bool load_takes_unseen(const struct load *load);
/* What the device is set to: a set of another one is refused. */
struct load_place {
    uint32_t counts_per_rev;
    uint32_t heads;
    /* Of the core. */
    uint32_t lanes;
    bool has_mean;
    bool has_modulators;
    bool has_failover;
    bool has_real_orders;
    /* As the parameter head_delays. */
    uint32_t delays;
};

/* `active`: what is active, or NULL. */
enum load_answer load_end(struct load *load, const struct load_place *place,
                          const struct coefficients *active, uint32_t crc);

/* The set is refused, or what was being received is dropped. */
void load_refuse(struct load *load, enum load_answer reason);

/* Asserts what is true between any two calls. */
void load_assert(const struct load *load);

/* What is coming or waiting is dropped; what is loaded stays. */
void load_abort(struct load *load);

/* What was received, or a set from elsewhere (`unjudged`: its lanes that nobody could judge),
   belongs to the operator from now on. */
void load_take_over_received(struct load *load);
void load_take_over(struct load *load, const struct coefficients *set,
                    const struct thermal *thermal, const struct followed *followed,
                    uint64_t unjudged);

/* What was loaded before is judged: it is at work again, or not. */
void load_at_work_again(struct load *load);
void load_reject(struct load *load, enum load_answer reason);

/* The loaded set where it is at work, NULL otherwise. */
const struct coefficients *load_at_work(const struct load *load);

/* Lanes of the loaded set that follow a condition; none where it is not at work. */
struct followed load_followed_at_work(const struct load *load);

/* Nothing is loaded any more. */
void load_forget(struct load *load);

/* The core has begun anew: what is loaded is judged again. */
void load_again(struct load *load, uint32_t counts_per_rev);

/* The calibration's lanes of what is active (NULL: nothing): all but the loaded ones. */
void load_own_lanes(const struct load *load, const struct coefficients *active,
                    struct coefficients *own);

/* `candidate`: the lanes of `set` (NULL: none), at a temperature where `thermal` is not NULL, and
   after them those of `own` (NULL: none) whose orders it has not, as many as fit. */
void load_combine(const struct coefficients *set, const struct thermal *thermal, double celsius,
                  const struct coefficients *own, uint32_t lanes, struct coefficients *candidate);

#endif
