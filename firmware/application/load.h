/* SPDX-License-Identifier: Apache-2.0 */

/* Receives coefficients that the operator loads, in addition to those of the calibration.

   They arrive in frames (lines of the console), each with its numbers and their CRC. All frames from load_begin() to
   load_end() form a set, which is used as a whole or not at all: it waits until captured turns have judged each of its
   orders. The calibration leaves out every order that has a loaded lane. */

#ifndef ARCTRUE_LOAD_H
#define ARCTRUE_LOAD_H

#include <stdbool.h>
#include <stdint.h>

#include "arctrue_number_formats.h"
#include "capture.h"
#include "coefficients.h"
#include "followed.h"
#include "line_phase.h"
#include "loaded_watch.h"
#include "table_place.h"
#include "thermal.h"

enum load_state {
    LOAD_NONE,
    /* Frames are arriving. */
    LOAD_RECEIVING,
    /* Turns judge the received set, or the set that was loaded before a start. */
    LOAD_WAITING,
    LOAD_ACTIVE,
    /* The received set is refused; the loaded set stays loaded. */
    LOAD_REFUSED,
};

/* State of the loaded set since the core restarted. */
enum loaded_state {
    LOADED_AT_WORK,
    /* No turn has judged the loaded set again yet. */
    LOADED_PENDING,
    /* The loaded set belongs to another table, this core cannot apply it, a turn contradicts it, or the points of its
       local table are lost. The firmware keeps the set, and turns judge it again after the next start. */
    LOADED_REJECTED,
};

enum load_answer {
    LOAD_TAKEN,
    /* Errors of a frame, which may be sent again. */
    LOAD_WRONG_CRC,
    LOAD_WRONG_FRAME,
    /* Errors of the set. */
    LOAD_TOO_MANY_LANES,
    LOAD_OUT_OF_RANGE,
    LOAD_ORDER_TWICE,
    LOAD_NOT_WHOLE,
    LOAD_ANOTHER_TABLE,
    LOAD_TOO_STEEP,
    LOAD_WORSE,
    LOAD_NOT_READ_BACK,
    /* Turns of two heads cannot show one of the set's orders; `load force` makes the firmware accept such an order. */
    LOAD_UNSEEN,
    /* A lane follows a condition, and the gateware is built without MODULATORS. */
    LOAD_NO_MODULATORS,
    /* The lanes that follow the speed would make the measurement of the speed unstable. */
    LOAD_UNSTABLE_SPEED,
    /* A lane has a real order, and the gateware is built without REAL_ORDERS, or a turn has too few counts for it. */
    LOAD_NO_REAL_ORDERS,
    LOAD_TOO_FEW_COUNTS,
    /* The set has a local table, and the gateware is built without LOCAL_TABLE. */
    LOAD_NO_LOCAL_TABLE,
    /* The set's mean has another number of heads than the core, its heads are at other places, or its delays differ. */
    LOAD_OTHER_HEADS,
    LOAD_OTHER_DELAYS,
    /* The set contains sets for a missing head, and the gateware is built without FAILOVER. */
    LOAD_NO_FAILOVER,
    /* The set uses a head that the gateware has left out, and contains no set without that head. */
    LOAD_HEAD_LEFT_OUT,
    LOAD_ANSWERS,
    /* The judgement needs more turns. */
    LOAD_NOT_YET,
};

/* Limit of the slope |d eps / d R| of a correction. */
#define LOAD_STEEPEST (ARCTRUE_STEEPEST_PERCENT / 100.0)

/* The set for a missing head that is being received: the coefficients that apply while one head is left out of the
   mean. */
struct load_without {
    /* Number of the missing head, from 1 on; 0: none has begun. */
    uint32_t head;
    uint32_t lanes;
    uint32_t next_lane;
    struct mean_set mean;
    /* Order of the previous lane, and the sum of |d eps / d R| over the lanes. */
    uint32_t order;
    double steepness;
    /* Largest sum of this kind over the complete sets. */
    double steepest;
    /* Heads whose sets are complete, one bit per head. */
    uint32_t whole;
};

