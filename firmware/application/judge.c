/* SPDX-License-Identifier: Apache-2.0 */

#include "judge.h"

#include <math.h>
#include <stddef.h>

#include "assertion.h"
#include "transfer_function.h"
#include "units.h"

/* The value of an order is refused if it leaves a larger error than the active value, and the difference exceeds the
   sum of NO_WORSE standard uncertainties, the effect of a change during the turn, and NOISE_SHARE times the noise of a
   reading. A smaller difference is within the noise of a reading. */
#define NO_WORSE 6.0
#define NOISE_SHARE 0.5
/* Least difference of a modulator (the factor of a lane that follows a condition, -1 to 1) with which two conditions
   count as different. */
#define OTHER_CONDITION 0.2
/* Limit of the change of an order that remains between two conditions, as a share of the change that its lanes compute.
   At this limit, in the worst case, the remaining change is as large as the change without the lanes. */
#define CHANGE_LEFT 0.5
/* Amplitude in counts below which an order is less than the rounding of the output. */
#define NOTHING_COUNTS 0.5

void judge_look(const struct judge *judge, const struct coefficients *set) {
    further_orders_look(judge->workspace, judge->turn, judge->estimate, set);
}

static struct sight judge_fitted_sight(const struct harmonic *harmonic, double gain_limit) {
    if (!harmonic->seen || harmonic->noise_gain > gain_limit) {
        return (struct sight){.state = SIGHT_UNSEEN};
    }
    double cosine = harmonic->by_separation_cosine;
    double sine = harmonic->by_separation_sine;
    return (struct sight){
        .state = SIGHT_CLEAR,
        .value = {harmonic->cosine, harmonic->sine},
        .variance = 0.5 * (harmonic->variance_cosine + harmonic->variance_sine),
        .by_separation = 0.5 * (cosine * cosine + sine * sine),
    };
}

/* Returns the variance at an order due to a change of order 1 during the turn. Suppose that order 1 grows by c from one
   end of the turn to the other (heat moves the centre). This sawtooth times a cosine appears in head 2 minus head 1 at
   order n as c/2pi (1/(n - 1) + 1/(n + 1)), less than c/2n. Order 1 itself differs by c/4pi from its value in the
   middle of the turn. */
static double judge_by_change(const struct judge *judge, uint32_t order) {
    double separation_rad = judge->estimate->separation_rad;
    double gain = noise_gain(order, separation_rad) / noise_gain(1, separation_rad);
    double share = order == 1 ? 1.0 / (4.0 * PI) : 0.5 / order;
    double leak = judge->change_arcsec * gain * share;
    return 0.5 * leak * leak;
}

struct sight judge_sight(const struct judge *judge, uint32_t order, struct vector applied) {
    ASSERT(judge->estimate->orders <= ORDERS_MAX);
    struct sight sight =
        order <= judge->estimate->orders
            ? judge_fitted_sight(&judge->estimate->harmonic[order - 1], judge->gain_limit)
            : further_orders_sight(judge->workspace, judge->estimate, order, judge->gain_limit,
                                   applied);
    if (sight.state == SIGHT_CLEAR && judge->change_arcsec > 0.0) {
        sight.by_change = judge_by_change(judge, order);
    }
    return sight;
}

static struct vector judge_components(const struct coefficients *coefficients, uint32_t order) {
    return coefficients != NULL ? coefficients_components(coefficients, order)
                                : (struct vector){0.0, 0.0};
}

/* Judges one order. A value below `nothing_arcsec` has no effect now but will have an effect at another temperature or
   condition; this limit is 0 if the order follows neither. */
static enum judgement judge_order(const struct sight *sight, struct vector value,
                                  struct vector present, double noise_arcsec, double nothing_arcsec,
                                  float *evidence) {
    if (sight->state != SIGHT_CLEAR) {
        return sight->state == SIGHT_UNSEEN ? JUDGED_NEVER : JUDGED_NOT_YET;
    }
    double u = sqrt(sight->variance + sight->by_separation);
    double change = sqrt(2.0 * sight->by_change);
    double left = sight_left(sight, value);
    *evidence += (float)sight_evidence(sight, value);
    double no_worse = NO_WORSE * u + change + NOISE_SHARE * noise_arcsec;
    if (*evidence <= -EVIDENCE_ENOUGH || left > sight_left(sight, present) + no_worse) {
        return JUDGED_WRONG;
    }
    bool is_nothing = vector_square(value) < nothing_arcsec * nothing_arcsec &&
                      left < nothing_arcsec + NO_WORSE * u + change;
    return *evidence >= EVIDENCE_ENOUGH || is_nothing ? JUDGED_RIGHT : JUDGED_NOT_YET;
}

