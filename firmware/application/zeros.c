/* SPDX-License-Identifier: Apache-2.0 */

#include "zeros.h"

#include <math.h>

#include "alarms.h"
#include "control.h"

/* Number of turns without two agreeing index marks after which the zeros are searched again. Normally two marks agree
   within two turns; otherwise head 1 loses counts in every turn or has lost its index. */
enum { DOUBT_TURNS = 4 };
/* Largest angle of head 1 at its index, in turns, that counts as a loss of counts; a mark further from the zero is
   probably a false pulse. */
#define LOST_TURNS_MOST (1.0 / 1024.0)

int32_t zeros_look(const struct application *application, uint32_t head, int32_t known) {
    uint32_t turn = (uint32_t)application->parameters.counts_per_rev;
    double tolerance = application->parameters.index_tolerance;
    int32_t angle = core_angle_at_index(&application->core, head, turn);
    if (fabs((double)angle) <= tolerance) {
        return 0;
    }
    return fabs((double)angle - known) > tolerance ? angle : known;
}

void zeros_forget(struct application *application) {
    application->position_at_bank = core_position(&application->core).head1_position;
    application->head2_zero = 0;
    application->zero_moves = core_zero_moves(&application->core);
    application->zero_in_doubt = false;
}

/* Searches the zeros of the heads again, because no two index marks of head 1 agreed for DOUBT_TURNS turns. The
   correction is off until the zeros are found. The coefficients are kept, because they refer to the index mark. */
static void zeros_find_anew(struct application *application) {
    core_rearm(&application->core);
    core_disarm_compare(&application->core);
    zeros_forget(application);
    alarm_between_turns(application, ALARM_ZERO_LOST);
    application->phase = PHASE_WAIT_FOR_INDEX;
}

void zeros_watch_doubt(struct application *application) {
    if (!application->zero_in_doubt && !core_head_index_error(&application->core, 0)) {
        return;
    }
    double off = fabs((double)zeros_look(application, 0, 0));
    int32_t position = core_position(&application->core).head1_position;
    if (off == 0.0 || off > LOST_TURNS_MOST * application->parameters.counts_per_rev) {
        application->zero_in_doubt = false;
    } else if (!application->zero_in_doubt) {
        application->zero_in_doubt = true;
        application->position_at_doubt = position;
    } else if (fabs((double)counts_apart(position, application->position_at_doubt)) >
               DOUBT_TURNS * application->parameters.counts_per_rev) {
        zeros_find_anew(application);
    }
}

void zeros_follow_head2(struct application *application) {
    int32_t zero = zeros_look(application, 1, application->head2_zero);
    application->report.alarms |= zero != application->head2_zero ? ALARM_ZERO_LOST : 0;
    application->head2_zero = zero;
}

bool zeros_moved(struct application *application) {
    uint32_t moves = core_zero_moves(&application->core);
    bool moved = moves != application->zero_moves;
    application->zero_moves = moves;
    application->report.alarms |= moved ? ALARM_ZERO_LOST : 0;
    if (moved && core_status(&application->core).compare_armed) {
        control_arm_compare(application);
    }
    return moved;
}

void zeros_watch(struct application *application) {
    zeros_watch_doubt(application);
    if (zeros_moved(application)) {
        alarm_between_turns(application, ALARM_ZERO_LOST);
        zeros_follow_head2(application);
        core_clear_faults(&application->core);
        control_capture_anew(application);
        control_give_back_bank(application);
    }
}