struct load {
    enum load_state state;
    enum load_answer reason;
    uint32_t frames;
    uint32_t next;
    /* CRC of all frames so far. */
    uint32_t crc;
    /* The set in reception, and the set that is loaded. */
    struct coefficients received;
    struct coefficients loaded;
    /* Temperature dependence of the lanes of these two sets. */
    struct thermal received_thermal;
    struct thermal thermal;
    /* Lanes of these two sets that follow a condition or have a real order. */
    struct followed received_followed;
    struct followed followed;
    /* Local tables of these two sets; choice 0: no table. `table_evidence`: log odds of the received table, summed over
       the turns so far. */
    struct load_table received_table;
    struct load_table table;
    double table_evidence;
    /* Sets for a missing head that are being received; the gateware holds their words. */
    struct load_without without;
    /* True if the received set is complete and not yet judged. */
    bool whole;
    /* True if the phase of a lane of a real order has become known or unknown, or has changed, and the core does not
       yet have the new words. */
    bool phase_given;
    /* `forced`: the operator accepts orders of the received set that no turn has judged. `unseen_taken`: the operator
       accepts only orders that no turn of two heads can show. */
    bool forced;
    bool unseen_taken;
    /* Logarithm of the odds of each received lane, summed over the turns so far. */
    float evidence[LANES_LIMIT];
    /* Received lanes that need more turns, and received lanes that no turn has judged; one bit per lane. */
    uint64_t undecided;
    uint64_t received_unjudged;
    /* Lanes that follow a condition, one bit per lane. `shown`: a turn has shown the lane, with modulator `shown_at`.
       `shown_twice`: another turn has shown the lane with a different modulator. */
    uint32_t shown;
    uint32_t shown_twice;
    float shown_at[FOLLOWED_LANES_MAX];
    /* Values in the first of these turns, arcsec: the part of the order that followed a condition, and the remaining
       error of the order. */
    struct vector shown_part[FOLLOWED_LANES_MAX];
    struct vector shown_left[FOLLOWED_LANES_MAX];
    /* Order that caused the refusal; 0: none. */
    uint32_t refused_order;
    /* The loaded set: its state, the lanes that no turn has judged, the CRC of all its frames (0: it came from the
       flash), and the turns' results for its lanes. */
    enum loaded_state loaded_state;
    uint64_t unjudged;
    uint32_t loaded_crc;
    struct loaded_watch watch;
    /* `finder`: results of the turns for the loaded lanes of real orders. `probe_seen`: the firmware has read the
       probe since these lanes began to wait. `probe_edges`: number of edges at the last of these readings. */
    struct line_finder finder[REAL_LANES_MAX];
    bool probe_seen;
    uint32_t probe_edges;
};

/* Tells whether lanes of the received set wait for a turn in the other direction (`other_direction` true) or at another
   speed (false). */
bool load_waits_for(const struct load *load, bool other_direction);

const char *load_state_name(enum load_state state);
const char *load_answer_name(enum load_answer answer);

/* Begins the reception of a set. The CRC-32 of a frame covers its numbers as little-endian words, in the order in which
   they are written; the CRC of the last frame covers the words of all frames before it. */
enum load_answer load_begin(struct load *load, uint32_t frames, uint32_t counts_per_rev,
                            uint32_t lanes, uint32_t crc);
enum load_answer load_lane(struct load *load, uint32_t number, uint32_t order,
                           uint32_t phase_offset, int32_t amplitude, uint32_t crc);
/* Sets the temperature dependence of an earlier lane. `number` counts these frames from 0 on. */
enum load_answer load_slope(struct load *load, uint32_t number, const struct thermal_lane *lane,
                            uint32_t crc);
/* Sets the temperature at which the lanes have the written values, and the time constant of the thermometer. */
enum load_answer load_temperature(struct load *load, int32_t reference_mc,
                                  uint32_t time_constant_ms, uint32_t crc);
/* Sets the range of temperature in which the lanes follow. This frame must come after the frame of load_temperature(),
   which presets the range. */
enum load_answer load_range(struct load *load, int32_t least_mc, int32_t most_mc, uint32_t crc);
/* Adds a lane that follows a condition. `number` counts these frames from 0 on. The settings of the conditions come
   after the lanes. */
enum load_answer load_followed(struct load *load, uint32_t number, const struct followed_lane *lane,
                               uint32_t crc);
enum load_answer load_conditions(struct load *load, uint32_t width, uint32_t dead_zone,
                                 uint32_t nominal_speed, uint32_t crc);
/* Adds a lane of a real order, whose phase is not known yet. `number` counts these frames from 0 on. */
enum load_answer load_real(struct load *load, uint32_t number, const struct real_lane *lane,
                           uint32_t crc);
/* Sets source, side and probe phase of an earlier lane of a real order; without this frame the operator gives the
   phase. */
enum load_answer load_phase_source(struct load *load, uint32_t number, const struct real_lane *lane,
                                   uint32_t crc);