struct vector judge_value(const struct judge *judge, const struct coefficients *set,
                          uint32_t order) {
    struct vector value = judge_components(set, order);
    if (judge->followed != NULL) {
        const struct vector part = followed_components(
            judge->followed, order, (uint32_t)judge->turn->counts_per_rev, &judge->motion);
        value.re += part.re;
        value.im += part.im;
    }
    return value;
}

uint32_t judge_measure_followed(const struct judge *judge, const struct coefficients *set,
                                struct followed_measured *measured) {
    const struct followed *followed = judge->followed;
    uint32_t counts_per_rev = (uint32_t)judge->turn->counts_per_rev;
    uint32_t number = 0;
    ASSERT(followed->lanes <= FOLLOWED_LANES_MAX && counts_per_rev > 0);
    for (uint32_t place = 0; place < followed->lanes; place++) {
        const struct followed_lane *lane = &followed->lane[place];
        double modulator = followed_modulator(followed, place, &judge->motion);
        const struct vector full = coefficients_lane_components(&lane->lane, counts_per_rev);
        double size = vector_length(full);
        if (!followed_lane_is_seen(lane) || lane->lane.order > judge->estimate->orders ||
            modulator == 0.0 || size == 0.0) {
            continue;
        }
        const struct vector value = judge_value(judge, set, lane->lane.order);
        const struct sight sight = judge_sight(judge, lane->lane.order, value);
        if (sight.state != SIGHT_CLEAR) {
            continue;
        }
        const struct vector left = vector_difference(sight.value, value);
        double along = (left.re * full.re + left.im * full.im) / size;
        measured[number++] = (struct followed_measured){
            .order = lane->lane.order,
            .modulator = lane->modulator,
            .measured_arcsec = size + along / modulator,
            .u_arcsec = sqrt(sight_variance(&sight)) / fabs(modulator),
            .loaded_arcsec = size,
        };
    }
    return number;
}

/* Compares this turn with an earlier turn under another condition. Returns false if the error that remains at the order
   changes between the two turns by more than CHANGE_LEFT times the change that the lanes compute, plus the noise. */
static bool judge_other_condition(const struct judge *judge, struct load *load, uint32_t place,
                                  const struct sight *sight, struct vector value) {
    const struct followed *followed = judge->followed;
    const struct vector part =
        followed_components(followed, followed->lane[place].lane.order,
                            (uint32_t)judge->turn->counts_per_rev, &judge->motion);
    const struct vector left = {sight->value.re - value.re, sight->value.im - value.im};
    double modulator = followed_modulator(followed, place, &judge->motion);
    if ((load->shown >> place & 1U) == 0) {
        load->shown |= 1U << place;
        load->shown_at[place] = (float)modulator;
        load->shown_part[place] = part;
        load->shown_left[place] = left;
    } else if (fabs(modulator - (double)load->shown_at[place]) >= OTHER_CONDITION) {
        double size = vector_length(vector_difference(part, load->shown_part[place]));
        double change = vector_length(vector_difference(left, load->shown_left[place]));
        /* The change contains the noise of two turns; the error of the heads' separation is the same in both turns. */
        double u = sqrt(2.0 * sight->variance);
        load->shown_twice |= 1U << place;
        return change <= CHANGE_LEFT * size + NO_WORSE * u + sqrt(2.0 * sight->by_change);
    }
    return true;
}

/* Judges the lanes that follow a condition. A turn confirms an order together with the lanes that follow this turn's
   condition; a lane is accepted once two turns with different modulators have confirmed it. */
