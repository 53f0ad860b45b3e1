/* SPDX-License-Identifier: Apache-2.0 */

/* What the application knows, and what every file of it asks: names of states, what is at work. */

#ifndef ARCTRUE_STATE_H
#define ARCTRUE_STATE_H

#include "average.h"
#include "capture_copy.h"
#include "core.h"
#include "fourier.h"
#include "further_orders.h"
#include "gate.h"
#include "heads_fit.h"
#include "kept_settings.h"
#include "least_squares.h"
#include "load.h"
#include "parameters.h"
#include "reading_function.h"
#include "save.h"
#include "table_temperature.h"

enum application_phase {
    PHASE_NO_CORE,
    PHASE_WAIT_FOR_INDEX,
    PHASE_CAPTURE,
    PHASE_SWAP,
    /* Several faults in a row, or settings that are lost: the core goes on with the coefficients that it
       has, and nothing is worked on. */
    PHASE_HELD,
};

/* Where the operator's settings come from. */
enum settings_origin {
    SETTINGS_PRESET,
    /* After a fault: as they were ordered before it. */
    SETTINGS_KEPT,
    /* After a fault that they did not outlive: as they were saved, or presets, and bypass where no
       correction is at work. */
    SETTINGS_LOST,
    /* At power-on: as they were saved. */
    SETTINGS_SAVED,
};

/* What has become of the coefficients that were saved. */
enum saved_state {
    SAVED_NONE,
    /* Captured turns have yet to confirm them. */
    SAVED_WAITING,
    SAVED_CONFIRMED,
    /* A turn speaks against them: they wait for the next `rearm`. */
    SAVED_NOT_CONFIRMED,
};

/* A capture for the console: asked for, copied, or such that it cannot be. */
enum dump_state { DUMP_NONE, DUMP_WANTED, DUMP_COPIED, DUMP_NOT_COPIED };

/* Where the candidate comes from. */
enum candidate_origin { OF_TURN, OF_LOAD, OF_PENDING, OF_SAVED };

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
    ALARM_SWAP = 512,
    /* The firmware began anew after a fault, not long ago. */
    ALARM_BEGAN_ANEW = 1024,
    ALARM_SAVED = 2048,
    ALARM_THERMOMETER = 4096,
    ALARM_CORE_RESET = 8192,
    /* The gateware has left a head out of the mean. */
    ALARM_HEAD_LEFT_OUT = 16384,
};

/* Sets for a missing head in the gateware's windows that belong to what is loaded. */
struct prepared {
    /* A bit per head; 0: the failover stays off. */
    uint32_t sets;
    /* Of their words, as they were read back. */
    uint32_t crc;
    /* Left-out heads of which the operator knows. */
    uint32_t told;
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
    /* What the loaded orders leave, of both predictions. */
    double loaded_arcsec;
    /* What the turn says of lanes that follow a condition: of the set that it judges, else of the loaded one. */
    struct followed_measured followed[FOLLOWED_LANES_MAX];
    uint32_t followed_lanes;
    /* A mean is corrected: how far a head's place is from where the mean expects it, at the most; below 0: not seen. */
    double mean_off_arcsec;
    /* Why the turn did not calibrate a mean that the device was to calibrate. */
    enum refusal mean_reason;
    uint32_t alarms;
    /* A, B and Z stand: the output lay too far behind. */
    bool output_stands;
    /* Faults that released the line drivers, of enum core_fault. */
    uint32_t release_causes;
    /* Of the die; known or absent, never a number that is none. */
    bool has_temperature;
    double temperature_c;
    /* Not yet told. */
    bool fresh;
    /* The turn has been told already: what is fresh is an alarm. */
    bool between_turns;
};

union calibration_workspace {
    struct fourier_workspace fourier;
    struct least_squares_workspace least_squares;
    struct heads_workspace heads;
    struct reading_workspace reading;
    struct further_workspace further;
};

/* What was written to memory is to outlive a new start. */
typedef void memory_settle(void);

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
    bool telemetry;
    /* NULL: they are not kept. */
    struct kept_settings *kept;
    memory_settle *settle;
    enum settings_origin settings_origin;
    uint32_t faults_in_a_row;
    /* It was told that the line drivers are released. */
    bool release_told;
    /* The bank that is ready. */
    struct core_header header;
    struct capture capture;
    enum dump_state dump;
    /* NULL: no capture is copied. */
    struct capture_copy *copy;
    int32_t position_at_bank;
    /* The angle of head 2 at its own index, counts: what it lost since the index that made its
       zero. The core moves head 1's zero in place of that: how often it has. */
    int32_t head2_zero;
    uint32_t zero_moves;
    /* The angle of head 1 at its index is not 0, and nothing has proven yet that counts were lost; since
       which position. */
    bool zero_in_doubt;
    int32_t position_at_doubt;
    uint32_t swaps_before;
    uint32_t swap_looks;
    /* What the latest turn says, refused or not; and what the latest turn that was taken says. */
    struct estimate measured;
    struct estimate estimate;
    /* Of the latest turn that calibrated the mean of three or four heads; `heads` of its geometry is 0 where the latest
       turn did not. */
    struct heads_found found;
    struct average average;
    enum verdict verdicts[ORDERS_MAX];
    struct coefficients active;
    struct coefficients candidate;
    struct load load;
    struct table_temperature table;
    struct prepared prepared;
    /* Of the table when the bank before was taken, at which time, and in the middle of this turn;
       as `table` says where nothing is known of before. */
    double before_celsius;
    double before_s;
    double middle_celsius;
    /* The speed swings: samples are taken at equal angles until the next start or dump. */
    bool by_angle;
    /* Of the core's time for the thermometer; 0: as the core says. In the virtual instrument fewer
       clocks are a second. */
    double temperature_clock_hz;
    /* Banks that followed the temperature between two turns. */
    uint32_t temperature_swaps;
    /* NULL: there is no flash. */
    struct save *save;
    enum saved_state saved_state;
    enum candidate_origin candidate_origin;
    /* `active` is at work. Where it is not, it is what was at work before the core began anew. */
    bool has_active;
    /* The operator wants nothing kept of what was known. */
    bool forgotten;
    /* The correction of before a fault is still at work; its coefficients are not known here. */
    bool inherited;
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

const char *output_fault_name(bool stands);
const char *application_phase_name(enum application_phase phase);
const char *settings_origin_name(enum settings_origin origin);
const char *saved_state_name(enum saved_state state);
const char *turn_result_name(enum turn_result result);

/* For lanes that follow the temperature: the table's, or NULL where none is known and they are as
   they were written. */
const struct thermal *application_thermal(const struct application *application,
                                          const struct thermal *thermal);

/* The correction is on, as far as the operator and the coefficients go. */
bool application_corrects(const struct application *application);

/* When the core takes its samples. */
enum core_capture application_capture(const struct application *application);

/* Asserts what is true between any two calls. */
void state_assert(const struct application *application);

/* There is a core, and it is worked with. */
bool state_works(const struct application *application);

/* The time of the core's own clock, s; 0 where its rate is not known. */
double state_seconds(const struct application *application);

/* What is at work, NULL where nothing is. */
const struct coefficients *state_active(const struct application *application);

#endif
