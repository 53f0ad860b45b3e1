/* SPDX-License-Identifier: Apache-2.0 */

#include "prepared.h"

#include <math.h>
#include <stddef.h>

#include "alarms.h"
#include "arctrue_number_formats.h"
#include "assertion.h"
#include "units.h"

enum { OFFSET_ONE = 1 << ARCTRUE_HEAD_OFFSET_FRACTION, PARITY_HEADS = 4 };
#define PARITY_ONE ((double)(1 << ARCTRUE_HEAD_WEIGHT_FRACTION))

void prepared_forget(struct application *application) {
    application->prepared.sets = 0;
    application->prepared.overwritten = false;
    if (application->configuration.has_failover && state_works(application)) {
        core_failover_off(&application->core);
    }
}

/* Makes every prepared set in the gateware invalid until new sets are complete. */
static void prepared_close(struct application *application, uint32_t counts_per_rev) {
    uint32_t heads = application->configuration.heads;
    const struct coefficients nothing = {.lanes = application->configuration.lanes,
                                         .counts_per_rev = counts_per_rev,
                                         .mean = {.heads = heads}};
    prepared_forget(application);
    if (!application->configuration.has_failover) {
        return;
    }
    application->prepared.sum = 0;
    for (uint32_t set = 1; set <= heads; set++) {
        application->prepared.sum += core_write_prepared(&application->core, set, &nothing);
    }
}

/* Makes a received set valid in the gateware once it is complete, by writing the words of its mean. */
static enum load_answer prepared_open(struct application *application, enum load_answer answer) {
    const struct load_without *set = &application->load.without;
    if (answer == LOAD_TAKEN && set->head != 0 && (set->whole >> (set->head - 1) & 1U) != 0) {
        const struct coefficients words = {
            .counts_per_rev = application->load.received.counts_per_rev, .mean = set->mean};
        application->prepared.sum += core_write_prepared(&application->core, set->head, &words);
    }
    return answer;
}

enum load_answer application_load_without(struct application *application, uint32_t head,
                                          uint32_t lanes, const struct mean_set *mean,
                                          uint32_t crc) {
    if (!application->configuration.has_failover || !state_works(application)) {
        return LOAD_NO_FAILOVER;
    }
    bool first = application->load.without.head == 0;
    enum load_answer answer = load_without(&application->load, head, lanes, mean, crc);
    if (answer == LOAD_TAKEN && first) {
        bool had_sets = application->prepared.sets != 0 || application->prepared.overwritten;
        prepared_close(application, application->load.received.counts_per_rev);
        application->prepared.overwritten = had_sets;
    }
    return answer;
}

enum load_answer application_load_without_head(struct application *application, uint32_t number,
                                               int32_t weight, uint32_t offset, uint32_t crc) {
    return prepared_open(application,
                         load_without_head(&application->load, number, weight, offset, crc));
}

enum load_answer application_load_without_lane(struct application *application, uint32_t number,
                                               const struct lane *lane, uint32_t crc) {
    enum load_answer answer = load_without_lane(&application->load, number, lane, crc);
    if (answer == LOAD_TAKEN) {
        application->prepared.sum +=
            core_write_prepared_lane(&application->core, application->load.without.head, number,
                                     lane, application->load.received.counts_per_rev);
    }
    return prepared_open(application, answer);
}

/* Tells whether the gateware holds the words that the firmware wrote. */
static bool prepared_are_whole(const struct application *application) {
    const struct prepared *prepared = &application->prepared;
    return core_prepared_sum(&application->core, application->configuration.lanes) ==
           prepared->sum + prepared->sum_of_all_heads;
}

void prepared_take_over(struct application *application) {
    prepared_hold(application, application->load.without.whole);
}

void prepared_hold(struct application *application, uint32_t sets) {
    struct prepared *prepared = &application->prepared;
    prepared->sets = sets;
    prepared->overwritten = false;
    application->report.alarms &= ~(uint32_t)ALARM_FAILOVER_OFF;
}

void prepared_keep(const struct application *application, struct kept_sets *kept) {
    const struct prepared *prepared = &application->prepared;
    uint32_t lanes = application->configuration.lanes;
    kept->number = 0;
    if (prepared->sets == 0 || !state_works(application) || !prepared_are_whole(application)) {
        return;
    }
    for (uint32_t head = 1; head <= HEADS_MOST; head++) {
        struct coefficients set = {.lanes = lanes,
                                   .counts_per_rev = application->active.counts_per_rev};
        if ((prepared->sets >> (head - 1) & 1U) != 0) {
            core_read_prepared(&application->core, head, &set);
            (void)kept_sets_add(kept, head, &set);
        }
    }
}

/* Reads all saved sets that this core can hold. Unless `sum` is NULL, writes them to the gateware and adds the sum of
   their words. Returns the missing heads of these sets, one bit per head. */
