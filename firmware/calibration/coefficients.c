/* SPDX-License-Identifier: Apache-2.0 */

#include "coefficients.h"

#include <math.h>
#include <stddef.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"

#define AMPLITUDE_STEPS ((double)(1 << ARCTRUE_AMPLITUDE_FRACTION))
#define ORDER_MOST ((1U << ARCTRUE_ORDER_WIDTH) - 1U)
#define AMPLITUDE_MOST ((1 << (ARCTRUE_AMPLITUDE_WIDTH - 1)) - 1)
#define AMPLITUDE_WORD_MAX ((double)AMPLITUDE_MOST)
#define PHASE_STEPS ((double)(1 << ARCTRUE_PHASE_WIDTH))

_Static_assert(LANES_LIMIT == ARCTRUE_LANES_MAX, "the register map holds this many lanes");
_Static_assert(ARCTRUE_PHASE_STEP_WIDTH % 2 == 0, "the phase step in two halves");

/* Computes the phase step, which is order / counts_per_rev in units of 2^-48 turn, by long division. It removes whole
   turns first, because the dividend of a single division, order times 2^49, has 65 bits. */
uint64_t coefficients_phase_step(uint32_t order, uint32_t counts_per_rev) {
    ASSERT(counts_per_rev > 0 && order <= ORDER_MOST);
    if (order == 0) {
        return 0;
    }
    uint64_t part = order % counts_per_rev;
    uint64_t step = 0;
    /* Divides in two steps of 24 bits, so that each dividend fits into 64 bits. */
    for (unsigned half = 0; half < 2; half++) {
        part <<= ARCTRUE_PHASE_STEP_WIDTH / 2;
        step = step << (ARCTRUE_PHASE_STEP_WIDTH / 2) | part / counts_per_rev;
        part %= counts_per_rev;
    }
    step += 2 * part >= counts_per_rev;
    return step & ((1ULL << ARCTRUE_PHASE_STEP_WIDTH) - 1);
}

static uint32_t phase_offset(double phase_rad) {
    double turns = phase_rad / (2.0 * PI);
    turns -= floor(turns);
    return (uint32_t)rint(turns * PHASE_STEPS) & ((1U << ARCTRUE_PHASE_WIDTH) - 1);
}

static enum refusal quantise_lane(const struct harmonic *harmonic, uint32_t order,
                                  uint32_t counts_per_rev, struct lane *lane) {
    double counts = harmonic_amplitude(harmonic) / (ARCSEC_PER_TURN / counts_per_rev);
    double amplitude = rint(counts * AMPLITUDE_STEPS);
    /* The negated comparison also refuses a value that is not a number. */
    if (!(amplitude <= AMPLITUDE_WORD_MAX)) {
        return REFUSED_AMPLITUDE;
    }
    *lane = (struct lane){phase_offset(harmonic_phase(harmonic)), (int32_t)amplitude, order};
    return NOT_REFUSED;
}

enum refusal coefficients_quantise(const struct estimate *estimate, const enum verdict *verdicts,
                                   uint32_t counts_per_rev, uint32_t lanes,
                                   struct coefficients *coefficients) {
    ASSERT(estimate->orders <= ORDERS_MAX && lanes <= LANES_LIMIT && counts_per_rev > 0);
    uint32_t used = 0;
    *coefficients = (struct coefficients){.lanes = lanes, .counts_per_rev = counts_per_rev};
    for (uint32_t place = 0; place < estimate->orders && used < lanes; place++) {
        if (verdicts[place] != VERDICT_APPLIED) {
            continue;
        }
        enum refusal reason = quantise_lane(&estimate->harmonic[place], place + 1, counts_per_rev,
                                            &coefficients->lane[used++]);
        if (reason != NOT_REFUSED) {
            return reason;
        }
    }
    return NOT_REFUSED;
}

bool coefficients_lane_is_valid(const struct lane *lane) {
    return lane->order != 0 && lane->order <= ORDER_MOST &&
           lane->phase_offset < 1U << ARCTRUE_PHASE_WIDTH && lane->amplitude <= AMPLITUDE_MOST &&
           lane->amplitude >= -AMPLITUDE_MOST - 1;
}

const struct lane *coefficients_lane_of(const struct coefficients *coefficients, uint32_t order) {
    ASSERT(coefficients == NULL || coefficients->lanes <= LANES_LIMIT);
    uint32_t lanes = coefficients != NULL && order != 0 ? coefficients->lanes : 0;
    for (uint32_t lane = 0; lane < lanes; lane++) {
        if (coefficients->lane[lane].order == order) {
            return &coefficients->lane[lane];
        }
    }
    return NULL;
}

bool coefficients_have(const struct coefficients *coefficients, uint32_t order) {
    return coefficients_lane_of(coefficients, order) != NULL;
}

uint32_t coefficients_most_order(const struct coefficients *coefficients) {
    ASSERT(coefficients->lanes <= LANES_LIMIT);
    uint32_t most = 0;
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        uint32_t order = coefficients->lane[lane].order;
        most = order > most ? order : most;
    }
    return most;
}

void coefficients_drop_orders(struct coefficients *coefficients, uint32_t most) {
    ASSERT(coefficients->lanes <= LANES_LIMIT);
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        if (coefficients->lane[lane].order > most) {
            coefficients->lane[lane] = (struct lane){0};
        }
    }
}

struct vector coefficients_lane_components(const struct lane *lane, uint32_t counts_per_rev) {
    ASSERT(counts_per_rev > 0);
    double amplitude = lane->amplitude / AMPLITUDE_STEPS * (ARCSEC_PER_TURN / counts_per_rev);
    struct vector unit = vector_unit(2.0 * PI * lane->phase_offset / PHASE_STEPS);
    return (struct vector){amplitude * unit.re, -amplitude * unit.im};
}

struct vector coefficients_components(const struct coefficients *coefficients, uint32_t order) {
    ASSERT(coefficients->lanes <= LANES_LIMIT && coefficients->counts_per_rev > 0);
    struct vector total = {0.0, 0.0};
    for (uint32_t lane = 0; lane < coefficients->lanes; lane++) {
        const struct lane *word = &coefficients->lane[lane];
        if (word->order == order) {
            const struct vector part =
                coefficients_lane_components(word, coefficients->counts_per_rev);
            total.re += part.re;
            total.im += part.im;
        }
    }
    return total;
}
