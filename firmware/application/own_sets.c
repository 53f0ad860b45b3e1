/* SPDX-License-Identifier: Apache-2.0 */

#include "own_sets.h"

#include "prepared.h"
#include "thermal.h"

/* Computes the set of coefficients that applies if the head with index `missing` is left out; returns false if there is
   no valid set. The set keeps the offsets of the mean of all heads, so that the zero does not move; weights, lanes and
   the constant part of the error are computed for the remaining heads. */
static bool own_sets_make_one(struct application *application, uint32_t missing) {
    struct heads_workspace *workspace = &application->workspace.heads;
    const struct heads_found *found = &application->found;
    struct coefficients *set = &workspace->made.without[missing];
    struct estimate *estimate = &workspace->made.of_mean;
    enum verdict verdicts[ORDERS_MAX];
    uint32_t counts_per_rev = application->candidate.counts_per_rev;
    struct mean_set mean = application->candidate.mean;
    mean.used &= ~(1U << missing);
    mean.carrier = missing == mean.carrier ? (missing + 1) % mean.heads : mean.carrier;
    if (!heads_weights(&found->geometry, mean.used, mean.weight)) {
        return false;
    }
    *estimate = workspace->made.disc;
    heads_estimate_of_mean(workspace, found, counts_per_rev, &mean, estimate);
    if (!estimate_is_finite(estimate) ||
        !mean_set_is_valid(&mean, application->configuration.heads, counts_per_rev)) {
        return false;
    }
    select_orders(estimate, application->configuration.lanes, application->parameters.gain_limit,
                  verdicts);
    enum refusal reason = coefficients_quantise(estimate, verdicts, counts_per_rev,
                                                application->configuration.lanes, set);
    set->mean = mean;
    return reason == NOT_REFUSED &&
           thermal_extent(&(struct thermal){0}, set).steepest < LOAD_STEEPEST;
}

void own_sets_make(struct application *application) {
    struct prepared *prepared = &application->prepared;
    bool wanted = application->configuration.has_failover &&
                  application->candidate_origin == OF_TURN &&
                  application->candidate.mean.heads == HEADS_MOST &&
                  application->found.geometry.heads == HEADS_MOST;
    prepared->has_made = wanted;
    prepared->made = 0;
    for (uint32_t head = 0; wanted && head < HEADS_MOST; head++) {
        prepared->made |= own_sets_make_one(application, head) ? 1U << head : 0U;
    }
}

void own_sets_write(struct application *application) {
    const struct coefficients *made = application->workspace.heads.made.without;
    struct prepared *prepared = &application->prepared;
    const struct coefficients nothing = {.lanes = application->configuration.lanes,
                                         .counts_per_rev = application->candidate.counts_per_rev,
                                         .mean = {.heads = HEADS_MOST}};
    if (!prepared->has_made) {
        return;
    }
    prepared->sum = 0;
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        bool has = (prepared->made >> head & 1U) != 0;
        prepared->sum +=
            core_write_prepared(&application->core, head + 1, has ? &made[head] : &nothing);
    }
    prepared_hold(application, prepared->made);
}
