/* SPDX-License-Identifier: Apache-2.0 */

#include "bank.h"

#include <math.h>
#include <stddef.h>

#include "alarms.h"
#include "assertion.h"
#include "control.h"
#include "follow_temperature.h"
#include "restart.h"

/* Number of turns of head 1 without a ready bank after which the capture counts as stuck. */
enum { STUCK_TURNS = 4 };

/* Enters the safe state after a stuck capture: the correction decays to 0, and the capture restarts. */
static void bank_is_stuck(struct application *application, int32_t position) {
    application->stuck_captures++;
    alarm_between_turns(application, ALARM_STUCK_CAPTURE);
    restart_with_nothing(application);
    core_control(&application->core, false, true, CAPTURE_OFF);
    control_write(application);
    application->position_at_bank = position;
}

void bank_watch(struct application *application) {
    if (application_capture(application) == CAPTURE_BY_SYNC) {
        return;
    }
    int32_t position = core_position(&application->core).head1_position;
    double moved = fabs((double)counts_apart(position, application->position_at_bank));
    if (moved > STUCK_TURNS * application->parameters.counts_per_rev) {
        bank_is_stuck(application, position);
    }
}

/* Returns the angle of head 1 at the first sample minus head 1's first word, modulo a turn. The angle at the present
   position is known; `travel`, the number of counts from the first sample to this position, is right even if words
   wrap. */
static uint32_t bank_angle_offset(const struct core_position *position, int32_t first_word,
                                  uint32_t counts_per_rev) {
    int64_t travel = counts_apart(position->head1_turn_position, first_word);
    int64_t first_angle = (int64_t)position->head1_angle - travel;
    int64_t offset = (first_angle - first_word) % counts_per_rev;
    return (uint32_t)(offset < 0 ? offset + counts_per_rev : offset);
}

/* Returns the mean speed of head 1 since the first sample, counts per clock; 0 if no time has passed. */
static double bank_mean_speed(const struct core_position *position, int32_t first_word,
                              uint64_t start_time) {
    double clocks = (double)(position->time - start_time);
    double travel = counts_apart(position->head1_turn_position, first_word);
    return clocks > 0.0 ? travel / clocks : 0.0;
}

/* Computes the angle of each head at the first sample, and its travel up to the last one. `travel`, the number of counts
   since the first sample, is right even if words wrap. */
static void bank_start_angles(const struct core_turns *turns, struct capture *capture) {
    for (uint32_t head = 0; head < capture->heads && capture->words != NULL; head++) {
        const volatile int32_t *words = head < 2 ? capture->words : capture->further;
        int64_t travel = counts_apart(turns->turn_position[head], words[head % 2]);
        int64_t angle = ((int64_t)turns->angle[head] - travel) % capture->counts_per_rev;
        capture->start[head] = (int32_t)(angle < 0 ? angle + capture->counts_per_rev : angle);
        capture->travel[head] =
            counts_apart(capture_word(capture, capture->samples - 1, head), words[head % 2]);
    }
}

void bank_take(struct application *application) {
    const struct core_access *core = &application->core;
    struct core_position position = core_position(core);
    uint32_t heads = application->configuration.heads;
    const struct core_turns turns = core_turns(core, heads);
    struct core_header header = core_capture_header(core);
    uint32_t turn = (uint32_t)application->parameters.counts_per_rev;
    uint32_t depth = application->configuration.capture_depth;
    uint32_t samples = header.samples < depth ? header.samples : depth;
    ASSERT(turn > 0);
    application->header = header;
    follow_middle_of_turn(application);
    application->position_at_bank = position.head1_position;
    const volatile int32_t *words = samples ? core->capture(core->context, 2 * samples) : NULL;
    const volatile int32_t *further =
        samples && heads > 2 ? core->further_capture(core->context, 2 * samples) : NULL;
    application->capture = (struct capture){
        .words = words,
        .samples = samples,
        .flags = header.flags,
        .counts_per_rev = turn,
        .angle_offset = words != NULL ? bank_angle_offset(&position, words[0], turn) : 0,
        .head2_zero = application->head2_zero,
        .period_clocks = application_capture(application) == CAPTURE_BY_TIME
                             ? (uint32_t)application->parameters.sample_period
                             : 0U,
        .mean_speed = words != NULL ? bank_mean_speed(&position, words[0], header.start_time) : 0.0,
        .clock_hz = application->configuration.clock_hz,
        .heads = heads,
        .further = further,
    };
    bank_start_angles(&turns, &application->capture);
}

void bank_copy(struct application *application) {
    struct capture_copy *copy = application->copy;
    double celsius;
    ASSERT(copy != NULL);
    if (!capture_copy_take(copy, &application->capture)) {
        application->dump = DUMP_NOT_COPIED;
        return;
    }
    copy->sequence_number = application->header.sequence_number;
    copy->start_time = application->header.start_time;
    copy->separation_udeg = (int32_t)rint(application->parameters.separation_deg * 1e6);
    copy->has_temperature =
        application->read_temperature != NULL &&
        application->read_temperature(application->temperature_context, &celsius);
    copy->temperature_cdeg = copy->has_temperature ? (int32_t)rint(celsius * 100.0) : 0;
    application->dump = DUMP_COPIED;
}