/* Sets the phase of a lane of a real order in the active set, u0.24 turn, at angle 0 of turn `turn` of the core.
   Returns false if there is no such lane. */
bool load_phase(struct load *load, uint32_t number, uint32_t phase, int32_t turn);
/* Begins a local table. Its points follow in frames of LOAD_POINTS points; points beyond the last point of the table
   are 0. */
enum load_answer load_table(struct load *load, const struct table_place *place, uint32_t crc);
enum load_answer load_points(struct load *load, uint32_t number, const int32_t points[LOAD_POINTS],
                             uint32_t crc);
/* States that the lanes correct a mean: `mean` holds carrier, heads, offset and delays. One frame per head follows. */
enum load_answer load_mean(struct load *load, const struct mean_set *mean, uint32_t crc);
enum load_answer load_head(struct load *load, uint32_t number, int32_t weight, uint32_t offset,
                           uint32_t crc);
/* Begins the set for the missing head `head`, counted from 1; it must come after the mean of all heads. `mean` holds
   carrier, heads and offset. One frame per head and one per lane follow, orders ascending. No lane may follow
   temperature or condition or have a real order. */
enum load_answer load_without(struct load *load, uint32_t head, uint32_t lanes,
                              const struct mean_set *mean, uint32_t crc);
enum load_answer load_without_head(struct load *load, uint32_t number, int32_t weight,
                                   uint32_t offset, uint32_t crc);
enum load_answer load_without_lane(struct load *load, uint32_t number, const struct lane *lane,
                                   uint32_t crc);
/* Lanes of the received set that become active without a judgement: either all lanes that no turn has decided, or only
   lanes that no turn of two heads can show. The frame `load force` uses the same values. */
enum load_scope { LOAD_FORCES_ALL = 1, LOAD_FORCES_UNSEEN = 2 };
enum load_answer load_force(struct load *load, uint32_t scope, uint32_t crc);
bool load_takes_unseen(const struct load *load);
/* Settings of the device; load_end() refuses a set for other settings. */
struct load_place {
    uint32_t counts_per_rev;
    uint32_t heads;
    /* Properties of the core. */
    uint32_t lanes;
    bool has_mean;
    bool has_modulators;
    bool has_failover;
    bool has_real_orders;
    bool has_local_table;
    /* Value of the parameter head_delays. */
    uint32_t delays;
};

/* Ends the reception and checks the received set. `active`: the active coefficients, or NULL. */
enum load_answer load_end(struct load *load, const struct load_place *place,
                          const struct coefficients *active, uint32_t crc);

/* Clears the results of earlier turns for the received set. */
void load_begin_evidence(struct load *load);

/* Refuses the received set, even if its reception has not ended, and stores the reason. */
void load_refuse(struct load *load, enum load_answer reason);

/* Asserts the conditions that hold between any two calls. */
void load_assert(const struct load *load);

/* Drops the set that is being received or waits; the loaded set stays loaded. */
void load_abort(struct load *load);

/* Make the received set, or a saved set, the loaded set (`unjudged`: its lanes that no turn has judged). */
void load_take_over_received(struct load *load);
void load_take_over(struct load *load, const struct coefficients *set,
                    const struct thermal *thermal, const struct followed *followed,
                    const struct load_table *table, uint64_t unjudged);

/* Ends the judgement of a set that was loaded before: it becomes active again, or is rejected. */
void load_at_work_again(struct load *load);
void load_reject(struct load *load, enum load_answer reason);

/* Returns the loaded set if it is active, otherwise NULL. */
const struct coefficients *load_at_work(const struct load *load);

/* Returns the lanes of the loaded set that follow a condition or have a real order; none if the set is not active. */
struct followed load_followed_at_work(const struct load *load);

/* Discards the loaded set and every set in reception. */
void load_forget(struct load *load);

/* Starts a new judgement of the loaded set after a restart of the core. */
void load_again(struct load *load, uint32_t counts_per_rev);

/* Copies the calibration's lanes from `active` (NULL: none): all lanes whose orders the loaded set does not have. */
void load_own_lanes(const struct load *load, const struct coefficients *active,
                    struct coefficients *own);

/* Fills `candidate` with the lanes of `set` (NULL: none), at the temperature `celsius` if `thermal` is not NULL,
   and then with the lanes of `own` (NULL: none) whose orders `set` does not have, as many as fit. If `set` has a mean,
   uses no lane of `own`. */
void load_combine(const struct coefficients *set, const struct thermal *thermal, double celsius,
                  const struct coefficients *own, uint32_t lanes, struct coefficients *candidate);

#endif
