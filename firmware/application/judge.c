/* SPDX-License-Identifier: Apache-2.0 */

#include "judge.h"

#include <math.h>
#include <stddef.h>

#include "assertion.h"
#include "transfer_function.h"
#include "units.h"

/* ln 1000: a value is taken where it is a thousand times likelier than none, and refused where none
   is a thousand times likelier. An amplitude of 3.7 u decides in one turn. */
#define EVIDENCE_ENOUGH 6.9
/* A value may be further off than what is active by so many standard uncertainties, and by so much of
   the noise of a reading: no reading shows that. */
#define NO_WORSE 6.0
#define NOISE_SHARE 0.5
/* Below this an order is less than the rounding of the output, counts. */
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

/* Order 1 that grows by c from one end of the turn to the other (heat moves the centre) is, as a sawtooth times a
   cosine, at order n c/2pi (1/(n - 1) + 1/(n + 1)) in head 2 less head 1, less than c/2n; of order 1 itself
   c/4pi is left beside the value of the turn's middle. */
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

/* `nothing_arcsec`: a value below it is none now, and will be one at another temperature; 0 where the
   order does not follow the temperature. */
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

enum load_answer judge_received(const struct judge *judge, struct load *load,
                                const struct coefficients *active,
                                const struct coefficients *candidate) {
    const struct coefficients *set = &load->received;
    ASSERT(set->lanes <= LANES_LIMIT && set->counts_per_rev > 0);
    double half_count_arcsec = NOTHING_COUNTS * ARCSEC_PER_TURN / set->counts_per_rev;
    enum load_answer answer = LOAD_TAKEN;
    judge_look(judge, set);
    load->undecided = 0;
    load->received_unjudged = 0;
    for (uint32_t place = 0; place < set->lanes; place++) {
        uint32_t order = set->lane[place].order;
        if (order == 0) {
            continue;
        }
        struct vector value = judge_components(candidate, order);
        const struct sight sight = judge_sight(judge, order, value);
        bool follows = thermal_follows(&load->received_thermal, order);
        enum judgement found = judge_order(
            &sight, value, judge_components(active, order), judge->estimate->noise_arcsec,
            follows ? half_count_arcsec : 0.0, &load->evidence[place]);
        if (found == JUDGED_WRONG || (found == JUDGED_NEVER && !load->forced)) {
            load->refused_order = order;
            return found == JUDGED_WRONG ? LOAD_WORSE : LOAD_UNSEEN;
        }
        if (found == JUDGED_RIGHT) {
            continue;
        }
        if (load->forced) {
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
        struct vector value = judge_components(candidate, lane->order);
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
