/* SPDX-License-Identifier: Apache-2.0 */

#include "swap.h"

#include "alarms.h"
#include "assertion.h"
#include "control.h"
#include "local_table.h"
#include "own_sets.h"
#include "prepared.h"
#include "restart.h"

/* Largest number of reads of the swap counter. A swap ends within some hundred clocks of the core, and each read takes
   at least one bus access, so a swap that has not ended after these reads is lost. */
enum { SWAP_LOOKS_MOST = 1000 };

/* Returns the missing heads for which the candidate has a prepared set, one bit per head. Calibrated and saved sets
   are not in the gateware yet; swap_candidate() writes them before the swap. */
static uint32_t swap_sets(const struct application *application) {
    if (application->prepared.has_made) {
        return application->prepared.made;
    }
    if (application->candidate.mean.heads < 3) {
        return 0;
    }
    if (application->candidate_origin == OF_SAVED) {
        return prepared_saved(application);
    }
    return application->candidate_origin == OF_LOAD ? application->load.without.whole
                                                    : application->prepared.sets;
}

/* Writes to `set` the number of the prepared set for the head that is left out; this set becomes active in place of the
   idle bank. The number is 0 if no head is left out. Returns SWAP_HEAD_LEFT_OUT if no prepared set fits. */
static enum swap_answer swap_choose_set(const struct application *application, uint32_t *set) {
    const struct mean_set *mean = &application->candidate.mean;
    uint32_t used = mean->heads != 0 ? mean->used : 1U;
    uint32_t left_out = core_left_out(&application->core) & used;
    *set = 0;
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        if (left_out == 1U << head && (swap_sets(application) >> head & 1U) != 0) {
            *set = head + 1;
        }
    }
    return left_out == 0 || *set != 0 ? SWAP_ASKED : SWAP_HEAD_LEFT_OUT;
}

enum swap_answer swap_candidate(struct application *application, const struct followed *followed) {
    const struct core_access *core = &application->core;
    ASSERT(state_works(application));
    uint32_t lanes = application->configuration.lanes;
    uint32_t counts_per_rev = application->candidate.counts_per_rev;
    ASSERT(application->candidate.lanes + followed_all_lanes(followed) <= lanes);
    ASSERT(application->candidate.counts_per_rev ==
           (uint32_t)application->parameters.counts_per_rev);
    uint32_t set;
    core_failover_off(core);
    if (swap_choose_set(application, &set) != SWAP_ASKED) {
        prepared_arm(application);
        return SWAP_HEAD_LEFT_OUT;
    }
    core_write_coefficients(core, &application->candidate);
    core_write_followed(core, followed, counts_per_rev, lanes);
    core_write_real(core, followed, counts_per_rev, lanes);
    if (!core_verify_coefficients(core, &application->candidate) ||
        !core_verify_followed(core, followed, counts_per_rev, lanes) ||
        !core_verify_real(core, followed, counts_per_rev, lanes) ||
        !local_table_write(application)) {
        prepared_arm(application);
        return SWAP_NOT_READ_BACK;
    }
    if (application->configuration.has_failover && application->candidate.mean.heads > 2) {
        /* Writes every lane of the window; lanes that the candidate does not have are 0. */
        uint32_t own_lanes = application->candidate.lanes;
        application->candidate.lanes = lanes;
        application->prepared.sum_of_all_heads =
            core_write_prepared(core, 0, &application->candidate);
        application->candidate.lanes = own_lanes;
        own_sets_write(application);
    }
    if (application->candidate_origin == OF_SAVED) {
        prepared_restore(application);
    }
    application->swaps_before = core_swap_count(core);
    if (set != 0) {
        core_take_set(core, set);
    } else {
        core_swap(core);
    }
    application->active = application->candidate;
    application->has_active = true;
    application->forgotten = false;
    application->inherited = false;
    application->swaps++;
    application->swap_looks = 0;
    application->phase = PHASE_SWAP;
    control_write(application);
    return SWAP_ASKED;
}

/* Raises an alarm and switches the correction off, because it is unknown which coefficients are active. */
static void swap_lost(struct application *application) {
    alarm_between_turns(application, ALARM_SWAP);
    restart_with_nothing(application);
}

void swap_wait(struct application *application) {
    bool swapped = core_swap_count(&application->core) != application->swaps_before;
    if (swapped || ++application->swap_looks > SWAP_LOOKS_MOST) {
        application->phase = PHASE_CAPTURE;
    }
    if (!swapped && application->phase == PHASE_CAPTURE) {
        swap_lost(application);
    }
    if (swapped) {
        prepared_arm(application);
    }
}
