/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the reasons why a turn gives no coefficients. The last good coefficients stay active in every case. */

#ifndef ARCTRUE_REFUSAL_H
#define ARCTRUE_REFUSAL_H

enum refusal {
    NOT_REFUSED = 0,
    /* Reasons in the header of the capture. */
    REFUSED_EMPTY,
    REFUSED_INDEX_NOT_SEEN,
    REFUSED_INDEX_ERROR,
    REFUSED_ILLEGAL_TRANSITION,
    REFUSED_EDGE_SPACING,
    REFUSED_BANK_FULL,
    /* Reasons in the samples of the capture. */
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
    /* Reasons in the calculation. */
    REFUSED_SINGULAR,
    REFUSED_NOT_CONVERGED,
    REFUSED_NOT_FINITE,
    REFUSED_AMPLITUDE,
    REFUSED_NO_MEAN,
    /* Reasons of the gate. */
    REFUSED_NOISE,
    REFUSED_NOT_BETTER,
    REFUSALS,
};

/* Returns the word for the console and for telemetry; "unknown" for any other value. */
const char *refusal_name(enum refusal reason);

#endif