static enum load_answer judge_followed(const struct judge *judge, struct load *load,
                                       const struct coefficients *active,
                                       const struct coefficients *candidate) {
    const struct followed *followed = &load->received_followed;
    ASSERT(followed->lanes <= FOLLOWED_LANES_MAX && load->received.counts_per_rev > 0);
    double half_count_arcsec = NOTHING_COUNTS * ARCSEC_PER_TURN / load->received.counts_per_rev;
    enum load_answer answer = LOAD_TAKEN;
    for (uint32_t place = 0; place < followed->lanes; place++) {
        uint32_t order = followed->lane[place].lane.order;
        bool seen = followed_lane_is_seen(&followed->lane[place]);
        if (!seen || order > judge->estimate->orders) {
            if (!load_takes_unseen(load)) {
                load->refused_order = order;
                return LOAD_UNSEEN;
            }
            continue;
        }
        struct vector value = judge_value(judge, candidate, order);
        const struct sight sight = judge_sight(judge, order, value);
        float evidence = 0.0F;
        enum judgement found =
            judge_order(&sight, value, judge_components(active, order),
                        judge->estimate->noise_arcsec, half_count_arcsec, &evidence);
        bool right = found != JUDGED_WRONG;
        if (found == JUDGED_RIGHT) {
            right = judge_other_condition(judge, load, place, &sight, value);
        }
        if (!right) {
            load->refused_order = order;
            return LOAD_WORSE;
        }
        if (!load->forced && (load->shown_twice >> place & 1U) == 0) {
            answer = LOAD_NOT_YET;
        }
    }
    return answer;
}

enum load_answer judge_received(const struct judge *judge, struct load *load,
                                const struct coefficients *active,
                                const struct coefficients *candidate) {
    const struct coefficients *set = &load->received;
    ASSERT(set->lanes <= LANES_LIMIT && set->counts_per_rev > 0);
    double half_count_arcsec = NOTHING_COUNTS * ARCSEC_PER_TURN / set->counts_per_rev;
    judge_look(judge, set);
    enum load_answer answer = judge_followed(judge, load, active, candidate);
    if (answer != LOAD_TAKEN && answer != LOAD_NOT_YET) {
        return answer;
    }
    load->undecided = 0;
    load->received_unjudged = 0;
    for (uint32_t place = 0; place < set->lanes; place++) {
        uint32_t order = set->lane[place].order;
        if (order == 0) {
            continue;
        }
        struct vector value = judge_value(judge, candidate, order);
        const struct sight sight = judge_sight(judge, order, value);
        bool follows = thermal_follows(&load->received_thermal, order);
        enum judgement found = judge_order(
            &sight, value, judge_components(active, order), judge->estimate->noise_arcsec,
            follows ? half_count_arcsec : 0.0, &load->evidence[place]);
        if (found == JUDGED_WRONG || (found == JUDGED_NEVER && !load_takes_unseen(load))) {
            load->refused_order = order;
            return found == JUDGED_WRONG ? LOAD_WORSE : LOAD_UNSEEN;
        }
        if (found == JUDGED_RIGHT) {
            continue;
        }
        if (load->forced || found == JUDGED_NEVER) {
            load->received_unjudged |= 1ULL << place;
        } else {
            load->undecided |= 1ULL << place;
            answer = LOAD_NOT_YET;
        }
    }
    return answer;
}

static bool judge_is_unjudged(const struct coefficients *set, uint64_t unjudged, uint32_t order) {
    const struct lane *lane = coefficients_lane_of(set, order);
    return lane != NULL && (unjudged >> (uint32_t)(lane - set->lane) & 1U) != 0;
}

enum judgement judge_again(const struct judge *judge, const struct coefficients *set,
                           uint64_t unjudged, double small_arcsec, struct coefficients *candidate) {
    ASSERT(set->lanes <= LANES_LIMIT && candidate->lanes <= LANES_LIMIT);
    double all = 0.0;
    bool any = false;
    bool blurred = false;
    judge_look(judge, candidate);
    for (uint32_t place = 0; place < candidate->lanes; place++) {
        struct lane *lane = &candidate->lane[place];
        if (lane->order == 0 || judge_is_unjudged(set, unjudged, lane->order)) {
            continue;
        }
        struct vector value = judge_value(judge, candidate, lane->order);
        const struct sight sight = judge_sight(judge, lane->order, value);
        blurred = blurred || sight.state == SIGHT_BLURRED;
        if (sight.state != SIGHT_CLEAR) {
            continue;
        }
        double evidence = sight_evidence(&sight, value);
        if (evidence <= -EVIDENCE_ENOUGH) {
            bool small = sight_left(&sight, value) < small_arcsec;
            if (!small || coefficients_have(set, lane->order)) {
                return JUDGED_WRONG;
            }
            *lane = (struct lane){0};
            continue;
        }
        all += evidence;
        any = true;
    }
    bool nothing_to_judge = !any && !blurred;
    return nothing_to_judge || all >= EVIDENCE_ENOUGH ? JUDGED_RIGHT : JUDGED_NOT_YET;
}
