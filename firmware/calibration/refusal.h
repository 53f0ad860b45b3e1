/* SPDX-License-Identifier: Apache-2.0 */

/* Why a turn did not become coefficients. The last good ones stay in every case. */

#ifndef ARCTRUE_REFUSAL_H
#define ARCTRUE_REFUSAL_H

enum refusal {
    NOT_REFUSED = 0,
    /* What the capture's header says. */
    REFUSED_EMPTY,
    REFUSED_INDEX_NOT_SEEN,
    REFUSED_INDEX_ERROR,
    REFUSED_ILLEGAL_TRANSITION,
    REFUSED_EDGE_SPACING,
    REFUSED_BANK_FULL,
    /* What its samples say. */
    REFUSED_STANDS_STILL,
    REFUSED_SHORT_OF_A_TURN,
    REFUSED_MORE_THAN_A_TURN,
    REFUSED_REVERSAL,
    REFUSED_JUMP,
    REFUSED_WRONG_STEP,
    REFUSED_OVER_SPEED,
    REFUSED_INCONSISTENT_HEADS,
    REFUSED_HEADS_EXCHANGED,
    REFUSED_HEADS_ELSEWHERE,
    /* What the calculation says. */
    REFUSED_SINGULAR,
    REFUSED_NOT_CONVERGED,
    REFUSED_NOT_FINITE,
    REFUSED_AMPLITUDE,
    REFUSED_NO_MEAN,
    /* What the gate says. */
    REFUSED_NOISE,
    REFUSED_NOT_BETTER,
    REFUSALS,
};

/* A word for the console and for telemetry; "unknown" for anything else. */
const char *refusal_name(enum refusal reason);

#endif
