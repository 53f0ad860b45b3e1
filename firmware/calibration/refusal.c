/* SPDX-License-Identifier: Apache-2.0 */

#include "refusal.h"

static const char *const names[REFUSALS] = {
    [NOT_REFUSED] = "none",
    [REFUSED_EMPTY] = "empty",
    [REFUSED_INDEX_NOT_SEEN] = "index_not_seen",
    [REFUSED_INDEX_ERROR] = "index_error",
    [REFUSED_ILLEGAL_TRANSITION] = "illegal_transition",
    [REFUSED_EDGE_SPACING] = "edge_spacing",
    [REFUSED_BANK_FULL] = "bank_full",
    [REFUSED_STANDS_STILL] = "stands_still",
    [REFUSED_SHORT_OF_A_TURN] = "short_of_a_turn",
    [REFUSED_MORE_THAN_A_TURN] = "more_than_a_turn",
    [REFUSED_REVERSAL] = "reversal",
    [REFUSED_JUMP] = "jump",
    [REFUSED_WRONG_STEP] = "wrong_step",
    [REFUSED_OVER_SPEED] = "over_speed",
    [REFUSED_INCONSISTENT_HEADS] = "inconsistent_heads",
    [REFUSED_HEADS_EXCHANGED] = "heads_exchanged",
    [REFUSED_HEADS_ELSEWHERE] = "heads_elsewhere",
    [REFUSED_SINGULAR] = "singular",
    [REFUSED_NOT_CONVERGED] = "not_converged",
    [REFUSED_NOT_FINITE] = "not_finite",
    [REFUSED_AMPLITUDE] = "amplitude",
    [REFUSED_NO_MEAN] = "no_mean",
    [REFUSED_NOISE] = "noise",
    [REFUSED_NOT_BETTER] = "not_better",
};

const char *refusal_name(enum refusal reason) {
    return (unsigned)reason < REFUSALS ? names[reason] : "unknown";
}
