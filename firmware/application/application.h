/* SPDX-License-Identifier: Apache-2.0 */

/* What the processor does for ever: wait for the index, capture, verify, calibrate, write the
   idle bank, swap, monitor. One call of application_step() does one piece of it and returns. */

#ifndef ARCTRUE_APPLICATION_H
#define ARCTRUE_APPLICATION_H

#include "average.h"
#include "core.h"
#include "fourier.h"
#include "gate.h"
#include "least_squares.h"
#include "parameters.h"
#include "reading_function.h"

enum application_phase {
    PHASE_NO_CORE,
    PHASE_WAIT_FOR_INDEX,
    PHASE_CAPTURE,
    PHASE_DUMP,
    PHASE_SWAP,
};

enum turn_result { TURN_APPLIED, TURN_KEPT, TURN_REFUSED };

enum alarm {
    ALARM_NOISE = 1,
    ALARM_ERROR = 2,
    ALARM_SEPARATION = 4,
    ALARM_OUTPUT = 8,
    ALARM_OVERRUN = 16,
    ALARM_STUCK_CAPTURE = 32,
    ALARM_COEFFICIENTS = 64,
    ALARM_TEMPERATURE = 128,
    ALARM_ZERO_LOST = 256,
};

/* The latest turn, for the console and for telemetry. */
struct turn_report {
    uint32_t number;
    uint32_t sequence_number;
    uint64_t start_time;
    uint32_t samples;
    enum turn_result result;
    enum refusal reason;
    struct capture_fault fault;
    struct gate_prediction prediction;
    uint32_t alarms;
    /* Of the die; known or absent, never a number that is none. */
    bool has_temperature;
    double temperature_c;
    /* Not yet told. */
    bool fresh;
};

union calibration_workspace {
    struct fourier_workspace fourier;
    struct least_squares_workspace least_squares;
    struct reading_workspace reading;
};

/* False: no temperature is known; the value then stays as it was. */
typedef bool temperature_read(void *context, double *celsius);

struct application {
    struct core_access core;
    /* NULL: there is no sensor. */
    temperature_read *read_temperature;
    void *temperature_context;
    struct core_configuration configuration;
    struct parameters parameters;
    enum application_phase phase;
    /* Commands of the operator. */
    bool frozen;
    bool bypassed;
    bool dump_wanted;
    /* The bank that is ready. */
    struct core_header header;
    struct capture capture;
    uint32_t dumped;
    int32_t position_at_bank;
    /* The angle of head 2 at its own index, counts: what it lost since the index that made its
       zero. Head 1's zero is found anew in place of that. */
    int32_t head2_zero;
    uint32_t swaps_before;
    /* What is known of the error. */
    struct estimate estimate;
    struct average average;
    enum verdict verdicts[ORDERS_MAX];
    struct coefficients active;
    struct coefficients candidate;
    bool has_active;
    double usual_noise_arcsec;
    uint32_t noisy_turns;
    /* Bookkeeping. */
    struct turn_report report;
    uint32_t refusals[REFUSALS];
    uint32_t turns;
    uint32_t swaps;
    uint32_t stuck_captures;
    uint32_t overruns;
    /* Interrupts of the core; banks that were found without one since the bank before. */
    uint32_t interrupts;
    uint32_t banks_without_interrupt;
    bool interrupted;
    union calibration_workspace workspace;
};

/* Parameters at their presets, nothing known. */
void application_prepare(struct application *application, const struct core_access *core);

/* Where the temperature of a turn comes from. */
void application_use_temperature(struct application *application, temperature_read *read,
                                 void *context);

/* Find the core and set it up; the phase tells whether it is there. */
void application_start(struct application *application);

/* One piece of work; never waits. A calibration is one piece. */
void application_step(struct application *application);

/* The core has interrupted: call before the step that this is to cause. The interrupt says when to
   look, not what is there; a step without one finds the same, so a lost one costs time only. */
void application_interrupt(struct application *application);

/* There is more to do at once: do not sleep before the next step. */
bool application_busy(const struct application *application);

/* The operator's commands. */
void application_freeze(struct application *application, bool frozen);
void application_bypass(struct application *application, bool bypassed);
void application_forget(struct application *application);

const char *application_phase_name(enum application_phase phase);
const char *turn_result_name(enum turn_result result);
/* NULL for a bit that is no alarm. */
const char *alarm_name(uint32_t bit);

#endif