static uint32_t prepared_each_saved(const struct application *application, uint32_t *sum) {
    const struct saved *saved = &application->save->content;
    uint32_t lanes = application->configuration.lanes;
    uint32_t heads = application->configuration.heads;
    struct coefficients set;
    uint32_t sets = 0;
    uint32_t place = 0;
    if (!application->configuration.has_failover || saved->loaded.mean.heads != heads) {
        return 0;
    }
    for (uint32_t head; (head = kept_sets_next(&saved->sets, &place, heads,
                                               saved->loaded.counts_per_rev, &set)) != 0;) {
        if (set.lanes > lanes) {
            continue;
        }
        sets |= 1U << (head - 1);
        if (sum != NULL) {
            set.lanes = lanes;
            *sum += core_write_prepared(&application->core, head, &set);
        }
    }
    return sets;
}

uint32_t prepared_saved(const struct application *application) {
    return prepared_each_saved(application, NULL);
}

void prepared_restore(struct application *application) {
    prepared_close(application, application->candidate.counts_per_rev);
    prepared_hold(application, prepared_each_saved(application, &application->prepared.sum));
}

/* Returns the determinant of the rows 1, cos, sin of three heads. */
static double prepared_minor(const double place[3]) {
    return sin(place[1] - place[0]) + sin(place[2] - place[1]) + sin(place[0] - place[2]);
}

/* Computes c with sum c = 0 and sum c e^(j place) = 0: c holds the signed minors of the three equations, scaled so
   that the largest |c| is 1. The places are the offsets of the mean. Fewer than four heads have no parity. */
static void prepared_parity(const struct mean_set *mean, uint32_t counts_per_rev,
                            int32_t weight[HEADS_MOST]) {
    double c[PARITY_HEADS] = {0.0};
    double largest = 0.0;
    uint32_t at = 0;
    int32_t sum = 0;
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        weight[head] = 0;
    }
    if (mean->heads != PARITY_HEADS) {
        return;
    }
    for (uint32_t head = 0; head < PARITY_HEADS; head++) {
        double place[3];
        uint32_t others = 0;
        for (uint32_t other = 0; other < PARITY_HEADS; other++) {
            if (other != head) {
                place[others++] = 2.0 * PI * mean->offset[other] / OFFSET_ONE / counts_per_rev;
            }
        }
        c[head] = (head % 2 == 0 ? 1.0 : -1.0) * prepared_minor(place);
        if (fabs(c[head]) > largest) {
            largest = fabs(c[head]);
            at = head;
        }
    }
    double sign = c[0] < 0.0 ? -1.0 : 1.0;
    for (uint32_t head = 0; head < PARITY_HEADS && largest > 0.0; head++) {
        weight[head] = (int32_t)rint(sign * c[head] / largest * PARITY_ONE);
        sum += weight[head];
    }
    weight[at] -= sum;
}

void prepared_arm(struct application *application) {
    const struct parameters *parameters = &application->parameters;
    const struct core_access *core = &application->core;
    struct prepared *prepared = &application->prepared;
    const struct coefficients *active = state_active(application);
    if (prepared->sets == 0 || !state_works(application)) {
        return;
    }
    core_failover_off(core);
    if (!prepared_are_whole(application)) {
        prepared->sets = 0;
        alarm_between_turns(application, ALARM_COEFFICIENTS);
        return;
    }
    if (active == NULL || active->mean.heads < 3 || parameters->failover_causes == 0.0) {
        return;
    }
    struct core_failover_setup setup = {
        .causes = (uint32_t)parameters->failover_causes,
        .missing_counts = (uint32_t)parameters->failover_missing_counts,
        .step_limit = (uint32_t)parameters->failover_step_counts,
        .return_after = parameters->failover_return_s * application->configuration.clock_hz,
        .parity_limit = (uint32_t)parameters->failover_parity_counts,
    };
    prepared_parity(&active->mean, active->counts_per_rev, setup.parity_weight);
    core_failover_on(core, &setup);
}

void prepared_watch(struct application *application) {
    uint32_t left_out = core_left_out(&application->core);
    if ((left_out & ~application->prepared.reported) != 0) {
        alarm_between_turns(application, ALARM_HEAD_LEFT_OUT);
    }
    application->prepared.reported = left_out;
    bool refused = core_set_is_refused(&application->core);
    if (refused && !application->prepared.refused) {
        alarm_between_turns(application, ALARM_NO_SET);
    }
    application->prepared.refused = refused;
}

bool application_come_back(const struct application *application, uint32_t head) {
    bool is_out = head > 0 && head <= HEADS_MOST &&
                  (core_left_out(&application->core) >> (head - 1) & 1U) != 0;
    if (is_out) {
        core_come_back(&application->core, 1U << (head - 1));
    }
    return is_out;
}
