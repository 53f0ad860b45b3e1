/* SPDX-License-Identifier: Apache-2.0 */

#include "swap.h"

#include "alarms.h"
#include "assertion.h"
#include "control.h"
#include "restart.h"

/* A swap is over within some hundred clocks of the core; a look at its counter takes at least one
   access of its bus. */
enum { SWAP_LOOKS_MOST = 1000 };

bool swap_candidate(struct application *application, const struct followed *followed) {
    const struct core_access *core = &application->core;
    ASSERT(state_works(application));
    uint32_t lanes = application->configuration.lanes;
    uint32_t counts_per_rev = application->candidate.counts_per_rev;
    ASSERT(application->candidate.lanes + followed_all_lanes(followed) <= lanes);
    ASSERT(application->candidate.counts_per_rev ==
           (uint32_t)application->parameters.counts_per_rev);
    core_failover_off(core);
    core_write_coefficients(core, &application->candidate);
    core_write_followed(core, followed, counts_per_rev, lanes);
    core_write_real(core, followed, counts_per_rev, lanes);
    if (!core_verify_coefficients(core, &application->candidate) ||
        !core_verify_followed(core, followed, counts_per_rev, lanes) ||
        !core_verify_real(core, followed, counts_per_rev, lanes)) {
        return false;
    }
    application->swaps_before = core_swap_count(core);
    core_swap(core);
    application->active = application->candidate;
    application->has_active = true;
    application->forgotten = false;
    application->inherited = false;
    application->swaps++;
    application->swap_looks = 0;
    application->phase = PHASE_SWAP;
    control_write(application);
    return true;
}

/* Which coefficients are active is not known: safe is none. */
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
}
